"""Rows of packages of three accelerometers with an error put into their outputs: what the test of redundancy has of it.

What an attitude cannot explain of R outputs is a vector of as many components as readings are too many, one of one
package, three of two, each with a standard deviation of one where nothing is wrong.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Final

import numpy as np

from ams.arrays import FloatArray, block_diagonal
from ams.attitude.redundancy import LEVEL
from ams.attitude.spread import PredictionErrors, output_errors
from ams.attitude.static import redundancy_limit, tangents
from ams.attitude.two_package import angles_from_gravity
from ams.frames import wrap_rad
from ams.inference.inference import Inference, Package
from ams.inference.package.calibrated import CalibratedSensor, covariance_root, parameter_parts
from ams.inference.package.package_fit import Fitted, PackageAxes, resolved, stacked, weights_of
from ams.inference.package.packages import errors_of_two
from ams.statistics.distributions import f_quantile

_BEND_STEPS: Final = 3
_LARGEST_DOF: Final = 1e7


class FaultedRows:
    """N rows at the attitudes that fit their outputs, of which each can be given an error."""

    def __init__(self, inference: Inference, readings: Mapping[str, FloatArray]) -> None:
        """Take (N,) readings that are numbers, of one package or two."""
        self._inference = inference
        second = inference.model_package
        together = (inference.package, None, 0.0) if second is None else inference.package.beside(second)
        self._gravity_relative_u = together[2]
        self.packages: tuple[Package, ...] = tuple(package for package in together[:2] if package is not None)
        self._sensors = [package.sensors(readings, inference.reading_sd_v) for package in self.packages]
        outputs = [
            package.outputs_v(sensors, readings) for package, sensors in zip(self.packages, self._sensors, strict=True)
        ]
        pairs = [stacked(sensors, read) for sensors, read in zip(self._sensors, outputs, strict=True)]
        self._axes = PackageAxes(*(k for k, _ in pairs))
        self.sensitivity_v_per_g = np.concatenate([np.linalg.norm(k, axis=1) for k, _ in pairs])
        self._weights = np.concatenate(
            [weights_of(s, k, resolved(k, v)) for s, (k, v) in zip(self._sensors, pairs, strict=True)], axis=1
        )
        self._at = self._fitted(np.concatenate([volts for _, volts in pairs], axis=1))
        self.predicted_v = self._axes.predicted_v(self._at)
        """(N, R) outputs less their offsets, as the attitudes make them."""

    @property
    def rows(self) -> int:
        return len(self.predicted_v)

    @cached_property
    def is_uncertain(self) -> bool:
        """Whether something of every output is uncertain; else any error shows, and no limit is to be told."""
        values = np.linalg.eigvalsh(self._covariance)
        return bool(np.all(np.isfinite(values)) and np.all(values[:, 0] > 1e-14 * values[:, -1]))

    def unexplained(self, errors_v: FloatArray) -> FloatArray:
        """Return (m, N, d) what is left, in standard deviations, of (m, N, R) errors of the outputs."""
        fit = self._with(errors_v)
        return np.asarray(np.einsum("ndr,mnr->mnd", self._whitening, fit.residual_v.reshape(errors_v.shape)))

    def linear(self, output: int) -> FloatArray:
        """Return (N, d) what is left of an error of one output, per g, as long as it is small."""
        return np.asarray(self._whitening[:, :, output] * self.sensitivity_v_per_g[output])

    def limits(self, output: int) -> FloatArray:
        """Return the (N,) squares beyond which a row is flagged that an error of one output makes disagree."""
        along = self.linear(output)
        parts = [
            np.einsum("nd,ndr,nrs,nes,ne->n", along, self._whitening, part, self._whitening, along, optimize=True)
            for part, _ in self._errors.calibration
        ]
        total = np.maximum(np.einsum("nd,nd->n", along, along), np.finfo(float).tiny)
        shares = np.stack([*parts, np.maximum(total - sum(parts), 0.0)]) / total
        dofs = [*(dof for _, dof in self._errors.calibration), np.inf]
        dof = np.stack([np.broadcast_to(np.asarray(value, dtype=float), total.shape) for value in dofs])
        if len(self.packages) == 1 and not self.packages[0].is_of_sting:
            return np.asarray(redundancy_limit(shares, dof) ** 2)
        with np.errstate(divide="ignore"):
            effective = 1.0 / np.sum(shares**2 / dof, axis=0)
        freedom = along.shape[1]
        return np.asarray(freedom * f_quantile(LEVEL, freedom, np.minimum(effective, _LARGEST_DOF)))

    def noise(self, draws: int, chance: np.random.Generator) -> FloatArray:
        """Draw (N, d, D) what is left where nothing is wrong: of calibrations, alike in all rows, and of readings."""
        read = chance.standard_normal((*self._errors.reading.shape, draws)) * np.sqrt(self._errors.reading)[..., None]
        for sensors, package, columns in self._by_package():
            for part in parameter_parts(sensors, package.together(sensors)):
                root = covariance_root(part.covariance)
                drawn = chance.standard_normal((root.shape[1], draws))
                if np.isfinite(part.dof):
                    drawn /= np.sqrt(chance.chisquare(max(part.dof, 1.0), draws) / max(part.dof, 1.0))
                rows = _by_parameters(sensors, self._force(columns.start))
                read[:, columns] += rows @ root @ drawn
        read += self._gravity_relative_u * self.predicted_v[..., None] * chance.standard_normal(draws)
        return np.asarray(self._whitening @ read)

    def changes_rad(self, errors_v: FloatArray) -> Mapping[str, FloatArray]:
        """Return by angle what (m, N, R) errors of the outputs change it by, (m, N)."""
        found, right = self._angles_rad(self._with(errors_v)), self._angles_rad(self._at)
        shape = errors_v.shape[:2]
        return {angle: np.abs(wrap_rad(found[angle].reshape(shape) - right[angle])) for angle in right}

    def _fitted(self, volts: FloatArray) -> Fitted:
        """Return the attitudes of (N, R) outputs less their offsets, terms of second and third order taken off."""
        fit = self._axes.fit(volts, self._weights)
        if all(sensor.is_linear for sensors in self._sensors for sensor in sensors):
            return fit
        for _ in range(_BEND_STEPS):
            bend = [sensor.quadratic_v(-fit.gravity) for sensor in self._sensors[0]]
            bend += [sensor.quadratic_v(-fit.in_model) for sensors in self._sensors[1:] for sensor in sensors]
            fit = self._axes.fit(volts - np.stack(bend, axis=1), self._weights)
        return fit

    def _with(self, errors_v: FloatArray) -> Fitted:
        times, outputs = len(errors_v), self.predicted_v.shape[1]
        volts = (self.predicted_v + errors_v).reshape(-1, outputs)
        return self._axes.fit(volts, np.tile(self._weights, (times, 1)))

    @cached_property
    def _errors(self) -> PredictionErrors:
        together = [package.together(sensors) for sensors, package, _ in self._by_package()]
        if len(together) == 1:
            return output_errors(self._sensors[0], -self._at.gravity, together[0])
        sensors = self._sensors[0], self._sensors[1]
        return errors_of_two(self._axes, self._at, sensors, (together[0], together[1]), self._gravity_relative_u)

    @cached_property
    def _covariance(self) -> FloatArray:
        """Of the outputs less their predictions, (N, R, R)."""
        reading = self._errors.reading[..., None] * np.eye(self._errors.reading.shape[1])
        return np.asarray(sum((part for part, _ in self._errors.calibration), reading))

    @cached_property
    def _whitening(self) -> FloatArray:
        """From (N, R) outputs to the (N, d) that no attitude explains, each of a standard deviation of one."""
        lower = np.linalg.cholesky(self._covariance)
        columns = np.linalg.solve(lower, self._axes.columns(self._at, tangents(self._at.gravity)))
        basis = np.linalg.svd(columns, full_matrices=True)[0][..., columns.shape[-1] :]
        return np.asarray(np.swapaxes(np.linalg.solve(np.swapaxes(lower, -1, -2), basis), -1, -2))

    def _by_package(self) -> list[tuple[list[CalibratedSensor], Package, slice]]:
        """Return the sensors of each package with the outputs that are theirs."""
        pairs = zip(self._sensors, self.packages, strict=True)
        return [(sensors, package, slice(3 * i, 3 * i + 3)) for i, (sensors, package) in enumerate(pairs)]

    def _force(self, first_output: int) -> FloatArray:
        return -self._at.in_model if first_output else -self._at.gravity

    def _angles_rad(self, at: Fitted) -> Mapping[str, FloatArray]:
        """Return the angles that the answer has, NaN where they are singular."""
        package = self.packages[0]
        if not package.is_of_sting:
            turn = np.eye(3) if package.alignment is None else package.alignment.rotation
            force = -at.gravity @ turn.T
            across = np.hypot(force[:, 1], force[:, 2])
            return {"pitch": np.arctan2(force[:, 0], across), "roll": np.arctan2(-force[:, 1], -force[:, 2])}
        found = angles_from_gravity(at.gravity, at.gravity)
        of_sting = {"pitch": found.pitch_rad, "yaw": found.yaw_rad}
        return of_sting if len(self.packages) == 1 else {**of_sting, "roll": at.roll_rad}


def _by_parameters(sensors: Sequence[CalibratedSensor], force: FloatArray) -> FloatArray:
    """Return the (N, S, Q) derivatives of the outputs by the parameters of all sensors in turn."""
    rows = [sensor.rows(force) for sensor in sensors]
    return np.stack([block_diagonal([row[i : i + 1] for row in rows]) for i in range(len(force))])
