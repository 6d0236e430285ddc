"""The linear form of a set: real = A·measured + B for each axis, as a TOML file, for systems that know two numbers.

Of v = b + k·f it keeps what lies along the nominal axis e: A = 1/k_e in local g per volt, B = −b/k_e in local g, their
covariance by propagation. What it neglects (cross axes, the quadratic terms, the temperature over its range) is
bounded for each axis, in g and as an angle where the axis is most sensitive to it. Straight lines have this form by
themselves, each name in their own units; what a line of three components neglects is bounded over the set's levels.
Source: SR's linear calibrations (real = A measured + B).
"""

import json
import math
import tomllib
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.errors import SetError
from ams.exports.c_text import check_accelerometers, is_of_one_quantity, lacks_accelerometers
from ams.exports.checksum_line import INTACT, ChecksumLine
from ams.exports.embedded import comment_lines
from ams.exports.format import Format
from ams.exports.json_text import parsed
from ams.exports.plain_values import check_same
from ams.exports.statement import check_status, statement
from ams.models.sensor_model import SetForm
from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet, from_document
from ams.sets.equations import GAIN_TC_NAMES, OFFSET_TC_NAMES, AxisNumbers
from ams.sets.instructions import polarity
from ams.sets.vectors import outputs_key
from ams.units import UNITS

HEAD = "# calrig coefficient set in linear form, version 1"
CHECKSUM_LINE = ChecksumLine("linear form", f"{HEAD}\n".encode(), b"# sha256 of all bytes above this line: ", b"\n")
LOSES = (
    "neglects cross axes, quadratic terms and temperature (bounds stated per axis) and keeps of the uncertainty only "
    "that of A and B"
)


@dataclass(frozen=True)
class LinearAxis:
    """One axis as real = gain * measured + offset, in local g and volts or in the units of a straight line."""

    gain: float
    offset: float
    covariance: FloatArray
    """(2, 2) of gain and offset; NaN where the set does not know it."""
    largest_error: float
    """What the neglected terms amount to at most, for |f| = 1 or the levels of the set, and within the validity."""


def to_linear_form(coefficients: CoefficientSet) -> bytes:
    """Return a set in linear form as the bytes of a TOML file.

    Raises: SetError for an equation or an axis that has no linear form.
    """
    _check_form(coefficients, "linear form")
    comment = comment_lines([f"Loses: {LOSES}.", *statement(coefficients)])
    lines = [HEAD, *(f"# {line}" for line in comment), *_toml(coefficients)]
    return CHECKSUM_LINE.append_to(("\n".join(lines) + "\n").encode("ascii"))


