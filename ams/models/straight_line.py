"""A straight line as a model for the solvers: measured = b + S·level, and from it real = A·measured + B.

The reference level is taken as known and the reading as what scatters, so the reading is regressed on the level and the
line is turned round afterwards: A = 1/S, B = −b/S. With two levels this is SR's two-point solution. Source: SR 4.1.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError
from ams.models.model import LinearModel, Stimulus

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}
_OBSERVABLE_SLOPE_U = 5.0


@dataclass(frozen=True)
class StraightLine(LinearModel):
    """One reading against one known quantity, each in the unit that is named."""

    nominal_axis: str
    unit: str
    """Of the quantity, such as ``g``, ``dps``, ``ut``."""
    measured_unit: str
    """Of the reading, such as ``v`` or ``counts``."""
    name: ClassVar[str] = "linear"
    convention: ClassVar[str] = "SR"
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED
    basis_key: ClassVar[Hashable | None] = "linear"

    @property
    def primary_names(self) -> tuple[str, ...]:
        return f"zero_level_{self.measured_unit}", f"k_{self.nominal_axis}_{self.measured_unit}_per_{self.unit}"

    @property
    def parameter_names(self) -> tuple[str, ...]:
        return f"gain_{self.unit}_per_{self.measured_unit}", f"offset_{self.unit}"

    def basis(self, stimulus: Stimulus) -> FloatArray:
        if stimulus.reference_level is None:
            raise ObservationsError(
                f"model linear: the observations have no known levels: it needs a column reference_{self.unit}; "
                "nothing was solved"
            )
        return np.stack([np.ones_like(stimulus.reference_level), stimulus.reference_level], axis=-1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:  # noqa: ARG002
        return {}

    def parameters(self, primary: FloatArray) -> FloatArray:
        return np.stack([1.0 / primary[..., 1], -primary[..., 0] / primary[..., 1]], axis=-1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        zero, slope = primary
        return np.array([[0.0, -1.0 / slope**2], [-1.0 / slope, zero / slope**2]])

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        uncertainty = float(np.sqrt(max(covariance[1, 1], 0.0)))
        if primary[1] != 0.0 and abs(primary[1]) >= _OBSERVABLE_SLOPE_U * uncertainty:
            return {}
        reason = (
            f"the reading's slope {primary[1]:.3g} is within five standard uncertainties ({uncertainty:.3g}) of zero: "
            "it does not follow the reference"
        )
        return dict.fromkeys(self.parameter_names, reason)
