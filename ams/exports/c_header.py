"""C header in floating point: macros, the equations as ``static inline`` functions, the test vectors and a self-test.

Whoever has only the header can evaluate the set and see that he does it right: ``…_self_test()`` recomputes every
vector and returns the largest relative error, which is to be at most 1e-12.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ams.errors import SetError
from ams.exports.c_fields import field_function, models_in_c
from ams.exports.c_text import (
    array,
    c_checksum_line,
    check_names,
    checked_header,
    closing,
    defined,
    filled,
    numbers_in,
    opening,
    prefix_of,
    primary_lines,
    refusal_text,
    sensed_names,
    verdict_lines,
)
from ams.exports.embedded import document_from
from ams.exports.format import Format
from ams.exports.plain_values import check_same
from ams.models.sensor_model import SetForm
from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers
from ams.sets.instructions import polarity
from ams.sets.vectors import INVERSE_STEPS, is_package, is_straight, outputs_key
from ams.units import UNITS

HEAD = "calrig coefficient set as C header, floating point, version 2"
CHECKSUM_LINE = c_checksum_line("C header", HEAD)
FIRST_LINE = c_checksum_line("C header", "calrig coefficient set as C header, floating point, version 1")
"""Of headers without the macros of the verdict, which are still read."""
FUNCTION_TEXT = [
    "Functions: PREFIX_force(INPUTS, f) gives what the sensors sense; PREFIX_AXIS_UNIT(f, temperature_degc) the "
    "output in OUTPUT (temperature_degc is ignored where the set has no temperature coefficients); of a package also "
    "PREFIX_angles(outputs_v, temperature_degc, pitch_deg, roll_deg). PREFIX_self_test() must return at most 1e-12. "
    "No function checks the validity: compare with the PREFIX_..._MIN and _MAX macros.",
]
CENTRED_TEXT = (
    "Coefficients: the macros by the names of the equations below are the coefficients of the set, and the tables "
    "PREFIX_AXIS_covariance are theirs; offset and k alone are the linear sensor that comes closest over the points of "
    "the calibration. PREFIX_AXIS_SENSED_K_X_... and so on are no coefficients: they are k minus what the centring of "
    "the terms of second and third order takes off it, PREFIX_AXIS_SENSED_CONSTANT_V is minus the constant that it "
    "takes off. The functions have the same equations by these, with the terms as they are: output = offset + "
    "sensed_k*f + terms + sensed_constant."
)
OUTPUT = """
static inline double @p@_@a@_offset_@u@(double temperature_degc)
{
    (void)temperature_degc;
    return @P@_@A@_@OFFSET@@offset@;
}

static inline double @p@_@a@_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0@gain@;
}

static inline double @p@_@a@_@u@(const double f[3], double temperature_degc)
{
    const double sensed_v = @P@_@A@_@KX@ * f[0] + @P@_@A@_@KY@ * f[1] + @P@_@A@_@KZ@ * f[2]@q@;
    return @p@_@a@_offset_@u@(temperature_degc) + @p@_@a@_gain(temperature_degc) * sensed_v;
}
"""
MODEL_OUTPUT = """
static inline double @p@_@a@_@u@(const double f[3], double temperature_degc)
{
    (void)temperature_degc;
    return @c@;
}
"""
ABOVE = "(temperature_degc - @P@_@A@_REFERENCE_TEMPERATURE_DEGC)"
ANGLES = """
/* outputs_v in the order @order@; returns 0, or -1 where the force is zero or not finite. */
static inline int @p@_angles(const double outputs_v[3], double temperature_degc, double *pitch_deg, double *roll_deg)
{
    const double degree = 0.017453292519943295;
    const double k[3][3] = {
        @rows@
    };
    const double s[3] = {
        @sensed@
    };
    double f[3];
    int i;
    for (i = 0; i < 3; i++) { /* Cramer's rule; the determinant's sign is kept, its size does not matter for angles */
        const double (*m)[3] = k;
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        f[i] = s[0] * (m[1][a] * m[2][b] - m[1][b] * m[2][a]) + s[1] * (m[2][a] * m[0][b] - m[2][b] * m[0][a])
             + s[2] * (m[0][a] * m[1][b] - m[0][b] * m[1][a]);
        f[i] *= @sign@;
    }
    if (!(f[0] * f[0] + f[1] * f[1] + f[2] * f[2] > 0.0) || !isfinite(f[0] + f[1] + f[2])) {
        return -1;
    }
    *pitch_deg = atan2(f[0], sqrt(f[1] * f[1] + f[2] * f[2])) / degree;
    *roll_deg = atan2(-f[1], -f[2]) / degree;
    return 0;
}
"""
BENT_ANGLES = """
/* outputs_v in the order @order@; returns 0, or -1 where the force is zero or not finite. */
static inline int @p@_angles(const double outputs_v[3], double temperature_degc, double *pitch_deg, double *roll_deg)
{
    const double degree = 0.017453292519943295;
    const double m[3][3] = {
        @rows@
    };
    const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                             + m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2])
                             + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    double f[3] = {0.0, 0.0, 0.0};
    int step, i;
    for (step = 0; step < @steps@; step++) { /* what is left of the outputs, by Cramer's rule; the bend is small */
        const double s[3] = {
            @left@
        };
        for (i = 0; i < 3; i++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3;
            f[i] += (s[0] * (m[1][a] * m[2][b] - m[1][b] * m[2][a]) + s[1] * (m[2][a] * m[0][b] - m[2][b] * m[0][a])
                   + s[2] * (m[0][a] * m[1][b] - m[0][b] * m[1][a])) / determinant;
        }
    }
    if (!(f[0] * f[0] + f[1] * f[1] + f[2] * f[2] > 0.0) || !isfinite(f[0] + f[1] + f[2])) {
        return -1;
    }
    *pitch_deg = atan2(f[0], sqrt(f[1] * f[1] + f[2] * f[2])) / degree;
    *roll_deg = atan2(-f[1], -f[2]) / degree;
    return 0;
}
"""
SELF_TEST = """
static inline double @p@_self_test(void)
{
    const int rows = (int)(sizeof @p@_vectors / sizeof @p@_vectors[0]);
    double largest = 0.0;
    int row;
    for (row = 0; row < rows; row++) {
        const double *vector = @p@_vectors[row];
        double f[3], error;
        @p@_force(@inputs@, f);
@checks@
    }
    return largest;
}
"""
CHECK = """
        error = fabs(@p@_@a@_@u@(f, vector[@temperature@]) - vector[@column@]) / @P@_@A@_SCALE_@U@;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
