"""What a meter's step does to an estimate where it is large beside the noise.

Rounded to steps of q, readings are wrong by up to q/2. Noise well above q makes that one more noise. Below, all
replications of a point are wrong alike, and so is every point that reads on the same step: the mean of the error over
noise of σ is a sum of sines, of variance Σ (q/πk)²/2 · exp(−4π²k²σ²/q²), q²/12 without noise and nothing from σ = q/2
on. What a step does to one point alone is that point's lack of fit; what points share that read on one step is here,
and what a lack of fit tells too little of: of few points, or of one replication.
Of a mean of samples σ is that of single ones: about the mean of their dwell, and from replication to replication.
However many there are, they have that error in common.
Source: Widrow and Kollár, Quantization Noise, 2008, 4 and 17; GUM F.2.2.1.

The step is that of the samples where these are known, else of the readings (:mod:`ams.inputs.step_of_readings`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.inputs.step_of_readings import step_of, steps_of
from ams.observations import Sampled
from ams.solve.components import ComponentColumns
from ams.solve.expected import Belief
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.mixed_model import MixedEstimates

NAME: Final = "resolution"
_WAVES: Final = np.arange(1, 20)
_TOO_ALIKE: Final = 1.0 / 3.0
"""Of what steps leave of points that are wrong each by itself: with less they are wrong alike, as a model could be."""


def shared_variance(step: float, scatter_variance: float, points: int) -> float:
    """Return what all replications of a point have in common, by the variance in which rounded ones scatter.

    That is the mean over so many points, each at some place within a step: it may be larger than
    :func:`rounded_variance` of the noise by one standard error. It grows with the noise, and is halved until it is met.
    """
    low, high = 0.0, scatter_variance
    for _ in range(40):
        middle = 0.5 * (low + high)
        if rounded_variance(step, middle) + _standing_spread(step, middle) / points**0.5 < scatter_variance:
            low = middle
        else:
            high = middle
    return _common(step, low)


def repeated_by_steps(readings: FloatArray, layout: Layout) -> float:
    """Return the variance that the replications of a point have in common by the step of (N,) readings; 0: no step."""
    step, free = step_of(readings), layout.rows - layout.points
    if step is None or free < 1:
        return 0.0
    about = layout.about_points(readings)
    return shared_variance(step, float(about @ about) / free, layout.points)


def rounded_variance(step: float, noise_variance: float) -> float:
    """Return the variance in which rounded readings scatter: σ², and q²/12 less what they have in common."""
    return noise_variance + step**2 / 12.0 - _common(step, noise_variance)


def _standing_spread(step: float, noise_variance: float) -> float:
    """Return the standard deviation of that variance over the places within a step: of the first wave.

    Its cosine has the amplitude (q²/π² + 4σ²) exp(−2π²σ²/q²).
    """
    squares = step**2 / np.pi**2 + 4.0 * noise_variance
    return float(squares * np.exp(-2.0 * np.pi**2 * noise_variance / step**2) / np.sqrt(2.0))


def _common(step: float, noise_variance: float) -> float:
    waves = (step / (np.pi * _WAVES)) ** 2 / 2.0
    smoothed = np.exp(-4.0 * (np.pi * _WAVES / step) ** 2 * noise_variance)
    # The sum ends early: what is left of q²/12 is smoothed at least as the last wave is.
    return float(waves @ smoothed + (step**2 / 12.0 - waves.sum()) * smoothed[-1])


@dataclass(frozen=True, slots=True)
class _Steps:
    """What is known of one output."""

    size: float
    within: float
    """Variance of its samples within their dwells; 0 of single readings."""
    points: int
    """Over which the scatter is a mean."""

    def shared(self, scatter: float) -> float:
        """Return what readings have in common that scatter by such a variance from dwell to dwell."""
        return shared_variance(self.size, scatter + self.within, self.points)


def resolution(
    mixed: MixedEstimates, form: LinearForm, layout: Layout, outputs: FloatArray, sampled: Sequence[Sampled | None]
) -> ComponentColumns | None:
    """Return the component of (N, m) outputs; None where no output shows a step that noise does not smooth.

    ``sampled``: of every output, or none, as :class:`ams.solve.linearised.Linearised` has it.
    """
    stepped = _stepped(outputs, sampled, layout.points)
    if not stepped:
        return None
    size = mixed.estimator.shape[-2]
    covariance = np.zeros((outputs.shape[1], size, size))
    for index, samples in stepped.items():
        left = outputs[:, index] - form.basis @ mixed.estimate[index]
        estimator = mixed.estimator if mixed.estimator.ndim == 2 else mixed.estimator[index]
        beyond = float(mixed.lack_of_fit_variance[index])
        covariance[index] = _of_steps(estimator, layout, outputs[:, index], left, samples, beyond)
    return ComponentColumns(NAME, covariance, np.full(outputs.shape[1], np.inf)) if covariance.any() else None


def expected_resolution(
    mixed: MixedEstimates,
    layout: Layout,
    alone: LinearForm,
    outputs: FloatArray,
    beliefs: Sequence[Belief],
    names: Sequence[str],
) -> ComponentColumns | None:
    """Return what :func:`resolution` will tell on the average; None where no step is stated that noise leaves.

    ``outputs`` are without errors. ``names`` are those of the columns of ``alone``: their drift scatters rows as well.
    """
    size = mixed.estimator.shape[-2]
    covariance = np.zeros((outputs.shape[1], size, size))
    for index, belief in enumerate(beliefs):
        samples = belief.sampled
        if samples is not None and samples.step is not None:
            estimator = mixed.estimator if mixed.estimator.ndim == 2 else mixed.estimator[index]
            drift = np.array([belief.drift.get(name, 0.0) ** 2 for name in names])
            about = belief.precision**2 + float(np.mean(alone.basis**2 @ drift))
            shared = shared_variance(samples.step, about + samples.variance, samples.points)
            of_point = max(shared - belief.lack_of_fit**2, 0.0)
            covariance[index] = _along_steps(estimator, layout, outputs[:, index], samples.step, shared, of_point)
    return ComponentColumns(NAME, covariance, np.full(outputs.shape[1], np.inf)) if covariance.any() else None


def _stepped(outputs: FloatArray, sampled: Sequence[Sampled | None], points: int) -> dict[int, _Steps]:
    """Return what is known of the outputs that show a step."""
    known = {index: samples for index, samples in enumerate(sampled) if samples is not None}
    found = {
        index: _Steps(samples.step, samples.variance, samples.points)
        for index, samples in known.items()
        if samples.step is not None
    }
    if len(known) == outputs.shape[1]:
        return found
    steps = enumerate(steps_of(outputs))
    return found | {index: _Steps(step, 0.0, points) for index, step in steps if step and index not in known}


def _of_steps(
    estimator: FloatArray, layout: Layout, readings: FloatArray, left: FloatArray, steps: _Steps, beyond: float
) -> FloatArray:
    """Return the (P, P) covariance of one output with what its model ``left``, (N,), and its lack of fit ``beyond``."""
    means, left_of_points = layout.mean_by_point(readings), layout.mean_by_point(left)
    free = layout.rows - layout.points
    if free > 0:
        about = readings - means[layout.point]
        shared = of_point = steps.shared(float(about @ about) / free)
    else:
        # One reading a point: what scatters is noise and step, and is counted already.
        beyond = float(left @ left) / max(layout.rows - len(estimator), 1)
        shared, of_point = steps.shared(beyond), steps.shared(0.0)
    of_point = max(_with_what_is_hidden(of_point, left_of_points, len(estimator)) - beyond, 0.0)
    return _along_steps(estimator, layout, readings, steps.size, shared, of_point)


def _along_steps(
    estimator: FloatArray, layout: Layout, readings: FloatArray, step: float, shared: float, of_point: float
) -> FloatArray:
    """Return the (P, P) covariance: points that read on one step have ``shared`` of it, any other ``of_point``."""
    steps = np.rint((layout.mean_by_point(readings) - readings.min()) / step)
    _, on_step, points = np.unique(steps, return_inverse=True, return_counts=True)
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
