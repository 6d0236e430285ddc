"""Replications that are copies of another, whole or in part: equal to the last digit where readings scatter.

Replications tell noise and drift; of copies they tell none, and every uncertainty is too small. Readings repeat to the
last digit for two other reasons: a coarse meter puts them on the same step, or they were computed without noise. Then
either the readings of one replication show the step, or they lie on their fit; such outputs tell nothing of copies. A
meter whose step grows in a higher range shows it in the readings that repeat.

Where there are too few points for a smooth fit the other replications tell the scatter; where none is left, what is off
a plain line in gravity does, of readings with so many digits that no meter repeats them.

Rows may be copied under new numbers of points too, and pass for a design of twice as many. Rows of the same attitude
are then held against each other whatever their points are called: the second time that a replication is at an attitude
is looked at as a replication of its own.

One output may repeat at some attitudes by itself, where it does not feel what shakes the others: of one alone only
nearly all points are a copy. Two outputs that scatter repeat together at more points than chance gives in copies only.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.errors import ObservationsError
from ams.frames import from_level_axes
from ams.inputs.common_step import GRID, common_step
from ams.observations import Observations
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION

LEAST_POINTS: Final = 8
"""Of which one output must repeat for a part to be a copy."""
_FEWEST_IN_COMMON: Final = 5
"""Points of two replications: one more than a plain line in gravity takes."""
_IMPOSSIBLE: Final = 1e-9
"""Probability that what repeats does so by chance."""
_NEARLY_ALL: Final = 0.9
_EXACT: Final = 1e-7
"""Of the span: readings that lie so near a line in the force were computed, or rounded for a file."""
_LEAST_STEP: Final = 0.5
"""Of the scatter: with such a step and hardly any noise readings may repeat to the last digit."""
_NO_STEP: Final = 1e-7
"""Of the span: no meter whose readings repeat by their step has so fine a one."""
_LINE: Final = 4
"""Columns of a plain line in gravity, the first of the smooth ones."""
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


@dataclass(frozen=True)
class _Chance:
    """That a reading repeats to the last digit by chance."""

    probability: float
    coarsest: float
    """Step from which on readings repeat by it."""
    finest: float

    def explains(self, repeated: FloatArray) -> bool:
        """Return whether the readings that repeat show a coarse step that others do not, as in one range of a meter."""
        are_enough = np.unique(repeated).size >= _FEWEST_IN_COMMON
        return are_enough and common_step(repeated, self.finest) >= self.coarsest


def refuse_copies(observations: Observations) -> None:
    """Refuse replications, and rows under new numbers of points, that are copies. Raises: ObservationsError."""
    found = dict(_copies(observations))
    if not found:
        _refuse_renumbered(observations)
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


def _refuse_renumbered(observations: Observations) -> None:
    """Refuse rows that are copies of others under new numbers of points. Raises: ObservationsError."""
    renumbered = _by_attitude(observations)
    if renumbered is None:
        return
    found = next(_copies(renumbered), None)
    if found is None:
        return
    label, copy = found
    of, copied = (renumbered.replication == number for number in (copy.of, label))
    raise ObservationsError(
        f"{observations.source}: rows stand twice, under new numbers of points: {copy.equal} rows of replication "
        f"{_names(observations.replication[copied])} (points {_names(observations.point[copied])}) have attitudes and "
        f"outputs of replication {_names(observations.replication[of])} (points {_names(observations.point[of])}) to "
        "the last digit, which scatter otherwise and show no step of a meter; nothing was solved; what was measured "
        "once tells its noise once: give every row once"
    )


def _names(labels: IntArray) -> str:
    found = np.unique(labels).tolist()
    return str(found[0]) if len(found) == 1 else f"{found[0]} to {found[-1]}"


def _by_attitude(observations: Observations) -> Observations | None:
    """Return the rows with a point for each attitude, and a replication for each time that it was met in one.

    None where the points are the attitudes, or too few rows repeat in all outputs for a copy.
    """
    outputs = np.column_stack(list(observations.outputs.values()))
    if observations.rows - np.unique(outputs, axis=0).shape[0] < _FEWEST_IN_COMMON:
        return None
    _, attitude = np.unique(_conditions(observations), axis=0, return_inverse=True)
    pairs = np.unique(np.column_stack([attitude, observations.point]), axis=0)
    if pairs.shape[0] == np.unique(attitude).size == np.unique(observations.point).size:
        return None
    _, replication = np.unique(observations.replication, return_inverse=True)
    order = np.lexsort((np.arange(observations.rows), attitude, replication))
    begins = np.flatnonzero(
        np.concatenate([[True], np.any(np.diff([replication[order], attitude[order]], axis=1) != 0, axis=0)])
    )
    times = np.empty(observations.rows, dtype=np.int64)
    times[order] = np.arange(observations.rows) - np.repeat(begins, np.diff([*begins, observations.rows]))
    return replace(observations, point=attitude, replication=replication * (int(times.max()) + 1) + times)


def _conditions(observations: Observations) -> FloatArray:
    """Return (N, c) what was set in a row: attitude, rates, known level."""
    known = (observations.yaw_rad, observations.euler_rate_rad_s, observations.reference_level)
    return np.column_stack(
        [observations.pitch_rad, observations.roll_rad, *(values for values in known if values is not None)]
    )


def _copies(observations: Observations) -> Iterator[tuple[int, _Copy]]:
    """Yield a replication, and which other it is a copy of."""
    pairs = list(_repeating(observations))
    rows = {label: _by_point(observations, label) for label in {*chain.from_iterable(pairs)}}
    done: set[int] = set()
    for first, second in pairs:
        if second in done:
            continue
        common = sorted(rows[first].keys() & rows[second].keys())
        if len(common) < _FEWEST_IN_COMMON:
            continue
        here, there = (np.array([rows[label][point] for point in common]) for label in (first, second))
        copied = _copied(observations, first, here, there)
        if copied is not None:
            done.add(second)
            yield second, copied


def _repeating(observations: Observations) -> Iterator[tuple[int, int]]:
    """Yield the pairs of replications of which an output repeats at so many points that one may be a copy, in order."""
    labels, replication = np.unique(observations.replication, return_inverse=True)
    points, point = np.unique(observations.point, return_inverse=True)
    grids = []
    for values in observations.outputs.values():
        if np.ptp(values) > 0.0:
            grid = np.full((labels.size, points.size), np.nan)
            grid[replication, point] = values
            grids.append(grid)
    for first, label in enumerate(labels.tolist()):
        repeat = np.zeros(labels.size - first - 1, dtype=bool)
        for grid in grids:
            repeat |= np.count_nonzero(grid[first + 1 :] == grid[first], axis=1) >= _FEWEST_IN_COMMON
        for other in labels[first + 1 :][repeat].tolist():
            yield label, other


def _copied(observations: Observations, first: int, here: IntArray, there: IntArray) -> _Copy | None:
    outputs = observations.outputs
    equal = {axis: values[here] == values[there] for axis, values in outputs.items() if np.ptp(values[here]) > 0.0}
    repeats_of = {axis: _repeats(outputs[axis], here, same) for axis, same in equal.items()}
    if not any(repeats >= min(LEAST_POINTS, here.size) for repeats in repeats_of.values()):
        return None
    basis = _smooth(observations, here)
    others = np.setdiff1d(np.arange(observations.rows), np.concatenate([here, there]))
    chances = {
        axis: chance
        for axis in equal
        if (chance := _chance(outputs[axis][here], basis, _scatter_of(observations, axis, first, others))) is not None
    }
    if not chances:
        return None
    whole = tuple(
        axis
        for axis, chance in chances.items()
        if repeats_of[axis] >= _NEARLY_ALL * here.size and chance.probability ** repeats_of[axis] < _IMPOSSIBLE
    )
    if whole:
        both = np.logical_and.reduce([equal[axis] for axis in whole])
        still = [axis for axis in equal if axis not in chances and np.mean(equal[axis]) >= _NEARLY_ALL]
        is_all = len(whole) + len(still) == len(equal)
        return _Copy(first, tuple(outputs) if is_all else whole, int(both.sum()), here.size)
    together = np.logical_and.reduce(list(equal.values()))
    chances = {axis: chance for axis, chance in chances.items() if not chance.explains(outputs[axis][here][together])}
    if len(chances) <= 1:
        return None
    repeats = min(_repeats(outputs[axis], here, together) for axis in chances)
    expected = here.size * min(chance.probability for chance in chances.values())
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


def _scatter_of(observations: Observations, axis: str, first: int, others: IntArray) -> float:
    """Return by how much an output of one replication differs from the others', as a standard deviation; 0: by nothing.

    The median of absolute differences, so that others which are copies too and dwells that stand out tell little.
    """
    values, of_first = observations.outputs[axis], _by_point(observations, first)
    points = observations.point[others].tolist()
    paired = [(row, of_first[point]) for row, point in zip(others.tolist(), points, strict=True) if point in of_first]
    if not paired:
        return 0.0
    differences = np.abs(np.subtract(*values[np.array(paired).T]))
    return float(SD_PER_MEDIAN_DEVIATION * np.median(differences) / np.sqrt(2.0))


def _chance(read: FloatArray, basis: FloatArray, between: float) -> _Chance | None:
    """Return how probable it is that a reading repeats to the last digit; None where the readings do not tell it.

    ``between``: the scatter that other replications tell.
    """
    is_smooth = basis.shape[1] < read.size
    basis = basis if is_smooth else basis[:, :_LINE]
    left = read - basis @ np.linalg.lstsq(basis, read, rcond=None)[0]
    apart, span = float(np.sqrt(np.mean(left**2))), float(np.ptp(read))
    scatter = apart if is_smooth or between == 0.0 else between
    coarsest = _LEAST_STEP * scatter if is_smooth or between > 0.0 else _NO_STEP * span
    step = common_step(read, GRID * span)
    if apart <= _EXACT * span or step >= coarsest:
        return None
    return _Chance(float(step / (2.0 * np.sqrt(np.pi) * scatter)), coarsest, GRID * span)
