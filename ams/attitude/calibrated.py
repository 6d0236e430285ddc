"""A calibrated accelerometer with all its terms, as the inference of angles wants it: a line in the specific force.

v = b0 + b1 dT + (1 + s1 dT)(k·f + fᵀQf). The temperature terms are taken off the reading first, the quadratic ones
while the angles are sought; the variance of what is left holds the covariance of every term and the reading's
own. CR's sets sense gravity, the opposite of the specific force, so their k change sign here.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.errors import OutsideValidity
from ams.models.extended import Q_NAMES, quadratic_basis
from ams.models.thermal import TEMPERATURE_NAMES
from ams.sets.canonical import Json, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.fields import PER_G

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class CalibratedSensor:
    """One axis of a set at the temperatures of N readings."""

    names: Sequence[str]
    primary: FloatArray
    """(P,)"""
    covariance: FloatArray
    """(P, P)"""
    reading_sd_v: float
    rise_degc: FloatArray
    """(N,) or (1,) temperature above the reference."""

    @property
    def offset_v(self) -> float:
        return self._value("offset_v")

    @property
    def k_v_per_g(self) -> FloatArray:
        return np.array([self._value(name) for name in PER_G])

    def line_output_v(self, output_v: FloatArray) -> FloatArray:
        """(N,) what the reading would be at the reference temperature."""
        offset_tc, _ = (self._value(name) for name in TEMPERATURE_NAMES)
        return np.asarray((output_v - self.offset_v - offset_tc * self.rise_degc) / self._gain() + self.offset_v)

    def quadratic_v(self, force: FloatArray) -> FloatArray:
        """(N,) fᵀQf; zero where the force is not known."""
        q = np.array([self._value(name) for name in Q_NAMES])
        return np.asarray(np.nan_to_num(quadratic_basis(force) @ q))

    @property
    def is_linear(self) -> bool:
        return not any(self._value(name) for name in Q_NAMES)

    def output_variance_v2(self, force: FloatArray) -> FloatArray:
        """Of :meth:`line_output_v` less its prediction, calibration and reading together. Source: TP (52), (73)."""
        gain, rise = np.broadcast_arrays(self._gain(), self.rise_degc)
        sensed = force @ self.k_v_per_g + self.quadratic_v(force)
        ones = np.ones(force.shape[:-1])
        columns: dict[str, FloatArray] = {"offset_v": ones / gain}
        columns |= dict(zip(PER_G, np.moveaxis(force, -1, 0), strict=True))
        columns |= dict(zip(Q_NAMES, np.moveaxis(quadratic_basis(force), -1, 0), strict=True))
        columns |= dict(zip(TEMPERATURE_NAMES, (ones * rise / gain, rise * sensed / gain), strict=True))
        rows = np.stack([columns[name] for name in self.names], axis=-1)
        variance = np.einsum("...i,ij,...j->...", rows, self.covariance, rows)
        return np.asarray(variance + (self.reading_sd_v / gain) ** 2)

    def _gain(self) -> FloatArray:
        return np.asarray(1.0 + self._value(TEMPERATURE_NAMES[1]) * self.rise_degc)

    def _value(self, name: str) -> float:
        return float(self.primary[list(self.names).index(name)]) if name in self.names else 0.0


def sensor_of_set(
    coefficients: CoefficientSet, axis: str, reading_sd_v: float | None, temperature_degc: FloatArray | None
) -> CalibratedSensor:
    """One axis of a set; without a reading's standard deviation that of the calibration's rows stands for it.

    Raises: OutsideValidity where the set needs a temperature or states no standard error.
    """
    section = table(table(coefficients.document["axes"])[axis])
    primary = table(section["primary"])
    names = [str(name) for name in listed(primary["order"])]
    values = np.array([number(table(primary["values"])[name]) for name in names])
    sense = np.array([-1.0 if coefficients.convention == "CR" and name in PER_G else 1.0 for name in names])
    covariance = _matrix(primary["covariance"]) * np.outer(sense, sense)
    return CalibratedSensor(
        names, values * sense, covariance, _reading_sd_v(coefficients, axis, section, reading_sd_v),
        _rise_degc(coefficients, axis, section, temperature_degc),
    )  # fmt: skip


def _reading_sd_v(
    coefficients: CoefficientSet, axis: str, section: Mapping[str, Json], reading_sd_v: float | None
) -> float:
    stated = section["standard_error_v"] if reading_sd_v is None else reading_sd_v
    if stated is None:
        raise OutsideValidity(
            f"{coefficients.sensor}: axis {axis}: the set states no standard error; nothing was computed; "
            "give the standard deviation of a reading"
        )
    return number(stated)


def _rise_degc(
    coefficients: CoefficientSet, axis: str, section: Mapping[str, Json], temperature_degc: FloatArray | None
) -> FloatArray:
    if not coefficients.axes[axis].needs_temperature:
        return np.zeros(1)
    if temperature_degc is None:
        raise OutsideValidity(
            f"{coefficients.sensor}: temperature_degc is missing: the set has temperature coefficients; "
            "nothing was computed; give the sensor's own temperature"
        )
    reference = table(table(section["parameters"])["reference_temperature_degc"])["value"]
    return np.asarray(temperature_degc - number(reference))


def _matrix(value: Json) -> FloatArray:
    return np.array([[0.0 if cell is None else number(cell) for cell in listed(row)] for row in listed(value)])
