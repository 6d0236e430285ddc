"""Axes, angles and the specific force a package senses at rest.

Package axes are forward (x), right (y) and down (z). Pitch α is nose up, roll R right wing down, applied pitch first.
At rest the package senses f = (sin α, −cos α sin R, −cos α cos R), in units of local gravity. Source: TP (2), (4), (5)
and appendix A; checked against explicit rotations in the tests.
"""

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray, IntArray

Angle = TypeVar("Angle", float, FloatArray)

Array = NDArray[Any]
"""float64, or complex128 under a complex step."""

AXES = ("x", "y", "z")
ANGLES = ("pitch", "yaw", "roll")
"""From the outermost axis of a table in: the order of the columns of ``euler_rate_rad_s``."""
LEVEL_ANGLES = ("pitch", "roll")
"""What gravity alone tells of a package."""


@dataclass(frozen=True)
class Attitude:
    """Attitudes to evaluate a model at: arrays of the same length N, radians and °C."""

    pitch_rad: FloatArray
    roll_rad: FloatArray
    yaw_rad: FloatArray | None = None
    temperature_degc: FloatArray | None = None
    euler_rate_rad_s: FloatArray | None = None
    """(N, 3) rates of pitch, yaw and roll, for gyros."""
    reference_level: FloatArray | None = None
    """(N,) known value of the quantity, for straight lines."""
    level_errors: FloatArray | None = None
    """(N, q) what one standard uncertainty of each of q errors does to it."""
    scanned_v: FloatArray | None = None
    """(N, q) volts on each of the channels of a scanner that leaks."""
    gravity_errors_rad: FloatArray | None = None
    """(N, 3, q) along package axes, what one standard uncertainty of each of q errors turns gravity by."""
    time_s: FloatArray | None = None
    """(N,) seconds since the start of the run; None: at the reference time of a model with a time term."""
    mounting: IntArray | None = None
    """(N,) label of the mounting; None: the last."""
    from_level: FloatArray | None = None
    """(N, 3, 3) mean rotation from level axes into the package's while a row was read, for gyros."""


@dataclass(frozen=True)
class Exposure(Attitude):
    """What a coefficient set is applied at: an attitude or, for straight lines, the quantity itself."""

    package_level: FloatArray | None = None
    """(…, 3) along package axes, in the unit of the set, whatever the attitude."""


def specific_force(pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None) -> FloatArray:
    """Return the specific force in package axes, (N, 3), in units of local gravity.

    Source: TP (2), (4), (5); with yaw, between pitch and roll, CR (III-B.30) to (III-B.32) with the other sign.
    """
    cos_pitch = np.cos(pitch_rad)
    if yaw_rad is not None:
        return _yawed_and_rolled(np.sin(pitch_rad), np.zeros_like(pitch_rad), -cos_pitch, yaw_rad, roll_rad)
    return np.stack([np.sin(pitch_rad), -cos_pitch * np.sin(roll_rad), -cos_pitch * np.cos(roll_rad)], axis=-1)


def specific_force_by_pitch(
    pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None
) -> FloatArray:
    """Return ∂f/∂α, shape (N, 3), per radian."""
    sin_pitch = np.sin(pitch_rad)
    if yaw_rad is not None:
        return _yawed_and_rolled(np.cos(pitch_rad), np.zeros_like(pitch_rad), sin_pitch, yaw_rad, roll_rad)
    return np.stack([np.cos(pitch_rad), sin_pitch * np.sin(roll_rad), sin_pitch * np.cos(roll_rad)], axis=-1)


def specific_force_by_yaw(pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray) -> FloatArray:
    """Return the change of f by yaw, shape (N, 3), per radian: none at pitch 0, where the axis is upright."""
    sin_pitch, cos_yaw, sin_yaw = np.sin(pitch_rad), np.cos(yaw_rad), np.sin(yaw_rad)
    return _rolled(-sin_pitch * sin_yaw, -sin_pitch * cos_yaw, np.zeros_like(sin_pitch), roll_rad)


def specific_force_by_base(
    pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None
) -> FloatArray:
    """Return the change of f by a tilt of the base about its forward axis, shape (N, 3), per radian."""
    none = np.zeros_like(pitch_rad)
    if yaw_rad is None:
        return _rolled(none, np.ones_like(pitch_rad), none, roll_rad)
    return _yawed_and_rolled(none, np.ones_like(pitch_rad), none, yaw_rad, roll_rad)


def _yawed_and_rolled(
    x: FloatArray, y: FloatArray, z: FloatArray, yaw_rad: FloatArray, roll_rad: FloatArray
) -> FloatArray:
    """Return (N, 3) components in axes that are pitched already as they are in those of the package."""
    cos_yaw, sin_yaw = np.cos(yaw_rad), np.sin(yaw_rad)
    return _rolled(cos_yaw * x + sin_yaw * y, cos_yaw * y - sin_yaw * x, z, roll_rad)


def _rolled(x: FloatArray, y: FloatArray, z: FloatArray, roll_rad: FloatArray) -> FloatArray:
    cos_roll, sin_roll = np.cos(roll_rad), np.sin(roll_rad)
    return np.stack([x, cos_roll * y + sin_roll * z, cos_roll * z - sin_roll * y], axis=-1)


