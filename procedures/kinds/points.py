"""The schedule of a kind that is a list of points."""

from collections.abc import Sequence

from procedures.kinds.kind import PlanRequest, Schedule
from procedures.plan.points import Point, design_of_points, most_samples, steps_of_points


def schedule_of_points(request: PlanRequest, points: Sequence[Point]) -> Schedule:
    """Return the points in their order, once a replication, after one visit to the level attitude."""
    replications = request.procedure.procedure.replications
    return Schedule(
        design=design_of_points(points),
        steps=tuple(steps_of_points(request.axes, points, replications)),
        replications=replications,
        most_samples=most_samples(request.rig, points),
    )
