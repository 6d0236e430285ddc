"""Readings averaged over windows before they become angles: one answer a window, for a package that stands still.

All axes of a window are averaged over the same rows, those in which every reading is there: a moving package turns
between two rows. A window that lacks some is told by its flag; its time is that of what was averaged, and a standard
deviation that is stated for a whole window grows by the root of what share of it is left.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.attitude import flag_codes
from ams.errors import OutsideValidity
from ams.inference.rows.angle_stream import CARRIED_CODES, OF_STREAMS, SD_FACTOR, AngleStream, Answer, joined
from ams.inference.rows.sample_clock import SampleClock

_SAMPLE_NUMBER: Final = "number of the sample"


class AveragedAngles:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` before another one; windows follow one another.

    A row with a reading that is not a number is left out of its window; a window without any other row is answered as
    missing, at the time of its rows. Samples that never came, by ``time_s``, are missing from their window too; a
    window none of whose rows came has no answer. The last window has what is left. The answer gains the mean time of
    what was averaged, where times were read.
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
        self._rows = self._ahead = 0
        """Rows that came, and by how many samples the last one is further."""
        self._sample = -1

    @property
    def needed(self) -> tuple[str, ...]:
        return self.inner.needed

    @property
    def optional(self) -> tuple[str, ...]:
        passed = (name for name in self.inner.optional if name not in OF_STREAMS)
        return tuple(dict.fromkeys((*passed, "time_s", CARRIED_CODES)))

    @property
    def answers(self) -> tuple[str, ...]:
        return ("time_s", *self.inner.answers)

    @property
    def answers_at_once(self) -> bool:
        return False

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of the windows that further rows fill. Raises: OutsideValidity without a sampling rate."""
        rows = next(iter(readings.values())).size
        if not rows:
            return self._means({**readings, _SAMPLE_NUMBER: np.empty(0)})
        further = {
            **readings,
            _SAMPLE_NUMBER: self._sample_numbers(self._clock.steps(readings.get("time_s"), rows)).astype(float),
        }
        kept = {name: np.concatenate([self._kept.get(name, np.empty(0)), samples]) for name, samples in further.items()}
        # A window ends with its last sample, or with the first sample that is beyond it.
        running = (kept[_SAMPLE_NUMBER][-1] + 1.0) // self._window()
        ended = int(np.searchsorted(kept[_SAMPLE_NUMBER], running * self._window()))
        self._kept = {name: values[ended:] for name, values in kept.items()}
        return self._means({name: values[:ended] for name, values in kept.items()})

    def finish(self) -> Answer:
        """Return the last window, which has what is left."""
        is_due = bool(self._kept) and self._kept[_SAMPLE_NUMBER].size > 0
        due = self._means(self._kept, is_last=True) if is_due else None
        self._kept = {}
        last = self.inner.finish()
        timed = Answer({"time_s": np.empty(0), **last.columns}, last.codes, last.reasons)
        return timed if due is None else joined(due, timed)

    def _window(self) -> int:
        assert self._clock.interval_s is not None
        return max(round(self.window_s / self._clock.interval_s), 1)

    def _sample_numbers(self, steps: IntArray) -> IntArray:
        """Return the sample that each row is, from how many it is behind the one before.

        No two rows are the same sample: a row that is not after the one before, or has no time, is the next one.
        """
        samples, rows = self._sample + np.cumsum(steps), self._rows + np.arange(steps.size)
        ahead = np.maximum(np.maximum.accumulate(samples - rows), self._ahead)
        self._sample, self._rows, self._ahead = int(samples[-1]), self._rows + steps.size, int(ahead[-1])
        return np.asarray(rows + ahead, dtype=np.int64)

    def _means(self, rows: Mapping[str, FloatArray], *, is_last: bool = False) -> Answer:
        """Average the rows of whole windows, the last of which may be shorter, and answer the means."""
        sample_numbers = rows[_SAMPLE_NUMBER]
        windows = sample_numbers // self._window() if sample_numbers.size else sample_numbers
        starts = np.flatnonzero(np.diff(windows, prepend=-1.0))
        is_whole = np.logical_and.reduce([np.isfinite(rows[name]) for name in self.needed])
        left = _sums(is_whole.astype(float), starts)
        means = {
            name: _mean(values, np.isfinite(values) & is_whole, starts)
            for name, values in rows.items()
            if name not in (CARRIED_CODES, _SAMPLE_NUMBER)
        }
        if "time_s" in rows:
            of_all = _mean(rows["time_s"], np.isfinite(rows["time_s"]), starts)
            means["time_s"] = np.where(left > 0.0, means["time_s"], of_all)
        full = np.full(starts.size, float(self._window())) if starts.size else left
        samples = full.copy()
        if is_last:
            samples[-1] = sample_numbers[-1] % self._window() + 1.0
        if SD_FACTOR in self.inner.optional:
            means[SD_FACTOR] = np.sqrt(full / np.where(left > 0.0, left, full))
        found = self.inner.answer(means)
        codes = found.codes.astype(np.uint64)
        codes[(left > 0.0) & (left < samples)] |= np.uint64(flag_codes.WINDOW_SHORT)
        if CARRIED_CODES in rows and starts.size:
            # Of a window is true what is true of any sample in it.
            codes |= np.bitwise_or.reduceat(rows[CARRIED_CODES].astype(np.uint64), starts)
        time_s = means.get("time_s", np.full(codes.size, np.nan))
        reasons = {**found.reasons, **flag_codes.WINDOW_WORDS}
        return Answer({"time_s": time_s, **found.columns}, codes, reasons)


def _mean(values: FloatArray, is_taken: BoolArray, starts: IntArray) -> FloatArray:
    """Return the mean of those (n,) values that are taken, by the rows that windows start at; NaN of none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return _sums(np.where(is_taken, values, 0.0), starts) / _sums(is_taken.astype(float), starts)


def _sums(values: FloatArray, starts: IntArray) -> FloatArray:
    return np.add.reduceat(values, starts) if starts.size else np.empty(0)
