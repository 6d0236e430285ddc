"""What the single samples of a channel tell that the means of its dwells hide: the step they came in, their noise."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.inputs.step_of_readings import step_of
from ams.observations import Sampled

_ENOUGH: Final = 10_000
"""Samples tell a step, so many of every dwell."""


def sampled_of(samples: Sequence[FloatArray], point: IntArray, count: float | None = None) -> Sampled:
    """Return what the samples of N dwells, finite ones, show; ``point``: (N,) label of the design point.

    ``count``: what one count of their device is declared to be, in their unit; None where it is not known.
    """
    each = max(_ENOUGH // len(samples), 2)
    step = step_of(np.concatenate([of_dwell[:each] for of_dwell in samples]), count)
    points = np.unique(point).size
    if step is None:
        return Sampled(None, 0.0, points)
    sizes = np.array([of_dwell.size for of_dwell in samples])
    starts = np.cumsum(sizes) - sizes
    joined = np.concatenate(samples)
    about = joined - np.repeat(np.add.reduceat(joined, starts) / sizes, sizes)
    within = np.add.reduceat(about**2, starts) / sizes
    return Sampled(step, float(within.mean()), points)
