"""Low-pass filtering of sampled outputs before they are averaged.

A Chebyshev filter of type I: equal ripple in the pass band, then steeper than any other filter of its order without
zeros. CR filters each vector of samples so (V-B, figure 17), static tunnel use wants 0.3 to 0.6 Hz (TP 1). Forwards and
backwards it has no delay and twice the attenuation; the mean of a settled signal passes unchanged in both.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError


@dataclass(frozen=True)
class LowPass:
    """Settings of the filter."""

    cutoff_hz: float
    """Where the pass band ends: the gain is −ripple_db there."""
    sample_rate_hz: float
    order: int = 4
    ripple_db: float = 0.1
    is_two_way: bool = True
    """Forwards and backwards (no delay, for stored samples) or forwards only (for a live stream)."""

    def __post_init__(self) -> None:
        if not 0.0 < self.cutoff_hz < self.sample_rate_hz / 2.0:
            raise ObservationsError(
                f"filter: got a cut-off of {self.cutoff_hz:g} Hz, allowed above 0 and below {self.sample_rate_hz / 2:g}"
                " Hz, half the sample rate; nothing was filtered"
            )
        if not (1 <= self.order <= 12 and self.ripple_db > 0.0):
            raise ObservationsError(
                f"filter: got order {self.order} and ripple {self.ripple_db:g} dB, allowed order 1 to 12 and ripple "
                "above 0 dB; nothing was filtered"
            )


def low_pass(settings: LowPass, samples: FloatArray) -> FloatArray:
    """Filtered samples of the same shape, filtered along the first axis.

    A forward filter starts as if the first sample had always been there, so a settled signal gives no transient. The
    gain at zero frequency is exactly one for every order (an even order's ripple is taken out).
    Raises: ObservationsError where there are too few samples for a two-way filter, or one is not finite.
    """
    from scipy.signal import sosfilt, sosfiltfilt

    values = np.asarray(samples, dtype=float)
    if not np.all(np.isfinite(values)):
        raise ObservationsError("filter: a sample is not finite; it would spread over all that follow; drop it first")
    sections = _sections(settings)
    if not settings.is_two_way:
        start = _settled_state(sections, values[0])
        return np.asarray(sosfilt(sections, values, axis=0, zi=start)[0])
    padding = min(values.shape[0] - 1, int(np.ceil(3.0 * settings.sample_rate_hz / settings.cutoff_hz)))
    if values.shape[0] < 3 * settings.order:
        raise ObservationsError(
            f"filter: got {values.shape[0]} samples, a two-way filter of order {settings.order} needs "
            f"{3 * settings.order} or more"
        )
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=padding))


def gain(settings: LowPass, frequency_hz: FloatArray) -> FloatArray:
    """Amplitude gain at the frequencies, as :func:`low_pass` applies it."""
    from scipy.signal import sosfreqz

    _, response = sosfreqz(_sections(settings), worN=np.asarray(frequency_hz, dtype=float), fs=settings.sample_rate_hz)
    once = np.abs(response)
    return np.asarray(once**2 if settings.is_two_way else once)


def _sections(settings: LowPass) -> Any:
    from scipy.signal import cheby1

    sections = np.array(
        cheby1(settings.order, settings.ripple_db, settings.cutoff_hz, fs=settings.sample_rate_hz, output="sos")
    )
    at_rest = np.prod(sections[:, :3].sum(axis=1) / sections[:, 3:].sum(axis=1))
    sections[0, :3] /= at_rest
    return sections


def _settled_state(sections: Any, first: FloatArray) -> Any:
    from scipy.signal import sosfilt_zi

    state = sosfilt_zi(sections)
    return state * first if np.ndim(first) == 0 else state[:, :, None] * np.asarray(first)
