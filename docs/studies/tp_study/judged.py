"""One calibration judged as TP judges its own: table 2's columns, bands, and angles inferred back from the outputs.

All statistics in 1e-4 degrees of the sensor's own angle, residual / |S|.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from tp_study.laboratory import REFERENCE_DEGC, VOLTS, Temperature

from ams.analysis.predictions import model_of_solution, prediction_halfwidth_v
from ams.attitude.static import pitch_roll_from_three, pitch_with_known_roll
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration, Calibration, VarianceComponent
from ams.frames import Attitude, wrap_rad
from ams.inference.package.calibrated import CalibratedPackage, CalibratedSensor
from ams.inputs.request import CalibrationRequest
from ams.models.thermal import TemperatureCoefficients
from ams.observations import Observations
from procedures.report.bands import Along, Band, band_along

FloatArray = NDArray[np.float64]

PARTS = 1e4
"""Degrees to the table's unit."""
UNIT_RAD = float(np.deg2rad(1.0 / PARTS))
LINE = ("offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")


@dataclass(frozen=True)
class Statistics:
    """A row of table 2, from the twin."""

    points: int
    sigma_e: float
    sigma_bias: float
    sigma_prec: float
    t_bias: float
    f_bias: float
    sigma_b: float
    sigma_s: float
    t_b: float
    t_s: float
    f_bs: float
    lack_of_fit: bool
    """Found by the default test, and so on for drift."""
    drift_b: bool
    drift_s: bool


def solve(
    observations: Observations,
    with_roll: bool = True,
    temperature: Temperature | None = None,
    extended: Literal["no", "test", "yes"] = "no",
) -> Calibration:
    """One sensor; a temperature that is given is known and applied."""
    labels = list(observations.outputs)
    request = CalibrationRequest(
        model="pitch-roll" if with_roll else "pitch-only",
        nominal_axes={label: label for label in labels},
        extended=extended,
    )
    if temperature is not None:
        known = TemperatureCoefficients(*_coefficients(temperature))
        request = replace(
            request,
            temperature="apply",
            known_temperature=dict.fromkeys(labels, known),
            reference_temperature_degc=REFERENCE_DEGC,
        )
    return calibrate(observations, request)


def _coefficients(temperature: Temperature) -> tuple[float, float]:
    return temperature.offset_per_degc * VOLTS, temperature.sensitivity_per_degc * UNIT_RAD


def statistics(axis: AxisCalibration) -> Statistics:
    found = axis.replication
    assert found is not None
    values = {item.name: item for item in axis.parameters}
    unit_v = abs(float(values["sensitivity_v_per_g"].value or np.nan)) * UNIT_RAD
    tests = found.drift
    return Statistics(
        points=found.points,
        sigma_e=axis.standard_error_v / unit_v,
        sigma_bias=found.tp.sigma_bias_v / unit_v,
        sigma_prec=found.tp.sigma_prec_v / unit_v,
        t_bias=found.tp.t_bias,
        f_bias=found.tp.f_bias_95,
        sigma_b=_sigma(axis, "offset_v") / unit_v,
        sigma_s=_sigma(axis, "sensitivity_v_per_g") / unit_v,
        t_b=found.tp.drift["offset"].t,
        t_s=found.tp.drift["sensitivity"].t,
        f_bs=found.tp.drift["offset"].f_95,
        lack_of_fit=found.lack_of_fit.is_significant,
        drift_b=tests["offset"].is_significant,
        drift_s=tests["sensitivity"].is_significant,
    )


def _sigma(axis: AxisCalibration, name: str) -> float:
    """σ_j of TP 8: the spread between replications over √(R₁⁻¹)_jj, volts; R₁⁻¹ is n times the pooled one."""
    assert axis.replication is not None
    spread = np.std([values[name] for values in axis.replication.per_replication.values()], ddof=1)
    pooled = next(item.tp_standard_uncertainty for item in axis.parameters if item.name == name)
    assert pooled is not None
    scale = pooled / axis.standard_error_v * np.sqrt(axis.replication.replications)
    return float(spread / scale)


def residuals(axis: AxisCalibration) -> FloatArray:
    """1e-4 degrees."""
    return axis.residuals_v / _unit_v(axis)


def _unit_v(axis: AxisCalibration) -> float:
    k = np.array(axis.sensitive_axis_v_per_g)
    return float(np.sqrt(np.nansum(k**2))) * UNIT_RAD


def band(axis: AxisCalibration, observations: Observations, along: Along, pooled: bool = False) -> Band:
    """95 % bands in 1e-4 degrees; ``pooled``: by TP's covariance (50)."""
    solved = axis
    if pooled:
        parts = (VarianceComponent("residuals", axis.tp_primary_covariance, float(axis.degrees_of_freedom)),)
        solved = replace(axis, variance_components=parts)
    found, unit_v = band_along(solved, observations, along), _unit_v(axis)
    return Band(found.angle_deg, found.confidence_v / unit_v, found.prediction_v / unit_v)


