"""The equations a set names, each as text for people and as code for us, from the set's own numbers alone.

Every equation here is linear in the primary parameters b and k: v = b + k·f, with f the field that the model senses in
package axes (x forward, y right, z down; ``ams.sets.sensed_quantity``); the extended model adds terms of second and
third order. The usual parameters
(sensitivity, coning angle, azimuth) are derived from k; both forms are printed and both must give the same outputs.
Source: TP (1), (2), (4), (5); CR (III-B.27) to (III-B.32), (III-C.16) to (III-C.18).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.errors import SetError
from ams.models.cr import sensitive_axis
from ams.models.extended import CUBIC_NAME, Q_NAMES, TERM_NAMES
from ams.sets.sensed_quantity import FIELDS

FloatArray = NDArray[np.float64]

CONVENTIONS = {
    "TP": (
        "Package axes: x forward, y right, z down. Pitch alpha (nose up) about y, then roll R (right wing down) about "
        "x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha cos R) in local g. Source: NASA/TP-1999-209835."
    ),
    "CR": (
        "Axes: x forward, y right, z down; after half a turn about y, pitch T about y, then yaw P about the new z, "
        "then roll F about the new x. Sting package: G = (-sin T cos P, sin T sin P, cos T), gravity in local g. Model "
        "package: G_x the same, G_y = cos F G_y,sting + sin F G_z,sting, G_z = -sin F G_y,sting + cos F G_z,sting. "
        "Gyros: w = (sin P T' + F', cos P cos F T' + sin F P', -cos P sin F T' + cos F P') in deg/s, T', P', F' the "
        "rates of T, P, F. Source: NASA/CR-2003-212401."
    ),
}
CR_SOURCES = {
    "pitch-yaw-roll-sting": ("CR (III-B.27)", "CR (III-B.28)", "CR (III-B.29)"),
    "pitch-yaw-roll-model": ("CR (III-B.30)", "CR (III-B.31)", "CR (III-B.32)"),
    "gyro": ("CR (III-C.16)", "CR (III-C.17)", "CR (III-C.18)"),
}
PRIMARY_TEXT = "output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z"
TEMPERATURE_TEXT = (
    "; with temperature T and dT = T - reference_temperature_degc: offset_v becomes offset_v + offset_tc_v_per_degc*dT "
    "and every k, q and S is multiplied by 1 + sensitivity_tc_per_degc*dT; a coefficient that is not given is 0"
)
EXTENDED_TEXT = (
    " + q_xx_v_per_g2*(f_x^2 - f_z^2) + 2*q_xy_v_per_g2*f_x*f_y + 2*q_xz_v_per_g2*f_x*f_z "
    "+ q_yy_v_per_g2*(f_y^2 - f_z^2) + 2*q_yz_v_per_g2*f_y*f_z"
)
SYMBOLS = "; alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, "
PITCH_ROLL_TEXT = {
    "x": "v = b + S*(cos W sin alpha - sin W cos alpha sin(R + A))",
    "y": "v = b + S*(-cos W cos alpha sin R + sin W (sin A sin alpha - cos A cos alpha cos R))",
    "z": "v = b + S*(-cos W cos alpha cos R + sin W (cos A sin alpha - sin A cos alpha sin R))",
}
PITCH_ONLY_TEXT = {"x": "v = b + S*sin(alpha - p)", "z": "v = b - S*cos(alpha - p)"}
PITCH_ROLL_SOURCE = {"x": "TP (2)", "y": "TP (4)", "z": "TP (5)"}
DIRECTION_NAMES = ("k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")
PRIMARY_NAMES = ("offset_v", *DIRECTION_NAMES)
EXTENDED_NAMES = Q_NAMES
CUBIC_TEXT = " + k3_v_per_g3*{field}^3"
CENTRED_TEXT = (
    "; what multiplies each coefficient of second or third order, factors of 2 included, is taken without its best "
    "linear approximation c_0 + c_x*f_x + c_y*f_y + c_z*f_z (its row of centring, in this order), so that offset_v and "
    "k are those of the linear sensor that comes closest over the points of the calibration"
)
TEMPERATURE_NAMES = ("offset_tc_v_per_degc", "sensitivity_tc_per_degc")


@dataclass(frozen=True)
class Equation:
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

    @property
    def direction_v_per_g(self) -> FloatArray:
        """(3,) k of an accelerometer, a component that the model lacks as zero."""
        return np.array([self.primary.get(name, 0.0) for name in DIRECTION_NAMES])

    @property
    def direction(self) -> FloatArray:
        """(3,) k per unit of the field that the model senses: V/g, or V/(deg/s) for gyros."""
        names = FIELDS[self.model].directions if self.model in FIELDS else DIRECTION_NAMES
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
        """Whether the output is linear in the specific force."""
        return not self.quadratic_v_per_g2.any() and self.cubic_v_per_g3 == 0.0

    @property
    def taken_off(self) -> FloatArray:
        """(4,) constant (V) and direction (V/g) that the centring of the terms takes off the output."""
        if self.centring is None:
            return np.zeros(4)
        terms = np.array([self.primary[name] for name in TERM_NAMES[: len(self.centring)]])
        return np.asarray(terms @ self.centring)

    def terms_v(self, f: FloatArray) -> FloatArray:
        """What the terms of second and third order add at the specific force (…, 3)."""
        bent = np.sum(f @ self.quadratic_v_per_g2 * f, axis=-1)
        bent = bent + self.cubic_v_per_g3 * f[..., "xyz".index(self.nominal_axis)] ** 3
        off = self.taken_off
        return np.asarray(bent - off[0] - f @ off[1:])

    @property
    def scale_v(self) -> float:
        """|offset| + |k_x| + |k_y| + |k_z|, volts: what a relative tolerance is relative to."""
        return abs(self.primary["offset_v"]) + float(np.abs(self.direction).sum())

    @property
    def needs_temperature(self) -> bool:
        return any(self._coefficient(name) != 0.0 for name in TEMPERATURE_NAMES)

    def offset_v(self, temperature_degc: FloatArray | None) -> FloatArray:
        """The offset at the temperature."""
        return np.asarray(
            self.primary["offset_v"] + self._coefficient("offset_tc_v_per_degc") * self._above(temperature_degc)
        )

    def gain(self, temperature_degc: FloatArray | None) -> FloatArray:
        """What the sensitivity is multiplied by at the temperature."""
        return np.asarray(1.0 + self._coefficient("sensitivity_tc_per_degc") * self._above(temperature_degc))

    def _coefficient(self, name: str) -> float:
        value = self.primary.get(name, self.parameters.get(name))
        return 0.0 if value is None else value

    def _above(self, temperature_degc: FloatArray | None) -> FloatArray:
        reference = self.primary.get("reference_temperature_degc", self.parameters.get("reference_temperature_degc"))
        if not self.needs_temperature:
            return np.zeros(())
        if temperature_degc is None or reference is None:
            raise SetError(
                f"axis {self.axis}: has temperature coefficients and no temperature to use them with: got "
                f"temperature {temperature_degc} degc, reference {reference} degc, needed are both"
            )
        return np.asarray(temperature_degc - reference)


def predicted_v(numbers: AxisNumbers, f: FloatArray, temperature_degc: FloatArray | None) -> FloatArray:
    """The output of the axis at the field (…, 3) that its model senses, from the primary parameters."""
    sensed_v = f @ numbers.direction
    if not numbers.is_linear:
        sensed_v = sensed_v + numbers.terms_v(f)
    return np.asarray(numbers.offset_v(temperature_degc) + numbers.gain(temperature_degc) * sensed_v)


def derived_direction(numbers: AxisNumbers) -> FloatArray | None:
    """(3,) k from sensitivity, coning and azimuth (or the pitch misalignment); None where one of them is null."""
    sensitivity = numbers.parameters.get(FIELDS[numbers.model].sensitivity)
    angles_deg = [numbers.parameters.get(name) for name in _angles(numbers.model)]
    if sensitivity is None or any(angle is None for angle in angles_deg):
        return None
    angles_rad = np.radians(np.array(angles_deg, dtype=float))
    if FIELDS[numbers.model].convention == "CR":
        return np.asarray(sensitivity * sensitive_axis(numbers.nominal_axis, angles_rad[1], angles_rad[0]))
    along = _along_misalignment if numbers.model == "pitch-only" else _along_cone
    return sensitivity * along(numbers.nominal_axis, angles_rad)


def _angles(model: str) -> tuple[str, ...]:
    return ("pitch_misalignment_deg",) if model == "pitch-only" else ("coning_deg", "azimuth_deg")


def _along_cone(nominal_axis: str, angles_rad: FloatArray) -> FloatArray:
    coning, azimuth = angles_rad
    first = "xyz".index(nominal_axis)
    unit = np.zeros(3)
    unit[first] = np.cos(coning)
    unit[(first + 1) % 3] = np.sin(coning) * np.cos(azimuth)
    unit[(first + 2) % 3] = np.sin(coning) * np.sin(azimuth)
    return unit


def _along_misalignment(nominal_axis: str, angles_rad: FloatArray) -> FloatArray:
    cosine, sine = np.cos(angles_rad[0]), np.sin(angles_rad[0])
    return np.array([cosine, 0.0, sine]) if nominal_axis == "x" else np.array([-sine, 0.0, cosine])


def equation_of(model: str, nominal_axis: str, with_temperature: bool, centred_terms: int = 0) -> Equation:
    """The printed equation. Raises: SetError for a model or an axis that no set has an equation for."""
    suffix = TEMPERATURE_TEXT if with_temperature else ""
    if model in ("pitch-roll", "pitch-roll-extended") and nominal_axis in PITCH_ROLL_TEXT:
        extension = EXTENDED_TEXT if model == "pitch-roll-extended" else ""
        extension += CUBIC_TEXT.format(field=f"f_{nominal_axis}") if centred_terms > len(EXTENDED_NAMES) else ""
        suffix = (CENTRED_TEXT if centred_terms else "") + suffix
        derived = PITCH_ROLL_TEXT[nominal_axis] + extension + SYMBOLS + "W = coning_deg, A = azimuth_deg"
        return Equation(model, PITCH_ROLL_SOURCE[nominal_axis], PRIMARY_TEXT + extension + suffix, derived)
    if model == "pitch-only" and nominal_axis in PITCH_ONLY_TEXT:
        derived = PITCH_ONLY_TEXT[nominal_axis] + SYMBOLS + "p = pitch_misalignment_deg"
        return Equation(model, "TP (1)", PRIMARY_TEXT + " at R = 0; k_y_v_per_g is 0" + suffix, derived)
    if model in CR_SOURCES and nominal_axis in "xyz":
        return _cr_equation(model, nominal_axis, suffix)
    raise SetError(
        f"model {model!r}, nominal axis {nominal_axis!r}: no set of this version has its equation: known are "
        f"{', '.join(sorted(FIELDS))}; nothing was evaluated; use the version of calrig that wrote it"
    )


def _cr_equation(model: str, nominal_axis: str, suffix: str) -> Equation:
    field = FIELDS[model]
    symbol, i = field.symbol, "xyz".index(nominal_axis)
    own, first, second = (f"{symbol}_{'xyz'[(i + place) % 3]}" for place in range(3))
    primary = "output = offset_v + " + " + ".join(
        f"{name}*{symbol}_{axis}" for name, axis in zip(field.directions, "xyz", strict=True)
    )
    derived = (
        f"v = b + S*(cos C {own} + sin C (sin A {first} - cos A {second})); b = offset_v, S = {field.sensitivity}, "
        "C = coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg"
    )
    return Equation(model, CR_SOURCES[model][i], primary + suffix, derived)


def check_numbers(numbers: AxisNumbers, where: str) -> None:
    """Raises: SetError where the equation does not take these numbers."""
    equation_of(numbers.model, numbers.nominal_axis, numbers.needs_temperature)
    centred = () if numbers.centring is None else TERM_NAMES[: len(numbers.centring)]
    extension = (centred or EXTENDED_NAMES) if numbers.model == "pitch-roll-extended" else ()
    directions = FIELDS[numbers.model].directions
    allowed = {"offset_v", *directions, *extension, *TEMPERATURE_NAMES, "reference_temperature_degc"}
    unknown = sorted(set(numbers.primary) - allowed)
    if (
        unknown
        or not set(centred) <= set(numbers.primary)
        or "offset_v" not in numbers.primary
        or not set(directions) & set(numbers.primary)
    ):
        raise SetError(
            f"{where}: axis {numbers.axis}: the equation {numbers.model!r} does not take these primary parameters: got "
            f"{', '.join(numbers.primary)}, allowed are {', '.join(sorted(allowed))} with offset_v and at least one "
            "k; nothing was evaluated; use the version of calrig that wrote it"
        )
