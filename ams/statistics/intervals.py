"""Quantiles, effective degrees of freedom, Holm's correction, confidence and prediction intervals.

Source: TP (72) to (74) for the intervals, GUM G.4.1 (Welch-Satterthwaite) for effective degrees of freedom.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from math import isnan, nan
from typing import Final, NamedTuple, Protocol

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.calibration_result import FTest
from ams.statistics.distributions import (
    f_quantile,
    f_tail,
    normal_quantile,
    student_t_degrees_of_freedom,
    student_t_quantile,
)


def _largest_passed(p_values: Sequence[float], level: float, count: float) -> float:
    known = sorted(value for value in p_values if value == value)  # NaN is none
    largest = -1.0
    for index, value in enumerate(known):
        if value > level / min(count, len(known) - index):
            break
        largest = value
    return largest


class Component(Protocol):
    """An independent part of one covariance, or of those of several estimates."""

    @property
    def covariance(self) -> FloatArray:
        """(P, P), or (k, P, P)."""

    @property
    def dof(self) -> float | FloatArray:
        """One number, or (k,)."""


INFINITE_DOF = 1e7
"""Beyond this Student's t is the normal distribution to nine digits."""
_FEW_DOF = 3.0
_NORMAL_FACTOR = 1.9601
_ALMOST: Final = 1.0 + 1e-9
_TABLE_ROWS: Final = 2049
"""Evenly over 1/ν from 0 to 1: the straight line between two of ln t is off by less than 1e-6."""
NO_TEST = FTest(float("nan"), float("nan"), float("nan"), float("nan"), float("nan"), False)


def t_quantile(level: float, dof: float | FloatArray) -> FloatArray:
    """Return the half-width of the two-sided interval of the level (0.95), in standard uncertainties.

    NaN where dof is NaN.
    """
    share = 0.5 * (1.0 + level)
    dof = np.asarray(dof, dtype=float)
    finite = np.where(dof < INFINITE_DOF, dof, 1.0)
    factors = np.where(dof < INFINITE_DOF, student_t_quantile(share, finite), normal_quantile(share))
    return np.where(np.isnan(dof), np.nan, factors)


def t_factor(level: float, dof: float) -> float:
    """Return :func:`t_quantile` of one number of degrees of freedom."""
    share = 0.5 * (1.0 + level)
    if isnan(dof):
        return nan
    return float(student_t_quantile(share, dof) if dof < INFINITE_DOF else normal_quantile(share))


