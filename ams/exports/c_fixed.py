"""C header in fixed point, for machines without floating point: 32-bit words, 64-bit sums, a stated rounding error.

The specific force comes in units of 2^-30 local g, offsets and outputs are in units of 2^-26 V (15 nV; full scale
32 V), k in 2^-26 V per g. The output is b + round(k·f / 2^30), rounded half away from zero. With every input and
coefficient off by at most half a unit, |f| = 1, the output is off by at most
½ (b) + √3/2 (k: Σ|f_i| ≤ √3) + ½ (last rounding) units, and Σ|k_i|/2^31 units for f. What does not fit is refused.

Straight lines have the same arithmetic with bits of their own: 2^30 words of a level are the power of two that holds
every level of the calibration, and an output has as many bits as the largest one leaves. Σ|f_i| ≤ √3 does not hold of
levels, so ½ for each component of k stands in its place.
"""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ams.errors import SetError
from ams.exports.c_text import (
    array,
    c_checksum_line,
    check_accelerometers,
    check_names,
    checked_header,
    closing,
    defined,
    filled,
    is_of_one_quantity,
    lacks_accelerometers,
    numbers_in,
    opening,
    prefix_of,
    refusal_text,
    verdict_lines,
)
from ams.exports.embedded import document_from
from ams.exports.format import Format
from ams.exports.plain_values import check_same
from ams.frames import specific_force
from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers
from ams.sets.instructions import polarity
from ams.units import ARCSEC_PER_DEG, UNITS

HEAD = "calrig coefficient set as C header, fixed point, version {}"
CHECKSUM_LINES = tuple(c_checksum_line("C header in fixed point", HEAD.format(version)) for version in (1, 2))
"""Of every version, the first without the macros of the verdict; both are read."""
FORCE_BITS = 30
VOLT_BITS = 26
LARGEST_WORD = 2**31 - 1
LOSES = (
    "rounds coefficients to 2^-26 V and the force to 2^-30, leaves out terms of second and third order (bound of both "
    "stated in the file) and holds the uncertainty only in its comment"
)
LINES_LOSE = (
    "rounds coefficients, levels and outputs to the bits stated in the file (bound of it stated too) and holds the "
    "uncertainty only in its comment"
)
OUTPUT = """
/* f in 2^-@field_bits@ @field@, |f| <= 2^30 each; the output in 2^-@bits@ @unit@, \
at most @P@_@A@_ERROR_@U@ from the exact one */
static inline int32_t @p@_@a@_@words@(const int32_t f[3])
{
    const int64_t sum = (int64_t)@P@_@A@_K_X * f[0] + (int64_t)@P@_@A@_K_Y * f[1] + (int64_t)@P@_@A@_K_Z * f[2];
    const int64_t half = (int64_t)1 << 29, whole = (int64_t)1 << 30;
    const int64_t rounded = sum >= 0 ? (sum + half) / whole : -((half - sum) / whole);
    return (int32_t)(@P@_@A@_OFFSET + rounded);
}
"""
SELF_TEST = """
/* The number of test vectors that are not reproduced exactly: must be 0. */
static inline int @p@_self_test(void)
{
    const int rows = (int)(sizeof @p@_vectors / sizeof @p@_vectors[0]);
    int wrong = 0, row;
    for (row = 0; row < rows; row++) {
        const int32_t *vector = @p@_vectors[row];
@checks@
    }
    return wrong;
}
"""
CHECK = "        wrong += @p@_@a@_@words@(vector) != vector[@column@];"


@dataclass(frozen=True)
class Scale:
    """What the words of a set are in: one of the field is 2^-field_bits, one of an output 2^-output_bits."""

    field_bits: int
    output_bits: int
    field: str
    """The unit of the field in words, ASCII."""
    measured_unit: str
    """Of the outputs, as it is written in a key."""
    is_of_levels: bool

    def field_word(self, value: float) -> int:
        return _word(value, self.field_bits)

    def output_word(self, value: float) -> int:
        return _word(value, self.output_bits)

    def k_word(self, value: float) -> int:
        """Return a component of k per 2^30 words of the field."""
        return _word(value, self.output_bits + FORCE_BITS - self.field_bits)


