"""SR's straight line for an accelerometer at known attitudes: reading against the gravity along its nominal axis.

v = b + S·f_i, with f_i the share of local gravity along the nominal axis that follows from pitch, yaw and roll; turned
round it is SR's real = A·measured + B with A = 1/S and B = −b/S. A misalignment has no parameter here: it shows as lack
of fit wherever gravity is not along the axis. Levels that are known otherwise: :mod:`ams.models.straight_line`.
Source: SR 4.1 (accelerometer, one axis up and down).
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ams.arrays import FloatArray
from ams.frames import AXES, Attitude
from ams.models.model import LinearModel, Stimulus
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.models.straight_line import StraightLine

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}


@dataclass(frozen=True)
class LevelLine(LinearModel):
    """One accelerometer against the gravity that its nominal axis feels."""

    nominal_axis: str
    name: ClassVar[str] = "linear-accelerometer"
    convention: ClassVar[str] = "SR"
    measured_unit: ClassVar[str] = "v"
    parameter_names: ClassVar[tuple[str, ...]] = ("gain_g_per_v", "offset_g")
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED

    @property
    def primary_names(self) -> tuple[str, ...]:
        return "offset_v", f"k_{self.nominal_axis}_v_per_g"

    @property
    def basis_key(self) -> Hashable | None:
        return self.name, self.nominal_axis

    def basis(self, stimulus: Stimulus) -> FloatArray:
        gravity = PitchYawRoll(self.nominal_axis).basis(_with_yaw(stimulus))[:, 1 + self._component]
        return np.stack([np.ones_like(gravity), -gravity], axis=-1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        of_gravity = np.zeros(4, dtype=primary.dtype)
        of_gravity[1 + self._component] = -primary[1]
        slopes = PitchYawRoll(self.nominal_axis).angle_jacobian(of_gravity, _with_yaw(stimulus))
        return {name: slope for name, slope in slopes.items() if name != "yaw" or stimulus.yaw_rad is not None}

    def parameters(self, primary: FloatArray) -> FloatArray:
        return self._line.parameters(primary)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        return self._line.parameters_jacobian(primary)

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        return self._line.undetermined(primary, covariance)

    @property
    def _component(self) -> int:
        return AXES.index(self.nominal_axis)

    @property
    def _line(self) -> StraightLine:
        return StraightLine(self.nominal_axis, "g", "v")


def _with_yaw(stimulus: Stimulus) -> Attitude:
    yaw = np.zeros_like(stimulus.pitch_rad) if stimulus.yaw_rad is None else stimulus.yaw_rad
    return Attitude(stimulus.pitch_rad, stimulus.roll_rad, yaw)