def specific_force_by_roll(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return ∂f/∂R, shape (N, 3), per radian."""
    cos_pitch = np.cos(pitch_rad)
    zero = np.zeros_like(cos_pitch * roll_rad)
    return np.stack([zero, -cos_pitch * np.cos(roll_rad), cos_pitch * np.sin(roll_rad)], axis=-1)


def specific_force_by_turn(
    pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return ∂f by a turn of the package on its mount about x, y and z, (N, 3) each, per radian: −e × f.

    About x it is a slip of roll.
    """
    force = specific_force(pitch_rad, roll_rad, yaw_rad)
    none = np.zeros_like(force[:, 0])
    return (
        np.stack([none, force[:, 2], -force[:, 1]], axis=1),
        np.stack([-force[:, 2], none, force[:, 0]], axis=1),
        np.stack([force[:, 1], -force[:, 0], none], axis=1),
    )


def from_level_axes(pitch_rad: FloatArray, yaw_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return (…, 3, 3) from level axes into those of a stage, pitch, yaw, roll from outside in. Source: CR III-B."""
    (cp, sp), (cy, sy), (cr, sr) = ((np.cos(angle), np.sin(angle)) for angle in (pitch_rad, yaw_rad, roll_rad))
    zero, ones = np.zeros_like(cp), np.ones_like(cp)
    by_pitch = _matrices([[cp, zero, -sp], [zero, ones, zero], [sp, zero, cp]])
    by_yaw = _matrices([[cy, sy, zero], [-sy, cy, zero], [zero, zero, ones]])
    by_roll = _matrices([[ones, zero, zero], [zero, cr, sr], [zero, -sr, cr]])
    return np.asarray(by_roll @ by_yaw @ by_pitch)


def _matrices(rows: list[list[FloatArray]]) -> FloatArray:
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def body_rates_rad_s(euler_rad: Array, euler_rate_rad_s: Array) -> Array:
    """Return the angular velocity in model axes, (N, 3).

    ``euler_rad`` and ``euler_rate_rad_s`` are (N, 3): pitch, yaw, roll and their rates. Source: CR (III-C.2) to (5).
    """
    _, yaw, roll = np.moveaxis(euler_rad, -1, 0)
    pitch_rate, yaw_rate, roll_rate = np.moveaxis(euler_rate_rad_s, -1, 0)
    c_yaw, s_yaw, c_roll, s_roll = np.cos(yaw), np.sin(yaw), np.cos(roll), np.sin(roll)
    return np.stack(
        [
            s_yaw * pitch_rate + roll_rate,
            c_yaw * c_roll * pitch_rate + s_roll * yaw_rate,
            -c_yaw * s_roll * pitch_rate + c_roll * yaw_rate,
        ],
        axis=-1,
    )


def beside_axis(euler_rad: FloatArray, axis: int) -> FloatArray:
    """Return (N, 2, 3), in model axes, the two directions beside an axis of rotation: pitch 0, yaw 1, roll 2.

    Pitch and yaw lean in what carries them, and turn with what they carry; roll leans in the model. ``euler_rad`` is
    (N, 3): pitch, yaw, roll.
    """
    _, yaw, roll = np.moveaxis(euler_rad, -1, 0)
    c_yaw, s_yaw, c_roll, s_roll = np.cos(yaw), np.sin(yaw), np.cos(roll), np.sin(roll)
    whole, nothing = np.ones_like(roll), np.zeros_like(roll)
    beside = {
        0: ((c_yaw, -s_yaw * c_roll, s_yaw * s_roll), (nothing, s_roll, c_roll)),
        1: ((whole, nothing, nothing), (nothing, c_roll, -s_roll)),
        2: ((nothing, whole, nothing), (nothing, nothing, whole)),
    }[axis]
    return np.stack([np.stack(direction, axis=-1) for direction in beside], axis=1)


def euler_rates_rad_s(euler_rad: Array, body_rate_rad_s: Array) -> Array:
    """Return Euler rates (N, 3), the inverse of :func:`body_rates_rad_s`; no value at yaw ±90°. Source: CR (IV-D.4)."""
    _, yaw, roll = np.moveaxis(euler_rad, -1, 0)
    w_x, w_y, w_z = np.moveaxis(body_rate_rad_s, -1, 0)
    c_roll, s_roll = np.cos(roll), np.sin(roll)
    pitch_rate = (c_roll * w_y - s_roll * w_z) / np.cos(yaw)
    return np.stack([pitch_rate, s_roll * w_y + c_roll * w_z, w_x - np.sin(yaw) * pitch_rate], axis=-1)


def wrap_rad(angle_rad: FloatArray) -> FloatArray:
    """Return the same angle in (−π, π]."""
    return np.pi - np.mod(np.pi - angle_rad, 2.0 * np.pi)


def wrap_deg(angle_deg: Angle) -> Angle:
    """Return the same angle in (−180°, 180°]."""
    return 180.0 - (180.0 - angle_deg) % 360.0
