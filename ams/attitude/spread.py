"""From errors of outputs to errors of angles: standard deviations and 95 % intervals.

An inferred angle takes from several outputs, δ = A (v − v̂). What the calibration leaves uncertain of them comes in
independent parts with degrees of freedom of their own, and the axes of a package have much of it in common (an index of
the table turns all of them), so every part is a covariance between the outputs. The readings' own errors are
independent of one another and of all that. Source: TP (73), (89), (90), (103), (104); GUM G.4.1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.statistics.intervals import reading_halfwidth

Part = tuple[FloatArray, float | FloatArray]
"""A variance or covariance, and the degrees of freedom that it was estimated with."""


class UncertainSensor(Protocol):
    """What is not known of one output at (N, 3) specific force."""

    def calibration_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N,) independent parts of the prediction's variance."""

    def reading_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the (N,) variance of a reading where the sensor is used."""


class PackageErrors(Protocol):
    """What is not known of the outputs of a package together."""

    def output_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N, S, S) independent parts of the covariance of the predictions at (N, 3) specific force."""


@dataclass(frozen=True)
class Spread:
    """Of s angles."""

    sd: FloatArray
    """(N, s)"""
    half_95: FloatArray
    """(N, s)"""
    covariance: FloatArray
    """(N, s, s), of which ``sd`` are the roots of the diagonal."""


@dataclass(frozen=True)
class PredictionErrors:
    """Errors of S outputs less their predictions."""

    calibration: Sequence[Part]
    """(N, S, S)"""
    reading: FloatArray
    """(N, S)"""

    def of_angles(self, gain: FloatArray) -> Spread:
        """Return the spread of angles from (N, s, S) angles per output."""
        turned = np.swapaxes(gain, -1, -2)
        parts = [gain @ covariance @ turned for covariance, _ in self.calibration]
        variances = self._by_part(gain, parts)
        whole = sum(parts, (gain * self.reading[:, None, :]) @ turned)
        return Spread(np.sqrt(sum(variances.calibration, variances.reading)), variances.half_95(), np.asarray(whole))

    def angle_variances(self, gain: FloatArray) -> "AngleVariances":
        """Return what the parts leave of angles, from (N, s, S) angles per output."""
        turned = np.swapaxes(gain, -1, -2)
        return self._by_part(gain, [gain @ covariance @ turned for covariance, _ in self.calibration])

    def _by_part(self, gain: FloatArray, parts: Sequence[FloatArray]) -> "AngleVariances":
        calibration = [np.einsum("nss->ns", part) for part in parts]
        dof = [
            np.broadcast_to(np.asarray(d, dtype=float)[..., None], calibration[0].shape) for _, d in self.calibration
        ]
        return AngleVariances(calibration, dof, np.einsum("nsi,ni->ns", gain**2, self.reading))


@dataclass(frozen=True)
class AngleVariances:
    """Of s angles, part by part."""

    calibration: Sequence[FloatArray]
    """(N, s) each."""
    dof: Sequence[FloatArray]
    """(N, s) each."""
    reading: FloatArray
    """(N, s)"""

    def half_95(self, known: FloatArray | float = 0.0) -> FloatArray:
        """Return (N, s) half-widths with a variance that is ``known`` beside these parts: never less than without it.

        A known variance brings infinite degrees of freedom with it, and Student's factor can fall faster than the
        standard deviation grows.
        """
        without = reading_halfwidth(self.calibration, self.dof, self.reading)
        return np.fmax(without, reading_halfwidth(self.calibration, self.dof, self.reading, known_variance=known))


def output_errors(
    sensors: Sequence[UncertainSensor], force: FloatArray, package: PackageErrors | None = None
) -> PredictionErrors:
    """Return the errors of the outputs at (3, n) force.

    Without a package's covariance every axis' calibration counts as independent of the others'.
    """
    reading = np.stack([sensor.reading_variance_v2(force) for sensor in sensors], axis=-1)
    if package is not None:
        return PredictionErrors(package.output_parts(force), reading)
    parts: list[Part] = []
    for index, sensor in enumerate(sensors):
        for variance, dof in sensor.calibration_parts(force):
            covariance = np.zeros((*reading.shape, len(sensors)))
            covariance[:, index, index] = variance
            parts.append((covariance, dof))
    return PredictionErrors(parts, reading)


def beside_singular(along: FloatArray, across: FloatArray, is_singular: BoolArray) -> FloatArray:
    """Return standard deviations or half-widths of an angle's distance from its singular attitude.

    There the distance d is the length of a vector of two components, of which ``along`` and ``across`` are the spread
    along and across it. Read with an error e it is |d + e|, which is off by up to |e|, not by the component along it
    (at the singular attitude itself the linear 95 % interval holds 85 %). E|e|² is the sum of both squares; and
    |e|² stays within 1.96² times that sum in at least 95 %, whatever the two and their correlation. Source: Székely,
    Bakirov, Extremal probabilities for Gaussian quadratic forms (2003).
    """
    return np.where(is_singular, np.hypot(along, across), along)


def weighing_variances(sensors: Sequence[UncertainSensor], K: FloatArray, force: FloatArray) -> FloatArray:
    """Return (N, S) variances to weigh outputs by.

    They are each reading's own, and of the calibrations their mean in units of g.

    A calibration's own variance rests on a few replications. Weights by it would prefer the axis that happened to look
    sharp: intervals of pitch by three axes then hold 93 % with four replications. The mean is steadier, and weights
    need not be exact.
    """
    squares = np.sum(K**2, axis=-1)
    parts = [[variance for variance, _ in sensor.calibration_parts(force)] for sensor in sensors]
    calibration = np.stack([np.sum(sensor_parts, axis=0) for sensor_parts in parts], axis=-1)
    reading = np.stack([sensor.reading_variance_v2(force) for sensor in sensors], axis=-1)
    return np.asarray(reading + squares * np.mean(calibration / squares, axis=-1, keepdims=True))


def side_by_side(first: PredictionErrors, second: PredictionErrors) -> PredictionErrors:
    """Join the errors of two packages that were calibrated apart."""
    size, more = first.reading.shape[1], second.reading.shape[1]
    padded = [(np.pad(c, ((0, 0), (0, more), (0, more))), dof) for c, dof in first.calibration]
    padded += [(np.pad(c, ((0, 0), (size, 0), (size, 0))), dof) for c, dof in second.calibration]
    return PredictionErrors(padded, np.concatenate([first.reading, second.reading], axis=1))
