"""Temperature terms on offset and sensitivity, for any model that is linear in its primary parameters.

b(T) = b0 + b1 (T − T0), S(T) = S0 (1 + s1 (T − T0)), with T the sensor's own temperature; of second order with
b2 (T − T0)² and s2 (T − T0)² beside. Known coefficients are *applied* (the model stays linear, their uncertainty is
carried as a common error); unknown ones are *estimated*, which asks for a real span of temperature that is not time in
disguise, and of three temperatures or more for the second order. Source: TP 9.2.1 (figure 28b).
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ams.arrays import FloatArray
from ams.errors import DesignError, ObservationsError
from ams.models.added_parameters import WithAddedParameters
from ams.models.model import Stimulus
from ams.observations import Observations

TEMPERATURE_NAMES = ("offset_tc_v_per_degc", "sensitivity_tc_per_degc")
SECOND_ORDER_NAMES = ("offset_tc2_v_per_degc2", "sensitivity_tc2_per_degc2")
Order = Literal[1, 2]
"""Of the polynomials in temperature."""
SMALLEST_FITTED_SPAN_DEGC = 5.0
LARGEST_CORRELATION = 0.8
SMALLEST_BEND = 0.1
"""Of half the span squared: what the square of temperature must have (root mean square) beside a straight line."""


def names_of(order: Order) -> tuple[str, ...]:
    """Return the names of the terms up to an order, offset's and sensitivity's by turns."""
    return TEMPERATURE_NAMES if order == 1 else (*TEMPERATURE_NAMES, *SECOND_ORDER_NAMES)


def polynomial(coefficients: FloatArray, rise_degc: FloatArray) -> FloatArray:
    """Return c₁ dT + c₂ dT² … of (q,) coefficients."""
    total = np.zeros(())
    for coefficient in coefficients[::-1]:
        total = (total + coefficient) * rise_degc
    return np.asarray(total)


@dataclass(frozen=True)
class TemperatureCoefficients:
    """Known coefficients of one sensor axis with their standard uncertainties."""

    offset_tc_v_per_degc: float
    sensitivity_tc_per_degc: float
    offset_tc_standard_uncertainty_v_per_degc: float = 0.0
    sensitivity_tc_standard_uncertainty_per_degc: float = 0.0
    offset_tc2_v_per_degc2: float = 0.0
    sensitivity_tc2_per_degc2: float = 0.0
    offset_tc2_standard_uncertainty_v_per_degc2: float = 0.0
    sensitivity_tc2_standard_uncertainty_per_degc2: float = 0.0

    @property
    def order(self) -> Order:
        second = (
            self.offset_tc2_v_per_degc2,
            self.sensitivity_tc2_per_degc2,
            self.offset_tc2_standard_uncertainty_v_per_degc2,
            self.sensitivity_tc2_standard_uncertainty_per_degc2,
        )
        return 2 if any(second) else 1

    @property
    def has_uncertainties(self) -> bool:
        """Whether both coefficients of first order have one: without, they count as exact."""
        return self.offset_tc_standard_uncertainty_v_per_degc > 0.0 < self.sensitivity_tc_standard_uncertainty_per_degc

    @property
    def by_name(self) -> Mapping[str, tuple[float, float]]:
        """Coefficient to value and standard uncertainty."""
        pairs = (
            (self.offset_tc_v_per_degc, self.offset_tc_standard_uncertainty_v_per_degc),
            (self.sensitivity_tc_per_degc, self.sensitivity_tc_standard_uncertainty_per_degc),
            (self.offset_tc2_v_per_degc2, self.offset_tc2_standard_uncertainty_v_per_degc2),
            (self.sensitivity_tc2_per_degc2, self.sensitivity_tc2_standard_uncertainty_per_degc2),
        )
        return dict(zip(names_of(self.order), pairs, strict=False))


@dataclass(frozen=True)
class WithTemperature(WithAddedParameters):
    """A linear model whose first primary parameter is the offset, with temperature terms behind its own parameters."""

    reference_degc: float
    known: TemperatureCoefficients | None = None
    """None: the coefficients are estimated."""
    estimated_order: Order = 1
    """Where they are; what is known has the order that it has."""

    @property
    def order(self) -> Order:
        return self.estimated_order if self.known is None else self.known.order

    @property
    def added_names(self) -> tuple[str, ...]:
        return names_of(self.order)

    @property
    def reference(self) -> tuple[str, float]:
        return "reference_temperature_degc", self.reference_degc

    @property
    def fixed(self) -> Mapping[str, tuple[float, float]]:
        return {} if self.known is None else self.known.by_name

    @property
    def basis_key(self) -> Hashable | None:
        if self.known is None:
            return None
        return (self.base.basis_key, self.reference_degc, *self._known_slopes())

    def basis(self, stimulus: Stimulus) -> FloatArray:
        assert self.known is not None
        columns = self.base.basis(stimulus).copy()
        slopes = np.array(self._known_slopes())
        columns[:, 1:] *= (1.0 + polynomial(slopes, self._rise_degc(stimulus)))[:, None]
        return columns

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        """Estimate a slope for each sensitivity, then one that the slopes share: exact for noise-free data."""
        columns, rise = self.base.basis(stimulus), self._rise_degc(stimulus)[:, None]
        size, powers = columns.shape[1], [rise**power for power in range(1, self.order + 1)]
        blocks = [np.hstack([power, power * columns[:, 1:]]) for power in powers]
        free = np.linalg.lstsq(np.hstack([columns, *blocks]), output_v, rcond=None)[0]
        k = free[1:size]
        pairs = [
            (coefficients[0], k @ coefficients[1:] / (k @ k)) for coefficients in free[size:].reshape(self.order, size)
        ]
        return np.concatenate([free[:size], np.ravel(pairs)])

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        rise, (offset, slopes) = self._rise_degc(stimulus), self._coefficients(primary)
        acceleration_part = self._sensed(primary, stimulus)
        return np.asarray(primary[0] + polynomial(offset, rise) + (1.0 + polynomial(slopes, rise)) * acceleration_part)

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        rise = self._rise_degc(stimulus)
        columns = self.base.basis(stimulus) * np.ones_like(primary[:1])
        columns[:, 1:] *= (1.0 + polynomial(self._coefficients(primary)[1], rise))[:, None]
        sensed = self._sensed(primary, stimulus)
        powers = [rise**power for power in range(1, self.order + 1)]
        return np.column_stack([columns, *(column for power in powers for column in (power, power * sensed))])

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        scale = 1.0 + polynomial(self._coefficients(primary)[1], self._rise_degc(stimulus))
        base = self._split(primary)[0]
        return {name: scale * slope for name, slope in self.base.angle_jacobian(base, stimulus).items()}

    def _coefficients(self, primary: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return those of the offset and those of the sensitivity, by rising power."""
        added = self._split(primary)[1]
        return added[0::2], added[1::2]

    def _known_slopes(self) -> tuple[float, ...]:
        """Return the coefficients of the sensitivity, by rising power."""
        return tuple(value for value, _ in self.fixed.values())[1::2]

    def _sensed(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        return np.asarray(self.base.basis(stimulus)[:, 1:] @ self._split(primary)[0][1:])

    def _rise_degc(self, stimulus: Stimulus) -> FloatArray:
        if stimulus.temperature_degc is None:
            raise ObservationsError(
                "temperature: the model has temperature terms and no temperature was measured; "
                "give a column temperature_degc or solve with temperature none"
            )
        return np.asarray(stimulus.temperature_degc) - self.reference_degc


def refuse_unless_estimable(observations: Observations, order: Order = 1) -> None:
    """Refuse observations that cannot tell temperature coefficients from offset, sensitivity and time.

    Without times the order of the rows stands for time.

    Raises:
        DesignError: the span is under 5 °C, temperature follows time with a correlation above 0.8, or it stood at two
            values only and terms of second order are asked for.
    """
    temperature = observations.temperature_degc
    if temperature is None:
        raise ObservationsError(
            f"{observations.source}: temperature coefficients cannot be estimated: no temperature was measured; "
            "give a column temperature_degc or solve with temperature none"
        )
    span_degc = float(np.ptp(temperature))
    if span_degc < SMALLEST_FITTED_SPAN_DEGC:
        raise DesignError(
            f"{observations.source}: temperature coefficients cannot be estimated: it spans {span_degc:.3g} °C, "
            f"allowed {SMALLEST_FITTED_SPAN_DEGC:g} °C or more; add plateaus, or apply known coefficients"
        )
    time = np.arange(observations.rows) if observations.time_s is None else observations.time_s
    correlation = float(np.corrcoef(time, temperature)[0, 1])
    if abs(correlation) > LARGEST_CORRELATION:
        raise DesignError(
            f"{observations.source}: temperature coefficients cannot be estimated: temperature and time have a "
            f"correlation of {correlation:.2f}, allowed −{LARGEST_CORRELATION:g} to "
            f"{LARGEST_CORRELATION:g}: temperature would "
            "be time in disguise; visit every plateau more than once and from both sides, or apply known coefficients"
        )
    if order == 2 and not tells_curvature(temperature):
        raise DesignError(
            f"{observations.source}: temperature coefficients of second order cannot be estimated: {span_degc:.3g} °C "
            "are spanned with nearly nothing between the ends, and two temperatures determine a straight line; add a "
            "plateau between them, or solve with temperature_order 1"
        )


def tells_curvature(temperature_degc: FloatArray) -> bool:
    """Return whether (N,) temperatures tell a bend from a straight line: two, with hardly any between, do not."""
    return _bend(temperature_degc) >= SMALLEST_BEND * (0.5 * float(np.ptp(temperature_degc))) ** 2


def _bend(temperature_degc: FloatArray) -> float:
    """Return what is left of the square of temperature beside a straight line, root mean square."""
    rise = temperature_degc - temperature_degc.mean()
    square = rise**2 - np.mean(rise**2)
    left = square - rise * (rise @ square) / (rise @ rise)
    return float(np.sqrt(np.mean(left**2)))