def elsewhere(axis: AxisCalibration, full: Observations) -> tuple[AxisCalibration, float]:
    """The solution of a reduced design held against the full data, and the standard error of its residuals there."""
    fitted = model_of_solution(axis).predict(axis.primary, full)
    left = full.outputs[axis.axis] - fitted
    moved = replace(axis, fitted_v=fitted, residuals_v=left)
    return moved, float(np.sqrt(left @ left / (left.size - axis.primary.size)) / _unit_v(axis))


def share_inside(axis: AxisCalibration, observations: Observations) -> float:
    """Share of the residuals inside the 95 % prediction interval for one more dwell of this calibration."""
    attitude = Attitude(observations.pitch_rad, observations.roll_rad, None, observations.temperature_degc)
    half_v = prediction_halfwidth_v(axis, attitude, axis.standard_error_v, axis.degrees_of_freedom)
    return float(np.mean(np.abs(axis.residuals_v) <= half_v))


@dataclass(frozen=True)
class Inferred:
    """An angle inferred back, less the angle that was set, with half-widths: 1e-4 degrees, NaN where flagged."""

    error: FloatArray
    confidence: FloatArray
    prediction: FloatArray


def inferred_pitch(
    axis: AxisCalibration, observations: Observations, temperature: Temperature | None = None
) -> Inferred:
    """Pitch from one sensor with roll as the table has it; of the two answers the one nearer to the set pitch."""
    outputs = observations.outputs[axis.axis]
    if temperature is not None:
        outputs = _at_reference(axis, observations, temperature)
    found, sure = (
        pitch_with_known_roll(_line(axis, sd), outputs, observations.roll_rad) for sd in (axis.standard_error_v, 0.0)
    )
    k_x, k_y, k_z = _line(axis, 0.0).k_v_per_g
    across = k_y * np.sin(observations.roll_rad) + k_z * np.cos(observations.roll_rad)
    other = np.pi + 2.0 * np.arctan2(across, k_x) - found.pitch_rad
    error = _nearer(found.pitch_rad - observations.pitch_rad, other - observations.pitch_rad)
    return Inferred(error / UNIT_RAD, sure.pitch_half_95_rad / UNIT_RAD, found.pitch_half_95_rad / UNIT_RAD)


def _at_reference(axis: AxisCalibration, observations: Observations, temperature: Temperature) -> FloatArray:
    """Outputs as they would be at the reference temperature, by the known coefficients."""
    assert observations.temperature_degc is not None
    warmer, (by_offset, by_scale) = observations.temperature_degc - REFERENCE_DEGC, _coefficients(temperature)
    offset_v = float(axis.primary[0])
    return offset_v + (observations.outputs[axis.axis] - offset_v - by_offset * warmer) / (1.0 + by_scale * warmer)


def inferred_attitude(solved: Calibration, observations: Observations) -> tuple[Inferred, Inferred]:
    """Pitch and roll from three sensors; of (α, R) and (180° − α, R + 180°) the one nearer to what was set."""
    outputs = np.stack([observations.outputs[label] for label in solved.axes], axis=1)
    assert solved.package is not None
    package = CalibratedPackage([_line(axis, 0.0) for axis in solved.axes.values()], solved.package.components)
    noisy, sure = (
        pitch_roll_from_three(
            [_line(axis, sd * axis.standard_error_v) for axis in solved.axes.values()], outputs, package
        )
        for sd in (1.0, 0.0)
    )
    beyond = np.cos(observations.pitch_rad) < -1e-9
    pitch = np.where(beyond, np.pi - noisy.pitch_rad, noisy.pitch_rad) - observations.pitch_rad
    roll = np.where(beyond, noisy.roll_rad + np.pi, noisy.roll_rad) - observations.roll_rad
    at_zenith = np.abs(np.cos(observations.pitch_rad)) <= 1e-9
    pitch = np.where(at_zenith, _nearer(pitch, np.pi - noisy.pitch_rad - observations.pitch_rad), wrap_rad(pitch))
    return (
        Inferred(pitch / UNIT_RAD, sure.pitch_half_95_rad / UNIT_RAD, noisy.pitch_half_95_rad / UNIT_RAD),
        Inferred(wrap_rad(roll) / UNIT_RAD, sure.roll_half_95_rad / UNIT_RAD, noisy.roll_half_95_rad / UNIT_RAD),
    )


def _nearer(first_rad: FloatArray, second_rad: FloatArray) -> FloatArray:
    first, second = wrap_rad(first_rad), wrap_rad(second_rad)
    return np.where(np.abs(first) <= np.abs(second), first, second)


def _line(axis: AxisCalibration, reading_sd_v: float) -> CalibratedSensor:
    """(b, k) with the parts of their covariance; known temperature terms are taken out of the outputs beforehand."""
    kept = [index for index, name in enumerate(axis.primary_names) if name in LINE]
    square = np.ix_(kept, kept)
    parts = tuple(replace(part, covariance=part.covariance[square]) for part in axis.variance_components)
    names = [axis.primary_names[index] for index in kept]
    covariance = axis.primary_covariance[square]
    return CalibratedSensor(names, axis.primary[kept], covariance, reading_sd_v, np.zeros(1), parts)
