"""What is said of outputs that follow a temperature, and of how they follow the chamber's."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from ams.analysis.diagnostics.beliefs import (
    AXIS_OVER_TEMPERATURE,
    BY_POINT,
    BY_POINT_GAIN,
    BY_REPLICATION,
    CURVATURE,
    LAG,
    TERMS_OVER_TEMPERATURE,
    BeliefTest,
)
from ams.analysis.diagnostics.low_order import SYMBOLS
from ams.analysis.diagnostics.size_words import AxisWords
from ams.analysis.diagnostics.words.term_words import change_words
from ams.findings import Said


def _follows(where: str, test: BeliefTest, words: AxisWords) -> Said:
    others = ", or ".join(SYMBOLS.get(name, name) for name in test.fit_as_well)
    as_well = f"; {others} fits these points as well" if others else ""
    return Said(
        f"the output follows the recorded temperature by {words.scale.words(abs(test.size))} a °C, {where}, and no "
        f"temperature is modelled: offset and sensitivities hold part of it{as_well}",
        "apply known temperature coefficients, or hold the temperature",
    )


def _lag(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        "lag against the chamber: the sensor is not as warm as the record: after heating and after cooling its output "
        f"is still on the way, by {words.scale.words(test.size)} (root mean square), as with a time constant of about "
        f"{test.uncertainty:g} h; temperature coefficients are not to be trusted",
        "soak longer, or measure the temperature in the sensor",
    )


def _curvature(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        f"quadratic in temperature: offset or sensitivity bend by {words.scale.words(test.size)} (root mean square), "
        "which a straight line over temperature does not have; the result holds near the temperatures measured",
        "solve with terms of second order ([solve] temperature_order = 2)",
    )


def _terms(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        "terms of second or third order change with temperature: "
        f"{', '.join(change_words(change, words.scale) for change in test.changes)}; {words.scale.words(test.size)} "
        "over the temperatures measured (root mean square), which no term of the result has: away from their mean "
        "predictions and attitudes are off by more than is stated",
        "calibrate at the temperature of use",
    )


def _turns(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        f"the sensitive axis turns with temperature, by {words.scale.within(test.size, 2.0 * test.uncertainty)} a °C: "
        "offset and sensitivity are modelled over temperature, its direction is not; away from the mean of the "
        "temperatures measured predictions and attitudes are off by more than is stated",
        "calibrate at the temperature of use",
    )


WORDS: Final[Mapping[str, Callable[[BeliefTest, AxisWords], Said]]] = {
    BY_POINT: partial(_follows, "in step with the points, alike in every replication"),
    BY_POINT_GAIN: partial(_follows, "with its sensitivity, alike in every replication"),
    BY_REPLICATION: partial(_follows, "from replication to replication"),
    LAG: _lag,
    CURVATURE: _curvature,
    TERMS_OVER_TEMPERATURE: _terms,
    AXIS_OVER_TEMPERATURE: _turns,
}
