"""The quantiles and tails that angles at use need, by NumPy alone, under the names of ``scipy.special``.

A tunnel's computer that turns readings into angles has NumPy and little else. Where scipy is installed it is used;
these agree with it to 1e-10 (tested). Incomplete beta and gamma functions: continued fractions and series of
Abramowitz and Stegun 26.5.8, 6.5.29 and 6.5.31; quantiles: bisection on them.
"""

import math
from collections.abc import Callable
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from ams.arrays import FloatArray

_TINY = 1e-300
_TERMS = 500
_CLOSE = 4e-16
_STEPS = 200
_AS_NORMAL_DOF = 1e9
"""Student's and Fisher's distributions of more degrees of freedom are their limits to the last digits."""

_EXPANDED_DOF = 1e4

_log_gamma = np.vectorize(math.lgamma, otypes=[float])
_erfc = np.vectorize(math.erfc, otypes=[float])
_normal_quantile = np.vectorize(NormalDist().inv_cdf, otypes=[float])


def ndtr(z: ArrayLike) -> FloatArray:
    """Return the normal distribution's share below ``z``."""
    return np.asarray(0.5 * _erfc(-np.asarray(z) / math.sqrt(2.0)), dtype=np.float64)


def ndtri(probability: ArrayLike) -> FloatArray:
    """Return the normal quantile."""
    return np.asarray(_normal_quantile(probability), dtype=np.float64)


def stdtrit(degrees_of_freedom: ArrayLike, probability: ArrayLike) -> FloatArray:
    """Return Student's quantile."""
    dof, p = np.broadcast_arrays(np.asarray(degrees_of_freedom, float), np.asarray(probability, float))
    tail = np.where(p == 0.5, 0.25, np.minimum(p, 1.0 - p))
    finite = np.minimum(dof, _EXPANDED_DOF)

    def excess(log_t: FloatArray) -> FloatArray:
        return 0.5 * _beta_share(finite / 2.0, 0.5, finite / (finite + np.exp(2.0 * log_t))) - tail

    with np.errstate(divide="ignore"):  # between the normal distribution and Cauchy's, or beyond it below one degree
        lowest = np.log(np.abs(ndtri(tail))) - 1e-9
        highest = np.where(finite >= 1.0, np.log(1.0 / np.tan(np.pi * np.maximum(tail, 1e-300))) + 1e-9, 350.0)
    t = np.sign(p - 0.5) * np.exp(_falling_root(excess, lowest, highest))
    return np.where(p == 0.5, 0.0, np.where(dof >= _EXPANDED_DOF, _expanded(ndtri(p), dof), t))


