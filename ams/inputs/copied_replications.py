"""Replications that are copies of another, whole or in part: equal to the last digit where readings scatter.

Replications tell noise and drift; of copies they tell none, and every uncertainty is too small. Readings repeat to the
last digit for two other reasons: a coarse meter puts them on the same step, or they were computed without noise. Then
either the readings of one replication show the step, or they lie on their fit; such outputs tell nothing of copies.

One output may repeat at some attitudes by itself, where it does not feel what shakes the others: of one alone only
nearly all points are a copy. Two outputs that scatter repeat together at more points than chance gives in copies only.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.errors import ObservationsError
from ams.frames import from_level_axes
from ams.inputs.common_step import GRID, common_step
from ams.observations import Observations

LEAST_POINTS: Final = 8
"""That two replications must have in common, and of which one must repeat for a part to be a copy."""
_NEARLY_ALL: Final = 0.9
_EXACT: Final = 1e-7
"""Of the span: readings that lie so near a line in the force were computed, or rounded for a file."""
_LEAST_STEP: Final = 0.5
"""Of the scatter: with such a step and hardly any noise readings may repeat to the last digit."""
_FAR: Final = 6.0
"""Standard deviations of a count of points that repeat by chance."""


@dataclass(frozen=True)
class _Copy:
    """What repeats in a replication."""

    of: int
    axes: tuple[str, ...]
    equal: int
    points: int

    @property
    def is_in_part(self) -> bool:
        return self.equal < _NEARLY_ALL * self.points


def refuse_copies(observations: Observations) -> None:
    """Refuse replications that are copies. Raises: ObservationsError."""
    found = dict(_copies(observations))
    if not found:
        return
    shown = next(iter(found.values()))
    of_first = [
        str(label) for label, copy in found.items() if copy.of == shown.of and copy.is_in_part == shown.is_in_part
    ]
    others = len(found) - len(of_first)
    more = f" ({others} more are copies of others, or in part)" if others else ""
    noun, verb = ("replication", "is a copy") if len(of_first) == 1 else ("replications", "are copies")
    part = " in part" if shown.is_in_part else ""
    outputs = "outputs" if len(shown.axes) == len(observations.outputs) else f"output {' and '.join(shown.axes)}"
    raise ObservationsError(
        f"{observations.source}: {noun} {', '.join(of_first)} {verb}{part} of replication {shown.of}{more}: "
        f"{shown.equal} of {shown.points} points have the same {outputs} to the last digit, which scatter "
        "otherwise and show no step of a meter; nothing was solved; noise and drift are told by replications that "
        "were measured: give those, each once"
    )


def _copies(observations: Observations) -> Iterator[tuple[int, _Copy]]:
    """Yield a replication, and which other it is a copy of."""
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
        copied = _copied(observations, first, here, there)
        if copied is not None:
            done.add(second)
            yield second, copied


def _copied(observations: Observations, first: int, here: IntArray, there: IntArray) -> _Copy | None:
    outputs = observations.outputs
    equal = {axis: values[here] == values[there] for axis, values in outputs.items() if np.ptp(values[here]) > 0.0}
    if not any(_repeats(outputs[axis], here, same) >= LEAST_POINTS for axis, same in equal.items()):
        return None
    basis = _smooth(observations, here)
    chances = {axis: chance for axis in equal if (chance := _chance(outputs[axis][here], basis)) is not None}
    if not chances:
        return None
    whole = tuple(
        axis for axis in chances if _repeats(outputs[axis], here, equal[axis]) >= _NEARLY_ALL * here.size
    )  # fmt: skip
    if whole:
        both = np.logical_and.reduce([equal[axis] for axis in whole])
        still = [axis for axis in equal if axis not in chances and np.mean(equal[axis]) >= _NEARLY_ALL]
        is_all = len(whole) + len(still) == len(equal)
        return _Copy(first, tuple(outputs) if is_all else whole, int(both.sum()), here.size)
    if len(chances) == 1:
        return None
    together = np.logical_and.reduce(list(equal.values()))
    repeats = min(_repeats(outputs[axis], here, together) for axis in chances)
    expected = here.size * min(chances.values())
    if repeats < LEAST_POINTS or repeats <= expected + _FAR * np.sqrt(expected):
        return None
    return _Copy(first, tuple(outputs), int(together.sum()), here.size)


def _repeats(values: FloatArray, here: IntArray, same: BoolArray) -> int:
    """Return how many readings repeat, each value counted once: an output that hangs is no copy."""
    return int(np.unique(values[here][same]).size)


def _by_point(observations: Observations, label: int) -> dict[int, int]:
    rows = np.flatnonzero(observations.replication == label)
    return dict(zip(observations.point[rows].tolist(), rows.tolist(), strict=True))


def _smooth(observations: Observations, rows: IntArray) -> FloatArray:
    """Return columns in which an output without noise lies: of gravity, of rates, of the field and of known levels."""
    pitch, roll = observations.pitch_rad[rows], observations.roll_rad[rows]
    yaw = np.zeros_like(pitch) if observations.yaw_rad is None else observations.yaw_rad[rows]
    gravity = from_level_axes(pitch, yaw, roll)[:, :, 2]
    columns = [np.ones((rows.size, 1)), gravity, gravity**3]
    columns += [gravity[:, [i]] * gravity[:, [j]] for i in range(3) for j in range(i + 1)]
    if observations.euler_rate_rad_s is not None:
        columns.append(observations.euler_rate_rad_s[rows])
    if observations.from_level is not None:
        columns.append(observations.from_level[rows].reshape(rows.size, 9))
    if observations.reference_level is not None:
        level = observations.reference_level[rows]
        columns.append(np.column_stack([level, level**2]))
    return np.hstack(columns)


def _chance(read: FloatArray, basis: FloatArray) -> float | None:
    """Return how probable it is that a reading repeats to the last digit; None where the readings do not tell it."""
    if basis.shape[1] >= read.size:
        return None
    left = read - basis @ np.linalg.lstsq(basis, read, rcond=None)[0]
    scatter, span = float(np.sqrt(np.mean(left**2))), float(np.ptp(read))
    step = common_step(read, GRID * span)
    if scatter <= _EXACT * span or step >= _LEAST_STEP * scatter:
        return None
    return float(step / (2.0 * np.sqrt(np.pi) * scatter))
