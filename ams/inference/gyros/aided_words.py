"""What a filter of gyros and gravity says when its rows are over: of its innovations, of the zeros that it found."""

from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.attitude_filter import mean_band
from ams.attitude.kalman import Estimate

SURELY: Final = 4.0
"""Standard deviations by which a zero is told as lying outside what was stated of it."""


_LASTING: Final = {
    "--force-sd-g": "an offset or a steady acceleration, does not scatter, so that alone is no reason for a narrower "
    "one; nor is it in the deviations but as the set of the accelerometers counts it",
    "--field-sd-ut": "iron of the package or a declination, does not scatter, so that alone is no reason for a "
    "narrower one, which is in the deviations whole, as an error of all rows",
}
"""By option, what of the measurement no innovation shows, and where it is counted."""


def mean_in_words(what: str, innovations: FloatArray, option: str) -> str:
    """Return what the (2,) sum and number of normalised innovations say of the stated deviation."""
    total, count = innovations
    low, high = mean_band(3, int(count))
    mean = total / count
    if mean > high:
        verdict = f"more than assumed: {what} and estimate differ by more than {option} and the stated zeros explain"
    elif mean < low:
        verdict = (
            f"less than assumed: the rows scatter less than {option} has it; what is wrong in all rows alike, "
            f"{_LASTING[option]}"
        )
    else:
        verdict = "as assumed"
    return (
        f"mean normalised innovation of the {what} {mean:.3g} over {int(count)} rows, 3 expected, within "
        f"{low:.3g} to {high:.3g} in 99.9 %: {verdict}"
    )


def zeros_in_words(estimate: Estimate, prior_sd_rad_s: FloatArray, *, after_rest: bool) -> str:
    """Return how far the zeros at the end lie from those of the start, (3,) ``prior_sd_rad_s`` what was stated."""
    zeros, sds = np.rad2deg(estimate.bias_rad_s), np.rad2deg(np.sqrt(np.diag(estimate.covariance)[3:]))
    by_axis = ", ".join(f"{axis} {zero:+.2g} ({sd:.1g})" for axis, zero, sd in zip("xyz", zeros, sds, strict=True))
    origin = "the rest" if after_rest else "the calibration"
    said = f"zeros of the gyros at the end lie {by_axis} °/s (standard deviation) from those of {origin}"
    limit = SURELY * np.rad2deg(prior_sd_rad_s)
    beyond = [axis for axis, zero, of_axis in zip("xyz", zeros, limit, strict=True) if abs(zero) > of_axis]
    if not beyond:
        return said
    return (
        f"{said}: of {', '.join(beyond)} more than was stated; the rows before it was found lean on the stated zero: "
        "state a wider one (--zero-sd-dps), or begin with a rest (--rest-s)"
    )