def tabled_t_quantile(level: float, dof: FloatArray) -> FloatArray:
    """Return :func:`t_quantile` from a table over degrees of freedom, within 1e-6 of itself.

    For as many rows as a file has: a quantile costs as much as the attitude that it bounds.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 1.0 / dof
    factors = np.exp(np.interp(share, *_t_table(level)))
    beyond = share > 1.0
    if beyond.any():
        factors[beyond] = t_quantile(level, dof[beyond])
    return np.asarray(factors)


@cache
def _t_table(level: float) -> tuple[FloatArray, FloatArray]:
    """Return 1/ν and ln t."""
    share = np.linspace(0.0, 1.0, _TABLE_ROWS)
    with np.errstate(divide="ignore"):
        return share, np.log(t_quantile(level, 1.0 / share))


class FTestColumns(NamedTuple):
    """The same variance ratio of m sensor axes against one limit."""

    t: FloatArray
    """(m,); NaN where there is no test."""
    f_95: float
    p_value: FloatArray
    """(m,)"""
    numerator_dof: float
    denominator_dof: float
    is_significant: BoolArray
    """(m,)"""

    def judged(self, is_significant: BoolArray) -> "FTestColumns":
        """Return the same tests, significant as it is said."""
        return FTestColumns(*self[:-1], is_significant)

    def of(self, column: int, *, is_significant: bool | None = None, p_value: float | None = None) -> FTest:
        """Return the test of one axis; all NaN where there is none.

        ``is_significant``, ``p_value``: where they are known better.
        """
        t = float(self.t[column])
        if isnan(t):
            return NO_TEST
        p = float(self.p_value[column]) if p_value is None else p_value
        flag = bool(self.is_significant[column]) if is_significant is None else is_significant
        return FTest(t, self.f_95, p, self.numerator_dof, self.denominator_dof, flag)


def f_tests(
    variance_ratios: Mapping[str, FloatArray], numerator_dof: float, denominator_dof: float, level: float = 0.95
) -> dict[str, FTestColumns]:
    """Test (m,) variance ratios by name against their limit, significance before any correction for several tests."""
    if not (variance_ratios and numerator_dof > 0 and denominator_dof > 0):
        return {name: _no_tests(ratios.size) for name, ratios in variance_ratios.items()}

    limit = _f_limit(level, float(numerator_dof), float(denominator_dof))
    ratios = np.array(list(variance_ratios.values()))
    p_values, flags = f_tail(ratios, numerator_dof, denominator_dof), ratios > limit
    return {
        name: FTestColumns(t, limit, p_value, numerator_dof, denominator_dof, is_above)
        for name, t, p_value, is_above in zip(variance_ratios, ratios, p_values, flags, strict=True)
    }


@cache
def _f_limit(level: float, numerator_dof: float, denominator_dof: float) -> float:
    return float(f_quantile(level, numerator_dof, denominator_dof))


def _no_tests(size: int) -> FTestColumns:
    nothing = np.full(size, np.nan)
    return FTestColumns(nothing, np.nan, nothing, np.nan, np.nan, np.zeros(size, dtype=bool))


def f_test(variance_ratio: float, numerator_dof: float, denominator_dof: float, level: float = 0.95) -> FTest:
    """Test one variance ratio against its limit; all NaN where there is none."""
    if not (numerator_dof > 0 and denominator_dof > 0) or np.isnan(variance_ratio):
        return NO_TEST
    limit = _f_limit(level, float(numerator_dof), float(denominator_dof))
    p_value = float(f_tail(variance_ratio, numerator_dof, denominator_dof))
    return FTest(variance_ratio, limit, p_value, numerator_dof, denominator_dof, variance_ratio > limit)


def holm(p_values: FloatArray, level: float = 0.05, count: float = np.inf) -> BoolArray:
    """Return (m, q) which of q tests are significant; NaN never is.

    The chance of any false alarm among them is to stay at ``level``; of no tests none is. ``count``: as how many tests
    they count at most (:mod:`ams.statistics.tests_alike`); of some of them left, that bound stands as well.
    """
    if p_values.size == 0:
        return np.zeros(p_values.shape, dtype=bool)
    families = p_values.reshape(-1, p_values.shape[-1])
    if len(families) == 1:
        return np.asarray(p_values <= _largest_passed(families[0].tolist(), level, count))
    known = np.count_nonzero(~np.isnan(families), axis=1)
    passed = np.full(len(families), -1.0)
    for index in np.flatnonzero(np.fmin.reduce(families, axis=1) * np.minimum(count, known) <= _ALMOST * level):
        passed[index] = _largest_passed(families[index].tolist(), level, count)
    return np.asarray(p_values <= np.reshape(passed, (*p_values.shape[:-1], 1)))


def after_holm(tests: Mapping[str, FTestColumns]) -> dict[str, FTestColumns]:
    """Return the same tests, their significance after Holm's correction over all of them, axis by axis."""
    if not tests:
        return {}
    flags = holm(np.array([test.p_value for test in tests.values()]).T).T
    return {name: test.judged(flag) for flag, (name, test) in zip(flags, tests.items(), strict=True)}


