"""C header in floating point: macros, the equations as ``static inline`` functions, the test vectors and a self-test.

Whoever has only the header can evaluate the set and see that he does it right: ``…_self_test()`` recomputes every
vector and returns the largest relative error, which is to be at most 1e-12.
"""

from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import EXTENDED_NAMES, AxisNumbers
from ams.sets.export.c_text import (
    array,
    c_seal,
    check_evaluable,
    closing,
    defined,
    filled,
    numbers_in,
    opening,
    prefix_of,
    primary_lines,
)
from ams.sets.export.embedded import document_from
from ams.sets.export.native import check_same
from ams.sets.use import polarity
from ams.sets.vectors import is_package

HEAD = "calrig coefficient set as C header, floating point, version 1"
SEAL = c_seal("C header", HEAD)
FUNCTION_TEXT = [
    "Functions: PREFIX_force(pitch_deg, roll_deg, f) gives the specific force; PREFIX_AXIS_v(f, temperature_degc) the "
    "output in volts (temperature_degc is ignored where the set has no temperature coefficients); of a package also "
    "PREFIX_angles(outputs_v, temperature_degc, pitch_deg, roll_deg). PREFIX_self_test() must return at most 1e-12. "
    "No function checks the validity: compare with the PREFIX_..._MIN and _MAX macros.",
]
FORCE = """
static inline void @p@_force(double pitch_deg, double roll_deg, double f[3])
{
    const double degree = 0.017453292519943295;
    const double alpha = pitch_deg * degree, roll = roll_deg * degree;
    f[0] = sin(alpha);
    f[1] = -cos(alpha) * sin(roll);
    f[2] = -cos(alpha) * cos(roll);
}
"""
OUTPUT = """
static inline double @p@_@a@_offset_v(double temperature_degc)
{
    (void)temperature_degc;
    return @P@_@A@_OFFSET_V@offset@;
}

static inline double @p@_@a@_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0@gain@;
}

static inline double @p@_@a@_v(const double f[3], double temperature_degc)
{
    const double sensed_v = @P@_@A@_K_X_V_PER_G * f[0] + @P@_@A@_K_Y_V_PER_G * f[1] + @P@_@A@_K_Z_V_PER_G * f[2]@q@;
    return @p@_@a@_offset_v(temperature_degc) + @p@_@a@_gain(temperature_degc) * sensed_v;
}
"""
ABOVE = "(temperature_degc - @P@_@A@_REFERENCE_TEMPERATURE_DEGC)"
OFFSET = " + @P@_@A@_OFFSET_TC_V_PER_DEGC * " + ABOVE
GAIN = " + @P@_@A@_SENSITIVITY_TC_PER_DEGC * " + ABOVE
QUADRATIC = (
    "(f[0] * f[0] - f[2] * f[2])",
    "2.0 * f[0] * f[1]",
    "2.0 * f[0] * f[2]",
    "(f[1] * f[1] - f[2] * f[2])",
    "2.0 * f[1] * f[2]",
)
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
SELF_TEST = """
static inline double @p@_self_test(void)
{
    const int rows = (int)(sizeof @p@_vectors / sizeof @p@_vectors[0]);
    double largest = 0.0;
    int row;
    for (row = 0; row < rows; row++) {
        const double *vector = @p@_vectors[row];
        double f[3], error;
        @p@_force(vector[0], vector[1], f);
@checks@
    }
    return largest;
}
"""
CHECK = """
        error = fabs(@p@_@a@_v(f, vector[2]) - vector[@column@]) / @P@_@A@_SCALE_V;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
"""


def to_c_header(coefficients: CoefficientSet) -> bytes:
    """The bytes of the file. Raises: SetError where C has no form of the equations here."""
    check_evaluable(coefficients, "C header")
    prefix = prefix_of(coefficients)
    guard = f"{prefix}_h".upper()
    lines = [
        *opening(coefficients, HEAD, [text.replace("PREFIX", prefix) for text in FUNCTION_TEXT]),
        *(f"#ifndef {guard}", f"#define {guard} 1", "#include <math.h>", ""),
        *_macros(coefficients, prefix),
        *_tables(coefficients, prefix),
        *_functions(coefficients, prefix),
        f"#endif /* {guard} */",
        *closing(coefficients),
    ]
    return SEAL.sealed(("\n".join(lines) + "\n").encode("ascii"))


def from_c_header(content: bytes, where: str) -> CoefficientSet:
    """The set in the bytes of a file.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its macros or tables hold other numbers
    than the document in it.
    """
    body = SEAL.checked_body(content, where)
    coefficients = document_from(body, " * ", where)
    prefix = prefix_of(coefficients)
    expected = "\n".join([*_macros(coefficients, prefix), *_tables(coefficients, prefix)])
    check_same(numbers_in(body), numbers_in(expected.encode()), "macros and tables", where)
    return coefficients


