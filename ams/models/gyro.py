"""The gyro model of CR: a rate sensor senses the model's angular velocity along its misaligned axis.

It is the accelerometer model of :mod:`ams.models.cr` with another field: the angular velocity in model axes, which the
Euler rates build up, Θ̇ about the first intermediate y, Ψ̇ about the sting's z, Φ̇ about the model's x. So it is linear
in (b, S·u) as well, and the same exact solution serves. Source: CR (III-C.1) to (III-C.18), (IV-C.1) to (IV-C.18).
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ams.models.cr import SensorFit, fit_package

FloatArray = NDArray[np.float64]
Array = NDArray[Any]


def body_rates_rad_s(euler_rad: Array, euler_rate_rad_s: Array) -> Array:
    """Angular velocity in model axes, (N, 3).

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


def euler_rates_rad_s(euler_rad: Array, body_rate_rad_s: Array) -> Array:
    """The inverse of :func:`body_rates_rad_s`, (N, 3); it has no value at yaw ±90°. Source: CR (IV-D.4)."""
    _, yaw, roll = np.moveaxis(euler_rad, -1, 0)
    w_x, w_y, w_z = np.moveaxis(body_rate_rad_s, -1, 0)
    c_roll, s_roll = np.cos(roll), np.sin(roll)
    pitch_rate = (c_roll * w_y - s_roll * w_z) / np.cos(yaw)
    return np.stack([pitch_rate, s_roll * w_y + c_roll * w_z, w_x - np.sin(yaw) * pitch_rate], axis=-1)


def fit_gyros(
    euler_rad: FloatArray, euler_rate_rad_s: FloatArray, outputs_v: Mapping[str, FloatArray]
) -> dict[str, SensorFit]:
    """Every gyro of the package, keyed by axis, with its covariance; sensitivities in V per (rad/s).

    The covariance takes the samples' noise as white; filtered samples have fewer degrees of freedom than rows.
    Raises: DesignError where the motion does not turn the angular velocity in three dimensions.
    """
    return fit_package(body_rates_rad_s(euler_rad, euler_rate_rad_s), outputs_v)
