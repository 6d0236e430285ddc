"""What a run teaches, into the archive; and what the archive's runs of a rig teach of the next one.

A rig on twins learns from simulated runs alone, a real one from real runs alone. Where there is no archive, or one of
an older schema, nothing is learned: an estimate is no reason to refuse anything.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Final

from ams.archive.lessons import AxisComponents, Lesson, PartDuration, keep_lesson, past_lessons
from ams.errors import ArchiveError
from procedures.plan.learned_times import MOST_RUNS, LearnedTimes, PartSums, learned_from
from procedures.solution.beliefs import Pilot, Shown
from procedures.solution.part_durations import part_durations
from procedures.solution.pilot import mean_of_shown, shown_in
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from rig.description.rig_file import RigDescription

UNTAUGHT: Final = "the run is archived; calrig check and calrig plan learn nothing from it yet"
"""What it means where a run's lesson could not be kept."""


@dataclass(frozen=True)
class Learned:
    """What past runs of a rig taught."""

    times: LearnedTimes = LearnedTimes()  # noqa: RUF009  a frozen value
    pilot: Pilot | None = None
    """What the sensors showed; None where no past run could tell."""


def teach(archive_url: str, record: RunRecord, solved: Mapping[str, SolvedSensor]) -> None:
    """Keep what a finished run teaches. Raises: ArchiveError."""
    keep_lesson(
        archive_url,
        Lesson(
            journal_sha256=record.hashes["journal content"],
            rig=record.rig.rig.name,
            simulated=record.is_simulated,
            ended_utc=record.ended_utc,
            parts=[
                PartDuration(name, sums.count, sums.expected_s, sums.measured_s, sums.expected_s2, sums.rest_s2)
                for name, sums in part_durations(record).items()
            ],
            components=[
                AxisComponents(name, axis, record.plan.sensors[name].model, **asdict(shown))
                for (name, axis), shown in shown_in(record, solved).items()
            ],
        ),
    )


def learned(archive_url: str, rig: RigDescription) -> Learned:
    """Return what past runs of the rig taught."""
    try:
        lessons = past_lessons(archive_url, rig.rig.name, simulated=rig.is_simulated, most=MOST_RUNS)
    except ArchiveError:
        return Learned()
    timed = [lesson for lesson in lessons if lesson.parts]
    return Learned(learned_from([_sums(lesson) for lesson in timed]), _pilot(lessons))


def _sums(lesson: Lesson) -> dict[str, PartSums]:
    return {
        part.part: PartSums(part.steps, part.expected_s, part.measured_s, part.expected_s2, part.rest_s2)
        for part in lesson.parts
    }


def _pilot(lessons: Sequence[Lesson]) -> Pilot | None:
    of_sensor: dict[tuple[str, str], list[Shown]] = {}
    of_type: dict[tuple[str, str], list[Shown]] = {}
    for component in (component for lesson in lessons for component in lesson.components):
        shown = Shown(
            component.reading_g,
            component.dwell_g,
            component.lack_of_fit_g,
            component.offset_drift_g,
            component.sensitivity_drift,
        )
        of_sensor.setdefault((component.sensor, component.axis), []).append(shown)
        of_type.setdefault((component.type, component.axis), []).append(shown)
    if not of_sensor:
        return None
    runs = sum(bool(lesson.components) for lesson in lessons)
    return Pilot(
        f"{runs} past run{'s' if runs > 1 else ''} of this rig",
        {key: mean_of_shown(found) for key, found in of_sensor.items()},
        {key: mean_of_shown(found) for key, found in of_type.items()},
    )
