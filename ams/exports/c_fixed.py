"""C header in fixed point, for machines without floating point: 32-bit words, 64-bit sums, a stated rounding error.

The specific force comes in units of 2^-30 local g, offsets and outputs are in units of 2^-26 V (15 nV; full scale
32 V), k in 2^-26 V per g. The output is b + round(k·f / 2^30), rounded half away from zero. With every input and
coefficient off by at most half a unit, |f| = 1, the output is off by at most
½ (b) + √3/2 (k: Σ|f_i| ≤ √3) + ½ (last rounding) units, and Σ|k_i|/2^31 units for f. What does not fit is refused.
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
    closing,
    defined,
    filled,
    numbers_in,
    opening,
    prefix_of,
)
from ams.exports.embedded import document_from
from ams.exports.format import Format
from ams.exports.plain_values import check_same
from ams.frames import specific_force
from ams.sets.canonical import listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers
from ams.sets.instructions import polarity
from ams.units import ARCSEC_PER_DEG

HEAD = "calrig coefficient set as C header, fixed point, version 1"
CHECKSUM_LINE = c_checksum_line("C header in fixed point", HEAD)
FORCE_BITS = 30
VOLT_BITS = 26
LARGEST_WORD = 2**31 - 1
LOSES = (
    "rounds coefficients to 2^-26 V and the force to 2^-30, leaves out terms of second and third order (bound of both "
    "stated in the file) and holds the uncertainty only in its comment"
)
OUTPUT = """
/* f in 2^-30 local g, |f| <= 2^30 each; the output in 2^-26 V, at most @P@_@A@_ERROR_V from the exact one */
static inline int32_t @p@_@a@_counts(const int32_t f[3])
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
CHECK = "        wrong += @p@_@a@_counts(vector) != vector[@column@];"


@dataclass(frozen=True)
class FixedAxis:
    """One axis in words, and how far its output can be off."""

    axis: str
    offset: int
    k: tuple[int, int, int]
    error_v: float
    error_arcsec: float
    """The error of the angle where the axis is most sensitive to it."""

    def counts(self, f: tuple[int, int, int]) -> int:
        """Return the output in 2^-26 V, as the C function computes it."""
        total = sum(k * one for k, one in zip(self.k, f, strict=True))
        half, whole = 1 << (FORCE_BITS - 1), 1 << FORCE_BITS
        rounded = (total + half) // whole if total >= 0 else -((half - total) // whole)
        return self.offset + rounded


