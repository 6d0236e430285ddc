"""One axis of a magnetometer that may lie beside its nominal direction, in a field known as a vector.

measured = b + M_i·R·(B + a·c): R from level axes into package axes by the attitude, B what stands there, a·c the
coil's field along its unit direction c. M_i has three components, so that a field across the axis is not taken for an
offset. Gain and offset are SR's along the nominal axis: A = 1/M_ii, B = −b/M_ii. Where what stands along the coil is
not known it is one more parameter, linear about a first estimate. Source: SR 4.1; MATH 10.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError
from ams.frames import AXES, from_level_axes
from ams.models.model import LinearModel, Stimulus
from ams.models.straight_line import StraightLine

Vector = tuple[float, float, float]
_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}


@dataclass(frozen=True)
class FieldTriad(LinearModel):
    """One axis and the whole field; the reference level is the coil's field along its direction."""

    nominal_axis: str
    unit: str
    measured_unit: str
    package_axes: tuple[Vector, Vector, Vector]
    """x, y, z in the axes of the stage that carries the package."""
    coil: Vector
    """Unit vector, level axes."""
    surroundings: Vector
    """What stands beside the coil's field, level axes."""
    sensitive_axis: Vector | None = None
    """Where the component along the coil is estimated: about which M_i/M_ii, package axes. None: it is known."""
    name: ClassVar[str] = "linear"
    convention: ClassVar[str] = "SR"
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED

    @property
    def primary_names(self) -> tuple[str, ...]:
        across = tuple(f"k_{axis}_{self.measured_unit}_per_{self.unit}" for axis in self._others)
        beside = () if self.sensitive_axis is None else (f"surroundings_{self.measured_unit}",)
        return (*self._line.primary_names, *across, *beside)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        beside = () if self.sensitive_axis is None else (f"surroundings_{self.unit}",)
        return (*self._line.parameter_names, *beside, *(f"towards_{axis}_deg" for axis in self._others))

    @property
    def basis_key(self) -> Hashable | None:
        return self

    def basis(self, stimulus: Stimulus) -> FloatArray:
        if stimulus.reference_level is None:
            raise ObservationsError("model linear: the observations have no known field; nothing was solved")
        turned = to_package(self.package_axes, stimulus)
        coil = np.array(self.coil)
        beside, along = turned @ np.array(self.surroundings), turned @ coil
        field = beside + along * stimulus.reference_level[:, None]
        order = [AXES.index(axis) for axis in (self.nominal_axis, *self._others)]
        columns = [np.ones_like(stimulus.reference_level), *field[:, order].T]
        if self.sensitive_axis is not None:
            columns.append(along @ np.array(self.sensitive_axis))
        return np.stack(columns, axis=-1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:  # noqa: ARG002
        return {}

    def parameters(self, primary: FloatArray) -> FloatArray:
        zero, slope, *across = np.moveaxis(primary, -1, 0)[:4]
        beside = [] if self.sensitive_axis is None else [self._along_coil + primary[..., 4] / slope]
        towards = [np.rad2deg(1.0) * np.arctan(component / slope) for component in across]
        return np.stack([1.0 / slope, -zero / slope, *beside, *towards], axis=-1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        slope = primary[1]
        rows = np.zeros((len(self.parameter_names), primary.size))
        rows[:2, :2] = self._line.parameters_jacobian(primary[:2])
        if self.sensitive_axis is not None:
            rows[2, 1], rows[2, 4] = -primary[4] / slope**2, 1.0 / slope
        for index, component in enumerate(primary[2:4]):
            square = slope**2 + component**2
            rows[index - 2, 1] = np.rad2deg(-component / square)
            rows[index - 2, 2 + index] = np.rad2deg(slope / square)
        return rows

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        reasons = self._line.undetermined(primary[:2], covariance[:2, :2])
        return dict.fromkeys(self.parameter_names, next(iter(reasons.values()))) if reasons else {}

    @property
    def _others(self) -> tuple[str, ...]:
        return tuple(axis for axis in AXES if axis != self.nominal_axis)

    @property
    def _along_coil(self) -> float:
        return float(np.array(self.coil) @ np.array(self.surroundings))

    @property
    def _line(self) -> StraightLine:
        return StraightLine(self.nominal_axis, self.unit, self.measured_unit)


def to_package(package_axes: tuple[Vector, Vector, Vector], stimulus: Stimulus) -> FloatArray:
    """Return (N, 3, 3) from level axes into package axes, at the attitudes."""
    yaw = np.zeros_like(stimulus.pitch_rad) if stimulus.yaw_rad is None else stimulus.yaw_rad
    return np.asarray(np.array(package_axes) @ from_level_axes(stimulus.pitch_rad, yaw, stimulus.roll_rad))
