"""Replications that are copies of another: equal to the last digit where readings scatter.

Replications tell noise and drift; of copies they tell none, and every uncertainty is too small. Readings repeat to the
last digit for two other reasons: a coarse meter puts them on the same step, or they were computed without noise. Then
either the readings of one replication show the step, or they lie on their fit.
"""

from collections.abc import Iterator
from itertools import combinations
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.errors import ObservationsError
from ams.frames import specific_force
from ams.inputs.common_step import GRID, common_step
from ams.observations import Observations

LEAST_POINTS: Final = 8
"""That two replications must have in common."""
_NEARLY_ALL: Final = 0.9
_EXACT: Final = 1e-7
"""Of the span: readings that lie so near a line in the force were computed, or rounded for a file."""
_LEAST_STEP: Final = 0.5
"""Of the scatter: with such a step and hardly any noise readings may repeat to the last digit."""


def refuse_copies(observations: Observations) -> None:
    """Refuse replications that are copies. Raises: ObservationsError."""
    found = dict(_copies(observations))
    if not found:
        return
    first = next(iter(found.values()))[0]
    of_first = [str(label) for label, (of, _) in found.items() if of == first]
    equal, points = next(of for of in found.values())[1]
    others = len(found) - len(of_first)
    more = f" ({others} more are copies of others)" if others else ""
    noun, verb = ("replication", "is a copy") if len(of_first) == 1 else ("replications", "are copies")
    raise ObservationsError(
        f"{observations.source}: {noun} {', '.join(of_first)} {verb} of replication {first}{more}: {equal} of {points} "
        "points have the same outputs to the last digit, which scatter otherwise and show no step of a meter; nothing "
        "was solved; noise and drift are told by replications that were measured: give those, each once"
    )


def _copies(observations: Observations) -> Iterator[tuple[int, tuple[int, tuple[int, int]]]]:
    """Yield a replication, which other it is a copy of, and how many points of how many are equal."""
    labels = np.unique(observations.replication)
    rows = {int(label): _by_point(observations, int(label)) for label in labels}
    done: set[int] = set()
    for first, second in combinations(rows, 2):
        if second in done:
            continue
        common = sorted(rows[first].keys() & rows[second].keys())
        if len(common) < LEAST_POINTS:
            continue
        here, there = (np.array([rows[label][point] for point in common]) for label in (first, second))
        moving = [values for values in observations.outputs.values() if np.ptp(values[here]) > 0.0]
        if not moving:
            continue
        equal = np.logical_and.reduce([values[here] == values[there] for values in moving])
        if np.mean(equal) < _NEARLY_ALL or not _scatter(observations, here, moving):
            continue
        done.add(second)
        yield second, (first, (int(equal.sum()), len(common)))


def _by_point(observations: Observations, label: int) -> dict[int, int]:
    rows = np.flatnonzero(observations.replication == label)
    return dict(zip(observations.point[rows].tolist(), rows.tolist(), strict=True))


def _scatter(observations: Observations, rows: IntArray, outputs: list[FloatArray]) -> bool:
    """Return whether the outputs of one replication scatter about the force, without the steps of a meter."""
    force = specific_force(observations.pitch_rad[rows], observations.roll_rad[rows])
    bends = [force[:, i] * force[:, j] for i in range(3) for j in range(i + 1)] + [force[:, i] ** 3 for i in range(3)]
    basis = np.column_stack([np.ones(rows.size), force, *bends])
    if basis.shape[1] >= rows.size:
        return False
    for values in outputs:
        read = values[rows]
        left = read - basis @ np.linalg.lstsq(basis, read, rcond=None)[0]
        scatter, span = float(np.sqrt(np.mean(left**2))), float(np.ptp(read))
        if scatter > _EXACT * span and common_step(read, GRID * span) < _LEAST_STEP * scatter:
            return True
    return False
