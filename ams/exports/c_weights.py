"""The weighted least squares of a package in C: what its outputs are weighed by, and the unit force that fits them.

The estimate is that of :mod:`ams.attitude.three_axes`, TP (99) to (108): each output weighs by the variance of its
reading and, of the calibrations, by their mean in units of g. Where the axes are equally sharp it is nearly the
direction of what they sense; where one is much less sharp than the others, that direction is several times worse.
"""

from collections.abc import Mapping
from typing import Final

from ams.exports.c_text import defined_unless, filled
from ams.sets.axis_section import standard_error_of
from ams.sets.canonical import listed, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import GAIN_TC_NAMES, OFFSET_TC_NAMES, AxisNumbers

TEXT: Final = (
    "The angles are those of weighted least squares, as calrig attitude has them: each output weighs by the "
    "standard deviation of its reading, @readings@ (those of the calibration; define them before #include where "
    "readings are otherwise sharp), and by what the calibrations leave uncertain of it."
)
VARIANCE: Final = """
/* What the calibration leaves uncertain of the output of axis @a@ at f, at the reference temperature, in V^2. */
static inline double @p@_@a@_variance_v2(const double f[3], double temperature_degc)
{
    const double gain = @p@_@a@_gain(temperature_degc);
    const double slope[@count@] = {
        @slopes@
    };
    double sum = 0.0;
    int i, j;
    for (i = 0; i < @count@; i++) {
        for (j = 0; j < @count@; j++) {
            const double covariance = @p@_@a@_covariance[i][j];
            sum += isfinite(covariance) ? slope[i] * slope[j] * covariance : 0.0; /* not determined: NAN */
        }
    }
    return sum;
}
"""
WEIGHING: Final = """
static inline void @p@_inverse(double inverse[3][3])
{
    const double m[3][3] = {
        @rows@
    };
    const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                             + m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2])
                             + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    int i, j;
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, p = (j + 1) % 3, q = (j + 2) % 3;
            inverse[i][j] = (m[p][a] * m[q][b] - m[p][b] * m[q][a]) / determinant;
        }
    }
}

/* Covariance of K^-1 (outputs - offsets) at f by the variances that the outputs are weighed by, up to a factor. */
static inline void @p@_weighing(const double f[3], double temperature_degc, double inverse[3][3], double weighing[3][3])
{
    const double square[3] = {
        @squares@
    };
    const double reading_v[3] = {
        @read@
    };
    const double calibration_v2[3] = {
        @calibrations@
    };
    double mean = 0.0, all = 0.0, variance[3];
    int i, j;
    for (i = 0; i < 3; i++) {
        mean += calibration_v2[i] / square[i] / 3.0; /* an axis' own rests on a few replications */
    }
    for (i = 0; i < 3; i++) {
        variance[i] = reading_v[i] * reading_v[i] + square[i] * mean;
        all += variance[i];
    }
    for (i = 0; i < 3; i++) {
        variance[i] = all > 0.0 ? variance[i] : 1.0;
    }
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            weighing[i][j] = inverse[i][0] * variance[0] * inverse[j][0] + inverse[i][1] * variance[1] * inverse[j][1]
                           + inverse[i][2] * variance[2] * inverse[j][2];
        }
    }
}

/* The f of the length of gravity that fits best what three axes sense: f = sensed - lambda C f, TP (99) to (108).
   Returns 0 where no step of @most@ settles it: f is then the direction of what is sensed, far from any attitude. */
static inline int @p@_fitted(const double sensed[3], double gravity, double temperature_degc, double inverse[3][3],
                             double f[3])
{
    const double length = sqrt(sensed[0] * sensed[0] + sensed[1] * sensed[1] + sensed[2] * sensed[2]);
    double weighing[3][3], moved = 1.0;
    int step, i;
    for (i = 0; i < 3; i++) {
        f[i] = sensed[i] * (gravity / length);
    }
    @p@_weighing(f, temperature_degc, inverse, weighing);
    for (step = 0; step < @most@ && moved > 1e-14; step++) {
        double along[3], next[3], factor, to_length;
        for (i = 0; i < 3; i++) {
            along[i] = weighing[i][0] * f[0] + weighing[i][1] * f[1] + weighing[i][2] * f[2];
        }
        factor = (f[0] * sensed[0] + f[1] * sensed[1] + f[2] * sensed[2] - gravity * gravity)
               / (f[0] * along[0] + f[1] * along[1] + f[2] * along[2]);
        for (i = 0; i < 3; i++) {
            next[i] = sensed[i] - factor * along[i];
        }
        to_length = gravity / sqrt(next[0] * next[0] + next[1] * next[1] + next[2] * next[2]);
        for (i = 0, moved = 0.0; i < 3; i++) {
            const double change = fabs(next[i] * to_length - f[i]);
            moved = change > moved || change != change ? change : moved; /* once not a number, always */
            f[i] = next[i] * to_length;
        }
    }
    if (moved <= 1e-9 && f[0] * sensed[0] + f[1] * sensed[1] + f[2] * sensed[2] > 0.0) {
        return 1;
    }
    for (i = 0; i < 3; i++) {
        f[i] = sensed[i] * (gravity / length);
    }
    return 0;
}
"""
_STEPS_AT_MOST: Final = 20
"""As many as :mod:`ams.attitude.three_axes` takes; readings that belong to the set take three."""
_ABOVE: Final = "(temperature_degc - @P@_@A@_REFERENCE_TEMPERATURE_DEGC)"
_SENSED_BY_GAIN: Final = "(@p@_@a@_v(f, temperature_degc) - @p@_@a@_offset_v(temperature_degc)) / (gain * gain)"


