"""From a run's journal to everything it leaves behind: solution, coefficient sets, archive, report, exports.

A pure function of the journal but for the files: delivering twice writes the same bytes and publishes nothing new.
Only a finished run leaves coefficient sets; any run leaves a report that says what it is.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ams.archive.histories import history
from ams.archive.runs import Override, PublishedRun
from ams.calibration.findings_document import full_document
from ams.errors import AmsError, ArchiveError, OutsideValidity
from ams.exports import dcc, json_text
from ams.exports.formats import export_set, format_named
from ams.sets.canonical import table
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.sensed_quantity import FIELDS
from ams.surveillance.adjustment import Adjustment, acceptance_of, adjust
from procedures.delivery.publish import publish_solved
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_record
from procedures.records.states import State
from procedures.report.paper.pdf import Attachment
from procedures.report.view import Past, RunView
from procedures.report.write import view_of, write_report
from procedures.solution.lines import lines_document
from procedures.solution.provenance import provenance_of
from procedures.solution.record import RunRecord, read_record
from procedures.solution.request import SolvedSensor
from rig.crash_points import CrashPoint, crash_point


@dataclass(frozen=True)
class SolvedRun:
    """A run as its journal tells it, and its solution."""

    folder: Path
    record: RunRecord
    sensors: Mapping[str, SolvedSensor]

    @property
    def is_finished(self) -> bool:
        return self.record.state == State.FINISHED

    @property
    def dwells_done(self) -> int:
        """Accepted dwells of the design."""
        return sum(dwell.accepted and dwell.purpose == "design" for dwell in self.record.dwells)

    @property
    def failures(self) -> Sequence[str]:
        """Why a sensor has no solution, one sentence each."""
        return [f"{name}: {solved.failure}" for name, solved in self.sensors.items() if solved.failure is not None]


@dataclass(frozen=True)
class Delivery:
    """What was written."""

    run: SolvedRun
    view: RunView
    report: Path
    sets: Mapping[str, Path]
    """Sensor to its coefficient file; empty unless the run is finished."""
    exports: Sequence[Path]
    archive_url: str | None
    """Where the sets were published; None where they were not."""
    archived: PublishedRun | None = None
    """As found and as left of every sensor, as the archive has them."""
    refusal: AmsError | None = None
    """Why the archive did not take the run; everything else was written."""


def solve_run(folder: Path) -> SolvedRun:
    """Read a journal whole and solve every sensor of it. Raises: JournalError, PlanError, DescriptionError."""
    with JournalReader.open(folder) as reader:
        record = read_record(reader)
    return SolvedRun(folder, record, solve_record(record))


def deliver(run: SolvedRun, archive_url: str | None) -> Delivery:
    """Write report and figures; of a finished run also coefficient sets and exports, and publish them.

    Raises: ams.errors.AmsError where a set cannot be built or written; what the archive refuses is told in the result.
    """
    crash_point(CrashPoint.SOLVED)
    sets = sets_of(run) if run.is_finished else {}
    paths = {name: _write(one, run.folder / "coefficients", "json") for name, one in sets.items()}
    crash_point(CrashPoint.SETS_WRITTEN)
    archived, refusal = _published(run, sets, archive_url)
    crash_point(CrashPoint.PUBLISHED)
    view = view_of(run.record, run.sensors, _past(run, sets, archived, archive_url))
    report = write_report(view, run.folder, [attached for one in sets.values() for attached in attachments(one)])
    crash_point(CrashPoint.REPORTED)
    # Last: a format that has no form of a set refuses it, and everything else is delivered by then.
    exports = [
        _write(one, run.folder / "exports", kind) for one in sets.values() for kind in run.record.plan.export_formats
    ]
    published_to = archive_url if sets and refusal is None else None
    return Delivery(run, view, report, paths, exports, published_to, archived, refusal)


def _published(
    run: SolvedRun, sets: Mapping[str, CoefficientSet], archive_url: str | None
) -> tuple[PublishedRun | None, AmsError | None]:
    """What the archive has of the run, or why it refuses: the rest is delivered all the same."""
    if not sets or archive_url is None:
        return None, None
    try:
        return publish_solved(archive_url, run.folder, run.record, run.sensors, sets), None
    except AmsError as refusal:
        return None, refusal


def _past(
    run: SolvedRun,
    sets: Mapping[str, CoefficientSet],
    archived: PublishedRun | None,
    archive_url: str | None,
) -> Past:
    """As found, as left, and the calibrations before: as the archive knew them when this run ended."""
    if archived is None or archive_url is None:
        return Past(_as_left(run, sets))
    try:
        told = {name: history(archive_url, name, until_utc=one.created_utc) for name, one in sets.items()}
    except ArchiveError:  # what was published stands; the look at the years before is told where the command looks
        told = {}
    return Past(archived.adjustments, {name: one for name, one in told.items() if len(one.history.labels) > 1})


def _as_left(run: SolvedRun, sets: Mapping[str, CoefficientSet]) -> dict[str, Adjustment]:
    """Without an archive nothing is known of before: the new sets on their own data."""
    adjustments = {}
    for name, one in sets.items():
        accepted = acceptance_of(table(one.provenance["acceptance"] or {}))
        with suppress(OutsideValidity):  # a set that tells no angles (gyros, packages of CR)
            rows = run.sensors[name].observations
            adjustments[name] = adjust(None, one, rows, accepted, run.record.plan.usage_pitch_deg)
    return adjustments


def sensors_document(run: SolvedRun) -> dict[str, Any]:
    """``{"SN1047": {"axes": …}}``; a sensor without a solution says why under ``error``."""
    return {name: _sensor_document(solved) for name, solved in run.sensors.items()}


def _sensor_document(solved: SolvedSensor) -> dict[str, Any]:
    if solved.static:
        return {"axes": {}, "static": {axis: asdict(one) for axis, one in solved.static.items()}}
    if solved.calibration is None:
        return {"axes": {}, "error": solved.failure}
    if solved.calibration.model == "linear":
        return lines_document(solved.calibration, solved.budgets)
    return full_document(solved.calibration, solved.observations, solved.budgets)


def run_document(delivery: Delivery) -> dict[str, Any]:
    """What ``calrig run --json`` prints at the end."""
    run = delivery.run
    return {
        "run": str(run.folder),
        "state": run.record.state,
        "dwells_done": run.dwells_done,
        "dwells_planned": len(run.record.plan.design_dwells),
        "sensors": sensors_document(run),
        "report": str(delivery.report),
        "sets": [str(path) for path in delivery.sets.values()],
    }


def sets_of(run: SolvedRun) -> dict[str, CoefficientSet]:
    """Sensor to the set of its solution; a sensor without one is missing. Raises: ams.errors.SetError."""
    return {
        name: build_set(solved.calibration, provenance_of(solved, run.record))
        for name, solved in run.sensors.items()
        if solved.calibration is not None and solved.calibration.model in FIELDS
    }


def _write(coefficients: CoefficientSet, folder: Path, kind: str) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / format_named(kind, coefficients.sensor).file_name(coefficients.sensor)
    export_set(coefficients, kind, path)
    return path


def attachments(coefficients: CoefficientSet) -> list[Attachment]:
    """A set as the files inside the PDF: for machines as the laboratory's own set and as a DCC."""
    wanted = (
        (json_text.FORMAT, "application/json", "coefficient set"),
        (dcc.FORMAT, "application/xml", "digital calibration certificate"),
    )
    return [
        Attachment(
            form.file_name(coefficients.sensor),
            media_type,
            f"{coefficients.sensor}: {what}",
            form.to_bytes(coefficients),
        )
        for form, media_type, what in wanted
    ]


def publish_folder(
    folder: Path, archive_of: Callable[[bool], str], override: Override | None = None
) -> tuple[str, PublishedRun]:
    """A finished run out of its journal, solved again and published; returns where, and what is there now.

    Raises: RequestError where the run did not finish or has nothing to publish; ams.errors.ArchiveError.
    """
    run = solve_run(folder)
    if not run.is_finished:
        raise RequestError(
            f"{folder}: the run is {run.record.state}, only a finished one has sets; nothing was published; "
            f"calrig handover {folder} says what comes next"
        )
    sets = sets_of(run)
    if not sets:
        raise RequestError(f"{folder}: no sensor has a solution: {'; '.join(run.failures)}; nothing was published")
    url = archive_of(run.record.is_simulated)
    return url, publish_solved(url, folder, run.record, run.sensors, sets, override)
