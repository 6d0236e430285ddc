"""How good a design is before anything is measured: variance function, figures of merit, rank.

The variance of a predicted output over the variance of a reading is φᵀP⁻¹φ with φ = (1, sin α, −cos α sin R,
−cos α cos R) and P the sum of φφᵀ over the points: free of the sensor's own parameters. Box's figure of merit V is K
times its mean over a box of angles; its square root is what is tabulated. Source: TP (52), (53), (127), theorems I to
IV and table 1, whose values hold for the whole roll circle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.errors import DesignError
from ams.frames import Attitude, specific_force
from ams.models.accelerometer import PitchRoll
from ams.solve.linear_form import RANK_TOLERANCE, factor

PITCH_ROLL_TERMS = 4
"""Offset and three sensitivities, TP (2)."""
_NODES = 48
"""Gauss-Legendre nodes an axis: exact to rounding for second harmonics over two turns and less."""
_GRID = 91
"""Pitches and rolls at which the variance is looked at first."""
_PEAKS = 12
"""Of the grid, the largest, that are followed to their maximum."""
_POLISHING = 24
"""Rounds in which a maximum is followed on ever finer grids."""


@dataclass(frozen=True)
class AngleBox:
    """A box of attitudes, radians; the whole roll circle unless it is narrowed."""

    pitch_rad: tuple[float, float]
    roll_rad: tuple[float, float] = (-np.pi, np.pi)

    def __post_init__(self) -> None:
        for name, (low, high) in (("pitch", self.pitch_rad), ("roll", self.roll_rad)):
            if not (np.isfinite(low) and np.isfinite(high) and low <= high):
                raise DesignError(
                    f"box: {name}: got {np.rad2deg(low):g}° to {np.rad2deg(high):g}°, allowed a range that "
                    "does not fall; nothing was evaluated"
                )


@dataclass(frozen=True)
class DesignEvaluation:
    """One design, evaluated for the model with roll."""

    figure_of_merit_sqrt: float
    """V^½ over the calibration box."""
    usage_figure_of_merit_sqrt: float | None
    """V_R^½ over the usage box; None without one."""
    max_variance: float
    """Largest φᵀP⁻¹φ in the calibration box."""
    rank: int
    """Of the design matrix: 4 determines the model."""


def gradient(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return (N, 4) φ of TP (127)."""
    force = specific_force(pitch_rad, roll_rad)
    return np.concatenate([np.ones((*force.shape[:-1], 1)), force], axis=-1)


def design_rank(pitch_rad: FloatArray, roll_rad: FloatArray) -> int:
    """Return the rank of the design matrix of the model with roll, 1 to 4."""
    basis = gradient(pitch_rad, roll_rad)
    length = np.linalg.norm(basis, axis=0)
    return int(np.linalg.matrix_rank(basis / np.where(length > 1e-12, length, np.inf), rtol=RANK_TOLERANCE))


def variance_function(
    pitch_rad: FloatArray, roll_rad: FloatArray, at_pitch_rad: FloatArray, at_roll_rad: FloatArray
) -> FloatArray:
    """Return φᵀP⁻¹φ at attitudes of any common shape, for the points (N,) of a design.

    Raises:
        DesignError: the points cannot determine the model.
    """
    return _variance(_inverse_moments(pitch_rad, roll_rad), at_pitch_rad, at_roll_rad)


def max_variance(pitch_rad: FloatArray, roll_rad: FloatArray, box: AngleBox) -> float:
    """Return the largest value of the variance function in the box, polished from the highest places of a grid."""
    inverse = _inverse_moments(pitch_rad, roll_rad)
    pitch, roll = np.linspace(*box.pitch_rad, _GRID), np.linspace(*box.roll_rad, _GRID)
    values = _variance(inverse, *np.meshgrid(pitch, roll, indexing="ij"))
    cells = [np.unravel_index(i, values.shape) for i in _highest(values)]
    cell = (pitch[1] - pitch[0], roll[1] - roll[0])
    return max(_polish(inverse, box, (float(pitch[i]), float(roll[j])), cell) for i, j in cells)


def evaluate_design(
    pitch_rad: FloatArray, roll_rad: FloatArray, calibration_box: AngleBox, usage_box: AngleBox | None = None
) -> DesignEvaluation:
    """Return figures of merit, largest variance and rank of a design of K points.

    Raises:
        DesignError: the points cannot determine the model.
    """
    inverse = _inverse_moments(pitch_rad, roll_rad)
    usage = None if usage_box is None else float(np.sqrt(pitch_rad.size * _mean_variance(inverse, usage_box)))
    return DesignEvaluation(
        figure_of_merit_sqrt=float(np.sqrt(pitch_rad.size * _mean_variance(inverse, calibration_box))),
        usage_figure_of_merit_sqrt=usage,
        max_variance=max_variance(pitch_rad, roll_rad, calibration_box),
        rank=PITCH_ROLL_TERMS,
    )


def _inverse_moments(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    names = PitchRoll.primary_names
    return factor(gradient(pitch_rad, roll_rad), names, Attitude(pitch_rad, roll_rad)).unscaled_covariance


def _variance(inverse: FloatArray, pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    phi = gradient(pitch_rad, roll_rad)
    return np.asarray(np.einsum("...i,ij,...j->...", phi, inverse, phi))


def _mean_variance(inverse: FloatArray, box: AngleBox) -> float:
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    axes = [0.5 * (low + high) + 0.5 * (high - low) * nodes for low, high in (box.pitch_rad, box.roll_rad)]
    values = _variance(inverse, *np.meshgrid(*axes, indexing="ij"))
    return float(weights @ values @ weights) / 4.0


def _highest(values: FloatArray) -> NDArray[np.intp]:
    """Return the flat places of the highest local maxima of a grid, the border included."""
    padded = np.pad(values, 1, constant_values=-np.inf)
    rows, columns = values.shape
    around = np.stack([padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)])
    peaks = np.flatnonzero(values >= around.max(axis=0))
    return peaks[np.argsort(values.ravel()[peaks])[::-1][:_PEAKS]]


def _polish(inverse: FloatArray, box: AngleBox, start: tuple[float, float], cell: tuple[float, float]) -> float:
    """Climb from a place of the grid, ever finer once the top is inside the window."""
    halves, best = np.array(cell), -np.inf
    for _ in range(_POLISHING):
        axes = [
            np.clip(np.linspace(centre - half, centre + half, 11), low, high)
            for centre, half, (low, high) in zip(start, halves, (box.pitch_rad, box.roll_rad), strict=True)
        ]
        values = _variance(inverse, *np.meshgrid(*axes, indexing="ij"))
        i, j = np.unravel_index(int(np.argmax(values)), values.shape)
        if values[i, j] <= best or (0 < i < 10 and 0 < j < 10):
            halves = halves / 4.0
        best, start = max(best, float(values[i, j])), (float(axes[0][i]), float(axes[1][j]))
    return best
