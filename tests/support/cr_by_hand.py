"""CR's outputs in (B, S, A, C) and their derivatives, by hand: the reference for the models that calrig solves.

Source: CR (III-B.27) to (III-B.32), (III-C.16) to (III-C.18), (IV-A.7) to (IV-A.32).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.errors import DesignError
from ams.frames import AXES
from ams.models.cr import CrSensor, sensitive_axis

Array = NDArray[Any]
"""float64, or complex128 under a complex step."""


def predict_v(axis: str, parameters: Array, field: Array) -> Array:
    """Return the output in volts, (N,).

    ``parameters`` is (B, S, A, C) in volts, volts per unit of field, radians; ``field`` is (N, 3): gravity in g, or the
    angular velocity in rad/s for a gyro. Source: CR (III-B.27) to (III-B.32), (III-C.16) to (III-C.18).
    """
    bias, sensitivity, azimuth, coning = parameters
    return np.asarray(bias + sensitivity * (field @ sensitive_axis(axis, azimuth, coning)))


def jacobian(axis: str, parameters: Array, field: Array) -> Array:
    """Return the derivatives by (B, S, A, C), (N, 4). Source: CR (IV-A.7) to (IV-A.32), derived anew."""
    _, sensitivity, azimuth, coning = parameters
    i = AXES.index(axis)
    along, first, second = field[:, i], field[:, (i + 1) % 3], field[:, (i + 2) % 3]
    c_a, s_a, c_c, s_c = np.cos(azimuth), np.sin(azimuth), np.cos(coning), np.sin(coning)
    across = s_a * first - c_a * second
    return np.stack(
        [
            np.ones_like(along),
            c_c * along + s_c * across,
            sensitivity * s_c * (c_a * first + s_a * second),
            sensitivity * (-s_c * along + c_c * across),
        ],
        axis=1,
    )


def sensor_from_linear(axis: str, linear: FloatArray) -> CrSensor:
    """Return the sensor on the branch C ≤ 90° with signed S from (b, k_x, k_y, k_z)."""
    i = AXES.index(axis)
    k = np.asarray(linear[1:], dtype=float)
    norm = float(np.linalg.norm(k))
    if norm == 0.0:
        raise DesignError(f"sensor {axis}: the sensitivity is zero: it has no sensitive axis; check its wiring")
    sign = -1.0 if k[i] < 0 else 1.0
    first, second = sign * k[(i + 1) % 3], sign * k[(i + 2) % 3]
    coning = float(np.arctan2(np.hypot(first, second), abs(k[i])))
    azimuth = float(np.arctan2(first + 0.0, -second)) if coning > 0 else 0.0
    return CrSensor(axis, float(linear[0]), sign * norm, azimuth, coning)