def _expanded(z: FloatArray, dof: FloatArray) -> FloatArray:
    """Return Student's quantile of many degrees of freedom from the normal one (Abramowitz and Stegun 26.7.5)."""
    first, second = (z**3 + z) / 4.0, (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    third = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    return z + first / dof + second / dof**2 + third / dof**3


def fdtrc(numerator_dof: ArrayLike, denominator_dof: ArrayLike, ratio: ArrayLike) -> FloatArray:
    """Return the share of Fisher's distribution above ``ratio``."""
    d1, d2, f = np.broadcast_arrays(*(np.asarray(value, float) for value in (numerator_dof, denominator_dof, ratio)))
    finite = np.minimum(d2, _AS_NORMAL_DOF)
    share = _beta_share(finite / 2.0, d1 / 2.0, finite / (finite + d1 * f))
    return np.where(d2 >= _AS_NORMAL_DOF, chdtrc(d1, d1 * f), share)


def fdtri(numerator_dof: ArrayLike, denominator_dof: ArrayLike, probability: ArrayLike) -> FloatArray:
    """Return Fisher's quantile."""
    d1, d2, p = np.broadcast_arrays(
        *(np.asarray(value, float) for value in (numerator_dof, denominator_dof, probability))
    )
    log_f = _falling_root(
        lambda log_f: fdtrc(d1, d2, np.exp(log_f)) - (1.0 - p), np.full(d1.shape, -350.0), np.full(d1.shape, 40.0)
    )
    return np.exp(log_f)


def chdtrc(degrees_of_freedom: ArrayLike, value: ArrayLike) -> FloatArray:
    """Return the share of chi-square above ``value``."""
    dof, x = np.broadcast_arrays(np.asarray(degrees_of_freedom, float), np.asarray(value, float))
    return _gamma_tail(dof / 2.0, x / 2.0)


def chdtri(degrees_of_freedom: ArrayLike, tail: ArrayLike) -> FloatArray:
    """Return what chi-square exceeds with probability ``tail``."""
    dof, wanted = np.broadcast_arrays(np.asarray(degrees_of_freedom, float), np.asarray(tail, float))
    log_x = _falling_root(
        lambda log_x: chdtrc(dof, np.exp(log_x)) - wanted, np.full(dof.shape, -350.0), np.full(dof.shape, 40.0)
    )
    return np.exp(log_x)


def _falling_root(excess: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray) -> FloatArray:
    """Return where ``excess`` falls through zero: the chord of the bracket (Illinois), halved where that lags."""
    above, below = excess(low), excess(high)
    for step in range(_STEPS):
        with np.errstate(divide="ignore", invalid="ignore"):
            chord = high + below * (high - low) / (above - below)
        halved = 0.5 * (low + high)
        between = halved if step % 4 == 3 else np.where((chord > low) & (chord < high), chord, halved)
        value = excess(between)
        is_above = value > 0.0
        above, below = (
            np.where(is_above, value, np.where(is_above, above, 0.5 * above)),
            np.where(is_above, 0.5 * below, value),
        )
        low, high = np.where(is_above, between, low), np.where(is_above, high, between)
        if np.all((high - low <= 1e-14 * (1.0 + np.abs(high))) | (value == 0.0)):
            break
    return between


def _beta_share(a: ArrayLike, b: ArrayLike, x: ArrayLike) -> FloatArray:
    """Return the regularised incomplete beta function I_x(a, b)."""
    a, b, x = np.broadcast_arrays(*(np.asarray(value, float) for value in (a, b, x)))
    turned = x > (a + 1.0) / (a + b + 2.0)
    p, q, y = np.where(turned, b, a), np.where(turned, a, b), np.where(turned, 1.0 - x, x)
    with np.errstate(divide="ignore"):
        log_front = (
            _log_gamma(p + q) - _log_gamma(p) - _log_gamma(q)
            + p * np.log(y) + q * np.log1p(-y) - np.log(p)
        )  # fmt: skip
    share = np.exp(log_front) * _beta_fraction(p, q, y)
    return np.asarray(np.where(turned, 1.0 - share, share), dtype=np.float64)


def _beta_fraction(a: FloatArray, b: FloatArray, x: FloatArray) -> FloatArray:
    """Return the continued fraction 26.5.8 by Lentz's method."""
    c = np.ones_like(x)
    d = 1.0 / _away_from_zero(1.0 - (a + b) * x / (a + 1.0))
    fraction = d
    for m in range(1, _TERMS):
        for term in (
            m * (b - m) * x / ((a + 2 * m - 1.0) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0)),
        ):
            d = 1.0 / _away_from_zero(1.0 + term * d)
            c = _away_from_zero(1.0 + term / c)
            fraction = fraction * d * c
        if np.all(np.abs(d * c - 1.0) < _CLOSE):
            break
    return fraction


def _gamma_tail(a: FloatArray, x: FloatArray) -> FloatArray:
    """Return the regularised upper incomplete gamma function Q(a, x)."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        front = np.exp(a * np.log(x) - x - _log_gamma(a))
        term = total = 1.0 / a
        for n in range(1, _TERMS):
            term = term * x / (a + n)
            total = total + term
            if np.all((term < _CLOSE * total) | (x >= a + 1.0)):
                break
        below = front * total
        b = x + 1.0 - a
        c, d = np.full_like(x, 1.0 / _TINY), 1.0 / _away_from_zero(b)
        fraction = d
        for n in range(1, _TERMS):
            b = b + 2.0
            weight = -n * (n - a)
            d = 1.0 / _away_from_zero(weight * d + b)
            c = _away_from_zero(b + weight / c)
            fraction = fraction * d * c
            if np.all((np.abs(d * c - 1.0) < _CLOSE) | (x < a + 1.0)):
                break
        return np.where(x <= 0.0, 1.0, np.where(x < a + 1.0, 1.0 - below, front * fraction))


def _away_from_zero(value: FloatArray) -> FloatArray:
    return np.where(np.abs(value) < _TINY, _TINY, value)
