"""Low-pass filtering of sampled outputs before they are averaged.

A Chebyshev filter of type I: equal ripple in the pass band, then steeper than any other filter of its order without
zeros. CR filters each vector of samples so (V-B, figure 17), static tunnel use wants 0.3 to 0.6 Hz (TP 1). The mean of
a settled signal passes unchanged. The filter runs forwards only, so slow changes come late by the group delay, which is
known and taken off the time; an all-pass behind the filter makes it whole samples, since half a sample of a package
that turns is an angle.
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


class LowPassStream:
    """The filter over a stream of (n, …) samples: chunks of any length give what the whole would have given.

    It starts as if the first sample had always been there, so a settled signal gives no transient. The gain at zero
    frequency is exactly one for every order (an even order's ripple is taken out). Answers come ``delay_s`` late. A
    sample that is not a number is filtered as the last good one.
    """

    def __init__(self, settings: LowPass) -> None:
        self._sections = _sections(settings)
        self._state: Any = None
        self._last: FloatArray | None = None

    def feed(self, samples: FloatArray) -> FloatArray:
        """Return the filtered samples; NaN before the first good one."""
        from scipy.signal import sosfilt

        values = np.array(samples, dtype=float)
        if not values.shape[0]:
            return values
        whole = np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
        good = np.flatnonzero(whole)
        before = 0
        if self._last is None:
            if not good.size:
                return np.full_like(values, np.nan)
            before = int(good[0])
            self._state = _settled_state(self._sections, values[before])
            self._last = values[before]
        last = np.concatenate([self._last[None], values])
        source = np.maximum.accumulate(np.where(whole, np.arange(1, len(values) + 1), 0))
        held = last[source]
        self._last = held[-1]
        found = np.full_like(values, np.nan)
        found[before:], self._state = sosfilt(self._sections, held[before:], axis=0, zi=self._state)
        return found


def delay_s(settings: LowPass) -> float:
    """Return by how much a forward filter is late for slow changes: whole samples, by the all-pass behind it."""
    return _delay_samples(_sections(settings)) / settings.sample_rate_hz


def settling_samples(settings: LowPass, left: float = 1e-3) -> int:
    """Return after how many samples a step has come within ``left`` of its end for good."""
    from scipy.signal import sosfilt

    sections = _sections(settings)
    slowest = max(float(np.max(np.abs(np.roots(section[3:])))) for section in sections)
    count = int(np.ceil(3.0 * np.log(left / 10.0) / np.log(slowest))) + 2
    off = np.abs(sosfilt(sections, np.ones(count)) - 1.0) > left
    return int(np.flatnonzero(off)[-1]) + 1 if off.any() else 0


def _sections(settings: LowPass) -> Any:
    from scipy.signal import cheby1

    sections = np.array(
        cheby1(settings.order, settings.ripple_db, settings.cutoff_hz, fs=settings.sample_rate_hz, output="sos")
    )
    at_rest = np.prod(sections[:, :3].sum(axis=1) / sections[:, 3:].sum(axis=1))
    sections[0, :3] /= at_rest
    return np.vstack([sections, _all_pass(_delay_samples(sections))])


def _all_pass(delay_samples: float) -> FloatArray:
    """Return a section of Thiran's all-pass that makes a delay whole: it adds half a sample to one and a half."""
    added = np.ceil(delay_samples + 0.5) - delay_samples
    pole = (1.0 - added) / (1.0 + added)
    return np.array([pole, 1.0, 0.0, 1.0, pole, 0.0])


def _delay_samples(sections: FloatArray) -> float:
    """Return the group delay at zero frequency."""
    delay = 0.0
    for b_0, b_1, b_2, _, a_1, a_2 in sections.tolist():
        delay += (b_1 + 2.0 * b_2) / (b_0 + b_1 + b_2) - (a_1 + 2.0 * a_2) / (1.0 + a_1 + a_2)
    return float(delay)


def _settled_state(sections: Any, first: FloatArray) -> Any:
    from scipy.signal import sosfilt_zi

    state = sosfilt_zi(sections)
    return state * first if np.ndim(first) == 0 else state[:, :, None] * np.asarray(first)
