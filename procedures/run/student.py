"""Limits of Student's t and of χ², for the decisions that a run makes about its own readings."""

from functools import lru_cache


@lru_cache(maxsize=256)
def t_limit(degrees_of_freedom: int, false_alarm: float) -> float:
    """|t| that chance alone exceeds with probability ``false_alarm`` (two-sided)."""
    from scipy.special import stdtrit

    return float(-stdtrit(degrees_of_freedom, false_alarm / 2.0))


@lru_cache(maxsize=256)
def small_variance_ratio(degrees_of_freedom: int, false_alarm: float) -> float:
    """s²/σ² that chance alone falls below with probability ``false_alarm``."""
    from scipy.special import gammaincinv

    return float(2.0 * gammaincinv(degrees_of_freedom / 2.0, false_alarm) / degrees_of_freedom)


@lru_cache(maxsize=256)
def median_variance_ratio(degrees_of_freedom: int) -> float:
    """Median of s²/σ² for normal readings: below 1, far below for few degrees of freedom."""
    return small_variance_ratio(degrees_of_freedom, 0.5)