def combined_dof(variances: FloatArray, dof: FloatArray) -> FloatArray:
    """Return the effective degrees of freedom of sums of (c, …) variances with (c,) or (c, …) degrees of freedom.

    Welch-Satterthwaite, GUM (G.2b). It is too generous where a part has one or two degrees of freedom (two or three
    replications: 95 % intervals cover 86 to 93 %): there Student's factors are averaged with the variances as weights
    (Cochran and Cox), and the degrees of freedom are those that have this factor at 95 %.
    """
    dof = dof.reshape(*dof.shape, *[1] * (variances.ndim - dof.ndim))
    total, there = variances.sum(axis=0), variances > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.where(there, variances**2 / dof, 0.0).sum(axis=0)
        effective = np.where(spread > 0.0, total**2 / spread, np.inf)
        few = (there & (dof < _FEW_DOF)).any(axis=0)
        if few.any():
            factor = np.where(there, variances * t_quantile(0.95, dof), 0.0).sum(axis=0) / total
            effective = np.where(
                few & (factor > _NORMAL_FACTOR), student_t_degrees_of_freedom(0.975, factor), effective
            )
    return np.asarray(np.where(total > 0.0, effective, np.nan))


def confidence_halfwidth(directions: FloatArray, components: Sequence[Component], level: float = 0.95) -> FloatArray:
    """Return the half-width of TP (72) for gᵀ·estimate, every row g of (m, P), from all variance components.

    Components of k estimates at once, (k, P, P), give (k, m) half-widths.
    """
    return prediction_halfwidth(directions, components, 0.0, np.inf, level)


def prediction_halfwidth(
    directions: FloatArray,
    components: Sequence[Component],
    reading_standard_deviation: float,
    reading_dof: float,
    level: float = 0.95,
) -> FloatArray:
    """Return the half-width for a new reading. Source: TP (73).

    The reading's own variance is that of the place where the calibration is used, not of the calibration.
    """
    variances = [_quadratic(directions, component.covariance) for component in components]
    dof = [np.asarray(component.dof, dtype=float) for component in components]
    return reading_halfwidth(variances, dof, reading_standard_deviation**2, level, reading_dof)


def reading_halfwidth(
    variances: Sequence[FloatArray],
    dof: Sequence[float | FloatArray],
    reading_variance: float | FloatArray,
    level: float = 0.95,
    reading_dof: float = np.inf,
    known_variance: float | FloatArray = 0.0,
) -> FloatArray:
    """Return the half-width from the parts of a calibration's variance and that of a reading.

    ``known_variance`` counts besides.

    A reading brings degrees of freedom with it: where the calibration has one or two, Student's factor would fall
    faster than the variance grows, and a reading would be told better than its mean. It never is.
    """
    of_reading, known = (np.broadcast_to(more, variances[0].shape) for more in (reading_variance, known_variance))
    degrees = [np.asarray(part_dof, dtype=float) for part_dof in dof]
    more = [np.full(degrees[0].shape, reading_dof), np.full(degrees[0].shape, np.inf)]
    return np.fmax(
        _halfwidth([*variances, of_reading, known], [*degrees, *more], level), _halfwidth(variances, degrees, level)
    )


def _halfwidth(variances: Sequence[FloatArray], dof: Sequence[FloatArray], level: float) -> FloatArray:
    stacked = np.stack(variances)
    return np.asarray(t_quantile(level, combined_dof(stacked, np.stack(dof))) * np.sqrt(stacked.sum(axis=0)))


def _quadratic(directions: FloatArray, covariance: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("mi,...ij,mj->...m", directions, covariance, directions, optimize=True))


MANY_DOF = 10_000.0
"""Beyond, Student's factor is that of the normal distribution to four digits."""


def degrees_of_freedom(dof: float | None) -> str:
    """Return degrees of freedom as a table has them: one decimal where they are few, no digits where they are many."""
    if dof is None or isnan(dof):
        return "—"
    if dof > MANY_DOF:
        return "∞" if dof >= INFINITE_DOF else "> 10 000"
    return f"{dof:.0f}" if dof >= 10 else f"{dof:.1f}".removesuffix(".0")
