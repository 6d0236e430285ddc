"""Limits of Student's t and of χ², for the decisions that a run makes about its own readings."""

from functools import lru_cache
from math import sqrt

import numpy as np

from ams.arrays import FloatArray
from ams.statistics.distributions import chi_square_quantile, student_t_quantile


@lru_cache(maxsize=256)
def t_limit(degrees_of_freedom: int, false_alarm: float) -> float:
    """|t| that chance alone exceeds with probability ``false_alarm`` (two-sided)."""
    return float(-student_t_quantile(false_alarm / 2.0, degrees_of_freedom))


@lru_cache(maxsize=256)
def small_variance_ratio(degrees_of_freedom: int, false_alarm: float) -> float:
    """s²/σ² that chance alone falls below with probability ``false_alarm``."""
    return float(chi_square_quantile(false_alarm, degrees_of_freedom) / degrees_of_freedom)


@lru_cache(maxsize=256)
def median_variance_ratio(degrees_of_freedom: int) -> float:
    """Median of s²/σ² for normal readings: below 1, far below for few degrees of freedom."""
    return small_variance_ratio(degrees_of_freedom, 0.5)


def has_slope(times_s: FloatArray, values: FloatArray, false_alarm: float) -> bool:
    """Return True where a straight line over time explains more than scatter would."""
    degrees = values.size - 2
    if degrees < 1:
        return False
    centred_s, centred = times_s - times_s.mean(), values - values.mean()
    spread = float(centred_s @ centred_s)
    if spread == 0.0:
        return False
    slope = float(centred_s @ centred) / spread
    rest = centred - slope * centred_s
    error = sqrt(max(float(rest @ rest), _rounding_v2(values)) / degrees / spread)
    return abs(slope) > t_limit(degrees, false_alarm) * error


def _rounding_v2(values: FloatArray) -> float:
    """Sum of squares that the arithmetic itself may leave in readings that are all the same."""
    return float(values.size * (4.0 * np.finfo(float).eps * np.abs(values).max()) ** 2)
