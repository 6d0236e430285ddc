"""A robust fit beside the estimate: by how much dwells that stand out a little, and to one side, have moved it.

Huber's estimate with k = 1.345 (95 % efficient where nothing is wrong) beside effects of points and replications: what
a dwell reads beyond k standard deviations is taken from it, until nothing changes. The fit of what was taken, averaged
over the replications, is the difference to the estimate. Its mean over the points, where readings that are wrong to one
side act, is held against how what was taken scatters about that fit from point to point. Two replications are as far
from their mean as each other and say nothing.
Source: Huber (1981), 7.8, winsorised residuals.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.time_order import LEAST_DOF
from ams.arrays import FloatArray
from ams.solve.linear_form import orthogonal
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, f_tail

_K: Final = 1.345
_ROUNDS: Final = 5
"""Each leaves a fifth of what the last one changed."""
_LEAST_REPLICATIONS: Final = 3


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
    taken = _taken(grid)
    readings = np.maximum(grid.present.reshape(grid.replications, -1).sum(axis=0), 1.0)
    by_point = taken.reshape(grid.replications, -1).sum(axis=0) / readings
    q = orthogonal(evidence.basis)[0]
    points, dof = q.shape[0], q.shape[0] - q.shape[1]
    rest, size = float(np.sum((by_point - q @ (q.T @ by_point)) ** 2)), float(np.mean(by_point))
    if dof < LEAST_DOF or not rest > 0.0:
        return None
    variance = rest / dof / points
    return RobustFit(float(f_tail(size**2 / variance, 1.0, float(dof))), -size, float(np.sqrt(variance)))


def _median(values: FloatArray) -> float:
    """Return the median of finite values: numpy's also looks for NaN, at three times the price."""
    half = values.size // 2
    parted = np.partition(values, half)
    return float(parted[half] if values.size % 2 else 0.5 * (parted[:half].max() + parted[half]))


def _taken(grid: GridResiduals) -> FloatArray:
    """Return (n K,) what is taken from every dwell."""
    plain, judged = grid.residuals[:, 0], grid.leverages > 0.0
    spread = np.sqrt(np.where(judged, grid.leverages, 1.0))
    sigma = SD_PER_MEDIAN_DEVIATION * _median(np.abs(plain / spread)[judged])
    high = np.where(judged, _K * sigma * spread, np.inf)
    low, left = -high, plain
    for round_ in range(_ROUNDS):
        taken = left - np.minimum(np.maximum(left, low), high)
        if round_ < _ROUNDS - 1:
            left = plain + (taken - grid.projected(taken[:, None])[:, 0])
    return taken
