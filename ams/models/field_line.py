"""SR's straight line for a sensor in a field that is switched, where something else stands as well.

Along and against a coil, with and without its field: v = b + S·(level + E·s), with the level that the coil adds, s = ±1
for the sense in which the axis lies, and E what stands without the coil, along its direction: the Earth's field, a
motor. Both senses tell b and S·E apart, so nothing need be nulled and nothing else known; E comes out beside A = 1/S
and B = −b/S. The sense is the sine of the pitch of a row: +90° along the coil, −90° against it. Source: SR 4.1.3.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ams.arrays import FloatArray
from ams.models.model import LinearModel, Stimulus
from ams.models.straight_line import StraightLine

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}


@dataclass(frozen=True)
class FieldLine(LinearModel):
    """One axis along and against a field, each in the unit that is named."""

    nominal_axis: str
    unit: str
    measured_unit: str
    name: ClassVar[str] = "linear"
    convention: ClassVar[str] = "SR"
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED
    basis_key: ClassVar[Hashable | None] = "field-line"

    @property
    def primary_names(self) -> tuple[str, ...]:
        return (*self._line.primary_names, f"surroundings_{self.measured_unit}")

    @property
    def parameter_names(self) -> tuple[str, ...]:
        return (*self._line.parameter_names, f"surroundings_{self.unit}")

    def basis(self, stimulus: Stimulus) -> FloatArray:
        return np.concatenate([self._line.basis(stimulus), np.sin(stimulus.pitch_rad)[:, None]], axis=1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:  # noqa: ARG002
        return {}

    def parameters(self, primary: FloatArray) -> FloatArray:
        zero, slope, beside = np.moveaxis(primary, -1, 0)
        return np.stack([1.0 / slope, -zero / slope, beside / slope], axis=-1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        zero, slope, beside = primary
        return np.array(
            [
                [0.0, -1.0 / slope**2, 0.0],
                [-1.0 / slope, zero / slope**2, 0.0],
                [0.0, -beside / slope**2, 1.0 / slope],
            ]
        )

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        reasons = self._line.undetermined(primary[:2], covariance[:2, :2])
        return dict.fromkeys(self.parameter_names, next(iter(reasons.values()))) if reasons else {}

    @property
    def _line(self) -> StraightLine:
        return StraightLine(self.nominal_axis, self.unit, self.measured_unit)
