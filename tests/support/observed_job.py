"""What a rig file and a procedure file do, stage by stage: refusals, plan, conversation, record, numbers, pages.

Two jobs are compared by it. What only repeats a file (its text, tables that are carried as declared, hashes) is left
out, so that a difference is something that a key has done.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, fields, is_dataclass, replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from file_keys import Document, toml_of
from unattended_run import UnattendedRun, asks

from ams.archive.sign_offs import SignOff
from ams.errors import AmsError
from ams.exports.formats import FORMATS
from ams.sets.coefficients import CoefficientSet
from ams.sets.stated_findings import significant_findings
from ams.surveillance.adjustment import Adjustment
from procedures.certificate.grounds import Grounds
from procedures.certificate.page import certificate_page
from procedures.check.check_report import check, to_document
from procedures.console.rights import refused_elsewhere
from procedures.delivery.deliver import SolvedRun, sensors_document, sets_of
from procedures.delivery.past import as_left
from procedures.errors import ProcedureError
from procedures.journal.header import make_header
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.read import read_procedure
from procedures.kinds.solve import solve_record
from procedures.plan.plan import Plan
from procedures.report.sections.equipment import Equipment
from procedures.report.view import RunView
from procedures.report.write import view_of
from procedures.run.begin import begin
from procedures.solution.record import read_record
from rig.assembly import open_rig as opening
from rig.assembly.identity import expected, require_expected
from rig.clock import VirtualClock
from rig.description.fault_plan import FaultPlan
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import RigError
from rig.lines.open_lines import Lines
from rig.link.byte_stream import ByteStream
from rig.link.gpib import GpibBus, GpibResource
from rig.link.transcript import Recorder
from rig.motion.jog_steps import steps_deg
from rig.motion.move import trusted_state

BEGAN = datetime(2026, 3, 1, 8, 0, tzinfo=UTC)
PATIENCE_RESTS = 200
"""A run that waits for a person is given up after so many rests."""
CARRIED = ("mount", "level", "chain", "job", "acceptance", "laboratory", "standards", "temperature_conversion")
"""Of a set's provenance: tables of the rig file as they stand there."""
SHA256 = re.compile(r"\b[0-9a-f]{64}\b")
ECHOES = ("plan_sha256", "rig", "title", "kind", "order", "seed", "replications", "model", "design")
"""Of ``calrig check``: words and numbers of the files."""


@dataclass(frozen=True)
class Job:
    """The two files as documents, and what goes wrong on the twins' lines."""

    rig: Document
    procedure: Document
    faults: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    """Name to text of what lies beside them."""


class SeenOnTheWire(BaseException):  # no error: the answer is known, and nothing may catch it on its way
    """What is said differs from what was said before."""


def stages(job: Job, folder: Path, said_before: Callable[[], str] = str) -> Iterator[tuple[str, str]]:
    """Do the job; what is seen at each stage, cheapest first. A refusal ends it.

    ``said_before`` returns the stage "wire" of the job that this one is compared with, once that has it: the first line
    that differs ends this one.
    """
    folder.mkdir()
    for name, text in job.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    files = folder / "rig.toml", folder / "procedure.toml"
    for path, document in zip(files, (job.rig, job.procedure), strict=True):
        path.write_text(toml_of(document), encoding="utf-8")
    try:
        rig, procedure = read_rig(files[0]), read_procedure(files[1])
        report = check(rig, procedure, fresh_seed=1)
        yield "from another machine", refused_elsewhere("continue", rig)
        yield "plan", _text({**_without_echoes(to_document(report)), "steps of all": report.plan.steps})
        yield from _performed(job, rig, report.plan, folder, said_before)
    except SeenOnTheWire as seen:
        yield "wire", str(seen)
    except (RigError, ProcedureError, AmsError) as refusal:
        yield "refusal", str(refusal).replace(str(folder), "")


class Wire(list[str]):
    """Everything said, line by line."""

    def __init__(self, said_before: list[str]) -> None:
        super().__init__()
        self._before = said_before

    def append(self, line: str) -> None:
        """Raises: SeenOnTheWire where another line stood here before."""
        if len(self) < len(self._before) and line != self._before[len(self)]:
            raise SeenOnTheWire(line)
        super().append(line)


def _without_echoes(document: Mapping[str, Any]) -> dict[str, Any]:
    axes = {
        name: {key: value for key, value in use.items() if key != "limits_deg"}
        for name, use in document["axes"].items()
    }
    return {key: value for key, value in document.items() if key not in ECHOES} | {"axes": axes}


def _performed(
    job: Job, rig: RigDescription, plan: Plan, folder: Path, said_before: Callable[[], str]
) -> Iterator[tuple[str, str]]:
    wire = Wire(said_before().splitlines())
    run_dir = folder / "run"
    run_dir.mkdir()
    clock = VirtualClock(BEGAN)
    header = make_header("run", plan, rig, folder / "rig.toml", folder / "procedure.toml", "tester", BEGAN)
    faults = FaultPlan.model_validate({"seed": 3, "fault": job.faults}) if job.faults else None
    nobody = UnattendedRun(run_dir, at={PATIENCE_RESTS: asks("abort")})

    def recorded(_key: str, open_line: Any) -> ByteStream:
        return Recorder(open_line(), wire.append)

    with ExitStack() as held, pytest.MonkeyPatch.context() as patch:
        patch.setattr(opening, "Lines", _noting_lines(wire))
        opened = opening.open_rig(rig, clock=_clock_of_the_rig(rig, clock), line_source=recorded, faults=faults)
        held.enter_context(opened)
        found = opened.identities()
        require_expected(expected(_as_at_ports(rig)), found)
        yield "who is there", _text(found)
        yield "jog", _text([_jogged(opened, name) for name in opened.axes])
        nobody.rig = opened
        outcome = begin(run_dir, header, plan, opened, nobody, nobody)
        opened.reconnect()
        jogged = [_jogged(opened, name) for name in opened.axes]
    yield "wire", "\n".join(wire)
    yield "jog afterwards", _text(jogged)
    with JournalReader.open(run_dir) as reader:
        record = read_record(reader)
    events = [(event.monotonic_s, event.kind, event.detail) for event in record.events if event.kind != "process"]
    yield "record", _text([outcome, record.state, events, record.dwells])
    yield from _delivered(SolvedRun(run_dir, record, solve_record(record)))


