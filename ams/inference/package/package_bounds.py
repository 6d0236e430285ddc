"""How far the outputs of a package may disagree at any attitude, for whoever has the coefficients and no covariances.

One number stands for all attitudes: the largest that rows of :mod:`ams.attitude.static` are held against anywhere in
the validity. What it flags is flagged there too; near attitudes that are known better some of what is flagged there
passes.
"""

from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.static import redundancy_limit
from ams.attitude.three_axes import LARGEST_SD_RAD, SMALLEST_SLOPE
from ams.frames import specific_force
from ams.inference.package.calibrated import CalibratedPackage, as_package, package_of_set, sensor_of_set
from ams.sets.axis_section import standard_error_of
from ams.sets.canonical import table
from ams.sets.coefficients import CoefficientSet

_STEPS: Final = 25
"""Of pitch and of roll, ends included."""
_ROUNDING: Final = 1e-12
"""What is left of the length where nothing is uncertain."""


@dataclass(frozen=True)
class PackageBounds:
    """Of three accelerometers, readings as sharp as those of the calibration."""

    length: float
    """What | |f|² − 1 | is below in 99.9 % of the rows of a package that is as calibrated, f in local g."""
    across: float
    """Where less of f lies across the longitudinal axis than this, f of length one, roll is not told to 5°."""


def package_bounds(coefficients: CoefficientSet) -> PackageBounds:
    """Return the bounds over the validity of a set of three accelerometers of pitch and roll.

    A set that states no standard error of its rows has those of readings without noise.
    """
    found = [_bounds_at(coefficients, degc) for degc in _temperatures(coefficients)]
    return PackageBounds(max(bound.length for bound in found), max(bound.across for bound in found))


def _temperatures(coefficients: CoefficientSet) -> list[float | None]:
    limits = coefficients.validity.temperature_degc
    if limits is None or not any(numbers.needs_temperature for numbers in coefficients.axes.values()):
        return [None]
    return [limits[0], sum(limits) / 2.0, limits[1]]


def _bounds_at(coefficients: CoefficientSet, temperature_degc: float | None) -> PackageBounds:
    degc = None if temperature_degc is None else np.array([temperature_degc])
    sensors = [sensor_of_set(coefficients, axis, _reading_sd_v(coefficients, axis), degc) for axis in coefficients.axes]
    package = as_package(sensors, package_of_set(coefficients, list(coefficients.axes), sensors))
    to_force = np.linalg.inv(np.stack([numbers.direction for numbers in coefficients.axes.values()]))
    force = _attitudes(coefficients.validity.pitch_deg, coefficients.validity.roll_deg)
    parts, dof = _parts(package, force)
    excess = 4.0 * _along(parts, force @ to_force)
    variance = excess.sum(axis=0)
    length = redundancy_limit(excess, np.broadcast_to(dof[:, None], excess.shape)) * np.sqrt(variance)
    pole = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    at_pole, _ = _parts(package, pole)
    lateral = np.array([_along(at_pole, np.broadcast_to(row, pole.shape)).sum(axis=0) for row in to_force[1:]])
    across = float(np.sqrt(lateral.sum(axis=0).max())) / LARGEST_SD_RAD
    return PackageBounds(max(float(length.max()), _ROUNDING), max(across, SMALLEST_SLOPE))


def _reading_sd_v(coefficients: CoefficientSet, axis: str) -> float:
    stated = standard_error_of(table(table(coefficients.document["axes"])[axis]), coefficients.axes[axis])
    return 0.0 if stated is None else stated


def _parts(package: CalibratedPackage, force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the (C, N, 3, 3) parts of the covariance of the outputs and their (C,) degrees of freedom."""
    known = package.output_parts(force)
    readings = np.stack([sensor.reading_variance_v2(force) for sensor in package.sensors], axis=-1)
    parts = np.stack([*(covariance for covariance, _ in known), readings[..., None] * np.eye(3)])
    return parts, np.array([*(dof for _, dof in known), np.inf])


def _along(parts: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the (C, N) variances of direction · outputs, (N, 3)."""
    return np.asarray(np.einsum("ni,cnij,nj->cn", direction, parts, direction))


def _attitudes(pitch_deg: tuple[float, float], roll_deg: tuple[float, float]) -> FloatArray:
    grid = product(np.linspace(*pitch_deg, _STEPS), np.linspace(*roll_deg, _STEPS))
    pitch, roll = np.radians(np.array(list(grid))).T
    return specific_force(pitch, roll)
