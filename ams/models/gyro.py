"""The gyro model of CR: a rate sensor senses the package's angular velocity along its misaligned axis.

It is CR's accelerometer model with another field: the angular velocity in package axes, which the rates of the angles
build up, Θ̇ about the first intermediate y, Ψ̇ about the sting's z, Φ̇ about the model's x. So it is linear in
(b, S·u) as well, and the same exact solution serves. Source: CR (III-C.1) to (III-C.18), (IV-C.1) to (IV-C.18).
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees
from typing import ClassVar

import numpy as np

from ams.arrays import Centring, FloatArray
from ams.errors import ObservationsError
from ams.frames import Attitude, body_rates_rad_s, from_level_axes, wrap_deg
from ams.models.accelerometer import PitchRoll
from ams.models.cr_sets import along_cr, cr_equation
from ams.models.extended import linear_part
from ams.models.model import LinearModel, Stimulus
from ams.models.rate_terms import (
    RATE_TERM_NAMES,
    RATE_TERMS,
    centred_rate_terms,
    rate_centring_over,
    slope_of_rate_terms,
)
from ams.models.sensor_model import RATE_INPUTS, Equation, SensorModel, SetForm

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}
_DEG_PER_RAD = degrees(1.0)
_STILL = 1e-3
"""Of the largest rate: a row that is slower stands."""


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
        return linear_part(velocity_of_dps(stimulus))

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        return _by_angle(np.broadcast_to(primary[1:4], (stimulus.roll_rad.size, 3)), stimulus)

    def parameters(self, primary: FloatArray) -> FloatArray:
        found = PitchRoll(self.nominal_axis).parameters(primary)
        found[..., 3] = wrap_deg(found[..., 3] + 90.0)
        return found

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        return PitchRoll(self.nominal_axis).parameters_jacobian(primary)

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        return PitchRoll(self.nominal_axis).undetermined(primary, covariance)


@dataclass(frozen=True)
class GyroWithTerms(LinearModel):
    """The same gyro with the nonlinearity of its scale factor beside it (:mod:`ams.models.rate_terms`)."""

    nominal_axis: str
    centring: Centring
    """(t, 4) what is taken off each term: of the square alone, or of both."""
    name: ClassVar[str] = Gyro.name
    convention: ClassVar[str] = Gyro.convention
    measured_unit: ClassVar[str] = Gyro.measured_unit
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED

    @property
    def term_names(self) -> tuple[str, ...]:
        return RATE_TERM_NAMES[: len(self.centring)]

    @cached_property
    def primary_names(self) -> tuple[str, ...]:
        return (*Gyro.primary_names, *self.term_names)

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        return (*Gyro.parameter_names, *self.term_names)

    @property
    def basis_key(self) -> Hashable:
        return self.name, self.nominal_axis, self.centring

    def basis(self, stimulus: Stimulus) -> FloatArray:
        velocity_dps = velocity_of_dps(stimulus)
        terms = centred_rate_terms(velocity_dps, self.nominal_axis, self.centring)
        return np.concatenate([linear_part(velocity_dps), terms], axis=1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        velocity_dps = velocity_of_dps(stimulus)
        slope = slope_of_rate_terms(primary[4:], velocity_dps, self.nominal_axis, self.centring)
        return _by_angle(primary[1:4] + slope, stimulus)

    def parameters(self, primary: FloatArray) -> FloatArray:
        linear = Gyro(self.nominal_axis).parameters(primary[..., :4])
        return np.concatenate([linear, primary[..., 4:]], axis=-1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        rows = np.eye(primary.size)
        rows[:4, :4] = Gyro(self.nominal_axis).parameters_jacobian(primary[:4])
        return rows

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        return Gyro(self.nominal_axis).undetermined(primary[:4], covariance[:4, :4])


def with_rate_terms(gyro: Gyro, stimulus: Stimulus, points: int) -> GyroWithTerms | None:
    """Return the gyro with the terms that the points determine; None where they determine none."""
    centring = rate_centring_over(velocity_of_dps(stimulus), points, gyro.nominal_axis)
    return None if centring is None else GyroWithTerms(gyro.nominal_axis, centring)


def velocity_of_dps(stimulus: Stimulus) -> FloatArray:
    """Return the (N, 3) angular velocity in package axes. Raises: ObservationsError where no rates are known."""
    euler, rate = _motion(stimulus)
    return np.asarray(_DEG_PER_RAD * body_rates_rad_s(euler, rate))


def mean_from_level(rows: Stimulus) -> FloatArray:
    """Return (N, 3, 3) the mean rotation from level axes into those of the package on each row.

    Where nothing states it a row that turns is taken to have turned whole turns: what lies along its axis is left.
    """
    if rows.from_level is not None:
        return rows.from_level
    yaw = np.zeros_like(rows.pitch_rad) if rows.yaw_rad is None else rows.yaw_rad
    stood, velocity = from_level_axes(rows.pitch_rad, yaw, rows.roll_rad), velocity_of_dps(rows)
    speed = np.linalg.norm(velocity, axis=1, keepdims=True)
    turns = speed > _STILL * speed.max(initial=0.0)
    unit = velocity / np.where(turns, speed, 1.0)
    along = np.einsum("ni,nj,njk->nik", unit, unit, stood)
    return np.where(turns[:, :, None], along, stood)


def _by_angle(slope_v_per_dps: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
    """Return the derivatives by the angles of an output with the (N, 3) slopes along package axes."""
    euler, rate = _motion(stimulus)
    k = np.rad2deg(slope_v_per_dps)
    _, yaw, roll = np.moveaxis(euler, -1, 0)
    _, w_y, w_z = np.moveaxis(body_rates_rad_s(euler, rate), -1, 0)
    by_yaw = rate[:, :1] * np.stack([np.cos(yaw), -np.sin(yaw) * np.cos(roll), np.sin(yaw) * np.sin(roll)], axis=-1)
    by_roll = w_z * k[:, 1] - w_y * k[:, 2]
    return {"pitch": np.zeros_like(yaw), "yaw": np.sum(by_yaw * k, axis=-1), "roll": by_roll}


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


_CENTRED_TEXT = (
    "; what multiplies each coefficient of second or third order is taken without its best linear approximation c_0 + "
    "c_x*w_x + c_y*w_y + c_z*w_z (its row of centring, in this order), so that offset_v and k are those of the "
    "straight line that comes closest over the points of the calibration"
)


def _equation(axis: str) -> Equation | None:
    return cr_equation(axis, "w", PER_DPS, "sensitivity_v_per_dps", _SOURCES)


def _centred_equation(axis: str, terms: int) -> Equation | None:
    found = _equation(axis)
    if found is None:
        return None
    powers = zip(RATE_TERM_NAMES[:terms], (2, 3), strict=False)
    bent = "".join(f" + {name}*w_{axis}^{power}" for name, power in powers)
    formula, _, symbols = found.derived.partition("; ")
    return replace(found, primary=found.primary + bent + _CENTRED_TEXT, derived=f"{formula}{bent}; {symbols}")


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
        equation=_equation,
        centred_equation=_centred_equation,
        low_order=RATE_TERMS,
        directions=PER_DPS,
        along=along_cr,
        c_field=_C_RATES,
        senses_rates=True,
        unit="dps",
    ),
)
