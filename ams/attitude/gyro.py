"""Pitch, yaw and roll from gyro outputs: Euler's rates integrated by Butcher's fifth-order method.

(IV-D.4) turns outputs into Euler rates that depend on the angles themselves; (IV-D.6) and (IV-D.7) advance them over
one sample interval with six evaluations at 0, ¼, ¼, ½, ¾ and 1 of it. Between samples the outputs are interpolated:
holding them constant over the step, as CR's listing does, costs 0.16° on the report's own profile at 100 Hz, linear
interpolation 0.00024°, cubic less. Source: CR IV-D, appendix E.
"""

from collections.abc import Mapping
from math import cos, sin
from typing import Final, Literal

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError, SolveError
from ams.models.cr import CrSensor, sensed_field

Interpolation = Literal["cubic", "linear", "hold"]
_Triple = tuple[float, float, float]

SMALLEST_COS_YAW: Final = 1e-3
_QUARTERS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)


def integrate_outputs(
    sensors: Mapping[str, CrSensor],
    outputs_v: Mapping[str, FloatArray],
    start_rad: FloatArray,
    interval_s: float,
    interpolation: Interpolation = "cubic",
) -> FloatArray:
    """Pitch, yaw, roll at every sample, (N, 3), from gyro outputs (N,) and the angles at the first sample.

    Raises: as :func:`integrate_rates`; DesignError where the sensors do not resolve three directions.
    """
    return integrate_rates(sensed_field(sensors, outputs_v), start_rad, interval_s, interpolation)


def integrate_rates(
    body_rate_rad_s: FloatArray, start_rad: FloatArray, interval_s: float, interpolation: Interpolation = "cubic"
) -> FloatArray:
    """Pitch, yaw, roll at every sample, (N, 3), from angular velocity in model axes, (N, 3), evenly sampled.

    Raises: ObservationsError with fewer than two samples (four for cubic) or an interval that is not positive;
    SolveError where yaw comes within 0.06° of ±90° or crosses it, where Euler's rates have no value.
    """
    needed = 4 if interpolation == "cubic" else 2
    if body_rate_rad_s.shape[0] < needed or not interval_s > 0:
        raise ObservationsError(
            f"gyro: got {body_rate_rad_s.shape[0]} samples at an interval of {interval_s:g} s: {interpolation} "
            f"interpolation needs {needed} samples or more and an interval above 0 s"
        )
    between = _between(body_rate_rad_s, interpolation)
    angles: _Triple = (float(start_rad[0]), float(start_rad[1]), float(start_rad[2]))
    path = np.empty_like(body_rate_rad_s, dtype=float)
    path[0] = angles
    side = 1.0 if cos(angles[1]) >= 0.0 else -1.0
    for n, rates in enumerate(between.tolist()):
        if side * cos(angles[1]) < SMALLEST_COS_YAW:
            raise SolveError(
                f"gyro: yaw is {np.degrees(angles[1]):.3f}° at sample {n}: Euler's rates have no value at ±90° and "
                "cannot be carried across; integrate the quaternion instead"
            )
        angles = _butcher_step(angles, rates, interval_s)
        path[n + 1] = angles
    return path


def _butcher_step(angles: _Triple, rates: list[_Triple], h: float) -> _Triple:
    """One step of (IV-D.6), (IV-D.7); ``rates`` at the five quarters of the interval."""
    k1 = _euler_rates(angles, rates[0])
    k2 = _euler_rates(_moved(angles, h / 4, (1.0, k1)), rates[1])
    k3 = _euler_rates(_moved(angles, h / 8, (1.0, k1), (1.0, k2)), rates[1])
    k4 = _euler_rates(_moved(angles, h / 2, (-1.0, k2), (2.0, k3)), rates[2])
    k5 = _euler_rates(_moved(angles, 3 * h / 16, (1.0, k1), (3.0, k4)), rates[3])
    k6 = _euler_rates(_moved(angles, h / 7, (-3.0, k1), (2.0, k2), (12.0, k3), (-12.0, k4), (8.0, k5)), rates[4])
    return _moved(angles, h / 90, (7.0, k1), (32.0, k3), (12.0, k4), (32.0, k5), (7.0, k6))


def _moved(angles: _Triple, factor: float, *terms: tuple[float, _Triple]) -> _Triple:
    pitch, yaw, roll = angles
    for weight, (d_pitch, d_yaw, d_roll) in terms:
        scale = factor * weight
        pitch, yaw, roll = pitch + scale * d_pitch, yaw + scale * d_yaw, roll + scale * d_roll
    return pitch, yaw, roll


def _euler_rates(angles: _Triple, rate: _Triple) -> _Triple:
    """:func:`ams.frames.euler_rates_rad_s` for one sample, on plain floats: forty times faster in a loop."""
    _, yaw, roll = angles
    w_x, w_y, w_z = rate
    c_roll, s_roll = cos(roll), sin(roll)
    pitch_rate = (c_roll * w_y - s_roll * w_z) / cos(yaw)
    return pitch_rate, s_roll * w_y + c_roll * w_z, w_x - sin(yaw) * pitch_rate


def _between(samples: FloatArray, interpolation: Interpolation) -> FloatArray:
    """Values at the quarters of every interval, (N − 1, 5, 3)."""
    at = np.array(_QUARTERS)
    first, last = samples[:-1, None, :], samples[1:, None, :]
    if interpolation == "hold":
        return np.repeat(first, 5, axis=1)
    if interpolation == "linear":
        return np.asarray(first + at[:, None] * (last - first))
    return _between_cubic(samples, at)


def _between_cubic(samples: FloatArray, at: FloatArray) -> FloatArray:
    """Four-point Lagrange interpolation, one-sided in the first and the last interval."""
    count = samples.shape[0]
    interval = np.arange(count - 1)
    left = np.clip(interval - 1, 0, count - 4)
    nodes = samples[left[:, None] + np.arange(4)]
    x = (interval - left)[:, None] + at
    weights = np.stack([_lagrange(x, j) for j in range(4)], axis=-1)
    return np.asarray(np.einsum("nqj,njc->nqc", weights, nodes))


def _lagrange(x: FloatArray, j: int) -> FloatArray:
    weight = np.ones_like(x)
    for m in range(4):
        if m != j:
            weight = weight * (x - m) / (j - m)
    return weight
