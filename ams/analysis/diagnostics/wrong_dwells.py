"""Is a dwell simply wrong? Studentised residuals, the largest first, Bonferroni over the dwells.

The largest |t| is held against Student's distribution with the other dwells' own scatter (externally studentised); a
dwell that is convicted is taken out and the next largest looked at, so that one wrong dwell convicts no neighbour: it
leaves a part of itself in every other replication of its point. Several hide each other in the scatter that they make:
where the tails are longer than the median deviation has them, dwells are taken out further, and all up to the last that
is significant are convicted (Rosner 1983). Where the points are few, most of a wrong dwell passes
for a change of the parameters of its replication: there the replications are taken to differ by their offset alone,
unless what is left without the dwell shows that they do not.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.residuals import GridResiduals
from ams.arrays import FloatArray, IntArray
from ams.inputs.step_of_readings import step_of
from ams.statistics.distributions import MEDIAN_EFFICIENCY, binomial_tail, f_tail
from ams.statistics.intervals import t_factor

LEAST_DOF = 4
"""Degrees of freedom that are needed to hold a dwell against the others."""
LARGEST_SHARE = 0.1
"""Of the dwells: when more than these are convicted, it is no matter of single dwells."""
_LARGEST_SHARE_OF_REPLICATION: Final = 0.25
"""The same of one replication's dwells: that was noisy as a whole. Two are never too many."""
_LONG_TAILS: Final = 1.2
"""Standard deviation over that of the median, from which on dwells may hide each other; it is judged by no more."""
_FAR: Final = 4.0
"""Standard deviations by the median: of normal noise one dwell in 16 000 is further off."""
_STEPS: Final = 1.5
"""Of a meter, by which a dwell is off at least."""
_TINY: Final = float(np.finfo(float).tiny)
_UNSTEADY: Final = 0.05
"""Chance of what differs between replications beside their offsets: where it is less, they differ by more."""


@dataclass(frozen=True)
class WrongDwells:
    """Of one output."""

    p_value: float
    """The least, over all dwells that were looked at."""
    dwells: tuple[int, ...]
    """Convicted, in the order of their sizes."""
    sizes: tuple[float, ...]
    """How far each reads off what the others say, in the output's unit."""
    deviations: tuple[float, ...]
    """The same in standard deviations of a dwell."""
    left: GridResiduals
    """What the others say."""


def largest_p_values(residuals: GridResiduals) -> tuple[FloatArray, IntArray]:
    """Return (m,) the Bonferroni-corrected p-value of the largest studentised residual, and its dwell."""
    squares, dof = residuals.squares, residuals.dof
    size = squares.size
    if dof < LEAST_DOF:
        return np.full(size, np.nan), np.zeros(size, dtype=np.int64)
    share = np.square(residuals.residuals)
    share *= residuals.weights[:, None]
    index = np.argmax(share, axis=0)
    largest = share[index, np.arange(size)]
    rest = np.maximum(squares - largest, _TINY)
    with np.errstate(over="ignore"):
        t_square = largest * (dof - 1) / rest
    pairs = 2 if residuals.replications == 2 else 1  # of two, both are as far from their mean
    p_value = np.count_nonzero(residuals.judged) / pairs * f_tail(t_square, 1.0, float(dof - 1))
    return np.where(squares > 0.0, np.minimum(p_value, 1.0), np.nan), index


def least_p_value(residuals: GridResiduals, first: float, enough: float, readings: FloatArray) -> float:
    """Return the least corrected p-value over the dwells of one output, the largest taken out one after the other.

    ``first``: that of the largest of all. No further dwell is looked at once one has ``enough``.
    ``readings`` (N,) say by what a dwell is off at least, where they show a meter's step.
    """
    if not (first <= enough or _has_long_tails(residuals)):
        return first
    least_size = _least_size(readings)
    least = _chance_of_far(residuals, least_size)
    for p_value, _, left in _after_each_other(residuals, least_size):
        least = min(least, p_value)
        if least <= enough or not _has_long_tails(left):
            break
    return least


def _least_size(readings: FloatArray) -> float:
    """Return the least by which a dwell is off: a reading that is rounded the other way is as far as one step."""
    return _STEPS * (step_of(readings) or 0.0)


def _has_long_tails(residuals: GridResiduals) -> bool:
    """Return whether dwells scatter by more than their median deviation says, so that some may hide in it."""
    if residuals.dof < LEAST_DOF:
        return False
    return float(residuals.squares[0]) > residuals.dof * (_LONG_TAILS * residuals.typical_sd) ** 2


def _after_each_other(
    residuals: GridResiduals, least_size: float, other_view: FloatArray | None = None
) -> Iterator[tuple[float, int, GridResiduals]]:
    """Yield the p-value of the dwell that stands out most, its number, and what it is among; then the same without it.

    As many as may be convicted, and one more; none that is off by less than the least. ``other_view``: as in
    :func:`convict`.
    """
    left = residuals
    for _ in range(_most(residuals) + 1):
        p_values, indices = largest_p_values(left)
        dwell = int(indices[0]) if other_view is None else _of_two(int(indices[0]), left, other_view)
        if not (np.isfinite(p_values[0]) and abs(left.reads_off(dwell)) > least_size):
            return
        yield float(p_values[0]), dwell, left
        left = left.without(dwell)


