"""A magnetometer beside gyros and accelerometers: the field that it stands in says where x points.

Gravity says nothing of yaw. A field that is known in the reference axes does: x forward at zero yaw, y to the right,
z down. Gravity and the field together give all three angles of a start that nobody stated.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.inference.inference import Package
from ams.sets.vectors import inferred_force, resolves

LEAST_SD_UT: Final = 1e-3
_LEAST_CROSS_UT: Final = 1.0
"""Of the field across gravity: less of it says nothing of yaw."""
_DOWN: Final = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class FieldAid:
    """The set of three magnetometers in the axes of the package, and the field where it is used."""

    package: Package
    reference_ut: tuple[float, float, float]
    """Along x at zero yaw, to the right, down."""
    sd_ut: float = 0.5
    """Standard deviation of what disturbance and the reference make of one component, alike in all rows; what the set
    leaves open is beside it."""

    def __post_init__(self) -> None:
        coefficients = self.package.coefficients
        senses_field = all(axis.form.unit == "ut" for axis in coefficients.axes.values())
        if tuple(self.package.columns) != tuple(coefficients.axes) or not senses_field:
            raise OutsideValidity(
                f"{coefficients.sensor}: got the axes {', '.join(self.package.columns)} by {self.package.model}, "
                "needed three magnetometers in µT; nothing was computed"
            )
        if not resolves(coefficients.axes):
            raise OutsideValidity(
                f"{coefficients.sensor}: its axes do not determine the field in three directions; nothing was computed"
            )
        x, y, _ = self.reference_ut
        if not (np.all(np.isfinite(self.reference_ut)) and np.hypot(x, y) >= _LEAST_CROSS_UT):
            raise OutsideValidity(
                f"field: got {', '.join(f'{component:g}' for component in self.reference_ut)} µT along x, y and z of "
                f"the reference axes: allowed are at least {_LEAST_CROSS_UT:g} µT across gravity, which alone say "
                "where x points; nothing was computed"
            )
        if not self.sd_ut >= LEAST_SD_UT:
            raise OutsideValidity(
                f"field: got a standard deviation of {self.sd_ut:g} µT: allowed are {LEAST_SD_UT:g} µT or more; "
                "nothing was computed"
            )

    @property
    def needed(self) -> tuple[str, ...]:
        """The columns that it is read from."""
        return tuple(self.package.columns.values())

    def field_ut(self, readings: Mapping[str, FloatArray]) -> FloatArray:
        """Return the (3, n) field in package axes."""
        outputs = {axis: readings[column] for axis, column in self.package.columns.items()}
        return np.ascontiguousarray(inferred_force(self.package.coefficients.axes, outputs, None).T)

    def start_rad(self, force_g: FloatArray, field_ut: FloatArray) -> FloatArray | None:
        """Return pitch, yaw and roll by one (3,) force and field; None where the two lie along one another.

        Gravity is believed before the field, whose part along it is left out (the triad of two directions).
        """
        across = np.cross(force_g, field_ut)
        if not np.linalg.norm(across) > 0.0:
            return None
        turn = _triad(-_DOWN, np.asarray(self.reference_ut)) @ _triad(force_g, field_ut).T
        ahead, right = turn[:, 0], turn[:, 1:]
        yaw = np.arctan2(ahead[1], np.hypot(ahead[0], ahead[2]))
        return np.array([np.arctan2(-ahead[2], ahead[0]), yaw, np.arctan2(-right[1, 1], right[1, 0])])


def _triad(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the (3, 3) axes, in columns, that two directions span."""
    along = first / np.linalg.norm(first)
    across = np.cross(first, second)
    across = across / np.linalg.norm(across)
    return np.stack([along, across, np.cross(along, across)], axis=-1)
