"""The zero of gyros from a rest: the mean of their outputs, and how well the rest itself says that nothing turned.

The rest is cut into ten stretches. Where it is one, their means scatter as the readings' noise does; where they scatter
by more, something turned or shook, and the zero is as uncertain as their scatter makes it.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray

STRETCHES: Final = 10
SIGNIFICANT: Final = 3.1
"""Of a variance of ten means over that of the noise: chi-square of 9 degrees of freedom goes beyond in 1 of 1000."""


@dataclass(frozen=True)
class ZeroAtRest:
    """What a rest told of three gyros."""

    mean_v: FloatArray
    """(3,) outputs."""
    covariance_v2: FloatArray
    """(3, 3) of their means."""
    scatter_v: FloatArray
    """(3,) standard deviation of the means of the stretches; 0 with too few readings for ten stretches of two."""
    is_still: bool
    """Whether noise explains their scatter."""


def zero_at_rest(outputs_v: FloatArray, reading_sd_v: FloatArray) -> ZeroAtRest:
    """Return the zero from (3, n) outputs, all of them numbers, with the noise of one reading of each."""
    readings = outputs_v.shape[1]
    by_noise = np.asarray(reading_sd_v, dtype=float) ** 2 / readings
    scatter = np.zeros(3)
    if readings >= 2 * STRETCHES:
        means = [part.mean(axis=1) for part in np.array_split(outputs_v, STRETCHES, axis=1)]
        scatter = np.asarray(np.std(means, axis=0, ddof=1))
    is_still = scatter**2 / STRETCHES <= SIGNIFICANT * by_noise
    variance = np.where(is_still, by_noise, scatter**2 / STRETCHES)
    return ZeroAtRest(outputs_v.mean(axis=1), np.diag(variance), scatter, bool(is_still.all()))
