"""The equations a set names, each as text for people and as code for us, from the set's own numbers alone.

Almost every equation is linear in the primary parameters b and k: v = b + k·f, with f the field that the model senses
in package axes (x forward, y right, z down; ``ams.sets.sensed_quantity``); the extended model adds terms of second and
third order, and a model may bring an equation of its own. The usual parameters
(sensitivity, coning angle, azimuth) are derived from k; both forms are printed and both must give the same outputs.
Source: TP (1), (2), (4), (5); CR (III-B.27) to (III-B.32), (III-C.16) to (III-C.18).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.errors import SetError
from ams.models.extended import CUBIC_NAME, Q_NAMES
from ams.models.sensor_model import Equation, ModelOutput, SetForm
from ams.sets.sensed_quantity import FIELDS, PER_G, Units, form_of

CONVENTIONS = {
    "TP": (
        "Package axes: x forward, y right, z down. Pitch alpha (nose up) about y, then roll R (right wing down) about "
        "x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha cos R) in local g. Source: NASA/TP-1999-209835."
    ),
    "SR": (
        "Package axes: x forward, y right, z down. h is the quantity itself along them: specific force in local g "
        "(level and at rest -1 along z), angular velocity, field. Source: EQUIS science report, 4.1."
    ),
    "CR": (
        "Axes: x forward, y right, z down; after half a turn about y, pitch T about y, then yaw P about the new z, "
        "then roll F about the new x. Sting package: G = (-sin T cos P, sin T sin P, cos T), gravity in local g. Model "
        "package: G_x the same, G_y = cos F G_y,sting + sin F G_z,sting, G_z = -sin F G_y,sting + cos F G_z,sting. "
        "Gyros: w = (sin P T' + F', cos P cos F T' + sin F P', -cos P sin F T' + cos F P') in deg/s, T', P', F' the "
        "rates of T, P, F. Source: NASA/CR-2003-212401."
    ),
}
TEMPERATURE_TEXT = (
    "; with temperature T and dT = T - reference_temperature_degc: offset_v becomes offset_v + offset_tc_v_per_degc*dT "
    "and every k, q and S is multiplied by 1 + sensitivity_tc_per_degc*dT; a coefficient that is not given is 0"
)
SECOND_ORDER_TEXT = (
    "; with temperature T and dT = T - reference_temperature_degc: offset_v becomes offset_v + offset_tc_v_per_degc*dT "
    "+ offset_tc2_v_per_degc2*dT^2 and every k, q and S is multiplied by 1 + sensitivity_tc_per_degc*dT + "
    "sensitivity_tc2_per_degc2*dT^2; a coefficient that is not given is 0"
)
DIRECTION_NAMES = PER_G
EXTENDED_NAMES = Q_NAMES
OFFSET_TC_NAMES = ("offset_tc_v_per_degc", "offset_tc2_v_per_degc2")
"""By rising power of the temperature above the reference."""
GAIN_TC_NAMES = ("sensitivity_tc_per_degc", "sensitivity_tc2_per_degc2")


@dataclass(frozen=True)
class PrintedEquation:
    """What a set prints about the equation of one axis."""

    name: str
    source: str
    primary: str
    derived: str


@dataclass(frozen=True)
class AxisNumbers:
    """The numbers of one axis, as the equation takes them."""

    axis: str
    model: str
    nominal_axis: str
    primary: Mapping[str, float]
    parameters: Mapping[str, float | None]
    centring: FloatArray | None = None
    """(t, 4) what is taken off each term of the extended model; None: nothing."""
    units: Units | None = None
    """Of output and field, where the model alone does not tell them."""

    @property
    def form(self) -> SetForm:
        """How a set has the model of this axis, in its units. Raises: SetError where no model of that name is known."""
        return form_of(self.model, self.units)

    @property
    def direction_v_per_g(self) -> FloatArray:
        """(3,) k of an accelerometer, a component that the model lacks as zero."""
        return np.array([self.primary.get(name, 0.0) for name in DIRECTION_NAMES])

    @property
    def direction(self) -> FloatArray:
        """(3,) k per unit of the field that the model senses: V/g, V/(deg/s) for gyros, whatever lines have."""
        names = self.form.directions if self.model in FIELDS else DIRECTION_NAMES
        return np.array([self.primary.get(name, 0.0) for name in names])

    @property
    def quadratic_v_per_g2(self) -> FloatArray:
        """(3, 3) symmetric traceless Q of the extended model, zero where the model is not extended."""
        xx, xy, xz, yy, yz = (self.primary.get(name, 0.0) for name in EXTENDED_NAMES)
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, -xx - yy]])

    @property
    def cubic_v_per_g3(self) -> float:
        """K₃ along the nominal axis."""
        return self.primary.get(CUBIC_NAME, 0.0)

    @property
    def is_linear(self) -> bool:
        """Whether the output is linear in what the model senses."""
        return self.model_output is None and not any(self.primary.get(name, 0.0) for name in self._low_order_names)

    @property
    def model_output(self) -> ModelOutput | None:
        """The model's own equation, where it is another than that of all others."""
        return FIELDS[self.model].output if self.model in FIELDS else None

    @property
    def centred_terms(self) -> tuple[str, ...]:
        """Names of the terms that stand in the equation without their best linear approximation."""
        return () if self.centring is None else self._low_order_names[: len(self.centring)]

    @property
    def bent_terms(self) -> tuple[str, ...]:
        """Names of the terms that stand in the equation, those of sets without a centring among them."""
        names = (*self.form.quadratic, *self.centred_terms) if self.centring is None else self.centred_terms
        return () if self.is_linear else names

    @property
    def _low_order_names(self) -> tuple[str, ...]:
        """Of the terms that the model may have."""
        low_order = FIELDS[self.model].low_order if self.model in FIELDS else None
        return () if low_order is None else low_order.names

    @property
    def taken_off(self) -> FloatArray:
        """(4,) constant (V) and direction (V/g) that the centring of the terms takes off the output."""
        if self.centring is None:
            return np.zeros(4)
        terms = np.array([self.primary[name] for name in self.centred_terms])
        # Added in this order on every machine: headers state what comes of it to the last digit.
        return np.asarray((terms[:, None] * self.centring).sum(axis=0))

    def terms_v(self, f: FloatArray) -> FloatArray:
        """Return what the terms of second and third order add at the (…, 3) field that the model senses."""
        low_order, off = self.form.low_order, self.taken_off
        assert low_order is not None, "an axis that is not linear has terms"
        coefficients = np.array([self.primary.get(name, 0.0) for name in low_order.names])
        return np.asarray(low_order.basis(f, self.nominal_axis) @ coefficients - off[0] - f @ off[1:])

    def centred_factors(self, field: FloatArray) -> FloatArray:
        """Return the (…, t) factors of the centred terms at the (…, 3) field: what one unit of each adds."""
        if self.centring is None or self.form.low_order is None:
            return np.zeros((*field.shape[:-1], 0))
        terms = self.form.low_order.basis(field, self.nominal_axis)[..., : len(self.centring)]
        return np.asarray(terms - self.centring[:, 0] - field @ self.centring[:, 1:].T)

    @property
    def largest_bend_v_per_g(self) -> float:
        """No less than the slope of :meth:`terms_v` anywhere within one g."""
        quadratic = 2.0 * float(np.linalg.norm(self.quadratic_v_per_g2, 2))
        return quadratic + 3.0 * abs(self.cubic_v_per_g3) + float(np.linalg.norm(self.taken_off[1:]))

    @property
    def scale_v(self) -> float:
        """|offset| + |k_x| + |k_y| + |k_z|, volts: what a relative tolerance is relative to."""
        if self.model_output is not None:
            return sum(abs(value) for name, value in self.primary.items() if name.endswith(("_v", "_v_per_g")))
        return abs(self.primary[self.form.offset]) + float(np.abs(self.direction).sum())

    @property
    def needs_temperature(self) -> bool:
        return self.temperature_order > 0

    @property
    def temperature_order(self) -> int:
        """Highest power of temperature that has a coefficient; 0 where none has."""
        pairs = enumerate(zip(OFFSET_TC_NAMES, GAIN_TC_NAMES, strict=True), start=1)
        return max((power for power, names in pairs if any(self.coefficient(name) for name in names)), default=0)

    @property
    def temperature_names(self) -> tuple[str, ...]:
        """Of the coefficients up to that power, offset's and gain's by turns."""
        pairs = zip(OFFSET_TC_NAMES, GAIN_TC_NAMES, strict=True)
        return tuple(name for names in list(pairs)[: self.temperature_order] for name in names)

    def offset_v(self, temperature_degc: FloatArray | None) -> FloatArray:
        """Return the offset at the temperature."""
        return np.asarray(
            self.primary[self.form.offset] + self._polynomial(OFFSET_TC_NAMES, self._above(temperature_degc))
        )

    def gain(self, temperature_degc: FloatArray | None) -> FloatArray:
        """Return what the sensitivity is multiplied by at the temperature."""
        return np.asarray(1.0 + self._polynomial(GAIN_TC_NAMES, self._above(temperature_degc)))

    def _polynomial(self, names: Sequence[str], rise_degc: FloatArray) -> FloatArray:
        total = self.coefficient(names[0]) * rise_degc
        return total if self.temperature_order < 2 else np.asarray(total + self.coefficient(names[1]) * rise_degc**2)

    def coefficient(self, name: str) -> float:
        """Return a coefficient of temperature, 0 where it is not given."""
        value = self.primary.get(name, self.parameters.get(name))
        return 0.0 if value is None else value

    def _above(self, temperature_degc: FloatArray | None) -> FloatArray:
        reference = self.primary.get("reference_temperature_degc", self.parameters.get("reference_temperature_degc"))
        if not self.needs_temperature:
            return np.zeros(())
        if temperature_degc is None or reference is None:
            raise SetError(
                f"axis {self.axis}: has temperature coefficients and no temperature to use them with: got "
                f"temperature {temperature_degc} °C, reference {reference} °C, needed are both"
            )
        return np.asarray(temperature_degc - reference)


