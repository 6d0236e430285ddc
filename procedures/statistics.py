"""Limits of Student's t and of χ², for the decisions that a run makes about its own readings."""

from functools import lru_cache
from math import exp, lgamma, log, sqrt

import numpy as np

from ams.arrays import FloatArray
from ams.statistics.distributions import chi_square_quantile, f_quantile, student_t_quantile


@lru_cache(maxsize=256)
def t_limit(degrees_of_freedom: int, false_alarm: float) -> float:
    """Return |t| that chance alone exceeds with probability ``false_alarm`` (two-sided)."""
    return float(-student_t_quantile(false_alarm / 2.0, degrees_of_freedom))


@lru_cache(maxsize=256)
def small_variance_ratio(degrees_of_freedom: int, false_alarm: float) -> float:
    """Return s²/σ² that chance alone falls below with probability ``false_alarm``."""
    return float(chi_square_quantile(false_alarm, degrees_of_freedom) / degrees_of_freedom)


@lru_cache(maxsize=256)
def median_variance_ratio(degrees_of_freedom: int) -> float:
    """Return the median of s²/σ² for normal readings: below 1, far below for few degrees of freedom."""
    return small_variance_ratio(degrees_of_freedom, 0.5)


@lru_cache(maxsize=256)
def degrees_of_median(degrees_of_freedom: int) -> float:
    """Return the degrees of freedom that one dwell brings to a variance learnt as the median over dwells.

    The median of K values of density f has the variance 1 / (4 K f²) at it; the χ² of that relative variance has 8 K
    (m f)² degrees of freedom. For many readings that is 2/π of what pooling them would bring.
    """
    half = degrees_of_freedom / 2.0
    median = float(chi_square_quantile(0.5, degrees_of_freedom))
    return 8.0 * exp(half * log(median / 2.0) - median / 2.0 - lgamma(half)) ** 2


@lru_cache(maxsize=4096)
def large_deviation_ratio(degrees_of_freedom: int, reference_degrees: float, false_alarm: float) -> float:
    """s/s₀ that chance alone exceeds with probability ``false_alarm``, where s₀ was learnt from readings as well."""
    return sqrt(float(f_quantile(1.0 - false_alarm, degrees_of_freedom, reference_degrees)))


FEWEST_DEGREES_SLOPE = 2
"""Beside a line. Three readings leave one, and no noise: rounded to a meter's digits they lie on a line by chance."""


def has_slope(times_s: FloatArray, values: FloatArray, false_alarm: float, least_error: float = 0.0) -> bool:
    """Return True where a straight line over time explains more than scatter would.

    ``least_error``: how far the line must rise at least, as the root of the sum of squares about its mean: what the
    noise known from elsewhere would do by chance.
    """
    degrees = values.size - 2
    if degrees < FEWEST_DEGREES_SLOPE:
        return False
    centred_s, centred = times_s - times_s.mean(), values - values.mean()
    spread = float(centred_s @ centred_s)
    if spread == 0.0:
        return False
    slope = float(centred_s @ centred) / spread
    rest = centred - slope * centred_s
    error = sqrt(max(float(rest @ rest), _rounding_v2(values)) / degrees / spread)
    return abs(slope) > max(t_limit(degrees, false_alarm) * error, least_error / sqrt(spread))


def _rounding_v2(values: FloatArray) -> float:
    """Sum of squares that the arithmetic itself may leave in readings that are all the same."""
    return float(values.size * (4.0 * np.finfo(float).eps * np.abs(values).max()) ** 2)
