"""H_E of TP appendix B at a solution: what the residuals' own curvature would do to the standard uncertainties.

R = F_cᵀ U_Y⁻¹ F_c − H_E with H_E = Σ e_k ∂²f_k. Models that are linear in their primary parameters have none; it counts
where residuals are large and the model is not linear (estimated temperature terms, a model of the caller's own). The
reported covariance stays without it: it holds what replications show, of which H_E knows nothing. TP (44), (45).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.models.model import Model, Stimulus

DIFFERENCE_STEP = 1e-5
"""Of a parameter, for the derivatives of the Jacobian by central differences."""


@dataclass(frozen=True)
class ResidualCurvature:
    """Of the free primary parameters of one axis, rows of equal weight."""

    names: tuple[str, ...]
    h_e: FloatArray
    """(F, F) in volts² per product of the parameters' units."""
    standard_uncertainty_ratio: Mapping[str, float]
    """Parameter to its standard uncertainty by R⁻¹ over that by (F_cᵀ F_c)⁻¹; NaN where R is no minimum."""


def residual_curvature(model: Model, primary: FloatArray, rows: Stimulus, residuals_v: FloatArray) -> ResidualCurvature:
    """Return H_E for (N,) residuals about the solution."""
    free = [index for index, name in enumerate(model.primary_names) if name not in model.fixed]
    names = tuple(model.primary_names[index] for index in free)
    h_e = np.zeros((len(free), len(free)))
    if model.basis_key is None:
        h_e = _by_differences(model, primary, rows, residuals_v, free)
    slopes = model.jacobian(primary, rows)[:, free]
    gauss = slopes.T @ slopes
    return ResidualCurvature(names, h_e, dict(zip(names, _ratios(gauss, h_e).tolist(), strict=True)))


def _by_differences(
    model: Model, primary: FloatArray, rows: Stimulus, residuals_v: FloatArray, free: list[int]
) -> FloatArray:
    columns = []
    for index in free:
        step = np.zeros(primary.size)
        step[index] = DIFFERENCE_STEP * (abs(primary[index]) or 1.0)
        ahead, behind = (model.jacobian(primary + sign * step, rows)[:, free].T @ residuals_v for sign in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step[index]))
    curvature = np.stack(columns, axis=1)
    return np.asarray(0.5 * (curvature + curvature.T))


def _ratios(gauss: FloatArray, h_e: FloatArray) -> FloatArray:
    scale = 1.0 / np.sqrt(np.diag(gauss))
    without, whole = (scale[:, None] * matrix * scale for matrix in (gauss, gauss - h_e))
    if np.linalg.eigvalsh(whole)[0] <= 0.0:
        return np.full(scale.size, np.nan)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(whole)) / np.diag(np.linalg.inv(without))))
