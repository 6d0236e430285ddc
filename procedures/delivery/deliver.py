"""From a run's journal to everything it leaves behind: solution, coefficient sets, archive, lessons, report, exports.

A pure function of the journal but for the files: delivering twice writes the same bytes and publishes nothing new,
also on another processor, whose last digits are others.
Only a finished run leaves coefficient sets; any run leaves a report that says what it is. Its parts are independent:
what hinders one is told and hinders no other, and delivering again makes what is missing.
"""

import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from ams.archive.runs import PublishedRun
from ams.calibration.findings_document import full_document
from ams.calibration_result import Calibration
from ams.errors import AmsError, WriteFailed
from ams.exports import dcc, json_text
from ams.exports.dcc_administration import IssuedCertificate
from ams.exports.formats import export_set, format_named
from ams.models.registry import is_solved_from_levels
from ams.sets.axis_section import primary_section
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.sensed_quantity import FIELDS
from ams.sets.stated_findings import LACKING
from procedures.delivery.kept_sets import kept_sets
from procedures.delivery.lessons import teach
from procedures.delivery.parts import DONE, NOT_DUE, Parts
from procedures.delivery.past import past_of
from procedures.delivery.publish import publish_solved
from procedures.delivery.set_aside import EXPORTS_FOLDER, set_old_aside
from procedures.delivery.taken_back_sets import withdraw_taken_back
from procedures.delivery.unsolved import keep_tracebacks
from procedures.journal.audit.audit_trail import clock_words, missing_in
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.unwritten import SETS_FOLDER
from procedures.kinds.solve import solve_record
from procedures.records.states import State
from procedures.report.overview import overview_rows
from procedures.report.paper.pdf import Attachment
from procedures.report.plain_page import PlainPage, write_plain
from procedures.report.view import Past, RunView
from procedures.report.write import (
    REPORT_FILE,
    Drawn,
    draw_report,
    sensor_document,
    view_of,
    write_paper,
    write_screen,
    write_sensor_document,
    write_verdict,
)
from procedures.solution.lines import lines_document
from procedures.solution.provenance import provenance_of
from procedures.solution.record import RunRecord, read_record
from procedures.solution.request import SolvedSensor
from rig.crash_points import CrashPoint, crash_point

Tell = Callable[[str], None]


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
        """Why a sensor has no result to use, one sentence each."""
        return [f"{name}: {solved.why_not_usable}" for name, solved in self.sensors.items() if solved.why_not_usable]


@dataclass(frozen=True)
class Delivery:
    """What was written, and what became of each part."""

    run: SolvedRun
    parts: Mapping[str, str]
    """Each of ``PARTS``: done, not due, or the sentence of what failed."""
    view: RunView | None
    """None where even the page's content could not be put together."""
    report: Path
    """Where the page is, or would be."""
    sets: Mapping[str, Path]
    """Sensor to its coefficient file; empty unless the run is finished."""
    exports: Sequence[Path]
    archive_url: str | None
    """Where the sets were published; None where they were not."""
    archived: PublishedRun | None = None
    """As found and as left of every sensor, as the archive has them."""
    defects: Mapping[str, str] = field(default_factory=dict)
    """Sensor or part that a defect hindered to its traceback; all of them stand in ``defects.txt`` of the run."""

    @property
    def failures(self) -> Mapping[str, str]:
        """The parts that are missing, each with its sentence; `calrig solve` makes them."""
        return {name: word for name, word in self.parts.items() if word != DONE and not word.startswith(NOT_DUE)}


def _tell_nobody(_step: str) -> None:
    return None


def solve_run(folder: Path, tell: Tell = _tell_nobody) -> SolvedRun:
    """Read a journal whole and solve every sensor of it; ``tell`` hears of each.

    Raises: JournalError, PlanError, DescriptionError.
    """
    tell("reading the journal")
    with JournalReader.open(folder) as reader:
        record = read_record(reader)
    return SolvedRun(folder, record, solve_record(record, tell))