def _macros(coefficients: CoefficientSet, prefix: str) -> list[str]:
    unit = table(coefficients.document["acceleration_unit"])
    validity = coefficients.validity
    ranges = {"pitch_{}_deg": validity.pitch_deg, "roll_{}_deg": validity.roll_deg}
    if validity.temperature_degc is not None:
        ranges["temperature_{}_degc"] = validity.temperature_degc
    limits = [
        defined(f"{prefix}_{name.format(end)}", value)
        for name, both in ranges.items()
        for end, value in zip(("min", "max"), both, strict=True)
    ]
    lines = [
        defined(f"{prefix}_set_sha256", f'"{coefficients.sha256}"'),
        defined(f"{prefix}_gravity_mps2", number(unit["value_mps2"])),
        *limits,
    ]
    for numbers in coefficients.axes.values():
        lines.append(defined(f"{prefix}_{numbers.axis}_polarity", polarity(numbers)))
        lines.append(defined(f"{prefix}_{numbers.axis}_scale_v", numbers.scale_v))
        lines.extend(primary_lines(prefix, numbers))
    return [*lines, ""]


def _tables(coefficients: CoefficientSet, prefix: str) -> list[str]:
    axes = ", ".join(f"{name}_v" for name in coefficients.axes)
    vectors = [
        [
            number(vector["pitch_deg"]),
            number(vector["roll_deg"]),
            number(vector.get("temperature_degc", 0.0)),
            *(number(table(vector["outputs_v"])[name]) for name in coefficients.axes),
        ]
        for vector in (table(entry) for entry in listed(coefficients.test_vectors["forward"]))
    ]
    return [
        f"/* pitch_deg, roll_deg, temperature_degc, {axes} */",
        *array("double", f"{prefix}_vectors", vectors),
        "",
        *(line for name in coefficients.axes for line in _covariance(coefficients, prefix, name)),
    ]


def _covariance(coefficients: CoefficientSet, prefix: str, axis: str) -> list[str]:
    primary: Document = table(table(table(coefficients.document["axes"])[axis])["primary"])
    rows = [[_or_nan(entry) for entry in listed(row)] for row in listed(primary["covariance"])]
    order = ", ".join(str(name) for name in listed(primary["order"]))
    return [f"/* in the order {order} */", *array("double", f"{prefix}_{axis}_covariance", rows), ""]


def _or_nan(entry: object) -> float:
    return float(entry) if isinstance(entry, int | float) else float("nan")


def _functions(coefficients: CoefficientSet, prefix: str) -> list[str]:
    names = {"p": prefix, "P": prefix.upper()}
    lines = filled(FORCE, names)
    for numbers in coefficients.axes.values():
        here = {**names, "a": numbers.axis, "A": numbers.axis.upper()}
        lines += ["", *filled("\n".join(filled(OUTPUT, _terms(numbers))), here)]
    if is_package(coefficients.axes):
        lines += ["", *filled("\n".join(filled(ANGLES, _package(coefficients))), names)]
    checks = [
        line
        for column, axis in enumerate(coefficients.axes, 3)
        for line in filled(CHECK, {**names, "a": axis, "A": axis.upper(), "column": column})
    ]
    return [*lines, "", *filled(SELF_TEST, {"checks": "\n".join(checks), **names}), ""]


def _terms(numbers: AxisNumbers) -> dict[str, str]:
    quadratic = [
        f"\n        + @P@_@A@_{name.upper()} * {term}" for name, term in zip(EXTENDED_NAMES, QUADRATIC, strict=True)
    ]
    return {
        "offset": OFFSET if numbers.needs_temperature else "",
        "gain": GAIN if numbers.needs_temperature else "",
        "q": "" if numbers.is_linear else "".join(quadratic),
    }


def _package(coefficients: CoefficientSet) -> dict[str, str]:
    import numpy as np

    axes = list(coefficients.axes.values())
    determinant = np.linalg.det(np.stack([numbers.direction_v_per_g for numbers in axes]))
    k = [", ".join(f"@P@_{n.axis.upper()}_K_{c}_V_PER_G" for c in "XYZ") for n in axes]
    sensed = [
        f"(outputs_v[{i}] - @p@_{n.axis}_offset_v(temperature_degc)) / @p@_{n.axis}_gain(temperature_degc)"
        for i, n in enumerate(axes)
    ]
    return {
        "order": ", ".join(coefficients.axes),
        "rows": ",\n        ".join(f"{{{row}}}" for row in k),
        "sensed": ",\n        ".join(sensed),
        "sign": "1.0" if determinant > 0.0 else "-1.0",
    }