def from_linear_form(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file: the whole one, out of its key ``document_json``.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its numbers are not those of the
    document in it.
    """
    body = CHECKSUM_LINE.checked_body(content, where)
    try:
        read = tomllib.loads(body.decode("ascii"))
        document = str(read["document_json"])
    except (ValueError, KeyError) as error:
        raise SetError(f"{where}: is no TOML file with the key document_json: {error}; {INTACT}") from error
    coefficients = from_document(parsed(document.encode(), f"{where}: document_json"), where)
    _check_form(coefficients, f"{where}: linear form")
    check_status(str(read.get("status")), body.decode("ascii"), "numbers", where)
    check_same(_comparable(read), _comparable(tomllib.loads("\n".join(_toml(coefficients)))), "numbers", where)
    return coefficients


def _check_form(coefficients: CoefficientSet, what: str) -> None:
    """Refuse a set that is neither of accelerometers of pitch and roll nor of straight lines. Raises: SetError."""
    if not is_of_one_quantity(coefficients):
        check_accelerometers(coefficients, what, "export c or json, which have every component of k")


def linear_axis(coefficients: CoefficientSet, name: str) -> LinearAxis:
    """Return an axis inverted for the force along its nominal axis.

    Raises: SetError where the axis does not sense along its nominal axis.
    """
    numbers = coefficients.axes[name]
    along = "xyz".index(numbers.nominal_axis)
    form, k = numbers.form, numbers.direction
    if abs(k[along]) < 0.5 * float(np.linalg.norm(k)):
        per = UNITS.get(f"{form.measured_unit}_per_{form.unit}", "")
        raise SetError(
            f"{coefficients.sensor}: axis {name}: linear form: got {k[along]:.6g} {per} along the nominal axis "
            f"{numbers.nominal_axis} of {float(np.linalg.norm(k)):.6g} {per}, allowed at least half of it; nothing was "
            "written; the sensor does not sense along its nominal axis: export another format"
        )
    offset_v, k_along = numbers.primary[form.offset], float(k[along])
    jacobian = np.array([[0.0, -1.0 / k_along**2], [-1.0 / k_along, offset_v / k_along**2]])
    covariance = jacobian @ _covariance(coefficients, name, along) @ jacobian.T
    across = np.abs(np.delete(k, along)) * _largest_across(coefficients, form, along)
    # Both levels may be at their ends at once; the components of a force of 1 may not.
    cross = float(across.sum()) if form.senses_level else math.hypot(*across)
    quadratic = largest_term_v(coefficients, numbers)
    warming_v = temperature_error_v(coefficients, numbers, float(np.linalg.norm(k)) + quadratic)
    error_g = (cross + quadratic + warming_v) / abs(k_along)
    return LinearAxis(1.0 / k_along, -offset_v / k_along, covariance, error_g)


def largest_term_v(coefficients: CoefficientSet, numbers: AxisNumbers) -> float:
    """Bound of the terms of second and third order for any |f| = 1; of a gyro's for any rate within the validity."""
    off, low_order = numbers.taken_off, numbers.form.low_order
    if numbers.form.senses_rates and low_order is not None:
        reach = np.full(3, max(map(abs, coefficients.validity.rate_dps or (0.0,))))
        terms = np.abs([numbers.primary.get(name, 0.0) for name in low_order.names])
        return float(low_order.basis(reach, numbers.nominal_axis) @ terms + np.abs(off) @ [1.0, *reach])
    largest_bent = float(np.abs(np.linalg.eigvalsh(numbers.quadratic_v_per_g2)).max()) + abs(numbers.cubic_v_per_g3)
    return largest_bent + abs(float(off[0])) + float(np.linalg.norm(off[1:]))


def _covariance(coefficients: CoefficientSet, name: str, along: int) -> FloatArray:
    """Return the (2, 2) covariance of offset and k along the nominal axis."""
    primary = table(table(table(coefficients.document["axes"])[name])["primary"])
    order = [str(entry) for entry in listed(primary["order"])]
    rows = [
        [math.nan if entry is None else number(entry) for entry in listed(row)] for row in listed(primary["covariance"])
    ]
    form = coefficients.axes[name].form
    indices = [order.index(form.offset), order.index(form.directions[along])]
    return np.array(rows)[np.ix_(indices, indices)]


def _largest_across(coefficients: CoefficientSet, form: SetForm, along: int) -> FloatArray:
    """Return (2,) how large what is sensed along the two other package axes may be: a force of 1, else the levels."""
    levels = coefficients.validity.levels
    if not form.senses_level:
        return np.ones(2)
    widest = max((abs(end) for limits in levels.values() for end in limits), default=1.0)
    reached = [max(map(abs, levels[name]), default=widest) if name in levels else widest for name in form.inputs]
    return np.delete(np.array(reached), along)


def temperature_error_v(coefficients: CoefficientSet, numbers: AxisNumbers, largest_sensed_v: float) -> float:
    limits = coefficients.validity.temperature_degc
    if not numbers.needs_temperature or limits is None:
        return 0.0
    reference = numbers.coefficient("reference_temperature_degc")
    largest_degc = max(abs(limits[0] - reference), abs(limits[1] - reference))
    pairs = enumerate(zip(OFFSET_TC_NAMES, GAIN_TC_NAMES, strict=True), start=1)
    return sum(
        largest_degc**power * (abs(numbers.coefficient(offset)) + abs(numbers.coefficient(gain)) * largest_sensed_v)
        for power, (offset, gain) in pairs
    )


def _toml(coefficients: CoefficientSet) -> list[str]:
    document = coefficients.document
    words = _Words.of(coefficients)
    lines = [
        *_keys(
            sensor=coefficients.sensor,
            set_sha256=coefficients.sha256,
            status=coefficients.standing,
            convention=coefficients.convention,
            gravity_mps2=coefficients.gravity_mps2,
            equation=f"{words.real} = {words.gain} * {words.measured} + {words.offset}"
            f"{'; g is the local g' if words.unit == 'g' else ''}",
            loses=LOSES,
            document_json=json.dumps(document, separators=(",", ":"), allow_nan=False),
        ),
    ]
    axes = {name: linear_axis(coefficients, name) for name in coefficients.axes}
    for name, axis in axes.items():
        lines += ["", f"[axes.{json.dumps(name)}]", *_axis_keys(coefficients.axes[name], axis, words)]
    for vector in listed(coefficients.test_vectors["forward"]):
        outputs = table(table(vector)[outputs_key(coefficients.axes)])
        lines += ["", "[[test_vectors]]"]
        for name, axis in axes.items():
            measured = number(outputs[name])
            real = axis.gain * measured + axis.offset
            lines.append(f"{json.dumps(name)} = {{ {words.measured} = {measured!r}, {words.real} = {real!r} }}")
    return lines


@dataclass(frozen=True)
class _Words:
    """The file's keys in the units of a set."""

    measured_unit: str
    unit: str

    @classmethod
    def of(cls, coefficients: CoefficientSet) -> "_Words":
        form = next(iter(coefficients.axes.values())).form
        return cls(form.measured_unit, form.unit)

    @property
    def gain(self) -> str:
        return f"a_{self.unit}_per_{self.measured_unit}"

    @property
    def offset(self) -> str:
        return f"b_{self.unit}"

    @property
    def measured(self) -> str:
        return f"measured_{self.measured_unit}"

    @property
    def real(self) -> str:
        return f"real_{self.unit}"


def _axis_keys(numbers: AxisNumbers, axis: LinearAxis, words: _Words) -> list[str]:
    stated: dict[str, object] = {
        "nominal_axis": numbers.nominal_axis,
        "polarity": polarity(numbers),
        words.gain: axis.gain,
        words.offset: axis.offset,
        "covariance": axis.covariance.tolist(),
        f"largest_error_{words.unit}": axis.largest_error,
    }
    if words.unit == "g":
        stated["largest_error_deg"] = math.degrees(axis.largest_error)
    order = f"{words.gain}, {words.offset}"
    return [
        *_keys(**stated),
        f"# covariance in the order {order}; largest errors: of the neglected terms, within the validity",
    ]


def _keys(**values: object) -> list[str]:
    """Return TOML keys.

    JSON's text of numbers, lists and ASCII strings is TOML's, but for NaN.
    """
    return [f"{name} = {_toml_value(value)}" for name, value in values.items()]


def _toml_value(value: object) -> str:
    if isinstance(value, str):
        return json.dumps(value.encode("ascii", "backslashreplace").decode())
    return json.dumps(value).replace("NaN", "nan")


def _comparable(read: Document) -> Document:
    """Return lists of tables as tables, so that they are compared number for number.

    Without the document, and without the status: an archive knows of an approval that the document does not hold.
    """
    vectors = {str(index): vector for index, vector in enumerate(listed(read.get("test_vectors")))}
    rest = {key: value for key, value in read.items() if key not in ("document_json", "status")}
    return {**rest, "test_vectors": vectors}


FORMAT = Format("linear", ".linear.toml", to_linear_form, from_linear_form, LOSES, lacks_accelerometers)
