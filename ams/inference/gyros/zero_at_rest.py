"""The zero of gyros from a rest: the mean of their outputs, and how well the rest itself says that nothing turned.

The rest is cut into ten stretches. Where it is one, their means scatter as the readings' noise does: as it is stated,
or as the readings scatter within the stretches where that is more (a set knows the noise of a dwell's mean, not that of
one reading). Where they scatter by more, something turned or shook: in which of them nothing did is not known, and the
zero is as uncertain as they lie apart.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.statistics.distributions import f_tail

STRETCHES: Final = 10
SIGNIFICANT: Final = 1e-3
"""Chance of so large a variance of ten means over that of the noise."""
_KNOWN: Final = 1e9
"""Degrees of freedom of a noise that is stated."""


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
    readings, apart = outputs_v.shape[1], np.zeros(3)
    noise_v2, scatter, dof = np.asarray(reading_sd_v, dtype=float) ** 2, np.zeros(3), np.full(3, _KNOWN)
    if readings >= 2 * STRETCHES:
        parts = np.array_split(outputs_v, STRETCHES, axis=1)
        means = np.array([part.mean(axis=1) for part in parts])
        scatter, apart = np.std(means, axis=0, ddof=1), np.ptp(means, axis=0)
        within_v2 = sum(part.var(axis=1) * part.shape[1] for part in parts) / (readings - STRETCHES)
        dof = np.where(within_v2 > noise_v2, readings - STRETCHES, _KNOWN)
        noise_v2 = np.maximum(within_v2, noise_v2)
    by_noise = noise_v2 / readings
    ratio = np.divide(scatter**2 / STRETCHES, by_noise, out=np.where(scatter > 0.0, np.inf, 0.0), where=by_noise > 0.0)
    is_still = f_tail(ratio, STRETCHES - 1.0, dof) > SIGNIFICANT
    variance = np.where(is_still, by_noise, apart**2 / 3.0)
    return ZeroAtRest(outputs_v.mean(axis=1), np.diag(variance), scatter, bool(is_still.all()))
