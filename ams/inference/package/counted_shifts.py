"""What a set counts of what its sensor may do after the calibration, as the rig file declared it."""

from collections.abc import Iterable
from typing import Final

from ams.inputs.shared_errors import SHIFTS
from ams.sets.canonical import table
from ams.sets.coefficients import CoefficientSet
from ams.sets.package_section import package_of

OFFSET_KEY: Final = "largest_offset_shift_v"
KEYS: Final = (OFFSET_KEY, "largest_sensitivity_shift")
"""Of a sensor in a rig file, in the order of :data:`ams.inputs.shared_errors.SHIFTS`."""


def undeclared_shifts(coefficients: CoefficientSet, axes: Iterable[str]) -> tuple[str, ...]:
    """Return those of :data:`KEYS` whose shift is not in the covariance of some of these axes."""
    section = package_of(coefficients.document)
    if section is not None:
        counted = [table(section["components"])]
    else:
        primary = [table(table(table(coefficients.document["axes"])[axis])["primary"]) for axis in axes]
        counted = [table(of_axis.get("components", {})) for of_axis in primary]
    return tuple(
        key for key, name in zip(KEYS, SHIFTS, strict=True) if not all(name in components for components in counted)
    )
