"""A solved run into the archive: the run as a row, its sensors with their rows, and who answers for what expired."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path

from ams.archive.dated_ahead import archived_ahead
from ams.archive.histories import history
from ams.archive.runs import MeasuredSensor, Override, PublishedRun, RunEntry, publish_run
from ams.archive.sets import Publication
from ams.errors import ArchiveError, ArchiveUnknown
from ams.findings import Finding
from ams.sets.coefficients import CoefficientSet
from procedures.delivery.taken_back_sets import withdraw_previous
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from procedures.solution.run_findings import findings_of_sensor
from rig.clock import SystemClock

WHAT_TO_DO_ABOUT_A_SWAP = (
    "look at serial numbers, channels and cables, put right what was exchanged and calibrate again; or, where each is "
    "what its name says, release the sets (calrig archive release)"
)
WHAT_TO_DO_ABOUT_AN_EARLIER_SWAP = (
    "the new sets count; look at what those before were used for, and withdraw them (calrig archive sign CHECKSUM "
    "withdrawn)"
)


def publish_solved(
    archive_url: str,
    folder: Path,
    record: RunRecord,
    solved: Mapping[str, SolvedSensor],
    sets: Mapping[str, CoefficientSet],
    override: Override | None = None,
    supersede: Override | None = None,
) -> PublishedRun:
    """Publish a solved run in the archive; what it teaches of the next is a step of its own (:mod:`.lessons`).

    Publishing again changes nothing; of several solutions of one run the one published last counts.

    Raises: ams.errors.ArchiveError where the archive or an expired standard refuses.
    """
    entry = run_entry(folder, record)
    measured = measured_sensors(record, solved, sets)
    usage = record.plan.usage_pitch_deg
    now = SystemClock().now_utc()
    withdraw_previous(archive_url, sets, record.run_id, is_simulated=record.is_simulated)
    return publish_run(
        archive_url, entry, measured, now, usage_pitch_deg=usage, override=override,
        lineage=record.lineage, supersede=supersede,
    )  # fmt: skip


def measured_sensors(
    record: RunRecord, solved: Mapping[str, SolvedSensor], sets: Mapping[str, CoefficientSet]
) -> list[MeasuredSensor]:
    """Return every sensor that has a set, with its rows and what the run as a whole says of it."""
    findings = {name: findings_of_sensor(record, solved[name]) for name in sets}
    return [
        MeasuredSensor(
            coefficients,
            solved[name].observations,
            record.plan.sensors[name].check_sensor,
            (*findings[name], *_turns(solved[name], findings[name])),
            solved[name].reference,
        )
        for name, coefficients in sets.items()
    ]


def _turns(solved: SolvedSensor, known: Sequence[Finding]) -> Iterator[Finding]:
    """Yield what the sensor's own dwells say of a table that turned, beside what is known of the run."""
    turns = () if solved.calibration is None else solved.calibration.turns
    yield from (turn for turn in turns if turn not in known)


def run_entry(folder: Path, record: RunRecord) -> RunEntry:
    """Return the run as the archive keeps it."""
    return RunEntry(
        journal_sha256=record.hashes["journal content"],
        run_id=record.run_id,
        title=record.plan.title,
        rig=record.rig.rig.name,
        operator=record.operator,
        simulated=record.is_simulated,
        started_utc=min((dwell.started_utc for dwell in record.dwells), default=record.created_utc),
        ended_utc=record.ended_utc,
        folder=str(folder.resolve()),
        software_version=record.versions["calrig"],
    )


def history_findings(archive_url: str, publications: Sequence[Publication], now_utc: datetime) -> Iterator[str]:
    """Yield what each sensor's history says with the calibration that was published just now, a sentence each.

    That is which of them look exchanged, what all sensors of its run changed alike, what was seen by it, a drift that
    goes on, and a change that its uncertainties do not explain where nothing can be judged yet; all of it where later
    calibrations are there already. Before that which of the sensor's sets are dated after ``now_utc``.
    """
    try:
        yield from archived_ahead(archive_url, [publication.sensor for publication in publications], now_utc)
    except ArchiveError as error:
        yield str(error)
    swaps = dict.fromkeys(entry.exchanged for entry in publications if entry.is_new and entry.exchanged)
    yield from (f"{sentence}: in quarantine; {WHAT_TO_DO_ABOUT_A_SWAP}" for sentence in swaps)
    earlier = dict.fromkeys(entry.exchanged_before for entry in publications if entry.is_new)
    yield from (f"{sentence}: {WHAT_TO_DO_ABOUT_AN_EARLIER_SWAP}" for sentence in earlier if sentence)
    shared: set[str] = set()
    for publication in publications:
        if not publication.is_new:
            continue
        try:
            whole = history(archive_url, publication.sensor)
        except ArchiveUnknown:  # its only set is in quarantine, which counts for no history and is told with the run
            continue
        except ArchiveError as error:  # what was published stands; only the look at the years before is missing
            yield str(error)
            continue
        found = whole.history
        run_id = next((label.run_id for label in found.labels if label.sha256 == publication.sha256), None)
        for change in whole.shared:
            if change.run_id == run_id and change.sentence not in shared:
                shared.add(change.sentence)
                yield change.sentence
        is_newest = found.labels[-1].sha256 == publication.sha256
        last = max((at for at, finding in enumerate(found.findings) if finding.kind != "mix-up"), default=None)
        for at, finding in enumerate(found.findings):
            goes_on = finding.kind == "drift" and at == last
            if not is_newest or goes_on or publication.sha256 in (finding.at.sha256, finding.seen.sha256):
                yield f"{finding.sentence}{f' (but {finding.rig_cause})' if finding.rig_cause else ''}"
        if is_newest and not found.findings and found.unexplained:
            yield f"{publication.sensor}: {found.unexplained}"
