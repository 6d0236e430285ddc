"""Confidence and prediction bands along pitch or roll, as TP's figures 22 to 54 draw them.

The half-width depends on everything that the model knows. A figure has one angle on its axis, so the band drawn is the
widest over what else the design visits: no point of the design has a wider one. The derivatives are the model's own.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ams.analysis.predictions import confidence_halfwidth_v, prediction_halfwidth_v
from ams.arrays import FloatArray, IntArray
from ams.calibration_result import AxisCalibration, VarianceComponent
from ams.frames import Attitude
from ams.observations import Observations

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
    """Return the widest 95 % band at every station along an angle, over what else the design visits.

    The prediction is for one more dwell of this calibration: its variance is S_E². Source: TP (72), (73).
    """
    angle_rad = observations.pitch_rad if along == "pitch" else observations.roll_rad
    stations = np.linspace(angle_rad.min(), angle_rad.max(), STATIONS)
    visited = _visited(observations, along)
    solved = replace(calibration, variance_components=components_of(calibration))
    everywhere = _stationed(stations, visited, along)
    confidence = confidence_halfwidth_v(solved, everywhere, LEVEL)
    prediction = prediction_halfwidth_v(solved, everywhere, solved.standard_error_v, solved.degrees_of_freedom, LEVEL)
    shape = (stations.size, visited.pitch_rad.size)
    return Band(
        np.rad2deg(stations), np.nanmax(confidence.reshape(shape), axis=1), np.nanmax(prediction.reshape(shape), axis=1)
    )


def components_of(calibration: AxisCalibration) -> tuple[VarianceComponent, ...]:
    """Return the parts of the covariance; the whole as one part where the solution names none."""
    if calibration.variance_components:
        return calibration.variance_components
    return (VarianceComponent("residuals", calibration.primary_covariance, float(np.nanmin(calibration.primary_dof))),)


def _visited(observations: Observations, along: Along) -> Attitude:
    """Return one row for each combination of everything but the angle along the figure, an even choice of at most 37.

    A band is widest at the ends of the temperatures, so only these are taken.
    """
    every = Attitude(
        observations.pitch_rad,
        observations.roll_rad,
        observations.yaw_rad,
        observations.temperature_degc,
        observations.euler_rate_rad_s,
    )
    other = every.roll_rad if along == "pitch" else every.pitch_rad
    columns = [other] if every.yaw_rad is None else [other, every.yaw_rad]
    first = np.unique(np.round(np.column_stack(columns), 9), axis=0, return_index=True)[1]
    visited = _taken(every, _thinned(first))
    if every.temperature_degc is None:
        return visited
    ends_degc = [every.temperature_degc.min(), every.temperature_degc.max()]
    count = visited.pitch_rad.size
    twice = _taken(visited, np.tile(np.arange(count), 2))
    return replace(twice, temperature_degc=np.repeat(ends_degc, count))


def _stationed(stations_rad: FloatArray, visited: Attitude, along: Along) -> Attitude:
    """Return every station with every visited combination, station by station."""
    count = visited.pitch_rad.size
    grid = _taken(visited, np.tile(np.arange(count), stations_rad.size))
    angle_rad = np.repeat(stations_rad, count)
    return replace(grid, pitch_rad=angle_rad) if along == "pitch" else replace(grid, roll_rad=angle_rad)


def _taken(attitude: Attitude, indices: IntArray) -> Attitude:
    """Return the rows at the places, which may repeat."""
    return Attitude(
        attitude.pitch_rad[indices],
        attitude.roll_rad[indices],
        None if attitude.yaw_rad is None else attitude.yaw_rad[indices],
        None if attitude.temperature_degc is None else attitude.temperature_degc[indices],
        None if attitude.euler_rate_rad_s is None else attitude.euler_rate_rad_s[indices],
    )


def _thinned(values: IntArray) -> IntArray:
    """Both ends and an even choice between, so that a design of any size draws in the same time."""
    if values.size <= MOST_OTHER_ANGLES:
        return values
    return np.asarray(values[np.linspace(0, values.size - 1, MOST_OTHER_ANGLES).round().astype(int)])
