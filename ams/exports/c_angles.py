"""Pitch and roll of a package in C, and what a program is told of them: an output that is wrong, a roll that is none.

The outputs of three axes have one length too many: where what they sense is not as long as gravity, one of them is
wrong, and the angles of that row with it. Its bound and that of roll are macros, which a program with readings of
another sharpness defines before it takes the header in.
"""

import math
from typing import Final

from ams.exports.c_text import defined, defined_unless, filled
from ams.exports.c_weights import weighing_functions
from ams.inference.package.package_bounds import package_bounds
from ams.sets.coefficients import CoefficientSet
from ams.sets.vectors import INVERSE_STEPS, ROUNDING_DEG, is_straight

TEXT: Final = (
    "@p@_angles(outputs_v, temperature_degc, pitch_deg, roll_deg) returns 0 where all is well, -1 where there are "
    "no angles, else the sum of @P@_ROLL_UNDETERMINED (near the vertical; roll is NAN), @P@_OUTPUTS_DISAGREE "
    "(what the three sense is longer or shorter than gravity by more than calibration and readings explain: an output"
    " is wrong, and no one knows by this row which; do not use the angles) and @P@_OUTSIDE_VALIDITY (pitch, roll, "
    "or temperature where it is a number; NAN: not known). Before #include, define @P@_GRAVITY_AT_USE_MPS2 where "
    "gravity is another than that of the calibration, and @P@_REDUNDANCY_LIMIT, the largest | |f|^2 - 1 |, and "
    "@P@_LEAST_ACROSS, the least part of f across the longitudinal axis that tells roll, where single readings are"
    " less sharp than the dwells of the calibration, or the package is shaken."
)
_CODES: Final = {"roll_undetermined": 1, "outputs_disagree": 2, "outside_validity": 4}
ANGLES: Final = """
/* outputs_v in the order @order@; returns -1 where the force is zero or not finite, else the sum of the codes above. */
static inline int @p@_angles(const double outputs_v[3], double temperature_degc, double *pitch_deg, double *roll_deg)
{
    const double degree = 0.017453292519943295;
    const double gravity = @P@_GRAVITY_AT_USE_MPS2 / @P@_GRAVITY_MPS2;
    double f[3] = {0.0, 0.0, 0.0}, sensed[3] = {0.0, 0.0, 0.0}, inverse[3][3], square = 0.0, across, moved = 1.0;
    int step, i, is_settled = 0, told = 0;
    @p@_inverse(inverse);
    for (step = 0; step < @steps@ && moved > 1e-14; step++) { /* @how@ */
        const double left[3] = {
            @left@
        };
        for (i = 0, moved = 0.0; i < 3; i++) {
            const double before = sensed[i];
            sensed[i] = f[i] + inverse[i][0] * left[0] + inverse[i][1] * left[1] + inverse[i][2] * left[2];
            moved += fabs(sensed[i] - before);
        }
        square = sensed[0] * sensed[0] + sensed[1] * sensed[1] + sensed[2] * sensed[2];
        if (!(square > 0.0) || !isfinite(square)) {
            return -1;
        }
        is_settled = @p@_fitted(sensed, gravity, temperature_degc, inverse, f);
    }
    across = sqrt(f[1] * f[1] + f[2] * f[2]);
    *pitch_deg = atan2(f[0], across) / degree;
    *roll_deg = atan2(-f[1], -f[2]) / degree;
    if (!is_settled || !(fabs(square / (gravity * gravity) - 1.0) <= @P@_REDUNDANCY_LIMIT)) {
        told |= @P@_OUTPUTS_DISAGREE;
    }
    if (@outside@) {
        told |= @P@_OUTSIDE_VALIDITY;
    }
    if (!(across >= @P@_LEAST_ACROSS * gravity)) {
        *roll_deg = NAN;
        told |= @P@_ROLL_UNDETERMINED;
    }
    return told;
}
"""
_STRAIGHT: Final = "once: the axes are straight"
_BENT: Final = "what is left of the outputs at f; the bend is small"
_DIGITS: Final = 2


def angle_macros(coefficients: CoefficientSet, prefix: str) -> list[str]:
    """Return the codes that the function returns, and the bounds that a program may define itself."""
    bounds = package_bounds(coefficients)
    bounded: dict[str, float | str] = {
        "gravity_at_use_mps2": f"{prefix}_gravity_mps2".upper(),
        "redundancy_limit": _rounded_up(bounds.length),
        "least_across": _rounded_up(bounds.across),
    }
    return [
        *(defined(f"{prefix}_{name}", code) for name, code in _CODES.items()),
        *(line for name, value in bounded.items() for line in defined_unless(f"{prefix}_{name}", value)),
    ]


def angle_function(coefficients: CoefficientSet) -> list[str]:
    """Return the function and what it takes, the prefix of their names left to fill in."""
    axes = list(coefficients.axes.values())
    is_linear = is_straight(coefficients.axes)
    left = [
        f"(outputs_v[{i}] - @p@_{n.axis}_@u@(f, temperature_degc)) / @p@_{n.axis}_gain(temperature_degc)"
        for i, n in enumerate(axes)
    ]
    words = {
        "order": ", ".join(coefficients.axes),
        "left": ",\n            ".join(left),
        "steps": "1" if is_linear else str(INVERSE_STEPS),
        "how": _STRAIGHT if is_linear else _BENT,
        "outside": "\n        || ".join(_outside(coefficients)),
    }
    return [*weighing_functions(coefficients), "", *filled(ANGLES, words)]


def _outside(coefficients: CoefficientSet) -> list[str]:
    """Return in C what makes a row one outside the validity."""
    low, high = "@P@_{0}_MIN_{1}", "@P@_{0}_MAX_{1}"
    pitch, roll, degc = ("PITCH", "DEG"), ("ROLL", "DEG"), ("TEMPERATURE", "DEGC")
    found = [
        f"*pitch_deg < {low.format(*pitch)} - {ROUNDING_DEG}",
        f"*pitch_deg > {high.format(*pitch)} + {ROUNDING_DEG}",
    ]
    if not coefficients.validity.goes_round:
        span = f"{high.format(*roll)} - {low.format(*roll)}"
        turned = f"*roll_deg - {low.format(*roll)} + {ROUNDING_DEG}"
        found.append(f"{turned} - 360.0 * floor(({turned}) / 360.0) > {span} + 2.0 * {ROUNDING_DEG}")
    if coefficients.validity.temperature_degc is not None:
        found += [f"temperature_degc < {low.format(*degc)}", f"temperature_degc > {high.format(*degc)}"]
    return found


def _rounded_up(value: float) -> float:
    """Return a bound to two digits, so that it is the same whatever computed the set's covariance."""
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - _DIGITS)
    return float(f"{math.ceil(value / unit) * unit:.{_DIGITS - 1}e}")
