"""What a run took, into the archive, and what the archive's runs of a rig teach of the next one."""

from ams.archive.durations import PartDuration, RunDurations, keep_durations, past_durations
from ams.errors import ArchiveAbsent, ArchiveError
from procedures.plan.learned_times import MOST_RUNS, LearnedTimes, PartSums, learned_from
from procedures.solution.part_durations import part_durations
from procedures.solution.record import RunRecord
from rig.description.rig_file import RigDescription


def teach(archive_url: str, record: RunRecord) -> None:
    """Keep how long the parts of a finished run took. Raises: ArchiveError."""
    parts = {
        name: PartDuration(sums.count, sums.expected_s, sums.measured_s, sums.expected_s2, sums.rest_s2)
        for name, sums in part_durations(record).items()
    }
    run = RunDurations(
        record.hashes["journal content"], record.rig.rig.name, record.is_simulated, record.ended_utc, parts
    )
    keep_durations(archive_url, run)


def learned_times(archive_url: str | None, rig: RigDescription) -> LearnedTimes:
    """Return what past runs of the rig taught; nothing where there is no archive or it is of an older schema.

    A rig on twins learns from simulated runs alone, a real one from real runs alone.
    """
    if archive_url is None:
        return LearnedTimes()
    try:
        runs = past_durations(archive_url, rig.rig.name, simulated=rig.is_simulated, most=MOST_RUNS)
    except (ArchiveAbsent, ArchiveError):
        return LearnedTimes()
    return learned_from([{name: _sums(part) for name, part in run.items()} for run in runs])


def _sums(part: PartDuration) -> PartSums:
    return PartSums(part.steps, part.expected_s, part.measured_s, part.expected_s2, part.rest_s2)