ACCELEROMETERS = Scale(FORCE_BITS, VOLT_BITS, "local g", "v", is_of_levels=False)


@dataclass(frozen=True)
class FixedAxis:
    """One axis in words, and how far its output can be off."""

    axis: str
    offset: int
    k: tuple[int, int, int]
    error: float
    """In the unit of the outputs: volts, or that of a line's readings."""
    error_of_field: float
    """The error in what is sensed along k: in g, or in the unit of a line's levels."""

    def counts(self, f: tuple[int, int, int]) -> int:
        """Return the output in words, as the C function computes it."""
        total = sum(k * component for k, component in zip(self.k, f, strict=True))
        half, whole = 1 << (FORCE_BITS - 1), 1 << FORCE_BITS
        rounded = (total + half) // whole if total >= 0 else -((half - total) // whole)
        return self.offset + rounded


def to_c_fixed(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a C header in fixed point.

    Of a set with terms of second and third order it has the linear sensor that comes closest to it. Raises: SetError
    where fixed point has no form of the equations (temperature, terms that are not centred) or a coefficient or output
    does not fit.
    """
    scale, axes = scale_of(coefficients), fixed_axes(coefficients)
    prefix = _prefix(coefficients)
    guard = f"{prefix}_h".upper()
    lost = LINES_LOSE if scale.is_of_levels else LOSES
    loses = [f"Loses: {lost}.", *(_error_text(coefficients, axis) for axis in axes)]
    lines = [
        *opening(coefficients, HEAD.format(len(CHECKSUM_LINES)), [refusal_text(prefix), *loses]),
        *(f"#ifndef {guard}", f"#define {guard} 1", "#include <stdint.h>", ""),
        *_macros(coefficients, axes, prefix),
        *_vectors(coefficients, axes, prefix),
        *_functions(scale, axes, prefix),
        f"#endif /* {guard} */",
        *closing(coefficients),
    ]
    return CHECKSUM_LINES[-1].append_to(("\n".join(lines) + "\n").encode("ascii"))


def from_c_fixed(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a header: the exact one, out of its comment.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its words are not those of the document
    in it.
    """
    body, version = checked_header(content, where, CHECKSUM_LINES)
    coefficients = document_from(body, " * ", where)
    prefix, axes = _prefix(coefficients), fixed_axes(coefficients)
    macros = _macros(coefficients, axes, prefix, has_verdict=version > 1)
    expected = "\n".join([*macros, *_vectors(coefficients, axes, prefix)])
    check_same(numbers_in(body), numbers_in(expected.encode()), "macros and tables", where)
    return coefficients


def _prefix(coefficients: CoefficientSet) -> str:
    """Return the prefix, not that of the floating-point header: a program may take both."""
    return f"{prefix_of(coefficients)}_fixed"


def scale_of(coefficients: CoefficientSet) -> Scale:
    """Return what the words of a set are in.

    Raises: SetError for another equation than that of accelerometers of pitch and roll or of straight lines in one
    unit, and where lines have no range of levels or outputs that do not fit into 32 bits.
    """
    if not is_of_one_quantity(coefficients):
        check_accelerometers(coefficients, "C header in fixed point", "use the floating-point header (c)")
        return ACCELEROMETERS
    form = next(iter(coefficients.axes.values())).form
    widest = max((abs(end) for limits in coefficients.validity.levels.values() for end in limits), default=0.0)
    if widest <= 0.0:
        raise SetError(
            f"{coefficients.sensor}: fixed point: got no range of levels in the set's validity, needed is one that is "
            "not 0: the words are made to hold it; nothing was written; use the floating-point header (c)"
        )
    whole_bits = math.ceil(math.log2(widest))
    largest = {
        name: abs(numbers.primary[form.offset]) + float(np.abs(numbers.direction).sum()) * 2.0**whole_bits
        for name, numbers in coefficients.axes.items()
    }
    name = max(largest, key=largest.__getitem__)
    # One bit is the sign's; 2 more words than the largest output leave room for the rounding of offset and k.
    bits = 31 - math.ceil(math.log2(largest[name] * (1.0 + 2.0**-28)))
    if bits < 0:
        unit = UNITS.get(form.measured_unit, form.measured_unit)
        raise SetError(
            f"{coefficients.sensor}: axis {name}: fixed point: overflow: got |zero level| + |k| up to "
            f"{largest[name]:.10g} {unit} at levels up to {2.0**whole_bits:.6g} {form.unit}, allowed below {2**31} "
            f"{unit} in 32 bits; nothing was written; use the floating-point header (c)"
        )
    field = UNITS.get(form.unit, form.unit)
    return Scale(FORCE_BITS - whole_bits, bits, field, form.measured_unit, is_of_levels=True)


def fixed_axes(coefficients: CoefficientSet) -> list[FixedAxis]:
    """Return the coefficients of every axis as whole numbers. Raises: SetError."""
    scale = scale_of(coefficients)
    check_names(coefficients)
    return [_fixed(coefficients.sensor, numbers, scale) for numbers in coefficients.axes.values()]


def _fixed(sensor: str, numbers: AxisNumbers, scale: Scale) -> FixedAxis:
    is_bent = not numbers.is_linear and numbers.centring is None
    if is_bent or numbers.needs_temperature:
        raise SetError(
            f"{sensor}: axis {numbers.axis}: fixed point: got {'quadratic' if is_bent else 'temperature'} "
            "terms, allowed is v = b + k.f alone; nothing was written; use the floating-point header (c)"
        )
    offset = scale.output_word(numbers.primary[numbers.form.offset])
    k = numbers.direction
    x, y, z = (scale.k_word(float(value)) for value in k)
    largest = abs(offset) + abs(x) + abs(y) + abs(z)
    if largest > LARGEST_WORD:
        raise SetError(
            f"{sensor}: axis {numbers.axis}: fixed point: overflow: got |offset| + |k| up to {numbers.scale_v:.6g} V, "
            f"allowed below {2 ** (31 - VOLT_BITS)} V in 32 bits of 2^-{VOLT_BITS} V; nothing was written; use the "
            "floating-point header (c)"
        )
    of_k = int(np.count_nonzero(k)) / 2.0 if scale.is_of_levels else math.sqrt(3.0) / 2.0
    units = 0.5 + of_k + 0.5 + (abs(x) + abs(y) + abs(z)) / 2.0 ** (FORCE_BITS + 1)
    error = units / 2.0**scale.output_bits + (0.0 if scale.is_of_levels else _left_out_v(numbers))
    return FixedAxis(numbers.axis, offset, (x, y, z), error, error / float(np.linalg.norm(k)))


def _left_out_v(numbers: AxisNumbers) -> float:
    """Return the most that the terms of second and third order do to an output at rest, at any attitude.

    They are looked at every degree; between, they turn by half a degree of their own slope. Whole words, so that every
    machine says the same.
    """
    if numbers.is_linear:
        return 0.0
    pitch, roll = np.meshgrid(np.radians(np.arange(-90.0, 91.0)), np.radians(np.arange(-180.0, 180.0)))
    between = numbers.largest_bend_v_per_g * math.radians(math.sqrt(0.5))
    largest_v = float(np.abs(numbers.terms_v(specific_force(pitch, roll))).max()) + between
    return math.ceil(largest_v * 2.0**VOLT_BITS) / 2.0**VOLT_BITS


def _word(value: float, bits: int = VOLT_BITS) -> int:
    """Return the nearest whole number of 2^-bits, half away from zero, exactly."""
    whole: int = math.floor(abs(Fraction(value)) * 2**bits + Fraction(1, 2))
    return -whole if value < 0.0 else whole


def _error_text(coefficients: CoefficientSet, axis: FixedAxis) -> str:
    form = coefficients.axes[axis.axis].form
    unit = UNITS.get(form.measured_unit, form.measured_unit)
    if form.senses_level:
        of_field = f"{axis.error_of_field:.2g} {UNITS.get(form.unit, form.unit)} of the level along k."
    else:
        arcsec = math.degrees(axis.error_of_field) * ARCSEC_PER_DEG
        of_field = f"{arcsec:.2g} arc seconds where the axis is most sensitive to the angle."
    return f"Axis {axis.axis}: the output is off by at most {axis.error!r} {unit}, {of_field}"


def _macros(coefficients: CoefficientSet, axes: list[FixedAxis], prefix: str, *, has_verdict: bool = True) -> list[str]:
    scale = scale_of(coefficients)
    field, output = ("level", "output") if scale.is_of_levels else ("force", "volt")
    lines = [
        defined(f"{prefix}_set_sha256", f'"{coefficients.sha256}"'),
        *(verdict_lines(coefficients, prefix) if has_verdict else []),
        defined(f"{prefix}_{field}_bits", scale.field_bits),
        defined(f"{prefix}_{output}_bits", scale.output_bits),
    ]
    for axis in axes:
        words = {"polarity": polarity(coefficients.axes[axis.axis]), "offset": axis.offset}
        words.update(zip(("k_x", "k_y", "k_z"), axis.k, strict=True))
        lines += [defined(f"{prefix}_{axis.axis}_{name}", word) for name, word in words.items()]
        lines.append(defined(f"{prefix}_{axis.axis}_error_{scale.measured_unit}", axis.error))
    return [*lines, ""]


def _vectors(coefficients: CoefficientSet, axes: list[FixedAxis], prefix: str) -> list[str]:
    scale, rows = scale_of(coefficients), []
    for entry in listed(coefficients.test_vectors["forward"]):
        field = _field_words(coefficients, table(entry), scale)
        rows.append([*field, *(axis.counts(field) for axis in axes)])
    unit = UNITS.get(scale.measured_unit, scale.measured_unit)
    outputs = ", ".join(f"{axis.axis} in 2^-{scale.output_bits} {unit}" for axis in axes)
    fields = "level_x, level_y, level_z" if scale.is_of_levels else "f_x, f_y, f_z"
    of = f" {scale.field}" if scale.is_of_levels else ""
    return [
        f"/* {fields} in 2^-{scale.field_bits}{of}, {outputs} */",
        *array("int32_t", f"{prefix}_vectors", rows),
        "",
    ]


def _field_words(coefficients: CoefficientSet, vector: Document, scale: Scale) -> tuple[int, int, int]:
    if scale.is_of_levels:
        inputs = next(iter(coefficients.axes.values())).form.inputs
        x, y, z = (number(vector[name]) for name in inputs)
    else:
        x, y, z = specific_force(np.radians(number(vector["pitch_deg"])), np.radians(number(vector["roll_deg"])))
    return scale.field_word(float(x)), scale.field_word(float(y)), scale.field_word(float(z))


def _functions(scale: Scale, axes: list[FixedAxis], prefix: str) -> list[str]:
    names: dict[str, object] = {
        "p": prefix,
        "P": prefix.upper(),
        "field_bits": scale.field_bits,
        "field": scale.field,
        "bits": scale.output_bits,
        "unit": UNITS.get(scale.measured_unit, scale.measured_unit),
        "U": scale.measured_unit.upper(),
        "words": "words" if scale.is_of_levels else "counts",
    }
    outputs = [
        line for axis in axes for line in ["", *filled(OUTPUT, {**names, "a": axis.axis, "A": axis.axis.upper()})]
    ]
    checks = [
        line
        for column, axis in enumerate(axes, 3)
        for line in filled(CHECK, {**names, "a": axis.axis, "column": column})
    ]
    return [*outputs, "", *filled(SELF_TEST, {"checks": "\n".join(checks), **names}), ""]


FORMAT = Format("c-fixed", ".fixed.h", to_c_fixed, from_c_fixed, LOSES, lacks_accelerometers)
