"""CR's accelerometers as models for the solvers: pitch, yaw and roll known, sting or model package.

The primary parameters are the offset and k = S·u per g of *gravity* in package axes (CR's sign: minus the specific
force of TP). Coning is TP's for the same k, and CR's azimuth is TP's plus a quarter turn; so the derived parameters
and their derivatives are those of :class:`ams.models.accelerometer.PitchRoll`. Source: CR (III-B.27) to (III-B.32).
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from ams.arrays import FloatArray
from ams.errors import DesignError, ObservationsError
from ams.frames import Attitude, wrap_deg
from ams.models.accelerometer import PitchRoll
from ams.models.cr import model_gravity_g, sting_gravity_g
from ams.models.cr_sets import along_cr, cr_equation
from ams.models.model import LinearModel, Stimulus
from ams.models.sensor_model import PER_G, SensorModel, SetForm

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}


@dataclass(frozen=True)
class PitchYawRoll(LinearModel):
    """CR (III-B.27) to (III-B.29) for the sting package, (III-B.30) to (III-B.32) for the model package."""

    nominal_axis: str
    package: str = "model"
    """``sting`` (roll does not reach it) or ``model``."""
    convention: ClassVar[str] = "CR"
    measured_unit: ClassVar[str] = "v"
    primary_names: ClassVar[tuple[str, ...]] = ("offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")
    parameter_names: ClassVar[tuple[str, ...]] = ("offset_v", "sensitivity_v_per_g", "coning_deg", "azimuth_deg")
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED

    def __post_init__(self) -> None:
        if self.package not in ("sting", "model"):
            raise DesignError(f"model pitch-yaw-roll: got package {self.package!r}, allowed 'sting' or 'model'")

    @property
    def name(self) -> str:
        return f"pitch-yaw-roll-{self.package}"

    @property
    def basis_key(self) -> Hashable | None:
        return ("pitch-yaw-roll", self.package)

    def basis(self, stimulus: Stimulus) -> FloatArray:
        gravity = self._gravity_g(stimulus)
        return np.concatenate([np.ones((gravity.shape[0], 1)), gravity], axis=1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        pitch, yaw, roll = self._angles(stimulus)
        k = primary[1:4]
        s_pitch, c_pitch, s_yaw, c_yaw = np.sin(pitch), np.cos(pitch), np.sin(yaw), np.cos(yaw)
        by_pitch = np.stack([-c_pitch * c_yaw, c_pitch * s_yaw, -s_pitch], axis=-1)
        by_yaw = np.stack([s_pitch * s_yaw, s_pitch * c_yaw, np.zeros_like(yaw)], axis=-1)
        _, g_y, g_z = np.moveaxis(self._gravity_g(stimulus), -1, 0)
        by_roll = g_z * k[1] - g_y * k[2] if self.package == "model" else np.zeros_like(pitch)
        return {
            "pitch": model_gravity_g(by_pitch, roll) @ k,
            "yaw": model_gravity_g(by_yaw, roll) @ k,
            "roll": by_roll,
        }

    def parameters(self, primary: FloatArray) -> FloatArray:
        found = PitchRoll(self.nominal_axis).parameters(primary)
        found[..., 3] = wrap_deg(found[..., 3] + 90.0)
        return found

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        return PitchRoll(self.nominal_axis).parameters_jacobian(primary)

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        return PitchRoll(self.nominal_axis).undetermined(primary, covariance)

    def _angles(self, stimulus: Stimulus) -> tuple[FloatArray, FloatArray, FloatArray]:
        if stimulus.yaw_rad is None:
            raise ObservationsError(
                "model pitch-yaw-roll: the observations have no yaw: it needs a column yaw_deg; "
                "nothing was solved; use the model pitch-roll where there is no yaw"
            )
        roll = stimulus.roll_rad if self.package == "model" else np.zeros_like(stimulus.pitch_rad)
        return stimulus.pitch_rad, stimulus.yaw_rad, roll

    def _gravity_g(self, stimulus: Stimulus) -> FloatArray:
        pitch, yaw, roll = self._angles(stimulus)
        return np.asarray(model_gravity_g(sting_gravity_g(pitch, yaw), roll))


_C_STING = """
    (void)roll;
    f[0] = -sin(pitch) * cos(yaw);
    f[1] = sin(pitch) * sin(yaw);
    f[2] = cos(pitch);
"""
_C_MODEL = """
    f[0] = -sin(pitch) * cos(yaw);
    f[1] = cos(roll) * sin(pitch) * sin(yaw) + sin(roll) * cos(pitch);
    f[2] = -sin(roll) * sin(pitch) * sin(yaw) + cos(roll) * cos(pitch);
"""


def _yaw(attitude: Attitude) -> FloatArray:
    assert attitude.yaw_rad is not None, "the inputs of the model say so"
    return attitude.yaw_rad


def _gravity_of_model(attitude: Attitude) -> FloatArray:
    return np.asarray(model_gravity_g(sting_gravity_g(attitude.pitch_rad, _yaw(attitude)), attitude.roll_rad))


def _gravity_of_sting(attitude: Attitude) -> FloatArray:
    """Return gravity in the sting's axes, which roll does not reach."""
    level = np.zeros_like(attitude.roll_rad)
    return np.asarray(model_gravity_g(sting_gravity_g(attitude.pitch_rad, _yaw(attitude)), level))


def _of_package(package: str) -> SensorModel:
    is_sting = package == "sting"
    first = 27 if is_sting else 30
    sources = (f"CR (III-B.{first})", f"CR (III-B.{first + 1})", f"CR (III-B.{first + 2})")
    form = SetForm(
        convention="CR",
        symbol="G",
        inputs=("pitch_deg", "roll_deg", "yaw_deg"),
        field=_gravity_of_sting if is_sting else _gravity_of_model,
        equation=lambda axis: cr_equation(axis, "G", PER_G, "sensitivity_v_per_g", sources),
        along=along_cr,
        c_field=_C_STING if is_sting else _C_MODEL,
        is_gravity=True,
        senses_roll=not is_sting,
    )
    return SensorModel(
        name=f"pitch-yaw-roll-{package}",
        make=partial(PitchYawRoll, package=package),
        columns=("pitch", "yaw") if is_sting else ("pitch", "yaw", "roll"),
        set_form=form,
        family="pitch-yaw-roll",
    )


STING = _of_package("sting")
MODEL = _of_package("model")