def are_lines(axes: Mapping[str, AxisNumbers]) -> bool:
    """Return whether every axis is a straight line of the quantity itself along the package's axes."""
    return all(numbers.form.senses_level for numbers in axes.values())


def predicted_v(numbers: AxisNumbers, f: FloatArray, temperature_degc: FloatArray | None) -> FloatArray:
    """Return the output of the axis at the field (…, 3) that its model senses, from the primary parameters."""
    formula = numbers.model_output
    if formula is not None:
        return np.asarray(formula.value_v(numbers.primary, f))
    sensed_v = f @ numbers.direction
    if not numbers.is_linear:
        sensed_v = sensed_v + numbers.terms_v(f)
    return np.asarray(numbers.offset_v(temperature_degc) + numbers.gain(temperature_degc) * sensed_v)


def derived_direction(numbers: AxisNumbers) -> FloatArray | None:
    """Return (3,) k from the derived parameters; None where one of them is null, or the model has none for it.

    The gain of a straight line tells the component along its nominal axis, the others are as they are.
    """
    form = numbers.form
    gain = None if form.gain is None else numbers.parameters.get(form.gain)
    if gain is not None:
        k = numbers.direction
        k["xyz".index(numbers.nominal_axis)] = 1.0 / gain
        return k
    sensitivity = numbers.parameters.get(form.sensitivity)
    angles_deg = [numbers.parameters.get(name) for name in form.angles]
    if form.along is None or sensitivity is None or any(angle is None for angle in angles_deg):
        return None
    return np.asarray(sensitivity * form.along(numbers.nominal_axis, np.radians(np.array(angles_deg, dtype=float))))