"""


def to_c_header(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a C header. Raises: SetError where C has no form of the equations here."""
    form = _form(coefficients)
    prefix = prefix_of(coefficients)
    unit = form.measured_unit
    words = {
        "PREFIX": prefix,
        "INPUTS": ", ".join(form.inputs),
        "UNIT": unit,
        "OUTPUT": "volts" if unit == "v" else UNITS.get(unit, unit),
    }
    guard = f"{prefix}_h".upper()
    lines = [
        *opening(coefficients, HEAD, [refusal_text(prefix), *(_worded(text, words) for text in _texts(coefficients))]),
        *(f"#ifndef {guard}", f"#define {guard} 1", "#include <math.h>", ""),
        *_macros(coefficients, prefix),
        *_tables(coefficients, prefix),
        *_functions(coefficients, prefix, form),
        f"#endif /* {guard} */",
        *closing(coefficients),
    ]
    return CHECKSUM_LINE.append_to(("\n".join(lines) + "\n").encode("ascii"))


def from_c_header(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a header.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its macros or tables hold other numbers
    than the document in it.
    """
    body, has_verdict = checked_header(content, where, CHECKSUM_LINE, FIRST_LINE)
    coefficients = document_from(body, " * ", where)
    prefix = prefix_of(coefficients)
    macros = _macros(coefficients, prefix, has_verdict=has_verdict)
    expected = "\n".join([*macros, *_tables(coefficients, prefix)])
    check_same(numbers_in(body), numbers_in(expected.encode()), "macros and tables", where)
    return coefficients


def _form(coefficients: CoefficientSet) -> SetForm:
    """Return the one form of all axes. Raises: SetError where they have several, or one that C has no form of here."""
    models = sorted({numbers.model for numbers in coefficients.axes.values()})
    check_names(coefficients)
    if len(models) != 1 or models[0] not in models_in_c():
        raise SetError(
            f"{coefficients.sensor}: C header: has no form of this set: got the models {', '.join(models)}, allowed is "
            f"one of {', '.join(models_in_c())} for all axes; nothing was written; export another format"
        )
    return next(iter(coefficients.axes.values())).form


def _texts(coefficients: CoefficientSet) -> list[str]:
    is_centred = any(numbers.centring is not None for numbers in coefficients.axes.values())
    return [*FUNCTION_TEXT, *([CENTRED_TEXT] if is_centred else [])]


def _worded(text: str, words: Mapping[str, str]) -> str:
    for name, word in words.items():
        text = text.replace(name, word)
    return text


def _macros(coefficients: CoefficientSet, prefix: str, *, has_verdict: bool = True) -> list[str]:
    lines = [
        defined(f"{prefix}_set_sha256", f'"{coefficients.sha256}"'),
        *(verdict_lines(coefficients, prefix) if has_verdict else []),
        defined(f"{prefix}_gravity_mps2", coefficients.gravity_mps2),
    ]
    for name, limits in table(coefficients.document["validity"]).items():
        quantity, unit_text = name.rsplit("_", 1)
        for end, value in zip(("min", "max"), listed(limits), strict=False):
            lines.append(defined(f"{prefix}_{quantity}_{end}_{unit_text}", number(value)))
    for numbers in coefficients.axes.values():
        lines.append(defined(f"{prefix}_{numbers.axis}_polarity", polarity(numbers)))
        lines.append(defined(f"{prefix}_{numbers.axis}_scale_{numbers.form.measured_unit}", numbers.scale_v))
        lines.extend(primary_lines(prefix, numbers))
    return [*lines, ""]


def _tables(coefficients: CoefficientSet, prefix: str) -> list[str]:
    inputs = [*_form(coefficients).inputs, "temperature_degc"]
    unit = _form(coefficients).measured_unit
    axes = ", ".join([*inputs, *(f"{name}_{unit}" for name in coefficients.axes)])
    vectors = [
        [
            *(number(vector.get(name, 0.0)) for name in inputs),
            *(number(table(vector[outputs_key(coefficients.axes)])[name]) for name in coefficients.axes),
        ]
        for vector in (table(entry) for entry in listed(coefficients.test_vectors["forward"]))
    ]
    return [
        f"/* {axes} */",
        *array("double", f"{prefix}_vectors", vectors),
        "",
        *(line for name in coefficients.axes for line in _covariance(coefficients, prefix, name)),
    ]


def _covariance(coefficients: CoefficientSet, prefix: str, axis: str) -> list[str]:
    primary: Document = table(table(table(coefficients.document["axes"])[axis])["primary"])
    rows = [[_or_nan(entry) for entry in listed(row)] for row in listed(primary["covariance"])]
    order = ", ".join(str(name) for name in listed(primary["order"]))
    about = f"/* of the set's coefficients, in the order {order} */"
    return [about, *array("double", f"{prefix}_{axis}_covariance", rows), ""]


def _or_nan(entry: object) -> float:
    return float(entry) if isinstance(entry, int | float) else float("nan")


def _functions(coefficients: CoefficientSet, prefix: str, form: SetForm) -> list[str]:
    unit = form.measured_unit
    names = {"p": prefix, "P": prefix.upper(), "u": unit, "U": unit.upper(), "OFFSET": form.offset.upper()}
    lines = field_function(prefix, form)
    for numbers in coefficients.axes.values():
        here = {**names, "a": numbers.axis, "A": numbers.axis.upper()}
        lines += ["", *filled(_output(numbers), here)]
    if is_package(coefficients.axes):
        angles = ANGLES if is_straight(coefficients.axes) else BENT_ANGLES
        lines += ["", *filled("\n".join(filled(angles, _package(coefficients))), names)]
    count = len(form.inputs)
    checks = [
        line
        for column, axis in enumerate(coefficients.axes, count + 1)
        for line in filled(CHECK, {**names, "a": axis, "A": axis.upper(), "temperature": count, "column": column})
    ]
    inputs = ", ".join(f"vector[{index}]" for index in range(count))
    return [*lines, "", *filled(SELF_TEST, {"checks": "\n".join(checks), "inputs": inputs, **names}), ""]


def _output(numbers: AxisNumbers) -> str:
    formula = numbers.model_output
    if formula is None:
        return "\n".join(filled(OUTPUT, _terms(numbers)))
    assert formula.c is not None, "models without C were refused"
    return MODEL_OUTPUT.replace(
        "@c@", formula.c.format(**{name: f"@P@_@A@_{name.upper()}" for name in formula.primary_names})
    )


def _terms(numbers: AxisNumbers) -> dict[str, str]:
    low_order = numbers.form.low_order
    factors = () if low_order is None else low_order.c(numbers.nominal_axis)
    bent = [
        f"\n        + @P@_@A@_{name.upper()} * {term}" for name, term in zip(numbers.bent_terms, factors, strict=False)
    ]
    if numbers.centring is not None:
        bent.append("\n        + @P@_@A@_SENSED_CONSTANT_V")
    k = zip(("KX", "KY", "KZ"), sensed_names(numbers), strict=True)
    return {
        **{symbol: name.upper() for symbol, name in k},
        "offset": _warmed(numbers.temperature_names[0::2]),
        "gain": _warmed(numbers.temperature_names[1::2]),
        "q": "" if numbers.is_linear else "".join(bent),
    }


def _warmed(names: Sequence[str]) -> str:
    """Return the terms of coefficients by rising power of temperature."""
    powers = enumerate(names, start=1)
    return "".join(f" + @P@_@A@_{name.upper()} * {' * '.join([ABOVE] * power)}" for power, name in powers)


def _package(coefficients: CoefficientSet) -> dict[str, str]:
    axes = list(coefficients.axes.values())
    determinant = np.linalg.det(np.stack([numbers.direction_v_per_g for numbers in axes]))
    k = [", ".join(f"@P@_{n.axis.upper()}_K_{c}_V_PER_G" for c in "XYZ") for n in axes]
    sensed = [
        f"(outputs_v[{i}] - @p@_{n.axis}_offset_@u@(temperature_degc)) / @p@_{n.axis}_gain(temperature_degc)"
        for i, n in enumerate(axes)
    ]
    left = [
        f"(outputs_v[{i}] - @p@_{n.axis}_@u@(f, temperature_degc)) / @p@_{n.axis}_gain(temperature_degc)"
        for i, n in enumerate(axes)
    ]
    return {
        "order": ", ".join(coefficients.axes),
        "left": ",\n            ".join(left),
        "steps": str(INVERSE_STEPS),
        "rows": ",\n        ".join(f"{{{row}}}" for row in k),
        "sensed": ",\n        ".join(sensed),
        "sign": "1.0" if determinant > 0.0 else "-1.0",
    }


FORMAT = Format("c", ".h", to_c_header, from_c_header)