def deliver(run: SolvedRun, archive_url: str | None, tell: Tell = _tell_nobody) -> Delivery:
    """Set, archive, lessons, exports, page and paper: what hinders one hinders no other, and nothing is raised.

    Only a finished run leaves sets; any run leaves a page and a paper.
    """
    crash_point(CrashPoint.SOLVED)
    # The archive before the page, which shows as found and as left as the archive has them; the paper is the page.
    parts = Parts(shlex.quote(str(run.folder)))
    names = with_set(run) if run.is_finished else ()
    built = {name: parts.made("set", lambda: set_of(run, name)) for name in names}  # noqa: B023  called at once
    sets: Mapping[str, CoefficientSet] = {name: made for name, made in built.items() if made is not None}
    kept: Mapping[str, CoefficientSet] | None = {}
    if archive_url is not None:
        url = archive_url
        kept = parts.made("archive", lambda: _kept(url, run.folder, sets))
        sets = {**sets, **(kept or {})}
    if not names:
        parts.leave_out(("set", "archive", "exports"), _why_no_set(run))
    elif not sets:
        parts.fail(("archive", "exports"), "there is no set")
    tell("writing coefficient sets, archive and exports")
    parts.made("set", lambda: set_old_aside(run.folder, sets, run.record.plan.sensors))
    standing = {name: made for name, made in sets.items() if made.withdrawal is None}
    if len(standing) < len(sets):
        parts.leave_out(("set", "archive", "exports"), _why_withdrawn(sets))
    paths = parts.made("set", lambda: _written_sets(run, standing)) if standing else {}
    crash_point(CrashPoint.SETS_WRITTEN)
    archived = None
    if standing and archive_url is not None and kept is not None:
        archived = _archived(url, run, standing, parts)
    elif sets and archive_url is None:
        parts.leave_out(("archive",), "no archive is asked for")
    if archived is None:
        parts.leave_out(("lessons",), "the run is not archived")
    crash_point(CrashPoint.PUBLISHED)
    exports = parts.made("exports", lambda: _exported(run, standing)) if standing else ()
    past = parts.made("html", lambda: past_of(run.record, run.sensors, sets, archived, archive_url))
    view = parts.made("html", lambda: view_of(run.record, run.sensors, past))
    drawn = None if view is None else parts.made("html", lambda: draw_report(view, tell))
    if drawn is None:
        parts.fail(("pdf",), "there is no page to print")
        _write_plain(run, view, parts)
    else:
        parts.made("html", lambda: write_screen(drawn, run.folder))
        tell("setting the paper")
        parts.made("pdf", lambda: write_paper(drawn, run.folder, _attached(standing.values())))
        _write_sensor_documents(run, drawn, standing, past, parts, tell)
    _write_hindered(run, view, parts)
    defects = {**_tracebacks(run), **parts.tracebacks}
    keep_tracebacks(run.folder, defects)
    crash_point(CrashPoint.REPORTED)
    published_to = archive_url if archived is not None else None
    page = run.folder / REPORT_FILE
    return Delivery(run, parts.in_words(), view, page, paths or {}, exports or (), published_to, archived, defects)


def _archived(
    archive_url: str, run: SolvedRun, sets: Mapping[str, CoefficientSet], parts: Parts
) -> PublishedRun | None:
    """Publish a run and then, where it is published, keep what it teaches: a lesson that fails takes no set away."""
    archived = parts.made("archive", lambda: publish_solved(archive_url, run.folder, run.record, run.sensors, sets))
    if archived is not None:
        parts.made("lessons", lambda: teach(archive_url, run.record, run.sensors))
    return archived


