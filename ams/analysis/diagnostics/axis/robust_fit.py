"""A robust fit beside the estimate: by how much dwells that stand out a little, and to one side, have moved it.

Huber's estimate with k = 1.345 (95 % efficient where nothing is wrong) beside effects of points and replications: what
a dwell reads beyond k standard deviations is taken from it, until nothing changes. The fit of what was taken, averaged
over the replications, is the difference to the estimate, and its mean over the points, where readings that are wrong to
one side act, is tested. Dwells that are wrong to one side feed how what was taken scatters as well, so that it is not
held against that: of the two sides, the one that less was taken from tells how long the tails are without them, and of
normal noise the median deviation tells it. The longer tails count. Of normal noise the standard deviation is 0.25 of
that of a dwell over the root of the number of dwells, or a little less, from three replications of a dozen points on
(simulated; Huber's efficiency alone says √(1/0.95 − 1) = 0.23). Two replications are as far from their mean as each
other and say nothing.
Source: Huber (1981), 7.8, winsorised residuals.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.time_order import LEAST_DOF
from ams.arrays import FloatArray
from ams.remembered import remembered
from ams.statistics.distributions import MEDIAN_EFFICIENCY, f_tail

_K: Final = 1.345
"""Standard deviations from which on a dwell counts for less: 95 % efficient for normal noise. Source: Huber (1964)."""
_ROUNDS: Final = 5
"""Each leaves a fifth of what the last one changed."""
_LEAST_REPLICATIONS: Final = 3
_SD_OF_NORMAL: Final = 0.25
"""Of the difference, for noise and a number of dwells of one."""
_SD_OF_TAILS: Final = 0.88
"""Of the difference, over the root of the sum of squares of what was taken: the fit takes a part of it back."""


@dataclass(frozen=True)
class RobustFit:
    """Of one output."""

    p_value: float
    size: float
    """Robust less ordinary fit in the mean over the points, in the output's unit."""
    expected: float
    """Standard deviation of that by chance."""


def robust_fit(evidence: Evidence, grid: GridResiduals) -> RobustFit | None:
    """Return the difference of a robust fit; None where too few replications or dwells tell it."""
    if evidence.sums is None or grid.replications < _LEAST_REPLICATIONS or grid.dof < LEAST_DOF:
        return None
    taken, sigma = _taken(grid)
    share = _share_of_mean(grid.present, grid.replications)
    of_mean = share * taken
    size = float(of_mean.sum())
    other_side = np.minimum(of_mean, 0.0) if size > 0.0 else np.maximum(of_mean, 0.0)
    of_tails = 2.0 * _SD_OF_TAILS**2 * float(other_side @ other_side)
    variance = max((_SD_OF_NORMAL * sigma) ** 2 * float(share @ share), of_tails)
    if not variance > 0.0:
        return None
    p_value = f_tail(size**2 / variance, 1.0, MEDIAN_EFFICIENCY * grid.dof)
    return RobustFit(float(p_value), -size, float(np.sqrt(variance)))


@remembered(16)
def _share_of_mean(present: FloatArray, replications: int) -> FloatArray:
    """Return (n K,) what every dwell has of the mean over the points, each the mean of its readings."""
    readings = np.maximum(present.reshape(replications, -1).sum(axis=0), 1.0)
    return np.tile(1.0 / (readings * readings.size), replications) * present


def _taken(grid: GridResiduals) -> tuple[FloatArray, float]:
    """Return (n K,) what is taken from every dwell, and the standard deviation of a dwell."""
    plain, sigma = grid.residuals[:, 0], grid.typical_sd
    high = np.where(grid.judged, _K * sigma * grid.spread, np.inf)
    low, left = -high, plain
    for round_ in range(_ROUNDS):
        taken = left - np.minimum(np.maximum(left, low), high)
        if round_ < _ROUNDS - 1:
            left = plain + (taken - grid.projected(taken[:, None])[:, 0])
    return taken, sigma
