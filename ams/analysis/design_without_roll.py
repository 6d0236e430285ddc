"""How good a design without roll is: the same figures as :mod:`ams.analysis.design_variance` for TP (1).

The variance function is φᵀP⁻¹φ with φ = (1, sin α, −cos α), a trigonometric polynomial of the second order in pitch.
Boxes are ranges of pitch alone. Source: TP 4.2, calibration without roll, and 5.3.1.
"""

import numpy as np

from ams.analysis.design_variance import DesignEvaluation
from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.models.accelerometer import PitchOnly
from ams.solve.linear_form import factor

PitchRange = tuple[float, float]

_TERMS = 3
"""Offset and two sensitivities, TP (1)."""
_NODES = 48
"""Of Gauss and Legendre, exact for polynomials to degree 95."""
_STATIONS = 721
"""Pitches at which the variance is looked at before its maximum is followed."""


def variance_without_roll(pitch_rad: FloatArray, at_pitch_rad: FloatArray) -> FloatArray:
    """Return φᵀP⁻¹φ at pitch angles (M,), for the points (N,) of a design.

    Raises:
        DesignError: the points cannot determine the model.
    """
    phi = _basis(at_pitch_rad)
    attitude = Attitude(pitch_rad, np.zeros_like(pitch_rad))
    return np.asarray(
        np.einsum(
            "ij,ij->i", phi @ factor(_basis(pitch_rad), PitchOnly.primary_names, attitude).unscaled_covariance, phi
        )
    )


def evaluate_without_roll(
    pitch_rad: FloatArray, calibration_range_rad: PitchRange, usage_range_rad: PitchRange | None = None
) -> DesignEvaluation:
    """Return figures of merit, largest variance and rank (3 determines the model). Raises: DesignError."""
    usage = None if usage_range_rad is None else _figure_of_merit_sqrt(pitch_rad, usage_range_rad)
    return DesignEvaluation(
        figure_of_merit_sqrt=_figure_of_merit_sqrt(pitch_rad, calibration_range_rad),
        usage_figure_of_merit_sqrt=usage,
        max_variance=_largest(pitch_rad, calibration_range_rad),
        rank=_TERMS,
    )


def _basis(pitch_rad: FloatArray) -> FloatArray:
    return PitchOnly("x").basis(Attitude(pitch_rad, np.zeros_like(pitch_rad)))


def _figure_of_merit_sqrt(pitch_rad: FloatArray, range_rad: PitchRange) -> float:
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    low, high = range_rad
    values = variance_without_roll(pitch_rad, 0.5 * (low + high) + 0.5 * (high - low) * nodes)
    return float(np.sqrt(pitch_rad.size * (weights @ values) / 2.0))


def _largest(pitch_rad: FloatArray, range_rad: PitchRange) -> float:
    """Return the largest variance in the range: a grid, then ever finer grids around its highest place."""
    low, high = range_rad
    while True:
        stations = np.linspace(low, high, _STATIONS)
        values = variance_without_roll(pitch_rad, stations)
        index = int(values.argmax())
        low, high = stations[max(index - 1, 0)], stations[min(index + 1, _STATIONS - 1)]
        if high - low < 1e-7:
            return float(values[index])