def _write_sensor_documents(
    run: SolvedRun,
    drawn: Drawn,
    sets: Mapping[str, CoefficientSet],
    past: Past | None,
    parts: Parts,
    tell: Tell,
) -> None:
    """Of several sensors each has a document of its own, which shows no other: for its customer."""
    names = list(run.sensors) if len(run.sensors) > 1 else []
    for index, name in enumerate(names, start=1):
        tell(f"document of {name} ({index} of {len(names)})")
        attached = [sets[name]] if name in sets else []
        parts.made("pdf", lambda: _write_sensor_document(run, drawn, past, name, _attached(attached)))  # noqa: B023


def _write_sensor_document(
    run: SolvedRun, drawn: Drawn, past: Past | None, name: str, attachments: Sequence[Attachment]
) -> Path:
    document = sensor_document(view_of(run.record, run.sensors, past, name), drawn.figures)
    return write_sensor_document(document, run.folder, attachments)


def _write_plain(run: SolvedRun, view: RunView | None, parts: Parts) -> None:
    """Leave a page that says why there is no report, where a part of it failed; a page of before would be of before."""
    why, record = parts.in_words()["html"], run.record
    page = PlainPage(record.plan.title, record.run_id, str(record.state), why, record.is_simulated)
    with suppress(WriteFailed, OSError):  # the disk, of which the parts have told
        write_plain(run.folder, page, tuple(record.plan.sensors), view)


def _write_hindered(run: SolvedRun, view: RunView | None, parts: Parts) -> None:
    """Have the verdict name the parts that a defect hindered, if any."""
    if (hindered := parts.hindered()) and view is not None:
        rows = [asdict(row) for row in overview_rows(view)]
        parts.made("html", lambda: write_verdict(run.folder, view.verdict, rows, view.state, hindered))


def _tracebacks(run: SolvedRun) -> dict[str, str]:
    return {name: solved.traceback for name, solved in run.sensors.items() if solved.traceback}


def _kept(archive_url: str, folder: Path, sets: Mapping[str, CoefficientSet]) -> dict[str, CoefficientSet]:
    """Withdraw what the journal took back since; return as :func:`kept_sets`. Raises: ams.errors.ArchiveError."""
    withdraw_taken_back(archive_url, folder)
    return kept_sets(archive_url, sets)


def _why_withdrawn(sets: Mapping[str, CoefficientSet]) -> str:
    """Say which sets are not delivered again, and why; files of before are not called back."""
    gone = [f"set {made.sha256[:12]} of {name} is {made.withdrawal}" for name, made in sets.items() if made.withdrawal]
    return f"{'; '.join(gone)}: it is not for use and not written again; do not use files of it from before"


def _why_no_set(run: SolvedRun) -> str:
    return "no sensor has a set" if run.is_finished else f"the run is {run.record.state}"


def _written_sets(run: SolvedRun, sets: Mapping[str, CoefficientSet]) -> dict[str, Path]:
    return {name: _write(coefficients, run.folder / SETS_FOLDER, "json") for name, coefficients in sets.items()}


def _exported(run: SolvedRun, sets: Mapping[str, CoefficientSet]) -> list[Path]:
    """Export every set in every format; those that have no form of a set are told when all others are written.

    Raises: the first refusal.
    """
    paths: list[Path] = []
    refusals: list[AmsError] = []
    for coefficients in sets.values():
        for kind in run.record.plan.export_formats:
            try:
                paths.append(_write(coefficients, run.folder / EXPORTS_FOLDER, kind))
            except AmsError as error:
                refusals.append(error)
    if refusals:
        raise type(refusals[0])("; ".join(dict.fromkeys(map(str, refusals))))
    return paths


def _attached(sets: Iterable[CoefficientSet]) -> list[Attachment]:
    return [attached for coefficients in sets for attached in attachments(coefficients)]


def sensors_document(run: SolvedRun) -> dict[str, Any]:
    """``{"SN1047": {"axes": …}}``; a sensor without a solution says why under ``error``."""
    return {name: _sensor_document(solved) for name, solved in run.sensors.items()}