def equation_of(
    model: str, nominal_axis: str, temperature_order: int, centred_terms: int = 0, units: Units | None = None
) -> PrintedEquation:
    """Return the printed equation. Raises: SetError for a model or an axis that no set has an equation for."""
    found = _printed(model, nominal_axis, centred_terms, units)
    if found is None:
        raise SetError(
            f"model {model!r}, nominal axis {nominal_axis!r}: no set of this version has its equation: known are "
            f"{', '.join(sorted(FIELDS))}; nothing was evaluated; use the version of calrig that wrote it, or install "
            "the distribution that brings the model"
        )
    suffix = ("", TEMPERATURE_TEXT, SECOND_ORDER_TEXT)[temperature_order]
    return PrintedEquation(model, found.source, found.primary + suffix, found.derived)


def _printed(model: str, nominal_axis: str, centred_terms: int, units: Units | None) -> Equation | None:
    if model not in FIELDS:
        return None
    form = form_of(model, units)
    if centred_terms:
        return None if form.centred_equation is None else form.centred_equation(nominal_axis, centred_terms)
    return form.equation(nominal_axis)


def check_numbers(numbers: AxisNumbers, where: str) -> None:
    """Refuse numbers that the equation does not take. Raises: SetError."""
    terms = len(numbers.centred_terms)
    equation_of(numbers.model, numbers.nominal_axis, numbers.temperature_order, terms, numbers.units)
    form = numbers.form
    if form.output is not None:
        allowed, complete = set(form.output.primary_names), set(form.output.primary_names) <= set(numbers.primary)
    else:
        required = {form.offset, *form.directions, *(numbers.centred_terms or form.quadratic)}
        allowed = required | {*OFFSET_TC_NAMES, *GAIN_TC_NAMES, "reference_temperature_degc"}
        needed_names = {form.offset, *numbers.centred_terms}
        complete = needed_names <= set(numbers.primary) and bool(set(form.directions) & set(numbers.primary))
    if set(numbers.primary) - allowed or not complete:
        needed = "all of them" if form.output is not None else f"{form.offset} and at least one k"
        raise SetError(
            f"{where}: axis {numbers.axis}: the equation {numbers.model!r} does not take these primary parameters: got "
            f"{', '.join(numbers.primary)}, allowed are {', '.join(sorted(allowed))} with {needed}; "
            "nothing was evaluated; use the version of calrig that wrote it"
        )
