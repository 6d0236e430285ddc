"""Whether one of two packages sits turned against the other, told by all rows together.

A model package that is turned on its mount disagrees with the sting package by the same angles in every row, and no row
by itself need show it: 10″ leave four rows of five without a flag where a reading scatters by 1.65″. What the attitude
of each row cannot explain of its six outputs is fitted over all rows with a constant turn about y and z of the model
(one about x is a roll); the errors of both calibrations and of gravity are the same in every row and are fitted with
it, held by their covariance. A reading's own error is new in every row; what a set's points lack of its equation is
not, and stands once in the variance of the turn, however many the rows are.

A turn is found where it is more than that variance allows, and where nothing beyond the noise is left when it is taken
out: a fault that came later, or another one, is no turn.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.inference.inference import Inference, Package
from ams.inference.package.calibrated import CalibratedSensor, as_package
from ams.inference.package.package_fit import Fitted, PackageAxes, resolved, stacked, weights_of
from ams.inference.package.packages import slopes_of
from ams.inference.watch.faulty_axis import LEAST_ROWS, LEVEL, PROVEN, parameter_factor
from ams.sets.axis_section import lack_of_fit_of
from ams.sets.canonical import table
from ams.statistics.distributions import chi_square_quantile
from ams.units import ARCSEC_PER_RAD


@dataclass(frozen=True, eq=False)
class Turn:
    """How the model package sits in its axes against the sting package, as both were calibrated."""

    about_yz_rad: FloatArray
    """(2,)"""
    covariance: FloatArray
    """(2, 2)"""
    chi_square: float
    """Of what is left of the rows."""
    dof: int

    @property
    def is_proven(self) -> bool:
        """Whether chance makes no such turn, and nothing else is wrong with the rows."""
        off = float(self.about_yz_rad @ np.linalg.solve(self.covariance, self.about_yz_rad))
        is_left_alone = self.chi_square <= float(chi_square_quantile(LEVEL, self.dof))
        return is_left_alone and off > float(chi_square_quantile(PROVEN, 2))

    @property
    def in_words(self) -> str:
        """What the turn is, with twice its standard deviations."""
        parts = zip(
            "yz", ARCSEC_PER_RAD * self.about_yz_rad, ARCSEC_PER_RAD * np.sqrt(np.diag(self.covariance)), strict=True
        )
        return " and ".join(f"{value:+.1f} ± {2.0 * sd:.1f}″ about {axis}" for axis, value, sd in parts)


def turn_of(inference: Inference, readings: Mapping[str, FloatArray]) -> Turn | None:
    """Return how the model package is turned by (N,) readings; None with one package, or too few rows."""
    if inference.model_package is None or next(iter(readings.values())).size < LEAST_ROWS:
        return None
    sting, model, gravity_u = inference.package.beside(inference.model_package)
    packages = (sting, model)
    sensors = [package.sensors(readings, inference.reading_sd_v) for package in packages]
    k, volts = zip(
        *(stacked(of, package.outputs_v(of, readings)) for of, package in zip(sensors, packages, strict=True)),
        strict=True,
    )
    axes = PackageAxes(*k)
    weights = [weights_of(of, each, resolved(each, v)) for of, each, v in zip(sensors, k, volts, strict=True)]
    fit = axes.fit(np.concatenate(volts, axis=1), np.concatenate(weights, axis=1))
    forces = (-fit.gravity, -fit.in_model)
    sd = np.sqrt(np.concatenate([_reading_variance(of, force) for of, force in zip(sensors, forces, strict=True)], 1))
    shared = _shared(packages, sensors, forces)
    if gravity_u:
        shared = np.concatenate([shared, gravity_u * axes.predicted_v(fit)[..., None]], axis=-1)
    unseen = _beyond_attitude(axes.columns(fit, slopes_of(fit.gravity)) / sd[..., None])
    rows = [unseen @ (part / sd[..., None]) for part in (_turned(k[1], fit), shared)]
    left = (unseen @ (fit.residual_v / sd)[..., None])[..., 0]
    lacks = max(_lack_of_fit_rad(package, of) for package, of in zip(packages, sensors, strict=True))
    turned, held = (part.reshape(left.size, -1) for part in rows)
    return _solved(left.ravel(), turned, held, lacks)


def _solved(left: FloatArray, turned: FloatArray, shared: FloatArray, lacks_rad: float) -> Turn:
    columns = np.concatenate([turned, shared], axis=1)
    normal = columns.T @ columns
    normal[np.arange(2, len(normal)), np.arange(2, len(normal))] += 1.0
    inverse = np.linalg.inv(normal)
    by_columns = columns.T @ left
    step = inverse @ by_columns
    chi_square = float(left @ left - by_columns @ step)
    return Turn(step[:2], inverse[:2, :2] + lacks_rad**2 * np.eye(2), chi_square, left.size - 2)


def _reading_variance(sensors: list[CalibratedSensor], force: FloatArray) -> FloatArray:
    return np.stack([sensor.reading_variance_v2(force) for sensor in sensors], axis=-1)


def _shared(
    packages: tuple[Package, Package], sensors: list[list[CalibratedSensor]], forces: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Return (N, 6, q) what the outputs are off by, per standard deviation of errors that all rows have alike."""
    parts = []
    for which, (package, of, force) in enumerate(zip(packages, sensors, forces, strict=True)):
        together = as_package(of, package.together(of))
        by_parameter = np.zeros((len(force), 6, sum(len(sensor.names) for sensor in of)))
        start = 0
        for axis, sensor in enumerate(of):
            by_parameter[:, 3 * which + axis, start : start + len(sensor.names)] = sensor.rows(force)
            start += len(sensor.names)
        parts.append(by_parameter @ parameter_factor(of, together))
    return np.concatenate(parts, axis=-1)


def _turned(k_of_model: FloatArray, fit: Fitted) -> FloatArray:
    """Return (N, 6, 2) the outputs per radian that the model package is turned by about its y and z."""
    across = [np.cross(fit.in_model, np.eye(3)[axis]) for axis in (1, 2)]
    by_model = -np.stack([gravity @ k_of_model.T for gravity in across], axis=-1)
    return np.concatenate([np.zeros_like(by_model), by_model], axis=1)


def _beyond_attitude(columns: FloatArray) -> FloatArray:
    """Return (N, 3, 6) unit rows across all that the attitude does to the outputs."""
    return np.swapaxes(np.linalg.qr(columns, mode="complete").Q[..., columns.shape[-1] :], -1, -2)


def _lack_of_fit_rad(package: Package, sensors: list[CalibratedSensor]) -> float:
    """Return the largest of what the points of the axes lack of their equation, as an angle."""
    sections, axes = table(package.coefficients.document["axes"]), package.coefficients.axes
    lacks_v = [lack_of_fit_of(table(sections[axis]), axes[axis]) for axis in package.columns]
    return max(v / float(np.linalg.norm(of.k_v_per_g)) for v, of in zip(lacks_v, sensors, strict=True))
