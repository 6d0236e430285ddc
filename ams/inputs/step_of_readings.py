"""The step that readings came in, told from the readings themselves.

The step is the largest of which nine readings in ten are whole multiples apart. Few readings, or many at few values,
show it as the last decimal that any of them has, or as a larger one that they have in common by more than chance.
"""

from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, column_blocks
from ams.inputs.common_step import GRID, common_step

_LEAST_REPEATED: Final = 0.05
"""Share of the readings that stand on the value of another: with less the noise is well above any step."""
_LEAST_VALUES: Final = 10
"""Different ones, of which a step is told."""
_SAME: Final = 1e-9
"""Of the span: what differs by less is one value."""
_WHOLE: Final = 0.02
"""Of a step: how near to a whole one a difference is that counts as one."""
_MOST_WHOLE: Final = 0.9
_PARTS: Final = 4
"""The smallest difference may be so many steps."""
_PARTS_OF_SPAN: Final = 2.0**31 - 1.0
"""As many as a whole number of 32 bits counts."""
_FEW_READINGS: Final = 200
"""Of which a step is told though hardly any repeat."""
_DECIMALS: Final = 7
"""Below the span: no meter whose step is seen over its noise has a finer one."""
_WHOLE_DECIMAL: Final = 1e-6
"""Of a decimal: how near to a whole one a reading is that was written with it."""
_BY_CHANCE: Final = 1e-3
"""Probability that readings have a larger step in common without being measured in it."""
_LEAST_PARTS: Final = 64
"""Of a span, of a step that no decimal shows: readings at a few levels are multiples of the distance between them."""


def steps_of(outputs: FloatArray) -> list[float | None]:
    """Return the steps of the readings of each of (N, m) outputs; None where none shows."""
    found: list[float | None] = [None] * outputs.shape[1]
    for block in column_blocks(outputs.shape[1]):
        columns = np.array(outputs[:, block].T, order="C")
        may = _may_repeat(columns) if len(outputs) > _FEW_READINGS else np.ones(len(columns), dtype=bool)
        for index in np.flatnonzero(may).tolist():
            found[block.start + index] = step_of(columns[index])
    return found


def _may_repeat(columns: FloatArray) -> BoolArray:
    """Return which of (m, N) columns may have readings enough on the value of another: none of the others does.

    Whole numbers of 2⁻³¹ of the span are sorted in half the time; values that count as one are at most three apart.
    """
    low = columns.min(axis=1, keepdims=True)
    span = columns.max(axis=1, keepdims=True) - low
    scaled = columns - low
    scaled *= _PARTS_OF_SPAN / np.where(span > 0.0, span, np.inf)
    parts = scaled.astype(np.int32)
    parts.sort(axis=1)
    alike = parts[:, 1:] - parts[:, :-1] <= int(_SAME * _PARTS_OF_SPAN + 1.0)
    return np.array([np.count_nonzero(row) >= _LEAST_REPEATED * columns.shape[1] for row in alike])


def step_of(readings: FloatArray, count: float | None = None) -> float | None:
    """Return the step of (N,) readings; None where none shows.

    ``count``: what one count of their device is declared to be; None where it is not known. A device that sends whole
    counts has no finer step, and readings that are not whole counts apart are taken as if nothing were declared.
    """
    ordered = np.sort(readings)
    apart = ordered[1:] - ordered[:-1]
    is_other = apart > _SAME * float(ordered[-1] - ordered[0])
    values = np.append(ordered[0], ordered[1:][is_other])
    repeated, others = readings.size - values.size, values.size - 1
    is_repeated = repeated >= _LEAST_REPEATED * readings.size
    if is_repeated and others >= _LEAST_VALUES:
        return _of_many(values - values[0])
    return _of_few(values, count) if others > 0 and (is_repeated or readings.size <= _FEW_READINGS) else None


def _of_many(values: FloatArray) -> float | None:
    gaps = np.sort(np.diff(values))
    for parts in range(1, _PARTS + 1):
        step = _by_whole(_refined(float(gaps[0]) / parts, gaps), values)
        if _is_whole(values / step).mean() >= _MOST_WHOLE:
            return step
    return None


def _of_few(values: FloatArray, count: float | None) -> float | None:
    """Return the step of different values in their order.

    That gaps have a step in common by chance is the less probable the more there are: each but one is a multiple of it
    by (least/step), or, where no decimal is the last, by the part of a step that counts as none. Gaps that are alike
    may be so by design, and so may be a few large steps.
    """
    span = float(values[-1] - values[0])
    are_counts = count is not None and _are_whole((values - values[0]) / count)
    decimal = count if are_counts else _last_decimal(values, span)
    least = GRID * span if decimal is None else 0.5 * decimal
    gaps = np.sort(np.diff(values))
    others = np.count_nonzero(np.diff(gaps) > least)
    step = common_step(values, least)
    parts = span / step
    if parts < _LEAST_PARTS:
        return decimal
    if decimal is None:
        return step if parts * (2.0 * GRID * parts) ** others < _BY_CHANCE else None
    return step if (decimal / step) ** others < _BY_CHANCE else decimal


def _last_decimal(values: FloatArray, span: float) -> float | None:
    """Return the largest power of ten of which all values are whole multiples."""
    largest = int(np.floor(np.log10(span)))
    for power in range(largest, largest - _DECIMALS - 1, -1):
        counts = values / 10.0**power
        if _are_whole(counts):
            return 10.0**power
    return None


def _are_whole(counts: FloatArray) -> bool:
    return bool((np.abs(counts - np.rint(counts)) < _WHOLE_DECIMAL).all())


def _refined(step: float, lengths: FloatArray) -> float:
    """Return the step by sorted lengths that grow, so that its digits do for the largest."""
    reach = 10.0
    while reach * step < 10.0 * float(lengths[-1]):
        step = _by_whole(step, lengths[lengths <= reach * step])
        reach *= 10.0
    return step


def _by_whole(step: float, lengths: FloatArray) -> float:
    """Return the step by which lengths are nearest to the whole numbers of it that they are."""
    counts = np.rint(lengths / step)
    square = float(counts @ counts)
    return float(counts @ lengths) / square if square else step


def _is_whole(counts: FloatArray) -> FloatArray:
    return np.asarray(np.abs(counts - np.rint(counts)) < _WHOLE)
