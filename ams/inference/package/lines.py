"""Calibrated accelerometers as straight lines in the specific force, from a solved calibration: v = b + k·f."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.spread import Part
from ams.calibration_result import AxisCalibration, Calibration, VarianceComponent
from ams.errors import DesignError
from ams.sets.sensed_quantity import FIELDS

_WITH_ROLL: Final = ["offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g"]
_WITHOUT_ROLL: Final = ["offset_v", "k_x_v_per_g", "k_z_v_per_g"]


@dataclass(frozen=True)
class SensorLine:
    """One calibrated accelerometer: v = b + k·f."""

    offset_v: float
    k_v_per_g: FloatArray
    """(3,) in package axes, per local g of specific force."""
    covariance: FloatArray
    """(4, 4) of (b, k_x, k_y, k_z) from the calibration; zeros where it is not to be counted."""
    reading_sd_v: float
    """Standard deviation of one (averaged) reading where the set is used."""
    components: Sequence[VarianceComponent] = ()
    """(4, 4) independent parts of the covariance; empty: it is known as it stands."""

    def output_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the variance of prediction plus reading at (N, 3) specific force. Source: TP (52), (73)."""
        return self._variance(self.covariance, force) + self.reading_variance_v2(force)

    def calibration_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N,) parts of the prediction's variance."""
        if not self.components:
            return [(self._variance(self.covariance, force), np.inf)]
        return [(self._variance(part.covariance, force), part.dof) for part in self.components]

    def reading_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the (N,) variance of a reading."""
        return np.full(force.shape[:-1], self.reading_sd_v**2)

    def _variance(self, covariance: FloatArray, force: FloatArray) -> FloatArray:
        basis = with_constant(force)
        return np.asarray(np.einsum("...i,ij,...j->...", basis, covariance, basis))


@dataclass(frozen=True)
class PackageLines:
    """The lines of a package, with what their calibrations have in common."""

    sensors: Sequence[SensorLine]
    components: Sequence[VarianceComponent]
    """(4 S, 4 S) of (b, k_x, k_y, k_z) of every sensor in turn."""

    def output_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N, S, S) parts of the covariance of the predictions."""
        basis = np.einsum("st,ni->nsti", np.eye(len(self.sensors)), with_constant(force))
        rows = basis.reshape(*basis.shape[:2], -1)
        return [(rows @ part.covariance @ np.swapaxes(rows, -1, -2), part.dof) for part in self.components]


def with_constant(force: FloatArray) -> FloatArray:
    """Return (…, 4): one and the specific force."""
    return np.concatenate([np.ones((*force.shape[:-1], 1)), force], axis=-1)


def sensor_line(solved: AxisCalibration, reading_sd_v: float) -> SensorLine:
    """Return the sensor as a calibration found it.

    ``reading_sd_v`` is that of the place of use, not of the calibration.

    CR's models sense gravity, the opposite of the specific force, so their sensitivities change sign here.
    Raises: DesignError for a model with further terms (extended, temperature), which a straight line cannot hold.
    """
    names = list(solved.primary_names)
    if names not in (_WITH_ROLL, _WITHOUT_ROLL):
        raise DesignError(
            f"attitude: axis {solved.axis}: model {solved.model} has the parameters {', '.join(names)}: only offset "
            "and sensitivities can be inverted here; apply its further terms to the outputs first"
        )
    turn = _onto_line(solved)
    line = turn @ solved.primary
    parts = tuple(replace(part, covariance=turn @ part.covariance @ turn.T) for part in solved.variance_components)
    return SensorLine(float(line[0]), line[1:], turn @ solved.primary_covariance @ turn.T, reading_sd_v, parts)


def package_lines(solved: Calibration, reading_sd_v: float) -> PackageLines:
    """Return all axes of a package as a calibration found them. Raises: DesignError as :func:`sensor_line`."""
    axes = list(solved.axes.values())
    sensors = [sensor_line(axis, reading_sd_v) for axis in axes]
    turns = [_onto_line(axis) for axis in axes]
    widths = [turn.shape[1] for turn in turns]
    turn = np.zeros((4 * len(axes), sum(widths)))
    for index, turned in enumerate(turns):
        start = sum(widths[:index])
        turn[4 * index : 4 * index + 4, start : start + turned.shape[1]] = turned
    parts = solved.package.components if solved.package is not None else axes[0].variance_components
    return PackageLines(sensors, [replace(part, covariance=turn @ part.covariance @ turn.T) for part in parts])


def _onto_line(solved: AxisCalibration) -> FloatArray:
    """Return the (4, P) matrix from primary parameters to (b, k), specific force."""
    turn = np.zeros((4, len(solved.primary_names)))
    for column, name in enumerate(solved.primary_names):
        is_gravity = name != "offset_v" and solved.model in FIELDS and FIELDS[solved.model].is_gravity
        turn[_WITH_ROLL.index(name), column] = -1.0 if is_gravity else 1.0
    return turn
