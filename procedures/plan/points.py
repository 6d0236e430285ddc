"""Schedules that are a list of points: at each an attitude, what is done there, and what field stands.

One visit to the level attitude is the check set; then the points in their order, once a replication.
"""

from collections.abc import Iterator, Sequence
from itertools import count
from math import ceil

from procedures.plan.designs import Design, DesignPoint
from procedures.plan.steps import Applied, Dwell, Motion, Rest, Step
from rig.description.rig_file import RigDescription

Point = tuple[dict[str, float], Motion | None, Applied | None]
"""Axis to attitude (degrees), what is done at it while reading, and the field."""


def steps_of_points(axes: Sequence[str], points: Sequence[Point], replications: int) -> Iterator[Step]:
    """Yield the check attitude and every point in every replication; axes that a point does not name stand at 0."""
    numbers = count()
    level = dict.fromkeys(axes, 0.0)
    yield Dwell(next(numbers), "check", 0, 0, level)
    for replication in range(1, replications + 1):
        for label, (attitude, motion, applied) in enumerate(points, start=1):
            yield Dwell(next(numbers), "design", replication, label, {**level, **attitude}, motion, applied)


def design_of_points(points: Sequence[Point]) -> Design:
    """Return the attitudes of the points as a design, labelled in their order."""
    stops = tuple(
        DesignPoint(label, attitude.get("pitch", 0.0), attitude.get("roll", 0.0), attitude.get("yaw", 0.0))
        for label, (attitude, _, _) in enumerate(points, start=1)
    )
    pitch, roll, yaw = (
        tuple(sorted({getattr(stop, f"{name}_deg") for stop in stops})) for name in ("pitch", "roll", "yaw")
    )
    return Design("schedule", stops, pitch, roll, yaw)


def most_samples(rig: RigDescription, points: Sequence[Point]) -> int:
    """Return how many samples of one stream the longest point takes at most."""
    fastest_hz = max((stream.samples_hz() for stream in rig.streams.values()), default=0.0)
    seconds = [motion.rest_seconds if isinstance(motion, Rest) else motion.seconds for _, motion, _ in points if motion]
    return ceil(max(seconds, default=0.0) * fastest_hz)
