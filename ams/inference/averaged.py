"""Readings averaged over windows before they become angles: one answer a window, for a package that stands still."""

from collections.abc import Mapping

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.inference.angle_stream import CARRIED_CODES, AngleStream, Answer, joined
from ams.inference.sample_clock import SampleClock


class AveragedAngles:
    """An :class:`ams.inference.angle_stream.AngleStream` before another one; windows follow one another.

    A reading that is not a number is left out of its window; a window without any is answered as missing. The last
    window has what is left. The answer gains the time of the windows' middles, where times were read.
    """

    def __init__(self, inner: AngleStream, window_s: float, rate_hz: float | None) -> None:
        if not inner.answers_at_once:
            raise OutsideValidity(
                "averages: belong to accelerometers at rest: angles of gyros are integrated from every sample; nothing "
                "was computed; leave the average out"
            )
        if not window_s > 0.0:
            raise OutsideValidity(f"averages: got a window of {window_s:g} s, allowed above 0 s; nothing was computed")
        self.inner, self.window_s = inner, window_s
        self._clock = SampleClock(rate_hz)
        self._kept: dict[str, FloatArray] = {}

    @property
    def needed(self) -> tuple[str, ...]:
        return self.inner.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*self.inner.optional, "time_s", CARRIED_CODES)))

    @property
    def answers(self) -> tuple[str, ...]:
        return ("time_s", *self.inner.answers)

    @property
    def answers_at_once(self) -> bool:
        return False

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of the windows that further rows fill. Raises: OutsideValidity without a sampling rate."""
        rows = next(iter(readings.values())).size
        if rows:
            self._clock.steps(readings.get("time_s"), rows)
        kept = {
            name: np.concatenate([self._kept.get(name, np.empty(0)), samples]) for name, samples in readings.items()
        }
        window = self._window() if rows else 1
        whole = next(iter(kept.values())).size // window if rows else 0
        self._kept = {name: values[whole * window :] for name, values in kept.items()}
        return self._means({name: values[: whole * window].reshape(whole, window) for name, values in kept.items()})

    def finish(self) -> Answer:
        """Return the last window, which has what is left."""
        left = {name: values[None, :] for name, values in self._kept.items() if values.size}
        due = self._means(left) if left else None
        self._kept = {}
        last = self.inner.finish()
        timed = Answer({"time_s": np.empty(0), **last.columns}, last.codes, last.reasons)
        return timed if due is None else joined(due, timed)

    def _window(self) -> int:
        assert self._clock.interval_s is not None
        return max(round(self.window_s / self._clock.interval_s), 1)

    def _means(self, windows: Mapping[str, FloatArray]) -> Answer:
        """Average (M, W) samples and answer them."""
        means = {name: _mean(values) for name, values in windows.items() if name != CARRIED_CODES}
        found = self.inner.answer(means)
        time_s = means.get("time_s", np.full(found.codes.size, np.nan))
        codes = found.codes
        if CARRIED_CODES in windows:
            # Of a window is true what is true of any sample in it.
            codes = codes | np.bitwise_or.reduce(windows[CARRIED_CODES].astype(np.uint64), axis=1)
        return Answer({"time_s": time_s, **found.columns}, codes, found.reasons)


def _mean(values: FloatArray) -> FloatArray:
    there = np.isfinite(values)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(there, values, 0.0).sum(axis=1) / there.sum(axis=1))