def _most(residuals: GridResiduals) -> int:
    """Return how many dwells may be convicted."""
    return max(1, int(LARGEST_SHARE * residuals.present.sum()))


def _chance_of_far(residuals: GridResiduals, least_size: float) -> float:
    """Return the chance that more dwells are far off than may be convicted; 1 where no more are."""
    far = np.maximum(_FAR * residuals.typical_sd, least_size * residuals.spread)
    count = int(np.count_nonzero(residuals.away > far))
    if count <= _most(residuals):
        return 1.0
    chance = float(f_tail(_FAR**2, 1.0, max(MEDIAN_EFFICIENCY * residuals.dof, 1.0)))
    return float(binomial_tail(count, int(np.count_nonzero(residuals.judged)), chance))


def judged_by(grid: GridResiduals, steady: GridResiduals | None) -> GridResiduals:
    """Return what the dwells of one output are judged by: ``steady``, where the replications differ by an offset alone.

    They do where without the dwell that stands out most they show no need of more parameters, and where that dwell, if
    it stands out by more than chance, explains more than all parameters of its own replication.
    """
    if steady is None or steady.dof < LEAST_DOF:
        return grid
    p_value, largest = largest_p_values(steady)
    dwell = int(largest[0])
    without, freely = steady.without(dwell), grid.without(dwell)
    dof, left = without.dof - freely.dof, float(freely.squares[0]) / max(freely.dof, 1)
    if dof < 1 or not left > 0.0:
        return grid
    f = max(float(without.squares[0] - freely.squares[0]), 0.0) / dof / left
    if f_tail(f, float(dof), float(max(freely.dof, 1))) <= _UNSTEADY:
        return grid
    of_replication = np.zeros((steady.replications, steady.points, grid.q.shape[1]))
    of_replication[dwell // steady.points] = grid.q
    beside_it = steady.beside(of_replication.reshape(-1, grid.q.shape[1]))
    return grid if p_value[0] <= _UNSTEADY and beside_it.squares[0] < without.squares[0] else steady


def smallest_detected(judged: GridResiduals, level: float) -> float:
    """Return how many standard deviations of a dwell one must be off to be convicted more often than not, at the worst.

    NaN where no dwell is judged.
    """
    leverages = judged.leverages[judged.judged]
    if judged.dof < LEAST_DOF or leverages.size == 0:
        return float("nan")
    pairs = 2 if judged.replications == 2 else 1
    bound = t_factor(1.0 - level * pairs / leverages.size, float(judged.dof - 1))
    return bound / float(np.sqrt(leverages.min()))


def convict(residuals: GridResiduals, level: float, other_view: FloatArray, readings: FloatArray) -> WrongDwells:
    """Return the dwells of one output that are wrong at a level; none where they are too many for single ones.

    ``other_view`` (n K,) are residuals with no effects of points: of two replications they say which one is wrong.
    ``readings`` (N,): as in :func:`least_p_value`.
    """
    steps: list[tuple[int, GridResiduals]] = []
    least_size = _least_size(readings)
    of_far = _chance_of_far(residuals, least_size)
    least, last = of_far, 0
    for p_value, dwell, left in _after_each_other(residuals, least_size, other_view):
        least = min(least, p_value)
        if not (p_value <= level or _has_long_tails(left)):
            break
        steps.append((dwell, left))
        last = len(steps) if p_value <= level else last
    wrong = steps[:last]
    left = wrong[-1][1].without(wrong[-1][0]) if wrong else residuals
    more_are_far = of_far <= level and _has_long_tails(left)
    if more_are_far or last > _most(residuals) or _is_of_a_replication(wrong):
        wrong, left = [], residuals
    sd = np.sqrt(left.squares[0] / max(left.dof, 1))
    sizes = tuple(before.reads_off(dwell) for dwell, before in wrong)
    in_deviations = tuple(size / sd if sd > 0.0 else np.inf for size in sizes)
    return WrongDwells(least, tuple(dwell for dwell, _ in wrong), sizes, in_deviations, left)


def _is_of_a_replication(steps: Sequence[tuple[int, GridResiduals]]) -> bool:
    """Return whether one replication has so many of these dwells that it was noisy as a whole."""
    if not steps:
        return False
    first = steps[0][1]
    replication = np.array([dwell for dwell, _ in steps]) // first.points
    wrong = np.bincount(replication, minlength=first.replications)
    present = first.present.reshape(first.replications, first.points).sum(axis=1)
    return bool(np.any(wrong > np.maximum(_LARGEST_SHARE_OF_REPLICATION * present, 2)))


def _of_two(dwell: int, left: GridResiduals, other_view: FloatArray) -> int:
    if left.replications != 2:
        return dwell
    other = (dwell + left.points) % (2 * left.points)
    return dwell if abs(other_view[dwell]) >= abs(other_view[other]) else other