def _jogged(opened: opening.Rig, name: str) -> tuple[object, str]:
    """Which steps a jog offers, and whether the axis may be moved before it is homed."""
    axis = opened.axes[name]
    try:
        trusted_state(axis)
    except RigError as refusal:
        return steps_deg(axis, opened.description.axes[name]), str(refusal)
    return steps_deg(axis, opened.description.axes[name]), ""


def _as_at_ports(rig: RigDescription) -> RigDescription:
    """The same rig behind ports, where the devices must be those that the file means; of twins nothing is asked."""
    tables = {name: getattr(rig, name) for name in ("axes", "readouts", "environment", "streams", "field")}
    return rig.model_copy(
        update={"twin": None}
        | {
            table: {
                name: device.model_copy(update={"resource" if table == "readouts" else "port": "socket://127.0.0.1:1"})
                for name, device in devices.items()
            }
            for table, devices in tables.items()
        }
    )


def _clock_of_the_rig(rig: RigDescription, clock: VirtualClock) -> VirtualClock | None:
    """The fixed clock where the rig file asks for virtual time; what else it asks for is looked at, not lived."""
    if opening.choose_clock(rig).__class__ is not VirtualClock:
        raise RigError("another clock than the virtual one")
    return clock


def _delivered(run: SolvedRun) -> Iterator[tuple[str, str]]:
    sets = sets_of(run) if run.is_finished else {}
    yield "numbers", _text(sensors_document(run))
    yield "sets", _text([_without_identity(coefficients) for coefficients in sets.values()])
    yield (
        "exports",
        _text(run.record.plan.export_formats)
        + "".join(
            SHA256.sub("", FORMATS["dcc"].to_bytes(coefficients).decode())
            for coefficients in sets.values()
            if coefficients.provenance["laboratory"]
        ),
    )
    yield "report", _text(_without_what_sections_only_carry(view_of(run.record, run.sensors)))
    left = as_left(run.record, run.sensors, sets) if sets else {}
    yield "judgement", _text(left)
    certificates = [_certificate(coefficients, left[name]) for name, coefficients in sets.items() if name in left]
    yield "certificate", SHA256.sub("", "".join(certificates))


def _without_what_sections_only_carry(view: RunView) -> RunView:
    """The view without hashes, versions, standards and what the rig file declares, as they stand there."""
    equipment = view.of_sections["equipment"]
    assert isinstance(equipment, Equipment)
    of_this_run = {"provenance": None, "equipment": replace(equipment, declared={}, standards=())}
    return replace(view, of_sections={**view.of_sections, **of_this_run})


def _without_identity(coefficients: CoefficientSet) -> dict[str, Any]:
    """The set without what it only carries; of the standards their names stay."""
    kept = {name: value for name, value in coefficients.document.items() if name not in ("checksum", "use")}
    kept["chain serials"] = coefficients.document["use"]["chain_serials"]
    kept["installation"] = coefficients.document["use"]["installation"]
    kept["provenance"] = {name: value for name, value in coefficients.provenance.items() if name not in CARRIED}
    kept["standards"] = [standard["name"] for standard in coefficients.provenance["standards"]]
    return kept


def _unsigned(coefficients: CoefficientSet) -> SignOff:
    return SignOff(coefficients.sha256, (), (), tuple(significant_findings(coefficients)))


def _certificate(coefficients: CoefficientSet, adjustment: Adjustment) -> str:
    return certificate_page(
        Grounds("C-1", date(2026, 3, 2), coefficients, adjustment, _unsigned(coefficients), is_specimen=True)
    )


def _noting_lines(wire: Wire) -> type[Lines]:
    """Lines that note how each is asked for: on a twin's line no baud rate is heard."""

    class NotingLines(Lines):
        def stream(self, key: str, port: str, baud_rate: int = 9600, **how: Any) -> ByteStream:
            wire.append(f"{key}: {port} {baud_rate} {how}")
            return super().stream(key, port, baud_rate, **how)

        def bus(self, key: str, resource: GpibResource) -> GpibBus:
            wire.append(f"{key}: {resource}")
            return super().bus(key, resource)

    return NotingLines


def _text(value: Any) -> str:
    """Hashes are of what is compared anyway, or of the files."""
    return SHA256.sub("", json.dumps(_plain(value), sort_keys=True, default=str))


def _plain(value: Any) -> Any:
    """As JSON takes it."""
    match value:
        case np.ndarray():
            return value.tolist()
        case np.generic():
            return value.item()
        case Mapping():
            return {str(key): _plain(inner) for key, inner in value.items()}
        case list() | tuple() | set() | frozenset():
            return [_plain(inner) for inner in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return value
