"""What the twin must be for TP's laboratory: noise, drift and soft mount, read off the columns of table 2.

Three things are set from a row and therefore prove nothing when they come out again: the noise of a dwell (from σ_prec,
less what drift puts into it), a drift of offset and sensitivity, linear in time (from σ_b and σ_S), and the soft
mount (from σ_bias). Everything else is an outcome. All figures in 1e-4 degrees.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tp_study.printed import Row

from ams.frames import specific_force
from ams.models.extended import quadratic_basis

FloatArray = NDArray[np.float64]

_ROUNDS = 60


@dataclass(frozen=True)
class Truth:
    """One sensor axis of the twin."""

    noise: float
    """Standard deviation of a dwell."""
    offset_drift: float
    """Per replication."""
    sensitivity_drift: float
    """Per replication, of S·f at one g."""
    q: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    """[xx, xy, xz, yy, yz]."""


def design_basis(pitch_deg: FloatArray, roll_deg: FloatArray, with_roll: bool) -> FloatArray:
    force = specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    columns = np.concatenate([np.ones((force.shape[0], 1)), force], axis=1)
    return columns if with_roll else columns[:, [0, 1, 3]]


def noise_and_drift(row: Row, basis: FloatArray, sensitivity_column: int) -> Truth:
    """Noise and drift that give the row's σ_prec, σ_b and σ_S on the average.

    σ_j² is the noise and D_j² n(n+1)/12 over the diagonal of R₁⁻¹; σ_prec² is (n−1)/n of the noise and, of a drift,
    its mean square about the middle replication. Where the row leaves no noise (row 22: offset and misalignment
    cannot be told apart over ±36°, and their estimates move together), the noise is S_w = σ_b/√T_b and the drifts are
    scaled to leave it.
    """
    n = row.replications
    inverse = np.diag(np.linalg.inv(basis.T @ basis))
    slope = float(np.mean(basis[:, sensitivity_column] ** 2))
    noise2 = row.sigma_prec**2
    drift2 = np.zeros(2)
    for _ in range(_ROUNDS):
        beyond = np.maximum(np.array([row.sigma_b, row.sigma_s]) ** 2 - noise2, 0.0)
        drift2 = beyond * inverse[[0, sensitivity_column]] * 12.0 / (n * (n + 1))
        left = row.sigma_prec**2 - _spread(drift2, slope, n)
        noise2 = 0.5 * (noise2 + n / (n - 1) * max(left, 0.0))
    if row.sigma_prec**2 <= 1.02 * _spread(drift2, slope, n):
        noise2 = row.sigma_b**2 / row.t_b
        wanted = row.sigma_prec**2 - (n - 1) / n * noise2
        drift2 = drift2 * wanted / _spread(drift2, slope, n)
    offset, sensitivity = np.sqrt(drift2)
    return Truth(float(np.sqrt(noise2)), float(offset), float(sensitivity))


def _spread(drift2: FloatArray, slope: float, n: int) -> float:
    return float((n * n - 1) / 12.0 * (drift2[0] + drift2[1] * slope))


def lack_of_fit_form(pitch_deg: FloatArray, roll_deg: FloatArray, with_roll: bool) -> FloatArray:
    """(5, 5) B: the mean square over the design of what a fit leaves of fᵀQf is qᵀ B q."""
    basis = design_basis(pitch_deg, roll_deg, with_roll)
    quadratic = quadratic_basis(specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg)))
    left = quadratic - basis @ np.linalg.lstsq(basis, quadratic, rcond=None)[0]
    return np.asarray(left.T @ left / left.shape[0])


def completed(form: FloatArray, known: FloatArray, direction: FloatArray, wanted2: float) -> FloatArray:
    """``known`` + c · ``direction``, c ≥ 0, so that qᵀ B q is ``wanted2``; ``known`` where that is enough already."""
    a = float(direction @ form @ direction)
    b = float(direction @ form @ known)
    c = float(known @ form @ known) - wanted2
    return known if c >= 0.0 else known + (np.sqrt(b * b - a * c) - b) / a * direction


def bias_beyond_noise(row: Row, truth: Truth) -> float:
    """σ_bias² less the share of the noise that K points with P parameters have in it."""
    share = (row.points - row.parameters) / (row.points * row.replications)
    return max(row.sigma_bias**2 - share * truth.noise**2, 0.0)


def expected_bias(row: Row, truth: Truth, form: FloatArray) -> float:
    """σ_bias to expect from noise and soft mount alone on a design with this form."""
    share = (row.points - row.parameters) / (row.points * row.replications)
    q = np.array(truth.q)
    return float(np.sqrt(share * truth.noise**2 + q @ form @ q))


def describe(truths: Mapping[str, Truth]) -> list[str]:
    """One Markdown table row a truth."""
    return [
        f"| {name} | {t.noise:.2f} | {t.offset_drift:.2f} | {t.sensitivity_drift:.2f} | "
        f"{', '.join(f'{value:.2f}' for value in t.q)} |"
        for name, t in truths.items()
    ]
