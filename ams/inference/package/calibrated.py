"""A calibrated accelerometer with all its terms, as the inference of angles wants it: a line in the specific force.

v = b0 + b1 dT + b2 dT² + (1 + s1 dT + s2 dT²)(k·f + terms of second and third order). The temperature terms are taken
off the reading first, the others while the angles are sought; the variance of what is left holds the covariance of
every term and the reading's own. CR's sets sense gravity, the opposite of the specific force, so their k change sign
here.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from ams.arrays import Centring, FloatArray, block_diagonal
from ams.attitude.spread import Part
from ams.calibration_result import VarianceComponent
from ams.errors import OutsideValidity
from ams.models.extended import CUBIC_NAME, Q_NAMES, TERM_NAMES, centred_basis, quadratic_basis
from ams.models.possible_temperature import possible_temperatures
from ams.models.thermal import SECOND_ORDER_NAMES, TEMPERATURE_NAMES, names_of
from ams.sets.axis_section import standard_error_of
from ams.sets.canonical import Json, listed, matrix, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.package_section import package_of
from ams.sets.sensed_quantity import PER_G

_POWERS: Final = MappingProxyType({**dict.fromkeys(PER_G, 1), **dict.fromkeys(Q_NAMES, 2), CUBIC_NAME: 3})
"""Powers of the force that a term has."""
_ROUNDING: Final = 1e-15
"""Of the largest variance: a direction that is only rounding."""
_NO_SHARES: Final[Mapping[str, float]] = MappingProxyType({})


@dataclass(frozen=True)
class CalibratedSensor:
    """One axis of a set at the temperatures of N readings."""

    names: Sequence[str]
    primary: FloatArray
    """(P,)"""
    covariance: FloatArray
    """(P, P)"""
    reading_sd_v: float | FloatArray
    """Of all readings, or (N,) of each."""
    rise_degc: FloatArray
    """(N,) or (1,) temperature above the reference."""
    components: Sequence[VarianceComponent] = ()
    """(P, P) independent parts of the covariance; empty: it is known as it stands."""
    nominal_axis: str = "x"
    centring: Centring = ()
    """Of the terms of second and third order."""

    @property
    def offset_v(self) -> float:
        return self._value("offset_v")

    @property
    def k_v_per_g(self) -> FloatArray:
        return np.array([self._value(name) for name in PER_G])

    def line_output_v(self, output_v: FloatArray) -> FloatArray:
        """Return (N,) what the reading would be at the reference temperature."""
        warmed = self._polynomial(0)
        return np.asarray((output_v - self.offset_v - warmed) / self._gain() + self.offset_v)

    def quadratic_v(self, force: FloatArray) -> FloatArray:
        """Return (N,) what the terms of second and third order add; zero where the force is not known."""
        return np.asarray(np.nan_to_num(self._terms(force) @ [self._value(name) for name in self._term_names]))

    @property
    def is_linear(self) -> bool:
        return not any(self._value(name) for name in TERM_NAMES)

    @property
    def _term_names(self) -> tuple[str, ...]:
        return TERM_NAMES[: len(self.centring)] if self.centring else Q_NAMES

    def _terms(self, force: FloatArray) -> FloatArray:
        """Return (…, t), each by one of its coefficient."""
        if not self.centring:
            return quadratic_basis(force)
        return centred_basis(force, self.nominal_axis, self.centring)

    def output_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the variance of :meth:`line_output_v` less its prediction, calibration and reading together.

        Source: TP (52), (73).
        """
        rows = self.rows(force)
        return np.asarray(_quadratic(rows, self.covariance) + self.reading_variance_v2(force))

    def calibration_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N,) parts of the prediction's variance."""
        rows, parts = self.rows(force), self.components or (VarianceComponent("", self.covariance, np.inf),)
        return [(_quadratic(rows, part.covariance), part.dof) for part in parts]

    def reading_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the (N,) variance of a reading."""
        return np.broadcast_to((self.reading_sd_v / self._gain()) ** 2, force.shape[:-1])

    def rows(self, force: FloatArray) -> FloatArray:
        """Return the (N, P) derivatives of :meth:`line_output_v` by the primary parameters."""
        gain, rise = np.broadcast_arrays(self._gain(), self.rise_degc)
        sensed = force @ self.k_v_per_g + self.quadratic_v(force)
        ones = np.ones(force.shape[:-1])
        columns: dict[str, FloatArray] = {"offset_v": ones / gain}
        columns |= dict(zip(PER_G, np.moveaxis(force, -1, 0), strict=True))
        columns |= dict(zip(self._term_names, np.moveaxis(self._terms(force), -1, 0), strict=True))
        columns |= dict(zip(TEMPERATURE_NAMES, (ones * rise / gain, rise * sensed / gain), strict=True))
        columns |= dict(zip(SECOND_ORDER_NAMES, (ones * rise**2 / gain, rise**2 * sensed / gain), strict=True))
        return np.stack([columns[name] for name in self.names], axis=-1)

    def _gain(self) -> FloatArray:
        return np.asarray(1.0 + self._polynomial(1))

    def _polynomial(self, which: int) -> FloatArray:
        """Return what temperature adds to the offset (0) or the gain (1)."""
        first, second = names_of(2)[which::2]
        return np.asarray(self._value(first) * self.rise_degc + self._value(second) * self.rise_degc**2)

    def _value(self, name: str) -> float:
        return float(self.primary[list(self.names).index(name)]) if name in self.names else 0.0


@dataclass(frozen=True)
class CalibratedPackage:
    """The axes of a package, with what their calibrations have in common."""

    sensors: Sequence[CalibratedSensor]
    components: Sequence[VarianceComponent]
    """(Q, Q) over the primary parameters of all sensors in turn."""

    def output_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N, S, S) parts of the covariance of the predictions."""
        rows = self.rows(force)
        return [(rows @ part.covariance @ np.swapaxes(rows, -1, -2), part.dof) for part in self.components]

    def rows(self, force: FloatArray) -> FloatArray:
        """Return the (N, S, Q) derivatives of the predictions by the primary parameters of all sensors in turn."""
        rows = np.zeros((*force.shape[:-1], len(self.sensors), sum(len(sensor.names) for sensor in self.sensors)))
        start = 0
        for index, sensor in enumerate(self.sensors):
            rows[..., index, start : start + len(sensor.names)] = sensor.rows(force)
            start += len(sensor.names)
        return rows


