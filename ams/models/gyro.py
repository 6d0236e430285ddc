"""The gyro model of CR: a rate sensor senses the package's angular velocity along its misaligned axis.

It is CR's accelerometer model with another field: the angular velocity in package axes, which the rates of the angles
build up, Θ̇ about the first intermediate y, Ψ̇ about the sting's z, Φ̇ about the model's x. So it is linear in
(b, S·u) as well, and the same exact solution serves. Source: CR (III-C.1) to (III-C.18), (IV-C.1) to (IV-C.18).
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from math import degrees
from typing import ClassVar

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError
from ams.frames import Attitude, body_rates_rad_s, wrap_deg
from ams.models.accelerometer import PitchRoll
from ams.models.cr import SensorFit, fit_package
from ams.models.cr_sets import along_cr, cr_equation
from ams.models.model import LinearModel, Stimulus
from ams.models.sensor_model import RATE_INPUTS, SensorModel, SetForm

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}
_DEG_PER_RAD = degrees(1.0)


def fit_gyros(
    euler_rad: FloatArray, euler_rate_rad_s: FloatArray, outputs_v: Mapping[str, FloatArray]
) -> dict[str, SensorFit]:
    """Fit every gyro of the package, keyed by axis, with its covariance; sensitivities in V per (rad/s).

    The covariance takes the samples' noise as white; filtered samples have fewer degrees of freedom than rows.
    Raises: DesignError where the motion does not turn the angular velocity in three dimensions.
    """
    return fit_package(body_rates_rad_s(euler_rad, euler_rate_rad_s), outputs_v)


@dataclass(frozen=True)
class Gyro(LinearModel):
    """CR (III-C.16) to (III-C.18) for the solvers; the primary parameters are b and k = S·u per °/s, package axes."""

    nominal_axis: str
    name: ClassVar[str] = "gyro"
    convention: ClassVar[str] = "CR"
    measured_unit: ClassVar[str] = "v"
    primary_names: ClassVar[tuple[str, ...]] = ("offset_v", "k_x_v_per_dps", "k_y_v_per_dps", "k_z_v_per_dps")
    parameter_names: ClassVar[tuple[str, ...]] = ("offset_v", "sensitivity_v_per_dps", "coning_deg", "azimuth_deg")
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED
    basis_key: ClassVar[Hashable | None] = "gyro"

    def basis(self, stimulus: Stimulus) -> FloatArray:
        euler, rate = _motion(stimulus)
        velocity_dps = _DEG_PER_RAD * body_rates_rad_s(euler, rate)
        return np.concatenate([np.ones((velocity_dps.shape[0], 1)), velocity_dps], axis=1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        euler, rate = _motion(stimulus)
        k = np.rad2deg(primary[1:4])
        _, yaw, roll = np.moveaxis(euler, -1, 0)
        _, w_y, w_z = np.moveaxis(body_rates_rad_s(euler, rate), -1, 0)
        pitch_rate = rate[:, 0]
        by_yaw = pitch_rate[:, None] * np.stack(
            [np.cos(yaw), -np.sin(yaw) * np.cos(roll), np.sin(yaw) * np.sin(roll)], axis=-1
        )
        return {"pitch": np.zeros_like(yaw), "yaw": by_yaw @ k, "roll": w_z * k[1] - w_y * k[2]}

    def parameters(self, primary: FloatArray) -> FloatArray:
        found = PitchRoll(self.nominal_axis).parameters(primary)
        found[..., 3] = wrap_deg(found[..., 3] + 90.0)
        return found

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        return PitchRoll(self.nominal_axis).parameters_jacobian(primary)

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        return PitchRoll(self.nominal_axis).undetermined(primary, covariance)


def _motion(stimulus: Stimulus) -> tuple[FloatArray, FloatArray]:
    """Return (N, 3) pitch, yaw, roll and their rates; without yaw it is zero."""
    if stimulus.euler_rate_rad_s is None:
        raise ObservationsError(
            "model gyro: the observations have no rates: it needs the columns pitch_rate_dps, yaw_rate_dps and "
            "roll_rate_dps; nothing was solved; use an accelerometer's model where nothing turned"
        )
    yaw = np.zeros_like(stimulus.roll_rad) if stimulus.yaw_rad is None else stimulus.yaw_rad
    return np.stack(np.broadcast_arrays(stimulus.pitch_rad, yaw, stimulus.roll_rad), axis=-1), stimulus.euler_rate_rad_s


PER_DPS = ("k_x_v_per_dps", "k_y_v_per_dps", "k_z_v_per_dps")
_SOURCES = ("CR (III-C.16)", "CR (III-C.17)", "CR (III-C.18)")
_C_RATES = """
    (void)pitch;
    f[0] = sin(yaw) * pitch_rate_dps + roll_rate_dps;
    f[1] = cos(yaw) * cos(roll) * pitch_rate_dps + sin(roll) * yaw_rate_dps;
    f[2] = -cos(yaw) * sin(roll) * pitch_rate_dps + cos(roll) * yaw_rate_dps;
"""


def _velocity_dps(attitude: Attitude) -> FloatArray:
    """Return the (…, 3) angular velocity in package axes."""
    assert attitude.yaw_rad is not None, "the inputs of the model say so"
    assert attitude.euler_rate_rad_s is not None, "the inputs of the model say so"
    euler = np.stack(np.broadcast_arrays(attitude.pitch_rad, attitude.yaw_rad, attitude.roll_rad), axis=-1)
    return np.asarray(np.rad2deg(body_rates_rad_s(euler, attitude.euler_rate_rad_s)))


GYRO = SensorModel(
    name="gyro",
    make=Gyro,
    columns=("yaw", "roll"),
    needs_rates=True,
    set_form=SetForm(
        convention="CR",
        symbol="w",
        inputs=("pitch_deg", "roll_deg", "yaw_deg", *RATE_INPUTS),
        field=_velocity_dps,
        equation=lambda axis: cr_equation(axis, "w", PER_DPS, "sensitivity_v_per_dps", _SOURCES),
        directions=PER_DPS,
        along=along_cr,
        c_field=_C_RATES,
        senses_rates=True,
        unit="dps",
    ),
)
