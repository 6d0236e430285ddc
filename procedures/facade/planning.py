"""``calrig.plan``: what a procedure would do, step by step; the procedure is a file, or is composed in Python."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from io import StringIO
from math import isfinite
from numbers import Real
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd
from rich.console import Console

from ams.whole_file import write_whole
from procedures.check.check_report import CheckReport, to_document
from procedures.check.check_report import check as check_plan
from procedures.check.check_text import render
from procedures.check.toml_text import toml_text, toml_value
from procedures.data.steps_table import steps_table
from procedures.errors import RequestError
from procedures.kinds.read import procedure_of
from procedures.numbers import duration
from procedures.plan.gravity_of_site import read_rig_of_site
from procedures.run.preflight import Preflight, preflight
from rig.description.read import read_rig
from rig.toml_file import TomlFile, read_toml

Tables = Mapping[str, Mapping[str, object]]
"""A procedure in Python: the tables and keys of the file."""
Attitudes = pd.DataFrame | Sequence[tuple[float, float]]
"""Columns pitch_deg and roll_deg (a gimbal: and yaw_deg), or pairs of pitch and roll."""

COMPOSED = Path("composed procedure")
"""What a mistake in composed tables is told of; the line is that of :attr:`PlannedRun.text`."""
_FILE_NAME = "procedure.toml"
_WIDTH = 110


@dataclass(frozen=True, eq=False)
class PlannedRun:
    """A run as it would be done: printed, it says what ``calrig check`` says. Made by :func:`plan`."""

    rig: Path
    """The rig file."""
    file: Path | None
    """The procedure file; None where it is composed."""
    text: str
    """The procedure as such a file."""
    points: pd.DataFrame | None
    """The attitudes of a design that was composed point by point."""
    report: CheckReport

    @property
    def title(self) -> str:
        return self.report.plan.title

    @property
    def steps(self) -> pd.DataFrame:
        """A row for every step in the order of the run: where each axis goes, what is measured there, and why."""
        return steps_table(self.report.plan)

    @property
    def document(self) -> dict[str, Any]:
        """What ``calrig check --json`` says of plan, duration and expected uncertainties."""
        return to_document(self.report)

    def preflight(self, out: str | Path = "runs", archive: str | None = None) -> Preflight:
        """Return what a run would meet if it began now, in sentences: refusals, and what it would not leave.

        ``out``: where its folder would be made. ``archive``: URL of the archive that keeps leases of shared devices.
        """
        now = datetime.now(UTC)
        return preflight(self.rig, read_rig(self.rig), self.report.plan, Path(out), now, archive_url=archive)

    def save(self, path: str | Path) -> Path:
        """Write the procedure file, and the points of a composed design beside it; returns its path.

        Raises: RequestError where it is there already with another text; WriteFailed.
        """
        target = Path(path)
        points = _points_beside(target)
        text = self.text if self.points is None else _with_points(self.text, points.name)
        if target.exists() and target.read_text(encoding="utf-8") != text:
            raise RequestError(f"{target}: is there already with another text; nothing was written; give another name")
        if self.points is not None:
            write_whole(points, _csv(self.points).encode("utf-8"))
        write_whole(target, text.encode("utf-8"))
        return target

    @contextmanager
    def procedure_file(self) -> Iterator[Path]:
        """Yield the procedure as a file: its own, or one that lasts as long as the context.

        Raises: RequestError where the file is no longer the one that was planned.
        """
        if self.file is None:
            with TemporaryDirectory() as folder:
                yield self.save(Path(folder) / _FILE_NAME)
        elif not self.file.exists() or self.file.read_text(encoding="utf-8-sig") != self.text:
            raise RequestError(f"{self.file}: is not what was planned; nothing was begun; plan it again")
        else:
            yield self.file

    def plot(self) -> Any:
        """Draw where every axis stands, step by step, as a Figure of matplotlib."""
        from procedures.data.drawings import attitudes_by_step

        return attitudes_by_step(self.steps)

    def __str__(self) -> str:
        page = Console(file=StringIO(), width=_WIDTH, no_color=True)
        page.print(render(self.report))
        assert isinstance(page.file, StringIO)
        return page.file.getvalue()

    def _repr_html_(self) -> str:
        expected = self.report.plan.expected
        counts = f"{len(self.report.plan.dwells)} dwells in {duration(expected.p50_s)} (p50)"
        advice = "".join(f"<li>{escape(line)}</li>" for line in self.report.advice)
        head = f"<p><b>{escape(self.title)}</b> on {escape(self.report.rig)}: {counts}</p>"
        return head + self.steps.head(10).to_html() + (f"<ul>{advice}</ul>" if advice else "")


def plan(procedure: str | Path | Tables, rig: str | Path, *, points: Attitudes | None = None) -> PlannedRun:
    """Plan a run and judge it as ``calrig check`` does. Opens no port and writes nothing.

    ``procedure``: a file, or its tables as mappings, such as ``{"procedure": {"title": …, "kind": "grid",
    "replications": 3}, "design": {"kind": "D", "pitch_deg": [-60, 0, 60], "roll_deg": [0, 90]}}``; relative paths in
    them are relative to the working folder. ``points``: attitudes in their order, instead of a ``design``.

    Raises: rig.errors.DescriptionError and PlanError for what cannot be done, in the sentences of the command.
    """
    described = read_rig_of_site(Path(rig))
    if isinstance(procedure, str | Path):
        if points is not None:
            raise RequestError("plan: points belong to a procedure that is composed; a file names its own ([design])")
        read = read_toml(Path(procedure))
        report = check_plan(described, procedure_of(read))
        return PlannedRun(Path(rig), Path(procedure), Path(procedure).read_text(encoding="utf-8-sig"), None, report)
    tables = {name: dict(keys) for name, keys in procedure.items()}
    if points is None:
        text = _text(_with_whole_paths(tables))
        return PlannedRun(Path(rig), None, text, None, check_plan(described, procedure_of(TomlFile(COMPOSED, text))))
    table = (
        points if isinstance(points, pd.DataFrame) else pd.DataFrame(list(points), columns=["pitch_deg", "roll_deg"])
    )
    for value in table.to_numpy().ravel():
        if not isinstance(value, Real) or not isfinite(value):
            raise RequestError(f"plan: points: got {value!r}, allowed are numbers in degrees; nothing was planned")
    attitudes = table.reset_index(drop=True).astype("float64")
    tables["design"] = {"order": "as-listed", **tables.get("design", {}), "kind": "file"}
    text = _text(tables)
    with TemporaryDirectory() as folder:
        there = _points_beside(Path(folder) / _FILE_NAME)
        there.write_text(_csv(attitudes), encoding="utf-8")
        description = procedure_of(TomlFile(COMPOSED, _with_points(text, str(there))))
        return PlannedRun(Path(rig), None, text, attitudes, check_plan(described, description))


def _text(tables: Tables) -> str:
    for table, keys in tables.items():
        for key, value in keys.items():
            try:
                toml_value(value)
            except TypeError as error:
                raise RequestError(f"plan: {table}.{key}: {error}; nothing was planned") from None
    return toml_text(tables)


def _csv(points: pd.DataFrame) -> str:
    return points.to_csv(index=False, lineterminator="\n")


def _points_beside(procedure: Path) -> Path:
    return procedure.with_name(f"{procedure.stem}-points.csv")


def _with_points(text: str, name: str) -> str:
    """Name the file of points in the table of the design, which is of the kind ``file``."""
    return text.replace('kind = "file"\n', f'kind = "file"\nfile = {toml_value(name)}\n', 1)


def _with_whole_paths(tables: Tables) -> Tables:
    """Make the one path that a procedure may hold absolute: a composed one has no folder of its own."""
    file = tables.get("design", {}).get("file")
    if not isinstance(file, str | Path):
        return tables
    return {**tables, "design": {**tables["design"], "file": str(Path(file).absolute())}}
