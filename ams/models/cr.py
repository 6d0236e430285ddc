"""The accelerometer models of CR: two packages on one sting, pitch, yaw and roll.

Every CR sensor is linear in its offset and in k = S·u, where u is the unit vector of its sensitive axis in the axes of
its own package and the field it senses is gravity in those axes, in units of local g. A sensor nominally along axis i
(cyclic: x, y, z, x, y) has, after the azimuth rotation first and the coning rotation second (III-B.7 to 12),

    u = cos C e_i + sin C (sin A e_{i+1} − cos A e_{i+2}).

The sting package is the model package at zero roll, so one model serves both. Tunnel axes: z down, gravity (0, 0, −G)
before the first half turn about y. Source: CR (III-B.1) to (III-B.32), (IV-A.7) to (IV-A.32).

All functions accept complex numbers, so that their derivatives can be checked by a complex step.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.errors import DesignError
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


@dataclass(frozen=True)
class SensorFit:
    """One sensor with what least squares knows about it, for rows of equal and independent noise."""

    sensor: CrSensor
    linear: FloatArray
    """(4,) b and k."""
    linear_covariance: FloatArray
    """(4, 4) S_E² R⁻¹ as TP (50)."""
    standard_error_v: float
    degrees_of_freedom: int

    def standard_uncertainties(self) -> Mapping[str, float | None]:
        """Return those of bias, sensitivity, azimuth and coning, in the units of :class:`CrSensor`.

        Azimuth and coning are None where the coning angle is within five of its standard uncertainties of zero: its
        direction cannot be told there, while b and k stay well defined.
        """
        sensor = self.sensor
        i = AXES.index(sensor.axis)
        across = self.linear_covariance[1:, 1:][np.ix_([(i + 1) % 3, (i + 2) % 3], [(i + 1) % 3, (i + 2) % 3])]
        coning_u = float(np.sqrt(np.linalg.eigvalsh(across)[-1]) / abs(sensor.sensitivity))
        u = sensitive_axis(sensor.axis, sensor.azimuth_rad, sensor.coning_rad)
        k_covariance = self.linear_covariance[1:, 1:]
        found: dict[str, float | None] = {
            "bias_v": float(np.sqrt(self.linear_covariance[0, 0])),
            "sensitivity": float(np.sqrt(u @ k_covariance @ u)),
            "azimuth_rad": None,
            "coning_rad": None,
        }
        if sensor.coning_rad > 5.0 * coning_u:
            slopes = np.stack([u, *self._turned_axes()], axis=1)
            covariance = np.linalg.solve(slopes, np.linalg.solve(slopes, k_covariance).T)
            found["azimuth_rad"], found["coning_rad"] = (float(np.sqrt(v)) for v in np.diag(covariance)[1:])
        return found

    def _turned_axes(self) -> tuple[FloatArray, FloatArray]:
        """Return ∂k/∂A and ∂k/∂C, (3,) each."""
        by = jacobian(
            self.sensor.axis,
            np.array([0.0, self.sensor.sensitivity, self.sensor.azimuth_rad, self.sensor.coning_rad]),
            np.eye(3),
        )
        return by[:, 2], by[:, 3]


def fit_sensor(axis: str, field: FloatArray, output_v: FloatArray) -> SensorFit:
    """Fit one sensor to (N, 3) field and (N,) outputs by exact, start-free least squares.

    Raises: DesignError where there are fewer than five rows, or the field does not span three dimensions and an offset.
    """
    basis = np.column_stack([np.ones(field.shape[0]), field])
    scale = np.linalg.norm(basis, axis=0)
    scale[scale == 0] = 1.0
    q, r = np.linalg.qr(basis / scale)
    singular = np.linalg.svd(r, compute_uv=False)
    rank = int(np.sum(singular > 1e-13 * singular[0]))
    if rank < 4 or basis.shape[0] < 5:
        raise DesignError(
            f"CR model: {field.shape[0]} rows determine only {rank} of offset and three sensitivities "
            f"(singular values {', '.join(f'{s:.2g}' for s in singular)}); "
            "five rows or more are needed, and the attitudes must turn the field about at least two axes"
        )
    inverse = np.linalg.inv(r) / scale[:, None]
    linear = inverse @ (q.T @ output_v)
    linear = linear + inverse @ (q.T @ (output_v - basis @ linear))
    residuals = output_v - basis @ linear
    dof = basis.shape[0] - 4
    variance = float(residuals @ residuals) / dof
    return SensorFit(
        sensor_from_linear(axis, linear), linear, variance * inverse @ inverse.T, float(np.sqrt(variance)), dof
    )


def fit_package(field: FloatArray, outputs_v: Mapping[str, FloatArray]) -> dict[str, SensorFit]:
    """Fit every sensor of one package, keyed by axis."""
    return {axis: fit_sensor(axis, field, output) for axis, output in outputs_v.items()}


def calibrate_package(field: FloatArray, outputs_v: Mapping[str, FloatArray]) -> dict[str, CrSensor]:
    """Fit as :func:`fit_package` does; return the sensors alone."""
    return {axis: fit.sensor for axis, fit in fit_package(field, outputs_v).items()}


def sensed_field(sensors: Mapping[str, CrSensor], outputs_v: Mapping[str, FloatArray]) -> FloatArray:
    """Return the field in package axes, (N, 3), from the outputs of a three-axis package.

    Source: CR (IV-B.1), (IV-B.2), (IV-D.1). Raises: DesignError where the sensitive axes do not span space.
    """
    K = np.stack([sensors[axis].k for axis in AXES])
    if abs(np.linalg.det(K / np.linalg.norm(K, axis=1)[:, None])) < 1e-9:
        raise DesignError("CR package: the three sensitive axes lie in one plane: the field cannot be resolved")
    volts = np.stack([outputs_v[axis] - sensors[axis].bias_v for axis in AXES], axis=-1)
    return np.asarray(np.linalg.solve(K, volts[..., None])[..., 0], dtype=float)


@dataclass(frozen=True)
class CrPair:
    """A calibrated sting package and a calibrated model package."""

    sting: Mapping[str, CrSensor]
    model: Mapping[str, CrSensor]


def calibrate_pair(
    pitch_rad: FloatArray,
    yaw_rad: FloatArray,
    roll_rad: FloatArray,
    sting_v: Mapping[str, FloatArray],
    model_v: Mapping[str, FloatArray],
    *,
    gravity_from_sting: bool = False,
) -> CrPair:
    """Calibrate in two steps: the sting package from pitch and yaw, then the model package.

    The latter takes roll and gravity in sting axes.

    ``gravity_from_sting`` takes the second step's gravity from the sting package just calibrated instead of from the
    table's angles: what a tunnel does where the sting's own angles are not known. Source: CR IV-A.

    For users of the library who have arrays: runs and files are solved by :mod:`ams.models.pitch_yaw_roll`.
    """
    gravity = sting_gravity_g(pitch_rad, yaw_rad)
    sting = calibrate_package(gravity, sting_v)
    if gravity_from_sting:
        gravity = sensed_field(sting, sting_v)
    return CrPair(sting, calibrate_package(model_gravity_g(gravity, roll_rad), model_v))
