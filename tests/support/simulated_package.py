"""Thousands of campaigns of three-axis packages: what errs in the table or in a replication is common to the axes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from simulated_columns import ARCSEC, NOISE_V, REFERENCE_DEGC, Scene, force_of, model_of, teeth_within, warmed

from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.inputs.request import select_rows
from ams.observations import Observations

FloatArray = NDArray[np.float64]
PACKAGE = np.array([[0.005, 2.4999, 0.0179, 0.0125], [-0.02, 0.0091, -2.48, 0.015], [0.011, -0.011, 0.02, 2.51]])
"""Offset (V) and vector of sensitivities (V/g) of x, y and z."""


@dataclass(frozen=True)
class SolvedPackages:
    solved: SolvedColumns
    """Three neighbouring columns for every package."""

    truth: FloatArray
    """(3, 4)"""

    @property
    def primary(self) -> FloatArray:
        """(m, 3, 4)"""
        return self.solved.primary[:, :4].reshape(-1, 3, 4)

    def components(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Part to its (m, 12, 12) covariance over the package and its degrees of freedom: all causes of all axes side
        by side, multiplied out at once."""
        return {
            part.name: (self._stacked(part), part.dof.reshape(-1, 3).min(axis=1)) for part in self.solved.components
        }

    def lines(self, axes: str, reading_sd_v: float) -> "list[ManyLines]":
        """Of some axes, each with every campaign's own calibration."""
        return [many_lines(self.solved, reading_sd_v, "xyz".index(axis), 3) for axis in axes]

    def together(self, axes: str) -> "ManyPackages":
        """What the calibrations of some axes have in common."""
        indices = np.concatenate([np.arange(4) + 4 * "xyz".index(axis) for axis in axes])
        parts = [(c[:, indices[:, None], indices], dof) for c, dof in self.components().values()]
        return ManyPackages(len(axes), parts)

    def _stacked(self, part) -> FloatArray:
        causes, count = part.causes, part.dof.size // 3
        if causes is None:
            linear = part.covariance[:, :4, :4].reshape(count, 3, 4, 4)
            return np.einsum("msij,st->msitj", linear, np.eye(3)).reshape(count, 12, 12)
        effects = np.broadcast_to(causes.effects, (3 * count, *causes.effects.shape[-2:]))[:, :4]
        effects = (causes.scale[:, None, None] * effects).reshape(count, 12, -1)
        covariance = effects @ np.swapaxes(effects, -1, -2)
        if causes.signs is None:
            return covariance
        signs = causes.signs.reshape(-1, count, 3)
        products = np.einsum("rmi,rmj->mij", signs, signs)
        length = np.sqrt(np.diagonal(products, axis1=1, axis2=2))
        return covariance * np.kron(products / (length[:, :, None] * length[:, None, :]), np.ones((4, 4)))