def reading_macros(coefficients: CoefficientSet, prefix: str) -> list[str]:
    """Return the standard deviation of a reading of each axis, in volts, which a program may define itself.

    A set that states no standard error of its rows has those of readings without noise.
    """
    sections = table(coefficients.document["axes"])
    stated = {name: standard_error_of(table(sections[name]), numbers) for name, numbers in coefficients.axes.items()}
    return [line for name, sd in stated.items() for line in defined_unless(f"{prefix}_{name}_reading_sd_v", sd or 0.0)]


def reading_names(coefficients: CoefficientSet, prefix: str) -> list[str]:
    """Return the names of these macros."""
    return [f"{prefix}_{name}_reading_sd_v".upper() for name in coefficients.axes]


def weighing_functions(coefficients: CoefficientSet) -> list[str]:
    """Return the functions that weigh and fit, the prefix of their names left to fill in."""
    axes = coefficients.axes.values()
    k = [[f"@P@_{n.axis.upper()}_K_{c}_V_PER_G" for c in "XYZ"] for n in axes]
    words = {
        "rows": ",\n        ".join(f"{{{', '.join(row)}}}" for row in k),
        "squares": ",\n        ".join(" + ".join(f"{name} * {name}" for name in row) for row in k),
        "read": _of_each(coefficients, "@P@_@A@_READING_SD_V / @p@_@a@_gain(temperature_degc)"),
        "calibrations": _of_each(coefficients, "@p@_@a@_variance_v2(f, temperature_degc)"),
        "most": _STEPS_AT_MOST,
    }
    variances = [line for numbers in axes for line in [*_variance(coefficients, numbers), ""]]
    return [*variances, *filled(WEIGHING, words)]


def _of_each(coefficients: CoefficientSet, text: str) -> str:
    return ",\n        ".join(text.replace("@A@", axis.upper()).replace("@a@", axis) for axis in coefficients.axes)


def _variance(coefficients: CoefficientSet, numbers: AxisNumbers) -> list[str]:
    """Return the function of one axis' variance: its table of covariances along what the coefficients multiply."""
    primary = table(table(table(coefficients.document["axes"])[numbers.axis])["primary"])
    slopes = _slopes(numbers)
    found = [slopes.get(str(name), "0.0") for name in listed(primary["order"])]
    words = {"count": len(found), "slopes": ",\n        ".join(found), "a": numbers.axis, "A": numbers.axis.upper()}
    return filled(VARIANCE, words)


def _slopes(numbers: AxisNumbers) -> Mapping[str, str]:
    """Return in C what an error of each coefficient makes of the output brought to the reference temperature."""
    form, low_order = numbers.form, numbers.form.low_order
    slopes = {form.offset: "1.0 / gain"}
    slopes |= {name: f"f[{index}]" for index, name in enumerate(form.directions)}
    names, terms = ((), ()) if low_order is None else (low_order.names, low_order.c(numbers.nominal_axis))
    for index, (name, term) in enumerate(zip(names, terms, strict=True)):
        off = "" if numbers.centring is None else _taken_off(*map(float, numbers.centring[index]))
        slopes[name] = f"{term}{off}"
    for names_of_powers, factor in ((OFFSET_TC_NAMES, "1.0 / gain"), (GAIN_TC_NAMES, _SENSED_BY_GAIN)):
        for power, name in enumerate(names_of_powers, 1):
            slopes[name] = f"{' * '.join([_ABOVE] * power)} * {factor}"
    return slopes


def _taken_off(constant: float, x: float, y: float, z: float) -> str:
    return f" - ({constant!r} + {x!r} * f[0] + {y!r} * f[1] + {z!r} * f[2])"
