"""Is a dwell simply wrong? Studentised residuals, the largest first, Bonferroni over the dwells.

The largest |t| is held against Student's distribution with the other dwells' own scatter (externally studentised); a
dwell that is convicted is taken out and the next largest looked at, so that one wrong dwell convicts no neighbour: it
leaves a part of itself in every other replication of its point.
"""

from dataclasses import dataclass

import numpy as np

from ams.analysis.diagnostics.residuals import GridResiduals
from ams.arrays import FloatArray, IntArray
from ams.statistics.distributions import f_tail

LEAST_DOF = 4
LARGEST_SHARE = 0.1
"""Of the dwells: when more than these are convicted, it is no matter of single dwells."""


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
    leverages, squares, dof = residuals.leverages, residuals.squares, residuals.dof
    size = squares.size
    if dof < LEAST_DOF:
        return np.full(size, np.nan), np.zeros(size, dtype=np.int64)
    judged = leverages > 0.0
    share = np.square(residuals.residuals)
    share *= np.divide(1.0, leverages, out=np.zeros_like(leverages), where=judged)[:, None]
    index = np.argmax(share, axis=0)
    largest = share[index, np.arange(size)]
    rest = np.maximum(squares - largest, np.finfo(float).tiny)
    with np.errstate(over="ignore"):
        t_square = largest * (dof - 1) / rest
    pairs = 2 if residuals.replications == 2 else 1  # of two, both are as far from their mean
    p_value = np.count_nonzero(judged) / pairs * f_tail(t_square, 1.0, float(dof - 1))
    return np.where(squares > 0.0, np.minimum(p_value, 1.0), np.nan), index


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
        column = left.column(dwell)
        deviations.append(float(left.residuals[dwell, 0] / column[dwell]))
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
