"""What is said where one declared figure alone decides how little is known: a slip of it must not pass unread."""

from collections.abc import Iterator, Mapping
from typing import Final

from ams.analysis.calibration_budget import AxisBudget, BudgetLine
from ams.calibration_result import AxisCalibration
from ams.inputs.shared_errors import NONLINEARITY, SHIFTS
from ams.rounding import two_digits

LARGEST_SHARE: Final = 0.99
"""Of the variance: everything else together is a tenth of the limit."""
LEAST_PART: Final = 0.01
"""Of the sensitivity times 1 g: near level it is half a degree, which no accelerometer is calibrated for."""
OFFSET, SENSITIVITY = "offset_v", "sensitivity_v_per_g"
KEYS: Final[Mapping[str, str]] = {
    NONLINEARITY: "largest_nonlinearity_v",
    SHIFTS[0]: "largest_offset_shift_v",
    SHIFTS[1]: "largest_sensitivity_shift",
    "temperature of use, offset": "largest_offset_tc_v_per_degc",
    "temperature of use, sensitivity": "largest_sensitivity_tc_per_degc",
}
"""Source of a budget to the key of the sensor that states it; a certificate's line names its own."""


def dominating_limits(axes: Mapping[str, AxisCalibration], budgets: Mapping[str, AxisBudget]) -> Iterator[str]:
    """Yield a sentence for every declared figure that makes offset or sensitivity of accelerometers unknown alone."""
    said: dict[str, list[str]] = {}
    for label, budget in budgets.items():
        sensitivity = next((item.value for item in axes[label].parameters if item.name == SENSITIVITY), None)
        if not sensitivity:
            continue
        for name in (OFFSET, SENSITIVITY):
            expanded = budget.expanded_95[name]
            if not expanded >= LEAST_PART * abs(sensitivity):
                continue
            for line in budget.lines:
                share = (line.contributions[name] / budget.combined[name]) ** 2
                if line.type == "B" and line.stated and share > LARGEST_SHARE:
                    part = f"{label} ±{two_digits(100.0 * expanded / abs(sensitivity))} % of 1 g"
                    said.setdefault(_in_words(line, name), []).append(part)
    for words, parts in said.items():
        yield f"{words}: {', '.join(parts)} (95 %); correct the figure, or take angles to be known no better than that"


def _in_words(line: BudgetLine, name: str) -> str:
    what = "the offset" if name == OFFSET else "the sensitivity"
    figure = f"{KEYS[line.source]}: {line.stated}" if line.source in KEYS else line.stated
    return f"one declared figure is nearly all that is not known of {what}, {line.source} ({figure})"