def to_c_fixed(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a C header in fixed point.

    Of a set with terms of second and third order it has the linear sensor that comes closest to it. Raises: SetError
    where fixed point has no form of the equations (temperature, terms that are not centred) or a coefficient or output
    does not fit.
    """
    axes = fixed_axes(coefficients)
    prefix = _prefix(coefficients)
    guard = f"{prefix}_h".upper()
    loses = [f"Loses: {LOSES}.", *(_error_text(axis) for axis in axes)]
    lines = [
        *opening(coefficients, HEAD, loses),
        *(f"#ifndef {guard}", f"#define {guard} 1", "#include <stdint.h>", ""),
        *_macros(coefficients, axes, prefix),
        *_vectors(coefficients, axes, prefix),
        *_functions(axes, prefix),
        f"#endif /* {guard} */",
        *closing(coefficients),
    ]
    return CHECKSUM_LINE.append_to(("\n".join(lines) + "\n").encode("ascii"))


def from_c_fixed(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a header: the exact one, out of its comment.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its words are not those of the document
    in it.
    """
    body = CHECKSUM_LINE.checked_body(content, where)
    coefficients = document_from(body, " * ", where)
    prefix, axes = _prefix(coefficients), fixed_axes(coefficients)
    expected = "\n".join([*_macros(coefficients, axes, prefix), *_vectors(coefficients, axes, prefix)])
    check_same(numbers_in(body), numbers_in(expected.encode()), "macros and tables", where)
    return coefficients


def _prefix(coefficients: CoefficientSet) -> str:
    """Return the prefix, not that of the floating-point header: a program may take both."""
    return f"{prefix_of(coefficients)}_fixed"


def fixed_axes(coefficients: CoefficientSet) -> list[FixedAxis]:
    """Return the coefficients of every axis as whole numbers. Raises: SetError."""
    check_accelerometers(coefficients, "C header in fixed point")
    check_names(coefficients)
    return [_fixed(coefficients.sensor, numbers) for numbers in coefficients.axes.values()]


def _fixed(sensor: str, numbers: AxisNumbers) -> FixedAxis:
    is_bent = not numbers.is_linear and numbers.centring is None
    if is_bent or numbers.needs_temperature:
        raise SetError(
            f"{sensor}: axis {numbers.axis}: fixed point: got {'quadratic' if is_bent else 'temperature'} "
            "terms, allowed is v = b + k.f alone; nothing was written; use the floating-point header (c)"
        )
    offset = _word(numbers.primary["offset_v"])
    x, y, z = (_word(float(value)) for value in numbers.direction_v_per_g)
    largest = abs(offset) + abs(x) + abs(y) + abs(z)
    if largest > LARGEST_WORD:
        raise SetError(
            f"{sensor}: axis {numbers.axis}: fixed point: overflow: got |offset| + |k| up to {numbers.scale_v:.6g} V, "
            f"allowed below {2 ** (31 - VOLT_BITS)} V in 32 bits of 2^-{VOLT_BITS} V; nothing was written; use the "
            "floating-point header (c)"
        )
    units = 0.5 + math.sqrt(3.0) / 2.0 + 0.5 + (abs(x) + abs(y) + abs(z)) / 2.0 ** (FORCE_BITS + 1)
    error_v = units / 2.0**VOLT_BITS + _left_out_v(numbers)
    slope_v_per_rad = float(np.linalg.norm(numbers.direction_v_per_g))
    return FixedAxis(numbers.axis, offset, (x, y, z), error_v, math.degrees(error_v / slope_v_per_rad) * ARCSEC_PER_DEG)


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


def _error_text(axis: FixedAxis) -> str:
    return (
        f"Axis {axis.axis}: the output is off by at most {axis.error_v!r} V, {axis.error_arcsec:.2g} arc seconds "
        "where the axis is most sensitive to the angle."
    )


def _macros(coefficients: CoefficientSet, axes: list[FixedAxis], prefix: str) -> list[str]:
    lines = [
        defined(f"{prefix}_set_sha256", f'"{coefficients.sha256}"'),
        defined(f"{prefix}_force_bits", FORCE_BITS),
        defined(f"{prefix}_volt_bits", VOLT_BITS),
    ]
    for axis in axes:
        words = {"polarity": polarity(coefficients.axes[axis.axis]), "offset": axis.offset}
        words.update(zip(("k_x", "k_y", "k_z"), axis.k, strict=True))
        lines += [defined(f"{prefix}_{axis.axis}_{name}", word) for name, word in words.items()]
        lines.append(defined(f"{prefix}_{axis.axis}_error_v", axis.error_v))
    return [*lines, ""]


def _vectors(coefficients: CoefficientSet, axes: list[FixedAxis], prefix: str) -> list[str]:
    rows = []
    for entry in listed(coefficients.test_vectors["forward"]):
        force = _force_words(number(table(entry)["pitch_deg"]), number(table(entry)["roll_deg"]))
        rows.append([*force, *(axis.counts(force) for axis in axes)])
    outputs = ", ".join(f"{axis.axis} in 2^-{VOLT_BITS} V" for axis in axes)
    return [f"/* f_x, f_y, f_z in 2^-{FORCE_BITS}, {outputs} */", *array("int32_t", f"{prefix}_vectors", rows), ""]


def _force_words(pitch_deg: float, roll_deg: float) -> tuple[int, int, int]:
    x, y, z = specific_force(np.radians(pitch_deg), np.radians(roll_deg))
    return _word(float(x), FORCE_BITS), _word(float(y), FORCE_BITS), _word(float(z), FORCE_BITS)


def _functions(axes: list[FixedAxis], prefix: str) -> list[str]:
    names = {"p": prefix, "P": prefix.upper()}
    outputs = [
        line for axis in axes for line in ["", *filled(OUTPUT, {**names, "a": axis.axis, "A": axis.axis.upper()})]
    ]
    checks = [
        line
        for column, axis in enumerate(axes, 3)
        for line in filled(CHECK, {**names, "a": axis.axis, "column": column})
    ]
    return [*outputs, "", *filled(SELF_TEST, {"checks": "\n".join(checks), **names}), ""]


FORMAT = Format("c-fixed", ".fixed.h", to_c_fixed, from_c_fixed, LOSES)
