"""What is said of residuals that repeat, stand out, or show the table."""

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import LACK_OF_FIT, ROBUST, SQUARENESS, UNEVEN, WRONG_DWELL, BeliefTest
from ams.analysis.diagnostics.size_words import AxisWords, Scale
from ams.analysis.diagnostics.stated_limits import MOST_MOVED
from ams.analysis.diagnostics.uneven_noise import uneven_words
from ams.findings import Said
from ams.rounding import significant
from ams.units import ARCSEC_PER_DEG


def _lack_of_fit(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        f"the residuals repeat from replication to replication: lack of fit, {words.scale.words(test.size)} (standard "
        f"deviation over the {'levels' if words.is_of_levels else 'attitudes'})"
        f"{', more than the table’s index errors explain' if words.has_table else ''}; {words.lack_is.fact}",
        words.lack_is.what_to_do,
    )


def _unsteady(_: BeliefTest, __: AxisWords) -> Said:
    return Said(
        "more than a tenth of the dwells stand out from their replications: this is no matter of single dwells but of "
        "an unsteady sensor, channel or supply",
        "look at the noise of the channel before the result is used",
    )


def _robust(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        f"a robust fit, which gives little weight to dwells that stand out, is {robust_size(test, words.scale)} from "
        f"the estimate: dwells read too far to one side, each too little to be named, or the noise is longer to one "
        f"side; either moves the estimate, by up to some {MOST_MOVED:.0f} times this difference; that is "
        f"{'' if test.is_held else 'not '}in the stated uncertainty of the offset",
        "look at the residuals of the channel",
    )


def robust_size(test: BeliefTest, scale: Scale) -> str:
    """Return how far a robust fit is from the estimate, which is told where it is not significant as well."""
    return f"{scale.words(test.size)} in the mean over the attitudes (by chance ±{scale.words(test.uncertainty)})"


def _squareness(test: BeliefTest, _: AxisWords) -> Said:
    return Said(
        f"the axes of the table are not at right angles: {significant(np.rad2deg(abs(test.size)) * ARCSEC_PER_DEG)}″ ± "
        f"{significant(np.rad2deg(2.0 * test.uncertainty) * ARCSEC_PER_DEG)}″, which this output sees at high pitch; "
        "predictions hold part of it",
        "have the table looked at, or solve package and table together ([solve] joint = true with a prior of "
        "squareness)",
    )


WORDS: Final[Mapping[str, Callable[[BeliefTest, AxisWords], Said]]] = {
    LACK_OF_FIT: _lack_of_fit,
    WRONG_DWELL: _unsteady,
    ROBUST: _robust,
    UNEVEN: lambda test, _: uneven_words(test),
    SQUARENESS: _squareness,
}
