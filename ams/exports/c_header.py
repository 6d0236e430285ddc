"""C header in floating point: macros, the equations as ``static inline`` functions, the test vectors and a self-test.

Whoever has only the header can evaluate the set and see that he does it right: ``…_self_test()`` recomputes every
vector and returns the largest relative error, which is to be at most 1e-12.
"""

from collections.abc import Sequence

from ams.errors import SetError
from ams.exports.c_angles import TEXT as ANGLES_TEXT
from ams.exports.c_angles import angle_function, angle_macros
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
from ams.exports.c_weights import TEXT as WEIGHTS_TEXT
from ams.exports.c_weights import reading_macros, reading_names
from ams.exports.embedded import document_from
from ams.exports.format import Format
from ams.exports.plain_values import check_same
from ams.models.sensor_model import SetForm
from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers
from ams.sets.instructions import polarity
from ams.sets.vectors import is_package, outputs_key
from ams.units import UNITS

HEAD = "calrig coefficient set as C header, floating point, version {}"
CHECKSUM_LINES = tuple(c_checksum_line("C header", HEAD.format(version)) for version in (1, 2, 3, 4))
"""Of every version; all are read."""
_VERDICT_SINCE, _ANGLES_SINCE, _WEIGHTS_SINCE = 2, 3, 4
"""The versions that had their macros first."""
FUNCTION_TEXT = (
    "Functions: @p@_force(@inputs@, f) gives what the sensors sense; @outputs@, each of (f, temperature_degc), the "
    "output in @unit@ (temperature_degc is ignored where the set has no temperature coefficients). They do not check "
    "the validity@limits@. @p@_self_test() must return at most 1e-12."
)
CENTRED_TEXT = (
    "Coefficients: the macros by the names of the equations below are the coefficients of the set, and the tables "
    "@covariances@ are theirs; offset and k alone are the linear sensor that comes closest over the points of the "
    "calibration. @P@_@A@_@KX@ and so on are no coefficients: they are k minus what the centring of the terms of "
    "second and third order takes off it, @P@_@A@_SENSED_CONSTANT_V is minus the constant that it takes off; every "
    "axis has its own. The functions have the same equations by these, with the terms as they are: output = offset + "
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
    guard = f"{prefix}_h".upper()
    lines = [
        *opening(
            coefficients,
            HEAD.format(len(CHECKSUM_LINES)),
            [refusal_text(prefix), *_texts(coefficients, prefix, form)],
        ),
        *(f"#ifndef {guard}", f"#define {guard} 1", "#include <math.h>", ""),
        *_macros(coefficients, prefix),
        *_tables(coefficients, prefix),
        *_functions(coefficients, prefix, form),
        f"#endif /* {guard} */",
        *closing(coefficients),
    ]
    return CHECKSUM_LINES[-1].append_to(("\n".join(lines) + "\n").encode("ascii"))


def from_c_header(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a header.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its macros or tables hold other numbers
    than the document in it.
    """
    body, version = checked_header(content, where, CHECKSUM_LINES)
    coefficients = document_from(body, " * ", where)
    prefix = prefix_of(coefficients)
    macros = _macros(coefficients, prefix, version)
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


def _texts(coefficients: CoefficientSet, prefix: str, form: SetForm) -> list[str]:
    """Return what the comment says of the functions, every name in it as the code has it."""
    unit, axes = form.measured_unit, coefficients.axes
    limits = [name.upper() for name, _ in _limits(coefficients, prefix)]
    words = {
        "p": prefix,
        "P": prefix.upper(),
        "inputs": ", ".join(form.inputs),
        "outputs": ", ".join(f"{prefix}_{axis}_{unit}" for axis in axes),
        "unit": "volts" if unit == "v" else UNITS.get(unit, unit),
        "readings": ", ".join(reading_names(coefficients, prefix)),
        "limits": f": compare with {', '.join(limits)}" if limits else "",
    }
    texts = [FUNCTION_TEXT, *([ANGLES_TEXT, WEIGHTS_TEXT] if is_package(axes) else [])]
    centred = next((numbers for numbers in axes.values() if numbers.centring is not None), None)
    if centred is not None:
        words["covariances"] = ", ".join(f"{prefix}_{axis}_covariance" for axis in axes)
        words |= {"A": centred.axis.upper(), "KX": sensed_names(centred)[0].upper()}
        texts.append(CENTRED_TEXT)
    return [" ".join(filled(text, words)) for text in texts]


def _macros(coefficients: CoefficientSet, prefix: str, version: int = len(CHECKSUM_LINES)) -> list[str]:
    lines = [
        defined(f"{prefix}_set_sha256", f'"{coefficients.sha256}"'),
        *(verdict_lines(coefficients, prefix) if version >= _VERDICT_SINCE else []),
        defined(f"{prefix}_gravity_mps2", coefficients.gravity_mps2),
    ]
    lines.extend(defined(name, value) for name, value in _limits(coefficients, prefix))
    for numbers in coefficients.axes.values():
        lines.append(defined(f"{prefix}_{numbers.axis}_polarity", polarity(numbers)))
        lines.append(defined(f"{prefix}_{numbers.axis}_scale_{numbers.form.measured_unit}", numbers.scale_v))
        lines.extend(primary_lines(prefix, numbers))
    if version >= _ANGLES_SINCE and is_package(coefficients.axes):
        lines.extend(angle_macros(coefficients, prefix))
    if version >= _WEIGHTS_SINCE and is_package(coefficients.axes):
        lines.extend(reading_macros(coefficients, prefix))
    return [*lines, ""]


def _limits(coefficients: CoefficientSet, prefix: str) -> list[tuple[str, float]]:
    """Return the macros of the validity and their values."""
    found = []
    for name, limits in table(coefficients.document["validity"]).items():
        quantity, unit_text = name.rsplit("_", 1)
        for end, value in zip(("min", "max"), listed(limits), strict=False):
            found.append((f"{prefix}_{quantity}_{end}_{unit_text}", number(value)))
    return found


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
        lines += ["", *filled("\n".join(angle_function(coefficients)), names)]
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


FORMAT = Format("c", ".h", to_c_header, from_c_header)
