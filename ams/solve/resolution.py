"""What a meter's step does to an estimate where it is large beside the noise: told from the readings themselves.

Rounded to steps of q, readings are wrong by up to q/2. Noise well above q makes that one more noise. Below, all
replications of a point are wrong alike, and so is every point that reads on the same step: the mean of the error over
noise of σ is a sum of sines, of variance Σ (q/πk)²/2 · exp(−4π²k²σ²/q²), q²/12 without noise and nothing from σ = q/2
on. What a step does to one point alone is that point's lack of fit; what points share that read on one step is here,
and what a lack of fit tells too little of: of few points, or of one replication.
Source: Widrow and Kollár, Quantization Noise, 2008, 4 and 17; GUM F.2.2.1.

The step is the largest of which nine readings in ten are whole multiples apart. Few readings show it as the last
decimal that any of them has, or as a larger one that they have in common by more than chance.
"""

from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, column_blocks
from ams.inputs.common_step import GRID, common_step
from ams.solve.components import ComponentColumns
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.mixed_model import MixedEstimates

NAME: Final = "resolution"
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
_WAVES: Final = np.arange(1, 20)
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
_TOO_ALIKE: Final = 1.0 / 3.0
"""Of what steps leave of points that are wrong each by itself: with less they are wrong alike, as a model could be."""


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


def step_of(readings: FloatArray) -> float | None:
    """Return the step of (N,) readings; None where none shows."""
    ordered = np.sort(readings)
    apart = ordered[1:] - ordered[:-1]
    is_other = apart > _SAME * float(ordered[-1] - ordered[0])
    values = np.append(ordered[0], ordered[1:][is_other])
    repeated, others = readings.size - values.size, values.size - 1
    if repeated >= _LEAST_REPEATED * readings.size and others >= _LEAST_VALUES:
        return _of_many(values - values[0])
    return _of_few(values) if readings.size <= _FEW_READINGS and others > 0 else None


def _of_many(values: FloatArray) -> float | None:
    gaps = np.sort(np.diff(values))
    for parts in range(1, _PARTS + 1):
        step = _by_whole(_refined(float(gaps[0]) / parts, gaps), values)
        if _is_whole(values / step).mean() >= _MOST_WHOLE:
            return step
    return None


def _of_few(values: FloatArray) -> float | None:
    """Return the step of different values in their order.

    That gaps have a step in common by chance is the less probable the more there are: each but one is a multiple of it
    by (least/step), or, where no decimal is the last, by the part of a step that counts as none. Gaps that are alike
    may be so by design, and so may be a few large steps.
    """
    span = float(values[-1] - values[0])
    decimal = _last_decimal(values, span)
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
        if (np.abs(counts - np.rint(counts)) < _WHOLE_DECIMAL).all():
            return 10.0**power
    return None


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


def shared_variance(step: float, scatter_variance: float) -> float:
    """Return what all replications of a point have in common, by the variance in which rounded ones scatter.

    That is σ² and what the rounding adds, q²/12 less the common part: it grows with σ, and is halved until it is met.
    """
    low, high = 0.0, scatter_variance
    for _ in range(40):
        middle = 0.5 * (low + high)
        if middle + step**2 / 12.0 - _common(step, middle) < scatter_variance:
            low = middle
        else:
            high = middle
    return _common(step, low)


def _common(step: float, noise_variance: float) -> float:
    waves = (step / (np.pi * _WAVES)) ** 2 / 2.0
    smoothed = np.exp(-4.0 * (np.pi * _WAVES / step) ** 2 * noise_variance)
    # The sum ends early: what is left of q²/12 is smoothed at least as the last wave is.
    return float(waves @ smoothed + (step**2 / 12.0 - waves.sum()) * smoothed[-1])


def resolution(mixed: MixedEstimates, form: LinearForm, layout: Layout, outputs: FloatArray) -> ComponentColumns | None:
    """Return the component of (N, m) outputs; None where no output shows a step that noise does not smooth."""
    steps = steps_of(outputs)
    if not any(steps):
        return None
    size = mixed.estimator.shape[-2]
    covariance = np.zeros((outputs.shape[1], size, size))
    for index, step in enumerate(steps):
        if step is not None:
            left = outputs[:, index] - form.basis @ mixed.estimate[index]
            estimator = mixed.estimator if mixed.estimator.ndim == 2 else mixed.estimator[index]
            beyond = float(mixed.lack_of_fit_variance[index])
            covariance[index] = _of_steps(estimator, layout, outputs[:, index], left, step, beyond)
    return ComponentColumns(NAME, covariance, np.full(outputs.shape[1], np.inf)) if covariance.any() else None


def _of_steps(
    estimator: FloatArray, layout: Layout, readings: FloatArray, left: FloatArray, step: float, beyond: float
) -> FloatArray:
    """Return the (P, P) covariance of one output with what its model ``left``, (N,), and its lack of fit ``beyond``."""
    means, left_of_points = layout.mean_by_point(readings), layout.mean_by_point(left)
    free = layout.rows - layout.points
    if free > 0:
        about = readings - means[layout.point]
        shared = of_point = shared_variance(step, float(about @ about) / free)
    else:
        # One reading a point: what scatters is noise and step, and is counted already.
        beyond = float(left @ left) / max(layout.rows - len(estimator), 1)
        shared, of_point = shared_variance(step, beyond), step**2 / 12.0
    of_point = max(_with_what_is_hidden(of_point, left_of_points, len(estimator)) - beyond, 0.0)
    _, on_step, points = np.unique(np.rint((means - readings.min()) / step), return_inverse=True, return_counts=True)
    effects = np.zeros((points.size, len(estimator)))
    np.add.at(effects, on_step[layout.point], estimator.T)
    effects *= np.sqrt(np.where(points > 1, shared, of_point))[:, None]
    return np.asarray(effects.T @ effects)


def _with_what_is_hidden(variance: float, left: FloatArray, size: int) -> float:
    """Return the variance of a point's error along a model of ``size`` parameters that ``left`` (K,) means of points.

    Where hardly anything is left of the errors they are what the model can follow, all of them.
    """
    square = float(left @ left)
    if square > _TOO_ALIKE * (left.size - size) * variance:
        return variance
    return max(variance, (left.size * variance - square) / size)
