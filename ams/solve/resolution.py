"""What a meter's step does to an estimate where it is large beside the noise: told from the readings themselves.

Rounded to steps of q, readings are wrong by up to q/2. Noise well above q makes that one more noise. Below, all
replications of a point are wrong alike, and so is every point that reads on the same step: the mean of the error over
noise of σ is a sum of sines, of variance Σ (q/πk)²/2 · exp(−4π²k²σ²/q²), q²/12 without noise and nothing from σ = q/2
on. What a step does to one point alone is that point's lack of fit; what points share that read on one step is here.
Source: Widrow and Kollár, Quantization Noise, 2008, 4 and 17; GUM F.2.2.1.

The step is the largest of which nine readings in ten are whole multiples apart.
"""

from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, column_blocks
from ams.solve.components import ComponentColumns
from ams.solve.layout import Layout

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


def steps_of(outputs: FloatArray) -> list[float | None]:
    """Return the steps of the readings of each of (N, m) outputs; None where none shows."""
    found: list[float | None] = [None] * outputs.shape[1]
    for block in column_blocks(outputs.shape[1]):
        columns = np.array(outputs[:, block].T, order="C")
        for index in np.flatnonzero(_may_repeat(columns)).tolist():
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
    span = float(ordered[-1] - ordered[0])
    is_other = apart > _SAME * span
    if np.count_nonzero(~is_other) < _LEAST_REPEATED * readings.size:
        return None
    if np.count_nonzero(is_other) < _LEAST_VALUES:
        return None
    values = np.append(ordered[0], ordered[1:][is_other]) - ordered[0]
    gaps = np.sort(np.diff(values))
    for parts in range(1, _PARTS + 1):
        step = _by_whole(_refined(float(gaps[0]) / parts, gaps), values)
        if _is_whole(values / step).mean() >= _MOST_WHOLE:
            return step
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
    return float(waves @ np.exp(-4.0 * (np.pi * _WAVES / step) ** 2 * noise_variance))


def resolution(estimator: FloatArray, layout: Layout, outputs: FloatArray) -> ComponentColumns | None:
    """Return the component of (N, m) outputs with a (P, N) or (m, P, N) estimator; None where no output shows a step.

    Without replications nothing tells noise from steps.
    """
    if layout.replications < 2:
        return None
    steps = steps_of(outputs)
    if not any(steps):
        return None
    sizes = (outputs.shape[1], *estimator.shape[-2:-1] * 2)
    covariance = np.zeros(sizes)
    for index, step in enumerate(steps):
        if step is not None:
            weighted = estimator if estimator.ndim == 2 else estimator[index]
            covariance[index] = _of_steps(weighted, layout, outputs[:, index], step)
    return ComponentColumns(NAME, covariance, np.full(outputs.shape[1], np.inf)) if covariance.any() else None


def _of_steps(estimator: FloatArray, layout: Layout, readings: FloatArray, step: float) -> FloatArray:
    means = np.bincount(layout.point, readings, layout.points) / layout.readings
    left = readings - means[layout.point]
    free = layout.rows - layout.points
    if free < 1:
        return np.zeros((len(estimator), len(estimator)))
    variance = shared_variance(step, float(left @ left) / free)
    _, on_step, points = np.unique(np.rint((means - readings.min()) / step), return_inverse=True, return_counts=True)
    effects = np.zeros((points.size, len(estimator)))
    np.add.at(effects, on_step[layout.point], estimator.T)
    effects = effects[points > 1]
    return np.asarray(variance * effects.T @ effects)
