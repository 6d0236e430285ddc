"""The largest step of which all readings are whole multiples apart, however few of them repeat.

It tells the digits of a file as well as the step of a meter, and whoever calls it says what a step means beside the
scatter. Of many readings :mod:`ams.inputs.step_of_readings` asks that they repeat instead.
"""

from typing import Final

import numpy as np

from ams.arrays import FloatArray

GRID: Final = 1e-8
"""Of the span: the finest grid of readings that is looked for."""


def common_step(readings: FloatArray, least: float) -> float:
    """Return the largest step of which all readings are whole multiples apart, by Euclid; some ``least`` for none."""
    step = 0.0
    for gap in np.sort(np.diff(np.unique(readings))).tolist():
        apart = gap
        while apart > least:
            step, apart = apart, step % apart
            apart = min(apart, step - apart)
        # Each larger gap tells the step to more digits, so that its errors do not add up.
        step = gap / max(round(gap / step), 1) if step else step
    return step