def _sensor_document(solved: SolvedSensor) -> dict[str, Any]:
    if solved.static:
        return {"axes": {}, "static": {axis: asdict(axis_result) for axis, axis_result in solved.static.items()}}
    if solved.calibration is None:
        return {"axes": {}, "verdict": "not usable", "error": solved.failure}
    if is_solved_from_levels(solved.calibration.model):
        return lines_document(solved.calibration, solved.budgets)
    return full_document(solved.calibration, solved.observations, solved.budgets)


def run_document(delivery: Delivery) -> dict[str, Any]:
    """Return the document that ``calrig run --json`` prints at the end."""
    run = delivery.run
    return {
        "run": str(run.folder),
        "state": run.record.state,
        "dwells_done": run.dwells_done,
        "dwells_planned": len(run.record.plan.design_dwells),
        "sensors": sensors_document(run),
        "report": str(delivery.report),
        "sets": [str(path) for path in delivery.sets.values()],
        "delivery": dict(delivery.parts),
    }


def sets_of(run: SolvedRun) -> dict[str, CoefficientSet]:
    """Return sensor to the set of its solution; a sensor without one is missing. Raises: ams.errors.SetError."""
    return {name: set_of(run, name) for name in with_set(run)}


def with_set(run: SolvedRun) -> tuple[str, ...]:
    """Return the sensors whose solution is a set."""
    return tuple(
        name
        for name, solved in run.sensors.items()
        if solved.calibration is not None
        and solved.calibration.model in FIELDS
        and not solved.calibration.unusable_axes
    )


def set_of(run: SolvedRun, name: str) -> CoefficientSet:
    """Return the set of a sensor that :func:`with_set` names. Raises: ams.errors.SetError."""
    solved = run.sensors[name]
    assert solved.calibration is not None
    return build_set(_with_words(solved.calibration, run.record), provenance_of(solved, run.record))


def primaries_of(run: SolvedRun) -> dict[str, dict[str, Any]]:
    """Return of every set that :func:`sets_of` would build the primary parameters alone, as they stand in it.

    A set with its test vectors and its checksum takes longer than to solve it. Raises: ams.errors.SetError.
    """
    return {
        name: {
            "axes": {
                axis: {"primary": primary_section(solved_axis, name)}
                for axis, solved_axis in solved.calibration.axes.items()
            }
        }
        for name, solved in run.sensors.items()
        if solved.calibration is not None and solved.calibration.model in FIELDS
    }


def _with_words(calibration: Calibration, record: RunRecord) -> Calibration:
    """Return the calibration with what a user of the set should know of its run."""
    lacks = () if record.is_simulated else missing_in(record.events)
    missing = [f"{LACKING}{sentence}" for sentence in lacks if not sentence.startswith("approved_by")]
    words = tuple(dict.fromkeys([*clock_words(record.events), *missing]))
    return replace(calibration, warnings=(*calibration.warnings, *words)) if words else calibration


def _write(coefficients: CoefficientSet, folder: Path, kind: str) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / format_named(kind, coefficients.sensor).file_name(coefficients.sensor)
    export_set(coefficients, kind, path)
    return path


def attachments(coefficients: CoefficientSet, certificate: IssuedCertificate | None = None) -> list[Attachment]:
    """Return a set as the files inside the PDF: for machines as the laboratory's own set and as a DCC.

    ``certificate``: the PDF is that one.
    """
    of = " (specimen)" if certificate is not None and certificate.is_specimen else ""
    contents = (
        (json_text.FORMAT, "application/json", "coefficient set", json_text.to_json(coefficients)),
        (dcc.FORMAT, "application/xml", f"digital calibration certificate{of}", dcc.to_dcc(coefficients, certificate)),
    )
    return [
        Attachment(form.file_name(coefficients.sensor), media_type, f"{coefficients.sensor}: {what}", content)
        for form, media_type, what, content in contents
    ]
