"""The journal's first page: what was to be done, on which rig, by whom, with which software."""

import hashlib
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import apsw
import numpy as np

from procedures.description.named_files import NamedFile
from procedures.errors import JournalError
from procedures.plan.plan import Plan
from rig.description.rig_file import RigDescription


@dataclass(frozen=True, slots=True)
class RunHeader:
    """Everything a run knew before it began. Texts are the files as they were read."""

    run_id: str
    title: str
    created_utc: datetime
    operator: str
    is_simulated: bool
    is_rehearsal: bool
    """True where every device was replaced by its twin, in virtual time."""
    software: Mapping[str, str]
    """Name to version."""
    plan_json: str
    plan_sha256: str
    rig_path: str
    rig_text: str
    rig_json: str
    """The description as it was understood, defaults filled in."""
    rig_sha256: str
    """Of ``rig_text``."""
    procedure_path: str
    procedure_text: str
    procedure_sha256: str
    named_files: tuple[NamedFile, ...] = ()
    """What the two files name, as it was read; none in a journal of before they were kept."""

    @property
    def plan(self) -> Plan:
        """Raises: PlanError where it is of another version."""
        return Plan.from_json(self.plan_json, f"run {self.run_id}: plan")

    @property
    def time_factor(self) -> float:
        """Rig seconds that pass in a second of the dates in the journal: 1 but for twins that live faster."""
        twin = json.loads(self.rig_json).get("twin") or {}
        time = twin.get("time")
        return float(time) if self.is_simulated and isinstance(time, int | float) else 1.0

    def to_json(self) -> str:
        return json.dumps(asdict(self) | {"created_utc": self.created_utc.isoformat()}, ensure_ascii=False)

    @staticmethod
    def from_json(text: str) -> "RunHeader":
        """Read a header. Raises: JournalError where it lacks what a header has."""
        try:
            document: dict[str, Any] = json.loads(text)
            document["created_utc"] = datetime.fromisoformat(document["created_utc"])
            document["named_files"] = tuple(NamedFile(**named) for named in document.get("named_files", ()))
            return RunHeader(**document)
        except (ValueError, TypeError, KeyError) as error:
            raise JournalError(f"journal: the header cannot be read: {error}; the journal was left as it is") from None


def make_header(
    run_id: str,
    plan: Plan,
    rig: RigDescription,
    rig_path: Path,
    procedure_path: Path,
    operator: str,
    created_utc: datetime,
    *,
    is_rehearsal: bool = False,
    named_files: Sequence[NamedFile] = (),
) -> RunHeader:
    """Make the header of a new run.

    ``rig`` is the description that is opened, twins in place where it is a rehearsal. ``named_files``: what the files
    at the two paths name.
    """
    plan_json = plan.to_json()
    rig_text, procedure_text = (
        path.read_bytes().decode("utf-8") for path in (rig_path, procedure_path)
    )  # as they lie there
    return RunHeader(
        run_id=run_id,
        title=plan.title,
        created_utc=created_utc,
        operator=operator,
        is_simulated=rig.is_simulated,
        is_rehearsal=is_rehearsal,
        software=software_versions(),
        plan_json=plan_json,
        plan_sha256=sha256(plan_json),
        rig_path=str(rig_path.resolve()),
        rig_text=rig_text,
        rig_json=rig.model_dump_json(),
        rig_sha256=sha256(rig_text),
        procedure_path=str(procedure_path.resolve()),
        procedure_text=procedure_text,
        procedure_sha256=sha256(procedure_text),
        named_files=tuple(named_files),
    )


def software_versions() -> dict[str, str]:
    """Return the versions of what measures and of what keeps the record."""
    return {
        "calrig": calrig_version(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "sqlite": apsw.sqlite_lib_version(),
    }


def calrig_version() -> str:
    return version("calrig")


def sha256(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()
