"""Pitch, yaw and roll of CR's frames from gyro outputs.

Body rates are multiplied up as quaternions, a million at a time (:mod:`ams.attitude.rate_scan`), and the angles read
off, continuous from the start. CR's own way stays beside it to be compared with: (IV-D.4) turns outputs into Euler
rates, (IV-D.6) and (IV-D.7) advance them by Butcher's fifth-order method with six evaluations at 0, ¼, ¼, ½, ¾ and 1
of an interval. Between samples the outputs are interpolated: holding them constant over the step, as CR's listing does,
costs 0.16° on the report's own profile at 100 Hz, linear interpolation 0.00024°, cubic less. Source: CR IV-D,
appendix E.
"""

from math import cos, sin
from typing import Final, Literal, Never

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.rate_scan import Interpolation
from ams.errors import SolveError

Method = Literal["quaternion", "butcher"]
_Triple = tuple[float, float, float]

SMALLEST_COS_YAW: Final = 1e-3
_CROSSED_RAD: Final = 0.75 * float(np.pi)
"""Pitch and roll both turn by half a turn where yaw passes ±90°."""
_QUARTERS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)


def quaternion_of_cr(angles_rad: FloatArray) -> FloatArray:
    """Return the quaternion, model to tunnel, of (3,) pitch, yaw and roll: turns about y, the new z, the new x."""
    (s_p, s_y, s_r), (c_p, c_y, c_r) = np.sin(np.asarray(angles_rad) / 2.0), np.cos(np.asarray(angles_rad) / 2.0)
    return np.array(
        [
            c_p * c_y * s_r + s_p * s_y * c_r,
            s_p * c_y * c_r + c_p * s_y * s_r,
            c_p * s_y * c_r - s_p * c_y * s_r,
            c_p * c_y * c_r - s_p * s_y * s_r,
        ]
    )


def cr_angles_rad(quaternion: FloatArray, start_rad: FloatArray) -> FloatArray:
    """Return pitch, yaw and roll, (3, n), of (4, n) quaternions, continuous from the angles that the first one has.

    Raises: SolveError where yaw comes within 0.06° of ±90° or crosses it: pitch and roll merge there.
    """
    x, y, z, w = quaternion
    side = 1.0 if cos(float(start_rad[1])) >= 0.0 else -1.0
    ahead_x, ahead_z = side * (1.0 - 2.0 * (y * y + z * z)), side * 2.0 * (x * z - w * y)
    sine, level = 2.0 * (x * y + w * z), np.hypot(ahead_x, ahead_z)
    roll_y, roll_z = side * (1.0 - 2.0 * (x * x + z * z)), side * 2.0 * (y * z - w * x)
    pitch, roll = np.unwrap(np.arctan2(-ahead_z, ahead_x)), np.unwrap(np.arctan2(-roll_z, roll_y))
    near = level[:-1] < SMALLEST_COS_YAW
    near |= (np.abs(np.diff(pitch)) > _CROSSED_RAD) & (np.abs(np.diff(roll)) > _CROSSED_RAD)
    yaw = np.unwrap(np.arctan2(sine, side * level))
    if near.any():
        _refuse_yaw(float(yaw[np.argmax(near)]), int(np.argmax(near)))
    angles = np.stack([pitch, yaw, roll])
    whole_turns = np.round((start_rad - angles[:, 0]) / (2.0 * np.pi))
    return np.asarray(angles + 2.0 * np.pi * whole_turns[:, None])


def _refuse_yaw(yaw_rad: float, sample: int) -> Never:
    raise SolveError(
        f"gyro: yaw is {np.degrees(yaw_rad):.3f}° at sample {sample}: Euler's rates have no value at ±90° and "
        "cannot be carried across; integrate the quaternion instead"
    )


def path_by_butcher(
    start: FloatArray, rates_rad_s: FloatArray, steps: slice, interval_s: float, interpolation: Interpolation
) -> FloatArray:
    """Return the attitudes along some steps by Butcher's method: a :data:`ams.attitude.rate_scan.Path`.

    Raises: SolveError where yaw comes within 0.06° of ±90°.
    """
    angles = cr_angles_rad(start[:, None], np.zeros(3))[:, 0]
    between = _between(rates_rad_s.T, interpolation)[steps]
    return quaternion_of_cr(_by_butcher(between, angles, interval_s).T)


def _by_butcher(between: FloatArray, start_rad: FloatArray, interval_s: float) -> FloatArray:
    """Return (m + 1, 3) angles from the rates at the quarters of m intervals, (m, 5, 3)."""
    angles: _Triple = (float(start_rad[0]), float(start_rad[1]), float(start_rad[2]))
    path = np.empty((len(between) + 1, 3))
    path[0] = angles
    side = 1.0 if cos(angles[1]) >= 0.0 else -1.0
    for n, rates in enumerate(between.tolist()):
        if side * cos(angles[1]) < SMALLEST_COS_YAW:
            _refuse_yaw(angles[1], n)
        angles = _butcher_step(angles, rates, interval_s)
        path[n + 1] = angles
    return path


def _butcher_step(angles: _Triple, rates: list[_Triple], h: float) -> _Triple:
    """Take one step of (IV-D.6), (IV-D.7); ``rates`` at the five quarters of the interval."""
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
    """Return :func:`ams.frames.euler_rates_rad_s` for one sample.

    On plain floats: forty times faster in a loop.
    """
    _, yaw, roll = angles
    w_x, w_y, w_z = rate
    c_roll, s_roll = cos(roll), sin(roll)
    pitch_rate = (c_roll * w_y - s_roll * w_z) / cos(yaw)
    return pitch_rate, s_roll * w_y + c_roll * w_z, w_x - sin(yaw) * pitch_rate


def _between(samples: FloatArray, interpolation: Interpolation) -> FloatArray:
    """Return the values at the quarters of every interval, (N − 1, 5, 3)."""
    at = np.array(_QUARTERS)
    first, last = samples[:-1, None, :], samples[1:, None, :]
    if interpolation == "hold":
        return np.repeat(first, 5, axis=1)
    if interpolation == "linear":
        return np.asarray(first + at[:, None] * (last - first))
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
