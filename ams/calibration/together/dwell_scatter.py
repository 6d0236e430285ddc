"""What single dwells are held against: the scatter of all, or of their own replication where these scatter unevenly.

A dwell of a loud replication stands out of all dwells together, and in no way out of those that were measured with it.
Residuals about points and replications have leverages h times the same variance in every dwell of a replication,
whatever the others scatter by: σ² of its own less 1/n of what its own has of the mean, and 1/n² of each other's. The
squares of one replication over the sum of its h tell that variance, with as many degrees of freedom as points remain
beside the model. Whether the replications differ is asked by their variances (Bartlett 1937).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.residuals import GridResiduals
from ams.arrays import FloatArray
from ams.statistics.distributions import chi_square_tail

_TINY: Final = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class DwellScatter:
    """Of m outputs over n K dwells, squares over their leverages."""

    variance: FloatArray
    """(n K, m) by all dwells."""
    without: FloatArray
    """(n K, m) by all but the one."""
    dof: float
    """Of the least certain variance, by all dwells."""


def scatter_of_all(grid: GridResiduals) -> DwellScatter:
    """Return the scatter of all dwells together, the same for each."""
    variance = np.maximum(grid.squares / grid.dof, _TINY)
    without = (grid.squares - _squares_of_dwells(grid)) / (grid.dof - 1)
    return DwellScatter(np.broadcast_to(variance, without.shape), np.maximum(without, _TINY), float(grid.dof))


def scatter_of_replications(grid: GridResiduals) -> DwellScatter:
    """Return the scatter of each dwell's replication."""
    squares, leverages, numbers = _of_replications(grid)
    share, points = float(leverages.sum() / numbers.sum()), grid.points
    variance = squares / np.maximum(leverages, _TINY)[:, None]
    left = np.maximum(leverages - share, _TINY)[:, None]
    without = (np.repeat(squares, points, axis=0) - share * _squares_of_dwells(grid)) / np.repeat(left, points, axis=0)
    return DwellScatter(
        np.maximum(np.repeat(variance, points, axis=0), _TINY), np.maximum(without, _TINY), float(numbers.min())
    )


def chances_of_even_scatter(grid: GridResiduals) -> FloatArray:
    """Return (m,) the chance that replications which scatter alike differ by so much; one where nothing scatters.

    Residuals of n replications are correlated by −1/(n − 1) of each other, which makes it a little too large; of two
    they are the same, and it is one.
    """
    squares, leverages, numbers = _of_replications(grid)
    known = numbers > 1.0
    if np.count_nonzero(known) < 2:
        return np.ones(grid.squares.size)
    squares, numbers = squares[known], numbers[known, None]
    variance = np.maximum(squares / leverages[known, None], _TINY)
    pooled = np.sum(numbers * variance, axis=0) / numbers.sum()
    spread = np.sum(numbers * np.log(pooled / variance), axis=0)
    between = float(numbers.size - 1)
    correction = 1.0 + (float(np.sum(1.0 / numbers)) - 1.0 / float(numbers.sum())) / (3.0 * between)
    return np.where(grid.squares > 0.0, chi_square_tail(np.maximum(spread, 0.0) / correction, between), 1.0)


def _of_replications(grid: GridResiduals) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (n, m) sums of squares of each replication, (n,) of their leverages, and (n,) degrees of freedom."""
    replications = grid.replications
    residuals = grid.residuals.reshape(replications, grid.points, -1)
    leverages = grid.leverages.reshape(replications, grid.points).sum(axis=1)
    share = 1.0 - 1.0 / replications if replications > 1 else 1.0
    return np.einsum("nkm,nkm->nm", residuals, residuals), leverages, leverages / share


def _squares_of_dwells(grid: GridResiduals) -> FloatArray:
    """Return (n K, m) what each dwell alone has of the squares."""
    return np.asarray(grid.residuals**2 * grid.weights[:, None])
