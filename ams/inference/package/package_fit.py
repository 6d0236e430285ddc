"""The attitude that fits the outputs of one package of three axes best, or of CR's two on one model, and what is left.

The unknowns are the direction of gravity in the axes of the first package and the roll of the second one against it: as
a unit vector and an angle they are regular wherever the packages resolve them. Source: CR (IV-B.1) to (IV-B.28).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.spread import UncertainSensor, weighing_variances
from ams.attitude.static import SMALLEST_SLOPE, Sensor, onto_unit_sphere, tangents
from ams.errors import DesignError
from ams.models.cr import model_gravity_g

_ITERATIONS: Final = 20


@dataclass(frozen=True)
class Fitted:
    """Attitudes of N rows, with what they leave of R outputs."""

    gravity: FloatArray
    """(N, 3) unit vectors in the axes of the first package."""
    roll_rad: FloatArray
    """(N,) of the second package against the first one; NaN without one."""
    residual_v: FloatArray
    """(N, R) outputs less their predictions."""

    @property
    def in_model(self) -> FloatArray:
        """Gravity in the axes of the second package, (N, 3)."""
        return model_gravity_g(self.gravity, self.roll_rad)


@dataclass(frozen=True)
class PackageAxes:
    """The sensitive axes of a package, or of two."""

    first: FloatArray
    """(3, 3) volts per g of specific force."""
    second: FloatArray | None = None

    def fit(self, volts: FloatArray, weights: FloatArray) -> Fitted:
        """Return what fits (N, R) outputs less their offsets best, by (N, R) weights."""
        if self.second is None:
            force, _ = onto_unit_sphere(self.first, volts, weights, resolved(self.first, volts))
            return Fitted(-force, np.full(len(volts), np.nan), volts - force @ self.first.T)
        gravity, in_model = -resolved(self.first, volts[:, :3]), -resolved(self.second, volts[:, 3:])
        roll = np.arctan2(
            in_model[:, 1] * gravity[:, 2] - in_model[:, 2] * gravity[:, 1],
            in_model[:, 1] * gravity[:, 1] + in_model[:, 2] * gravity[:, 2],
        )
        for _ in range(_ITERATIONS):
            along = tangents(gravity)
            fitted = Fitted(gravity, roll, volts)
            step = _step(self.columns(fitted, along), weights, volts - self.predicted_v(fitted))
            gravity = gravity + np.einsum("njt,nt->nj", along, step[:, :2])
            gravity = gravity / np.linalg.norm(gravity, axis=1, keepdims=True)
            roll = roll + step[:, 2]
            if np.all(np.abs(step) < 1e-13):
                break
        found = Fitted(gravity, roll, volts)
        return Fitted(gravity, roll, volts - self.predicted_v(found))

    def predicted_v(self, at: Fitted) -> FloatArray:
        """Return the (N, R) outputs less their offsets at an attitude."""
        by_first = -at.gravity @ self.first.T
        return by_first if self.second is None else np.concatenate([by_first, -at.in_model @ self.second.T], axis=1)

    def columns(self, at: Fitted, along: FloatArray) -> FloatArray:
        """Return the (N, R, s) derivatives by (N, 3, 2) two turns of gravity and, of two packages, by roll."""
        if self.second is None:
            return np.asarray(-np.einsum("ij,njs->nis", self.first, along))
        gravity, roll = at.gravity, at.roll_rad
        turned = np.stack([model_gravity_g(along[..., index], roll) for index in range(2)], axis=-1)
        in_model = at.in_model
        by_roll = np.stack([np.zeros_like(roll), in_model[:, 2], -in_model[:, 1]], axis=-1)
        sting = np.concatenate([np.einsum("ij,njs->nis", self.first, along), np.zeros((len(gravity), 3, 1))], axis=-1)
        by_gravity = np.einsum("ij,njs->nis", self.second, turned)
        model = np.concatenate([by_gravity, (by_roll @ self.second.T)[..., None]], axis=-1)
        return -np.concatenate([sting, model], axis=1)


def resolved(k: FloatArray, volts: FloatArray) -> FloatArray:
    """Return the (N, 3) directions that three outputs give by themselves."""
    force = np.linalg.solve(k, volts.T).T
    return np.asarray(force / np.linalg.norm(force, axis=1, keepdims=True))


def stacked(sensors: Sequence[Sensor], outputs_v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (3, 3) sensitivities and the (N, 3) outputs less their offsets.

    Raises: DesignError where the sensors lie in one plane.
    """
    k = np.stack([sensor.k_v_per_g for sensor in sensors])
    if len(sensors) != 3 or abs(np.linalg.det(k)) < SMALLEST_SLOPE * float(np.prod(np.linalg.norm(k, axis=1))):
        raise DesignError(
            f"package: {len(sensors)} sensitive axes do not resolve three directions: needed are three, "
            "not in one plane"
        )
    return k, np.atleast_2d(outputs_v) - np.array([sensor.offset_v for sensor in sensors])


def weights_of(sensors: Sequence[UncertainSensor], k: FloatArray, force: FloatArray) -> FloatArray:
    """Return the (N, 3) weights of the outputs of a package at (N, 3) specific force."""
    tiny = float(np.finfo(float).tiny)
    return np.asarray(1.0 / np.maximum(weighing_variances(sensors, k, force), tiny**0.5))


def _step(columns: FloatArray, weights: FloatArray, residual: FloatArray) -> FloatArray:
    relative = weights / weights.max(axis=1, keepdims=True)
    normal = np.einsum("nis,ni,nit->nst", columns, relative, columns)
    gradient = np.einsum("nis,ni,ni->ns", columns, relative, residual)
    return np.asarray((np.linalg.pinv(normal, rcond=1e-12) @ gradient[..., None])[..., 0])
