"""From a run's journal to everything it leaves behind: solution, coefficient sets, archive, report, exports.

A pure function of the journal but for the files: delivering twice writes the same bytes and publishes nothing new.
Only a finished run leaves coefficient sets; any run leaves a report that says what it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot
from pathlib import Path
from typing import TYPE_CHECKING, Any

from procedures.plan.plan import Plan
from procedures.provenance import provenance_of
from procedures.report.assemble import RunRecord, assemble_view
from procedures.run.header import RunHeader
from procedures.run.journal_reader import JournalReader
from procedures.run.records import DwellRecord, Event
from procedures.run.states import State
from procedures.solving import SolvedSensor, solve_sensors, standard_uncertainty_arcsec
from rig.description import RigDescription, rig_from_json

if TYPE_CHECKING:
    from ams.sets.coefficients import CoefficientSet
    from procedures.report.view import RunView

JOURNAL = "journal.sqlite"


@dataclass(frozen=True)
class SolvedRun:
    """A run as its journal tells it, and its solution."""

    folder: Path
    header: RunHeader
    state: State
    plan: Plan
    rig: RigDescription
    events: Sequence[Event]
    dwells: Sequence[DwellRecord]
    journal_sha256: str
    sensors: Mapping[str, SolvedSensor]

    @property
    def design_dwells(self) -> int:
        """Accepted dwells of the design."""
        return sum(dwell.accepted and dwell.purpose == "design" for dwell in self.dwells)


@dataclass(frozen=True)
class Delivery:
    """What was written."""

    run: SolvedRun
    view: "RunView"
    report: Path
    sets: Mapping[str, Path]
    """Sensor to its coefficient file."""
    exports: Sequence[Path]
    archive_url: str | None


def solve_run(folder: Path) -> SolvedRun:
    """Read a journal whole and solve every sensor of it. Raises: JournalError, PlanError, DescriptionError."""
    with JournalReader.open(folder / JOURNAL) as reader:
        header, state, journal_sha256 = reader.header, reader.state(), reader.sha256_of_content()
        events, dwells = list(reader.events()), list(reader.dwells())
    plan, rig = header.plan, rig_from_json(header.rig_json)
    sensors = solve_sensors(dwells, rig, plan.sensors, plan.solve, f"run {header.run_id}")
    return SolvedRun(folder, header, state, plan, rig, events, dwells, journal_sha256, sensors)


def deliver(run: SolvedRun, archive_url: str | None) -> Delivery:
    """Write report and figures; of a finished run also coefficient sets and exports, and publish them.

    Raises: ams.errors.AmsError where a set cannot be built, written or published.
    """
    view = _view(run)
    report = _write_report(run, view)
    sets = _sets(run) if run.state is State.FINISHED else {}
    paths = {name: _write_set(run.folder, coefficients) for name, coefficients in sets.items()}
    exports = [_export(run.folder, one, kind) for one in sets.values() for kind in run.plan.export_formats]
    if sets and archive_url is not None:
        _publish(archive_url, run, list(sets.values()))
    return Delivery(run, view, report, paths, exports, archive_url if sets else None)


def sensors_document(run: SolvedRun) -> dict[str, Any]:
    """``{"SN1047": {"axes": …}}``; a sensor without a solution says why under ``error``."""
    from ams.document import to_document

    return {
        name: {"axes": {}, "error": solved.failure} if solved.calibration is None else to_document(solved.calibration)
        for name, solved in run.sensors.items()
    }


def run_document(delivery: Delivery) -> dict[str, Any]:
    """What ``calrig run --json`` prints at the end."""
    run = delivery.run
    return {
        "run": str(run.folder),
        "state": str(run.state),
        "dwells_done": run.design_dwells,
        "dwells_planned": len(run.plan.design_dwells),
        "sensors": sensors_document(run),
        "report": str(delivery.report),
        "sets": [str(path) for path in delivery.sets.values()],
    }


def _view(run: SolvedRun) -> "RunView":
    header = run.header
    record = RunRecord(
        run_id=header.run_id,
        state=str(run.state),
        operator=header.operator,
        is_simulated=header.is_simulated,
        created_utc=header.created_utc,
        plan=run.plan,
        rig=run.rig,
        events=run.events,
        dwells=run.dwells,
        hashes={
            "journal content": run.journal_sha256,
            "plan": header.plan_sha256,
            "rig file": header.rig_sha256,
            "procedure file": header.procedure_sha256,
        },
        versions=header.software,
    )
    table_arcsec = hypot(*(standard_uncertainty_arcsec(run.rig, axis) for axis in ("pitch", "roll")))
    return assemble_view(record, run.sensors, table_arcsec)


def _write_report(run: SolvedRun, view: "RunView") -> Path:
    from procedures.report.figures import draw_figures, write_figures
    from procedures.report.page import write_page

    figures, report = draw_figures(view), run.folder / "report.html"
    write_figures(figures, run.folder / "figures")
    write_page(view, figures, report)
    return report


def _sets(run: SolvedRun) -> "dict[str, CoefficientSet]":
    from ams.sets.coefficients import build_set

    return {
        name: build_set(
            solved.calibration,
            provenance_of(solved, run.header, run.plan, run.rig, run.dwells, run.journal_sha256),
        )
        for name, solved in run.sensors.items()
        if solved.calibration is not None
    }


def _write_set(folder: Path, coefficients: "CoefficientSet") -> Path:
    from ams.sets.export.formats import export_set

    path = folder / "coefficients" / f"{coefficients.sensor}.json"
    path.parent.mkdir(exist_ok=True)
    export_set(coefficients, "json", path)
    return path


def _export(folder: Path, coefficients: "CoefficientSet", kind: str) -> Path:
    from ams.sets.export.formats import export_set

    path = folder / "exports" / f"{coefficients.sensor}.{kind}"
    path.parent.mkdir(exist_ok=True)
    export_set(coefficients, kind, path)
    return path


def _publish(archive_url: str, run: SolvedRun, sets: "Sequence[CoefficientSet]") -> None:
    """Published at the moment the run ended, by its own clock: publishing again changes nothing."""
    from ams.sets.archive import publish

    publish(archive_url, sets, run.events[-1].utc if run.events else run.header.created_utc)
