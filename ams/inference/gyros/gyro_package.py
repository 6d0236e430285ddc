"""Three calibrated gyros: rates from their outputs, and what is not known of these.

The rate in package axes is ω = K⁻¹(v − b), less what the nonlinearity of the scale factors makes of it, which is found
in a few steps. Its error is linear in the errors of the parameters: δω = −K⁻¹(ε_b + ε_K ω + ε_q h̃(ω)).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.inference.package.counted_shifts import OFFSET_KEY, undeclared_shifts
from ams.inputs.shared_errors import G_SENSITIVITY_LIMIT
from ams.sets.axis_section import standard_error_of
from ams.sets.canonical import listed, matrix, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.package_section import package_of
from ams.sets.vectors import INVERSE_STEPS

_SETTLED_RAD_S: Final = 1e-12
"""Of one step: far below what any reading resolves."""


@dataclass(frozen=True)
class GyroPackage:
    """Three calibrated gyros and the columns that they are read from."""

    coefficients: CoefficientSet
    columns: Mapping[str, str]
    """Axis to column."""
    reading_sd_v: float | None = None
    """Standard deviation of one reading where the set is used; None: that of the calibration."""

    def __post_init__(self) -> None:
        name, axes = self.coefficients.sensor, tuple(self.columns)
        self.coefficients.require_standing(name, "nothing was computed")
        if len(axes) != 3 or any(self.coefficients.axes[axis].form.unit != "dps" for axis in axes):
            raise OutsideValidity(f"{name}: got the axes {', '.join(axes)}, needed three gyros; nothing was computed")
        if self.coefficients.needs_temperature:
            raise OutsideValidity(
                f"{name}: gyros with temperature terms are not integrated here; nothing was computed; bring the "
                "outputs to the reference temperature first"
            )
        if np.linalg.cond(self.k_v_per_rad_s) > 1e6:
            raise OutsideValidity(f"{name}: the three gyros do not resolve three directions; nothing was computed")

    @property
    def k_v_per_rad_s(self) -> FloatArray:
        """(3, 3), a row for each axis."""
        return np.rad2deg(np.stack([self.coefficients.axes[axis].direction for axis in self.columns]))

    @property
    def offset_v(self) -> FloatArray:
        axes = [self.coefficients.axes[axis] for axis in self.columns]
        return np.array([axis.primary[axis.form.offset] for axis in axes])

    @property
    def at_rest_v(self) -> FloatArray:
        """(3,) outputs at no rate: the offsets are those of the straight lines that come closest."""
        axes, still = [self.coefficients.axes[axis] for axis in self.columns], np.zeros(3)
        bent_v = [0.0 if axis.is_linear else float(axis.terms_v(still)) for axis in axes]
        return np.asarray(self.offset_v + bent_v)

    def outputs_v(self, readings: Mapping[str, FloatArray]) -> FloatArray:
        """Return (3, n) volts."""
        return np.stack([readings[column] for column in self.columns.values()])

    def rates_rad_s(self, readings: Mapping[str, FloatArray]) -> FloatArray:
        """Return (3, n) rates along package axes."""
        return self.rates_above(self.outputs_v(readings) - self.offset_v[:, None])

    def rates_above(self, above_v: FloatArray) -> FloatArray:
        """Return (3, n) rates along package axes from (3, n) outputs less their offsets, found step by step."""
        inverse = np.linalg.inv(self.k_v_per_rad_s)
        straight = np.asarray(inverse @ above_v)
        axes = [self.coefficients.axes[axis] for axis in self.columns]
        if all(axis.is_linear for axis in axes):
            return straight
        rates = straight
        for _ in range(INVERSE_STEPS):
            previous, bent = rates, np.stack([axis.terms_v(np.rad2deg(rates.T)) for axis in axes])
            rates = straight - inverse @ bent
            if not np.nanmax(np.abs(rates - previous), initial=0.0) > _SETTLED_RAD_S:
                break
        return rates

    def reading_covariance(self) -> FloatArray:
        """Return the (3, 3) covariance of the rate of one sample. Raises: OutsideValidity where nothing states it."""
        inverse = np.linalg.inv(self.k_v_per_rad_s)
        return np.asarray(inverse * self.reading_sd() ** 2 @ inverse.T)

    def calibration_covariance(self) -> FloatArray:
        """Return the (3 p, 3 p) covariance of :class:`ams.attitude.rate_errors.RateErrors`."""
        inverse, size, terms = np.linalg.inv(self.k_v_per_rad_s), self._size, self._size - 4
        turn = np.zeros((3 * (4 + 3 * terms), 3 * size))
        for sensor in range(3):
            parts = [*range(4), *(4 + terms * sensor + term for term in range(terms))]
            for index, part in enumerate(parts):
                turn[3 * part : 3 * part + 3, size * sensor + index] = -inverse[:, sensor]
        return np.asarray(turn @ self._parameter_covariance() @ turn.T)

    def further_factors(self, *, from_rest: bool = False) -> Callable[[FloatArray], FloatArray] | None:
        """Return what the errors of the terms of second and third order go with; None where no axis has any.

        ``from_rest``: the outputs at rest are known, and what the terms do there is no error any more.
        """
        terms = self._size - 4
        if not terms:
            return None

        axes = self.coefficients.axes

        def factors(rate_rad_s: FloatArray) -> FloatArray:
            found = np.zeros((3 * terms, rate_rad_s.shape[1]))
            for index, axis in enumerate(self.columns):
                centred = axes[axis].centred_factors(np.rad2deg(rate_rad_s.T))
                at_rest = axes[axis].centred_factors(np.zeros(3)) if from_rest else 0.0
                found[terms * index : terms * index + centred.shape[1]] = (centred - at_rest).T
            return found

        return factors

    @property
    def _size(self) -> int:
        """Of offset, k and terms of the axis that has most."""
        return 4 + max(len(self.coefficients.axes[axis].centred_terms) for axis in self.columns)

    def _parameter_covariance(self) -> FloatArray:
        """Return (3 s, 3 s) of offset, k per rad/s and terms of every axis; what one lacks is zero and exact."""
        rows_of, size = {axis: self._indices(axis) for axis in self.columns}, self._size
        section = package_of(self.coefficients.document)
        covariance = np.zeros((3 * size, 3 * size))
        if section is not None:
            order = [str(name) for name in listed(section["order"])]
            stated = [order.index(f"{axis}.{name}") for axis, names in rows_of.items() for name in names]
            parts = [matrix(table(part)["covariance"]) for part in table(section["components"]).values()]
            indices = [size * first + name for first, names in enumerate(rows_of.values()) for name in names.values()]
            covariance[np.ix_(indices, indices)] = np.sum(parts, axis=0)[np.ix_(stated, stated)]
        else:
            for first, (axis, names) in enumerate(rows_of.items()):
                primary = table(table(table(self.coefficients.document["axes"])[axis])["primary"])
                order = [str(name) for name in listed(primary["order"])]
                stated = [order.index(name) for name in names]
                indices = [size * first + name for name in names.values()]
                covariance[np.ix_(indices, indices)] = matrix(primary["covariance"])[np.ix_(stated, stated)]
        scale = np.tile([1.0, *np.rad2deg(np.ones(3)), *np.ones(size - 4)], 3)
        return np.asarray(covariance * np.outer(scale, scale))

    def _indices(self, axis: str) -> dict[str, int]:
        """Return the primary parameters that an axis has, each with its place among offset, k_x, k_y, k_z and terms."""
        numbers = self.coefficients.axes[axis]
        names = (numbers.form.offset, *numbers.form.directions, *numbers.centred_terms)
        return {name: index for index, name in enumerate(names) if name in numbers.primary}

    @property
    def counts_shift(self) -> bool:
        """Whether the covariance has in it what the zeros do until the next calibration, as the rig file declared."""
        return OFFSET_KEY not in undeclared_shifts(self.coefficients, self.columns)

    @property
    def least_degrees_of_freedom(self) -> float:
        """The fewest of any part of the covariance, infinite where all are known as they stand."""
        section = package_of(self.coefficients.document)
        if section is not None:
            parts = [table(section["components"])]
        else:
            axes = [table(table(self.coefficients.document["axes"])[axis]) for axis in self.columns]
            parts = [table(table(axis["primary"]).get("components", {})) for axis in axes]
        stated = [table(part)["degrees_of_freedom"] for components in parts for part in components.values()]
        return min((number(dof) for dof in stated if dof is not None), default=np.inf)

    def force_covariance(self) -> FloatArray:
        """Return the (3, 3) covariance of rates, by what gravity does to zeros that were taken at another attitude.

        Two g at most, as upside down; nothing where the set states no limit.
        """
        sections, inverse = table(self.coefficients.document["axes"]), np.linalg.inv(self.k_v_per_rad_s)
        notes = [table(table(sections[axis])["notes"]) for axis in self.columns]
        limits_dps = np.array([2.0 * number(of_axis.get(G_SENSITIVITY_LIMIT, 0.0)) for of_axis in notes])
        u_v = np.deg2rad(np.linalg.norm(self.k_v_per_rad_s, axis=1)) * limits_dps / np.sqrt(3.0)
        return np.asarray(inverse * u_v**2 @ inverse.T)

    def reading_sd(self) -> FloatArray:
        """Return (3,) volts. Raises: OutsideValidity where nothing states it."""
        if self.reading_sd_v is not None:
            return np.full(3, self.reading_sd_v)
        sections = table(self.coefficients.document["axes"])
        stated = [standard_error_of(table(sections[axis]), self.coefficients.axes[axis]) for axis in self.columns]
        if None in stated:
            raise OutsideValidity(
                f"{self.coefficients.sensor}: the set states no standard error; nothing was computed; give the "
                "standard deviation of a reading"
            )
        return np.array(stated, dtype=float)