def covariance_root(covariance: FloatArray) -> FloatArray:
    """Return (Q, q) whose product with its transpose is a (Q, Q) covariance, of which parameters may be known."""
    values, vectors = np.linalg.eigh(covariance)
    kept = values > _ROUNDING * max(float(values[-1]), np.finfo(float).tiny)
    return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))


def parameter_parts(
    sensors: Sequence[CalibratedSensor], package: CalibratedPackage | None
) -> Sequence[VarianceComponent]:
    """Return the (Q, Q) parts of the covariance of the primary parameters of all sensors in turn."""
    if package is not None:
        return package.components
    none = [np.zeros_like(sensor.covariance) for sensor in sensors]
    return [
        replace(part, covariance=block_diagonal([*none[:axis], part.covariance, *none[axis + 1 :]]))
        for axis, sensor in enumerate(sensors)
        for part in sensor.components or (VarianceComponent("", sensor.covariance, np.inf),)
    ]


def as_package(sensors: Sequence[CalibratedSensor], package: CalibratedPackage | None) -> CalibratedPackage:
    """Return the package, or where its set does not state what the axes have in common, one that has nothing."""
    return package or CalibratedPackage(sensors, parameter_parts(sensors, None))


def package_of_set(
    coefficients: CoefficientSet,
    axes: Sequence[str],
    sensors: Sequence[CalibratedSensor],
    site_gravity_mps2: float | None = None,
    gravity_shares: Mapping[str, float] = _NO_SHARES,
) -> CalibratedPackage | None:
    """Return the package that some axes of a set make; None where the set does not state what they have in common.

    ``gravity_shares``: by cause, what gravity is wrong by where it is used, over gravity.
    """
    section = package_of(coefficients.document)
    if section is None or len(axes) < 2:
        return None
    order = [str(name) for name in listed(section["order"])]
    wanted = [f"{axis}.{name}" for axis, sensor in zip(axes, sensors, strict=True) for name in sensor.names]
    indices = [order.index(name) for name in wanted]
    sense = np.concatenate([_senses(coefficients, sensor.names, site_gravity_mps2) for sensor in sensors])
    parts = _components(table(section["components"]), indices, sense)
    relative = np.concatenate([_by_gravity(sensor.names, sensor.primary) for sensor in sensors])
    return CalibratedPackage(sensors, (*parts, *_of_gravity(relative, gravity_shares)))


def noise_of_set(coefficients: CoefficientSet, axes: Sequence[str]) -> VarianceComponent:
    """Return the (Q, Q) covariance that noise alone leaves the primary parameters of some axes in turn, TP (50).

    Known parameters have none, and of two axes it is independent.
    """
    sections = [table(table(coefficients.document["axes"])[axis]) for axis in axes]
    blocks = []
    for axis, section in zip(axes, sections, strict=True):
        primary = table(section["primary"])
        sense = _senses(coefficients, _line_names(coefficients, axis, [str(name) for name in listed(primary["order"])]))
        blocks.append(matrix(primary["tp_covariance"]) * np.outer(sense, sense))
    dof = min(number(section["degrees_of_freedom"]) for section in sections)
    return VarianceComponent("noise", block_diagonal(blocks), dof)


