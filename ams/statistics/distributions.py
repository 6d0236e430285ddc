"""Quantiles and tails of the distributions that intervals and tests use.

The one place that loads scipy.special, at the first call: importing the mathematics costs numpy alone, and a
coefficient set is applied, and turned into angles, without scipy. Everything broadcasts as numpy does.
"""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ams.arrays import FloatArray
from ams.errors import SolveError
from ams.statistics import without_scipy

if TYPE_CHECKING:
    from types import ModuleType

SD_PER_MEDIAN_DEVIATION = 1.4826
"""Of a normal variable, the standard deviation by the median of its distance from the median: 1/Φ⁻¹(3/4)."""

MEDIAN_EFFICIENCY = 0.37
"""Degrees of freedom of a standard deviation by the median over those of one by the squares."""


@cache
def _special() -> "ModuleType":
    try:
        import scipy.special  # 0.3 s, and not needed before the first interval
    except ImportError:
        return without_scipy
    special: ModuleType = scipy.special
    return special


def _called(function: str, *arguments: ArrayLike) -> FloatArray:
    known = getattr(_special(), function, None)
    if known is None:
        raise SolveError(
            "tests and intervals of a calibration need scipy, which is not installed; nothing was solved; "
            "pip install scipy (a coefficient set is read, checked, applied and turned into angles without it)"
        )
    return np.asarray(known(*arguments), dtype=np.float64)


def student_t_quantile(probability: ArrayLike, degrees_of_freedom: ArrayLike) -> FloatArray:
    """Return t with P(T ≤ t) = ``probability``."""
    return _called("stdtrit", degrees_of_freedom, probability)


def student_t_degrees_of_freedom(probability: ArrayLike, quantile: ArrayLike) -> FloatArray:
    """Return the degrees of freedom at which Student's quantile of ``probability`` is ``quantile``."""
    return _called("stdtridf", probability, quantile)


def normal_quantile(probability: ArrayLike) -> FloatArray:
    """Return z with P(Z ≤ z) = ``probability``."""
    return _called("ndtri", probability)


def normal_share(z: ArrayLike) -> FloatArray:
    """Return P(Z ≤ ``z``)."""
    return _called("ndtr", z)


def normal_density(z: ArrayLike) -> FloatArray:
    """Return the density of Z at ``z``."""
    return np.asarray(np.exp(-0.5 * np.square(z)) / np.sqrt(2.0 * np.pi), dtype=np.float64)


def f_quantile(probability: ArrayLike, numerator_dof: ArrayLike, denominator_dof: ArrayLike) -> FloatArray:
    """Return f with P(F ≤ f) = ``probability``."""
    return _called("fdtri", numerator_dof, denominator_dof, probability)


def f_tail(ratio: ArrayLike, numerator_dof: ArrayLike, denominator_dof: ArrayLike) -> FloatArray:
    """Return P(F > ``ratio``)."""
    return _called("fdtrc", numerator_dof, denominator_dof, ratio)


def chi_square_quantile(probability: ArrayLike, degrees_of_freedom: ArrayLike) -> FloatArray:
    """Return x with P(χ² ≤ x) = ``probability``."""
    return 2.0 * _called("gammaincinv", np.asarray(degrees_of_freedom) / 2.0, probability)


def chi_square_upper_quantile(tail: ArrayLike, degrees_of_freedom: ArrayLike) -> FloatArray:
    """Return x with P(χ² > x) = ``tail``."""
    return _called("chdtri", degrees_of_freedom, tail)


def chi_square_tail(value: ArrayLike, degrees_of_freedom: ArrayLike) -> FloatArray:
    """Return P(χ² > ``value``)."""
    return _called("chdtrc", degrees_of_freedom, value)


def binomial_tail(least: int, trials: int, chance: float) -> FloatArray:
    """Return the probability of ``least`` successes or more."""
    return _called("bdtrc", least - 1, trials, chance)


def digamma(value: ArrayLike) -> FloatArray:
    """Return the logarithmic derivative of the gamma function."""
    return _called("psi", value)


def trigamma(value: ArrayLike) -> FloatArray:
    """Return the second logarithmic derivative of the gamma function."""
    return _called("polygamma", 1, value)


def median(values: FloatArray) -> float:
    """Return the median of finite values: numpy's also looks for NaN, at three times the price."""
    half = values.size // 2
    parted = np.partition(values, half)
    return float(parted[half] if values.size % 2 else 0.5 * (parted[:half].max() + parted[half]))
