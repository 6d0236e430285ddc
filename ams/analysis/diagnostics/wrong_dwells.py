"""Is a dwell simply wrong? Studentised residuals, the largest first, Bonferroni over the dwells.

The largest |t| is held against Student's distribution with the other dwells' own scatter (externally studentised); a
dwell that is convicted is taken out and the next largest looked at, so that one wrong dwell convicts no neighbour: it
leaves a part of itself in every other replication of its point. Where the points are few, most of a wrong dwell passes
for a change of the parameters of its replication: there the replications are taken to differ by their offset alone,
unless what is left without the dwell shows that they do not.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.residuals import GridResiduals
from ams.arrays import FloatArray, IntArray
from ams.statistics.distributions import f_tail
from ams.statistics.intervals import t_factor

LEAST_DOF = 4
"""Degrees of freedom that are needed to hold a dwell against the others."""
LARGEST_SHARE = 0.1
"""Of the dwells: when more than these are convicted, it is no matter of single dwells."""
_TINY: Final = float(np.finfo(float).tiny)
_UNSTEADY: Final = 0.05
"""Chance of what differs between replications beside their offsets: where it is less, they differ by more."""


@dataclass(frozen=True)
class WrongDwells:
    """Of one output."""

    p_value: float
    """Of the largest, over all dwells; NaN where nothing is left to judge by."""
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


def convict(residuals: GridResiduals, level: float, other_view: FloatArray) -> WrongDwells:
    """Return the dwells of one output that are wrong at a level, one after the other.

    ``other_view`` (n K,) are residuals with no effects of points: of two replications they say which one is wrong.
    """
    first: float | None = None
    dwells: list[int] = []
    deviations: list[float] = []
    left = residuals
    most = max(1, int(LARGEST_SHARE * residuals.present.sum()))
    while len(dwells) <= most:
        p_values, indices = largest_p_values(left)
        first = float(p_values[0]) if first is None else first
        if not p_values[0] <= level:
            break
        dwell = _of_two(int(indices[0]), left, other_view)
        dwells.append(dwell)
        deviations.append(left.reads_off(dwell))
        left = left.without(dwell)
    if len(dwells) > most:
        dwells, deviations, left = [], [], residuals
    sd = np.sqrt(left.squares[0] / max(left.dof, 1))
    in_deviations = tuple(size / sd if sd > 0.0 else np.inf for size in deviations)
    return WrongDwells(float("nan") if first is None else first, tuple(dwells), tuple(deviations), in_deviations, left)


def _of_two(dwell: int, left: GridResiduals, other_view: FloatArray) -> int:
    if left.replications != 2:
        return dwell
    other = (dwell + left.points) % (2 * left.points)
    return dwell if abs(other_view[dwell]) >= abs(other_view[other]) else other