def simulate_packages(scene: Scene, campaigns: int, rng: np.random.Generator) -> SolvedPackages:
    """42 points as for one axis; lack of fit and drift are each axis' own, an index has one error for all."""
    grid = np.meshgrid(np.deg2rad(np.arange(-90.0, 91.0, 30.0)), np.deg2rad(np.arange(-180.0, 121.0, 60.0)))
    pitch, roll = (angle.ravel() for angle in grid)
    n, points, columns = scene.replications, pitch.size, 3 * campaigns
    package = PACKAGE.copy()
    package[0] = scene.truth
    basis = force_of(pitch, roll)
    spread = scene.drift * NOISE_V * np.sqrt(np.diag(np.linalg.inv(basis.T @ basis)))
    parameters = np.tile(package, (campaigns, 1))[:, None] + spread * rng.standard_normal((columns, n, 4))
    outputs = np.einsum("ki,mri->rkm", basis, parameters)
    if scene.index_limit_arcsec:
        stood = _stood(scene, pitch, roll, campaigns, rng)
        outputs = outputs + np.einsum("kci,ai->kca", stood - basis[:, None], package).reshape(points, columns)
    rise = 4.0 + rng.uniform(-1.0, 1.0, points) if scene.temperature else np.zeros(points)
    outputs = warmed(outputs, parameters[:, 0, 0], rise[:, None], rng)
    outputs = outputs + scene.lack_of_fit * NOISE_V * rng.standard_normal((points, columns))
    outputs_v = (outputs + NOISE_V * rng.standard_normal(outputs.shape)).reshape(n * points, columns)
    rows = Observations(
        replication=np.repeat(np.arange(n), points),
        point=np.tile(np.arange(points), n),
        pitch_rad=np.tile(pitch, n),
        roll_rad=np.tile(roll, n),
        outputs={},
        temperature_degc=np.tile(REFERENCE_DEGC + rise, n) if scene.temperature else None,
    )
    if scene.dropped > 0.0:
        kept = rng.uniform(size=rows.rows) >= scene.dropped
        rows, outputs_v = select_rows(rows, kept), outputs_v[kept]
    table = teeth_within(scene.index_limit_arcsec) if scene.index_limit_arcsec else None
    models = [model_of(scene, axis) for axis in "xyz"] * campaigns
    return SolvedPackages(solve_columns(rows, outputs_v, models, table=table), package)


def _stood(scene: Scene, pitch: FloatArray, roll: FloatArray, campaigns: int, rng: np.random.Generator) -> FloatArray:
    """(K, campaigns, 4) one and the specific force at the attitudes where the table truly stood."""
    true = []
    for angle in (pitch, roll):
        location = np.unique(np.round(angle, 6), return_inverse=True)[1]
        limit = scene.index_limit_arcsec * ARCSEC
        true.append(angle[:, None] + rng.uniform(-limit, limit, (location.max() + 1, campaigns))[location])
    return force_of(true[0].ravel(), true[1].ravel()).reshape(pitch.size, campaigns, 4)


def with_constant(force: FloatArray) -> FloatArray:
    return np.concatenate([np.ones((force.shape[0], 1)), force], axis=1)


@dataclass(frozen=True)
class ManyLines:
    """One axis of m packages, for m readings: each reading is of a package of its own."""

    primary: FloatArray
    """(m, 4)"""
    parts: list[tuple[FloatArray, FloatArray]]
    """(m, 4, 4) and (m,)"""
    reading_sd_v: float

    @property
    def offset_v(self) -> FloatArray:
        return self.primary[:, 0]

    @property
    def k_v_per_g(self) -> FloatArray:
        return self.primary[:, 1:]

    def output_variance_v2(self, force: FloatArray) -> FloatArray:
        return sum(variance for variance, _ in self.calibration_parts(force)) + self.reading_variance_v2(force)

    def calibration_parts(self, force: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        phi = with_constant(force)
        return [(np.einsum("mi,mij,mj->m", phi, covariance, phi), dof) for covariance, dof in self.parts]

    def reading_variance_v2(self, force: FloatArray) -> FloatArray:
        return np.full(force.shape[0], self.reading_sd_v**2)


def many_lines(solved, reading_sd_v: float, first: int = 0, step: int = 1) -> ManyLines:
    """Some of the columns that were solved together, at the reference temperature."""
    parts = [(part.covariance[first::step, :4, :4], part.dof[first::step]) for part in solved.components]
    return ManyLines(solved.primary[first::step, :4], parts, reading_sd_v)


@dataclass(frozen=True)
class ManyPackages:
    """What the axes of m packages have in common, for m readings."""

    axes: int
    parts: list[tuple[FloatArray, FloatArray]]

    def output_parts(self, force: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        rows = np.einsum("st,mi->msti", np.eye(self.axes), with_constant(force)).reshape(force.shape[0], self.axes, -1)
        return [(rows @ covariance @ np.swapaxes(rows, 1, 2), dof) for covariance, dof in self.parts]