def sensor_of_set(
    coefficients: CoefficientSet,
    axis: str,
    reading_sd_v: float | None,
    temperature_degc: FloatArray | None,
    site_gravity_mps2: float | None = None,
    gravity_shares: Mapping[str, float] = _NO_SHARES,
) -> CalibratedSensor:
    """Return one axis of a set as a sensor, at the site's g where it is another than the calibration's.

    ``gravity_shares``: by cause, what gravity is wrong by where it is used, over gravity. Without a reading's standard
    deviation that of the calibration's rows stands for it.

    Raises: OutsideValidity where the set needs a temperature or states no standard error.
    """
    section = table(table(coefficients.document["axes"])[axis])
    primary = table(section["primary"])
    names = _line_names(coefficients, axis, [str(name) for name in listed(primary["order"])])
    values = np.array([number(table(primary["values"])[str(name)]) for name in listed(primary["order"])])
    sense = _senses(coefficients, names, site_gravity_mps2)
    ratio = _gravity_ratio(coefficients, site_gravity_mps2)
    covariance = matrix(primary["covariance"]) * np.outer(sense, sense)
    relative = _by_gravity(names, values * sense)
    of_gravity = _of_gravity(relative, gravity_shares)
    covariance = covariance + sum(part.covariance for part in of_gravity)
    parts = _components(table(primary["components"]), list(range(len(names))), sense)
    stated = standard_error_of(section, coefficients.axes[axis]) if reading_sd_v is None else reading_sd_v
    if stated is None:
        raise OutsideValidity(
            f"{coefficients.sensor}: axis {axis}: the set states no standard error; nothing was computed; "
            "give the standard deviation of a reading"
        )
    return CalibratedSensor(
        names, values * sense, covariance, stated,
        _rise_degc(coefficients, axis, section, temperature_degc),
        (*parts, *of_gravity) if parts else (),
        coefficients.axes[axis].nominal_axis, _centring(coefficients.axes[axis].centring, ratio),
    )  # fmt: skip


def _line_names(coefficients: CoefficientSet, axis: str, names: Sequence[str]) -> list[str]:
    """Return the names with b and k called as those of accelerometers are, whatever unit the set's own have."""
    form = coefficients.axes[axis].form
    plain = dict(zip((form.offset, *form.directions), ("offset_v", *PER_G), strict=True))
    return [plain.get(name, name) for name in names]


def _gravity_ratio(coefficients: CoefficientSet, site_gravity_mps2: float | None) -> float:
    return 1.0 if site_gravity_mps2 is None else site_gravity_mps2 / coefficients.gravity_mps2


def _centring(rows: FloatArray | None, ratio: float) -> Centring:
    """Return what is taken off each term: a term that grows by r² takes a constant of r⁻² and a slope of r⁻¹ of it."""
    if rows is None:
        return ()
    powers = np.array([3 if index == len(Q_NAMES) else 2 for index in range(len(rows))])
    grown = rows / np.stack([ratio**powers, *[ratio ** (powers - 1)] * 3], axis=-1)
    return tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in grown)


def _senses(coefficients: CoefficientSet, names: Sequence[str], site_gravity_mps2: float | None = None) -> FloatArray:
    """Return what the parameters are multiplied by: CR's sets sense gravity, so their k change sign.

    At another g than the calibration's every term grows with as many powers of it as it has of the force.
    """
    ratio = _gravity_ratio(coefficients, site_gravity_mps2)
    sense = -1.0 if coefficients.convention == "CR" else 1.0
    return np.array([(sense if name in PER_G else 1.0) * ratio ** _POWERS.get(name, 0) for name in names])


def _by_gravity(names: Sequence[str], values: FloatArray) -> FloatArray:
    """Return what the parameters at another g change by in proportion to the g that they were calibrated at."""
    return np.asarray(values * [float(_POWERS.get(name, 0)) for name in names])


def _of_gravity(relative: FloatArray, shares: Mapping[str, float]) -> tuple[VarianceComponent, ...]:
    """Return the parts that the g of calibration and of use are wrong by, the same for all axes."""
    return tuple(
        VarianceComponent(name, np.outer(relative * share, relative * share), np.inf) for name, share in shares.items()
    )


def _components(stated: Mapping[str, Json], indices: Sequence[int], sense: FloatArray) -> tuple[VarianceComponent, ...]:
    """Return the parts of a covariance for some of its rows; degrees of freedom of null are infinite."""
    parts = []
    for name, value in stated.items():
        part = table(value)
        covariance = matrix(part["covariance"])[np.ix_(indices, indices)] * np.outer(sense, sense)
        dof = part["degrees_of_freedom"]
        parts.append(VarianceComponent(name, covariance, np.inf if dof is None else number(dof)))
    return tuple(parts)


def _quadratic(rows: FloatArray, covariance: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,ij,...j->...", rows, covariance, rows))


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
    return np.asarray(possible_temperatures(temperature_degc) - number(reference))
