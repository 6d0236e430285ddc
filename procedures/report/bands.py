"""Confidence and prediction bands along pitch or roll, as TP's figures 22 to 54 draw them.

The half-width depends on both angles. A figure has one of them on its axis, so the band drawn is the widest over the
values of the other one that the design visits: no point of the design has a wider one.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ams.frames import specific_force
from ams.models.extended import Q_NAMES, quadratic_basis
from ams.observations import Observations
from ams.solve.result import AxisCalibration, VarianceComponent
from ams.uncertainty.intervals import confidence_halfwidth, prediction_halfwidth

FloatArray = NDArray[np.float64]
Along = Literal["pitch", "roll"]
LEVEL = 0.95
STATIONS = 91
MOST_OTHER_ANGLES = 37


@dataclass(frozen=True)
class Band:
    """Half-widths along one angle."""

    angle_deg: FloatArray
    confidence_v: FloatArray
    prediction_v: FloatArray


def band_along(calibration: AxisCalibration, observations: Observations, along: Along) -> Band:
    """The widest 95 % band at every station along an angle, over the design's values of the other one.

    The prediction is for one more dwell of this calibration: its variance is S_E². Source: TP (72), (73).
    """
    angles = {"pitch": observations.pitch_rad, "roll": observations.roll_rad}
    other = "roll" if along == "pitch" else "pitch"
    stations = np.linspace(angles[along].min(), angles[along].max(), STATIONS)
    across = _thinned(np.unique(np.round(angles[other], 9)))
    grid = {along: np.repeat(stations, across.size), other: np.tile(across, stations.size)}
    directions = _directions(calibration, grid["pitch"], grid["roll"])
    components = components_of(calibration)
    confidence = confidence_halfwidth(directions, components, LEVEL)
    prediction = prediction_halfwidth(
        directions, components, calibration.standard_error_v, calibration.degrees_of_freedom, LEVEL
    )
    shape = (stations.size, across.size)
    return Band(
        np.rad2deg(stations), np.nanmax(confidence.reshape(shape), axis=1), np.nanmax(prediction.reshape(shape), axis=1)
    )


def components_of(calibration: AxisCalibration) -> tuple[VarianceComponent, ...]:
    """The parts of the covariance; the whole as one part where the solution names none."""
    if calibration.variance_components:
        return calibration.variance_components
    return (VarianceComponent("residuals", calibration.primary_covariance, float(np.nanmin(calibration.primary_dof))),)


def _directions(calibration: AxisCalibration, pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """(m, P) derivatives of the output by the primary parameters, at the solution's reference temperature.

    Temperature terms are zero there and add nothing.
    """
    force = specific_force(pitch_rad, roll_rad)
    columns = {"offset_v": np.ones(pitch_rad.size)}
    columns |= {f"k_{axis}_v_per_g": force[:, place] for place, axis in enumerate("xyz")}
    columns |= dict(zip(Q_NAMES, quadratic_basis(force).T, strict=True))
    nothing = np.zeros(pitch_rad.size)
    return np.stack([columns.get(name, nothing) for name in calibration.primary_names], axis=1)


def _thinned(values: FloatArray) -> FloatArray:
    """Both ends and an even choice between, so that a design of any size draws in the same time."""
    if values.size <= MOST_OTHER_ANGLES:
        return values
    return np.asarray(values[np.linspace(0, values.size - 1, MOST_OTHER_ANGLES).round().astype(int)])
