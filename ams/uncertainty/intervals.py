"""Quantiles, effective degrees of freedom, Holm's correction, confidence and prediction intervals.

Source: TP (72) to (74) for the intervals, GUM G.4.1 (Welch-Satterthwaite) for effective degrees of freedom.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ams.solve.result import FTest, VarianceComponent

FloatArray = NDArray[np.float64]

INFINITE_DOF = 1e7
"""Beyond this Student's t is the normal distribution to nine digits."""
_FEW_DOF = 3.0
_NORMAL_FACTOR = 1.9601


def t_quantile(level: float, dof: float | FloatArray) -> FloatArray:
    """Half-width of the two-sided interval of the level (0.95), in standard uncertainties; NaN where dof is NaN."""
    from scipy.special import ndtri, stdtrit

    share = 0.5 * (1.0 + level)
    dof = np.asarray(dof, dtype=float)
    finite = np.where(dof < INFINITE_DOF, dof, 1.0)
    return np.where(np.isnan(dof), np.nan, np.where(dof < INFINITE_DOF, stdtrit(finite, share), ndtri(share)))


def f_quantile(level: float, numerator_dof: float, denominator_dof: float) -> float:
    """Value that F stays below with probability ``level``."""
    from scipy.special import fdtri

    return float(fdtri(numerator_dof, denominator_dof, level))


def f_test(variance_ratio: float, numerator_dof: float, denominator_dof: float, level: float = 0.95) -> FTest:
    """A variance ratio against its limit, significance before any correction for several tests."""
    from scipy.special import fdtrc

    limit = f_quantile(level, numerator_dof, denominator_dof)
    p_value = float(fdtrc(numerator_dof, denominator_dof, variance_ratio))
    is_above = bool(variance_ratio > limit)
    return FTest(variance_ratio, limit, p_value, numerator_dof, denominator_dof, is_above)


def holm(p_values: Sequence[float], level: float = 0.05) -> tuple[bool, ...]:
    """Which of several tests are significant when the chance of any false alarm is to stay at ``level``. NaN
    never is."""
    known = [index for index, p in enumerate(p_values) if not np.isnan(p)]
    significant = [False] * len(p_values)
    for rank, index in enumerate(sorted(known, key=lambda index: p_values[index])):
        if p_values[index] > level / (len(known) - rank):
            break
        significant[index] = True
    return tuple(significant)


def effective_dof(directions: FloatArray, components: Sequence[VarianceComponent]) -> FloatArray:
    """(m,) effective degrees of freedom of gᵀ·estimate for every row g of (m, P); NaN where the variance is zero."""
    return combined_dof(
        np.stack([_quadratic(directions, component.covariance) for component in components]),
        np.array([component.dof for component in components]),
    )


def combined_dof(variances: FloatArray, dof: FloatArray) -> FloatArray:
    """Effective degrees of freedom of sums of (c, m) variances estimated with (c,) degrees of freedom.

    Welch-Satterthwaite, GUM (G.2b). It is too generous where a part has one or two degrees of freedom (two or three
    replications: 95 % intervals cover 86 to 93 %): there Student's factors are averaged with the variances as weights
    (Cochran and Cox), and the degrees of freedom are those that have this factor at 95 %.
    """
    total = variances.sum(axis=0)
    spread = (variances**2 / dof[:, None]).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        effective = np.where(spread > 0.0, total**2 / spread, np.inf)
        if dof.min() < _FEW_DOF:
            from scipy.special import stdtridf

            factor = (variances * t_quantile(0.95, dof)[:, None]).sum(axis=0) / total
            effective = np.where(factor > _NORMAL_FACTOR, stdtridf(0.975, factor), effective)
    return np.asarray(np.where(total > 0.0, effective, np.nan))


def confidence_halfwidth(
    directions: FloatArray, components: Sequence[VarianceComponent], level: float = 0.95
) -> FloatArray:
    """TP (72): half-width for gᵀ·estimate, every row g of (m, P), from all variance components."""
    variance = np.asarray(sum(_quadratic(directions, component.covariance) for component in components))
    return np.asarray(t_quantile(level, effective_dof(directions, components)) * np.sqrt(variance))


def prediction_halfwidth(
    directions: FloatArray,
    components: Sequence[VarianceComponent],
    reading_standard_deviation: float,
    reading_dof: float,
    level: float = 0.95,
    roll_slope_v_per_rad: FloatArray | None = None,
    roll_standard_uncertainty_rad: float = 0.0,
) -> FloatArray:
    """TP (73), and TP (74) where the roll angle is known on its own: half-width for a new reading.

    The reading's own variance is that of the place where the calibration is used, not of the calibration.
    """
    variances = [_quadratic(directions, component.covariance) for component in components]
    dof = [component.dof for component in components]
    variances.append(np.full(directions.shape[0], reading_standard_deviation**2))
    dof.append(reading_dof)
    if roll_slope_v_per_rad is not None:
        variances.append((roll_slope_v_per_rad * roll_standard_uncertainty_rad) ** 2)
        dof.append(float("inf"))
    stacked = np.stack(variances)
    return np.asarray(t_quantile(level, combined_dof(stacked, np.array(dof))) * np.sqrt(stacked.sum(axis=0)))


def _quadratic(directions: FloatArray, covariance: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("mi,ij,mj->m", directions, covariance, directions))


def significance(tests: Mapping[str, FTest]) -> Mapping[str, FTest]:
    """The same tests, their significance after Holm's correction over all of them."""
    from dataclasses import replace

    names = list(tests)
    flags = holm([tests[name].p_value for name in names])
    return {name: replace(tests[name], is_significant=flag) for name, flag in zip(names, flags, strict=True)}
