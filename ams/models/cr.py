"""CR's sensors and what they sense: two packages on one sting, pitch, yaw and roll.

Every CR sensor is linear in its offset and in k = S·u, where u is the unit vector of its sensitive axis in the axes of
its own package and the field it senses is gravity in those axes, in units of local g. A sensor nominally along axis i
(cyclic: x, y, z, x, y) has, after the azimuth rotation first and the coning rotation second (III-B.7 to 12),

    u = cos C e_i + sin C (sin A e_{i+1} − cos A e_{i+2}).

The sting package is the model package at zero roll, so one model serves both. Tunnel axes: z down, gravity (0, 0, −G)
before the first half turn about y. Source: CR (III-B.1) to (III-B.26). They are solved by
:mod:`ams.models.pitch_yaw_roll` and :mod:`ams.models.gyro`.

All functions accept complex numbers, so that their derivatives can be checked by a complex step.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.frames import AXES

Array = NDArray[Any]
"""float64, or complex128 under a complex step."""


@dataclass(frozen=True)
class CrSensor:
    """One sensor in CR's convention: accelerometer (V/g) or gyro (V/(rad/s))."""

    axis: str
    """Nominal axis: ``x``, ``y`` or ``z``."""
    bias_v: float
    sensitivity: float
    """Signed; V per g for an accelerometer, V per (rad/s) for a gyro."""
    azimuth_rad: float
    coning_rad: float
    """0 to π/2."""

    @property
    def k(self) -> FloatArray:
        """(3,) sensitivity times the sensitive axis, in package axes."""
        return self.sensitivity * sensitive_axis(self.axis, self.azimuth_rad, self.coning_rad)


def sting_gravity_g(pitch_rad: Array, yaw_rad: Array) -> Array:
    """Return gravity in sting axes, (N, 3), in units of local g. Source: CR (III-B.6), (IV-B.3) to (IV-B.5)."""
    pitch, yaw = np.broadcast_arrays(pitch_rad, yaw_rad)
    return np.stack([-np.sin(pitch) * np.cos(yaw), np.sin(pitch) * np.sin(yaw), np.cos(pitch)], axis=-1)


def model_gravity_g(sting_g: Array, roll_rad: Array) -> Array:
    """Return gravity in model axes, (N, 3), from gravity in sting axes and roll. Source: CR (III-B.5)."""
    g_x, g_y, g_z = np.moveaxis(np.asarray(sting_g), -1, 0)
    c, s = np.cos(roll_rad), np.sin(roll_rad)
    return np.stack([g_x + 0 * c, c * g_y + s * g_z, -s * g_y + c * g_z], axis=-1)


def sensitive_axis(axis: str, azimuth_rad: Any, coning_rad: Any) -> Array:
    """Return the unit vector of the sensitive axis in package axes, (3,)."""
    i = AXES.index(axis)
    u: list[Any] = [0.0, 0.0, 0.0]
    u[i] = np.cos(coning_rad)
    u[(i + 1) % 3] = np.sin(coning_rad) * np.sin(azimuth_rad)
    u[(i + 2) % 3] = -np.sin(coning_rad) * np.cos(azimuth_rad)
    return np.array(u)
