"""Readings low-pass filtered before they become angles, sample by sample, each answer at the time of its own reading.

CR filters every output before it is averaged (V-B). The filter runs forwards only, so a stream never waits for its end.
Slow changes come late by the group delay, which is taken off: a row is answered from the filter's answer so many
samples later. What the filter says before it has forgotten its start, a missing reading or a stretch that never came is
marked.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.attitude import flag_codes
from ams.attitude.filters import LowPass, LowPassStream, delay_s, settling_samples
from ams.inference.rows.angle_stream import CARRIED_CODES, OF_STREAMS, AngleStream, Answer, joined, nothing
from ams.inference.rows.sample_clock import SampleClock

NOT_FILTERED: Final = ("time_s", "roll_deg")
_HELD: Final = "codes of the filter"


@dataclass(frozen=True)
class LowPassWish:
    """What is asked of the filter, before the sampling rate is known."""

    cutoff_hz: float
    order: int = 4
    ripple_db: float = 0.1

    def at(self, rate_hz: float) -> LowPass:
        """Return the filter's settings. Raises: ObservationsError where they are none."""
        return LowPass(self.cutoff_hz, rate_hz, self.order, self.ripple_db)


class LowPassedAngles:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` before another one."""

    def __init__(self, inner: AngleStream, wish: LowPassWish, rate_hz: float | None) -> None:
        self.inner, self.wish = inner, wish
        self._clock = SampleClock(rate_hz)
        self._filter: LowPassStream | None = None
        self._delay = self._settling = 0
        self._kept: dict[str, FloatArray] = {}
        """Columns as they were read, of rows that wait for the filter's answer."""
        self._codes: flag_codes.AnswerCodes = np.empty(0, dtype=np.uint64)
        """Of rows that were handed on and are not answered yet."""
        self._since_bad = 0
        """Samples since the last that was none; the first stands for all before it."""

    @property
    def needed(self) -> tuple[str, ...]:
        return self.inner.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return tuple(name for name in dict.fromkeys((*self.inner.optional, "time_s")) if name not in OF_STREAMS)

    @property
    def answers(self) -> tuple[str, ...]:
        return self.inner.answers

    @property
    def answers_at_once(self) -> bool:
        return False

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles that further rows settle. Raises: OutsideValidity without a sampling rate."""
        rows = next(iter(readings.values())).size
        if not rows:
            return nothing(self.answers)
        steps = self._clock.steps(readings.get("time_s"), rows)
        running = self._filter or self._started()
        filtered = [name for name in self.needed if name not in NOT_FILTERED]
        samples = np.stack([readings[name] for name in filtered], axis=-1)
        is_whole = np.isfinite(samples).all(axis=1) & (steps == 1)
        found = running.feed(samples)
        codes = self._codes_of(is_whole, steps)
        arrived = {**readings, **dict(zip(filtered, found.T, strict=True))}
        return self._handed_on(arrived, codes)

    def finish(self) -> Answer:
        """Return the angles still due; the last rows, which the delay never reached, have none."""
        rows = next(iter(self._kept.values())).size if self._kept else 0
        if not rows:
            return self._answered(self.inner.finish())
        lost = {
            name: values if name in NOT_FILTERED else np.full(rows, np.nan)
            for name, values in self._kept.items()
            if name != _HELD
        }
        self._kept = {}
        due = self._answer_with(lost, np.full(rows, flag_codes.TRANSIENT, dtype=np.uint64))
        return joined(due, self._answered(self.inner.finish()))

    def _started(self) -> LowPassStream:
        assert self._clock.interval_s is not None
        settings = self.wish.at(1.0 / self._clock.interval_s)
        self._filter = LowPassStream(settings)
        # Rows keep their own times, so the delay that is taken off is whole samples: less than half of one stays.
        self._delay = round(delay_s(settings) * settings.sample_rate_hz)
        self._settling = settling_samples(settings) + 1
        return self._filter

    def _codes_of(self, is_whole: BoolArray, steps: IntArray) -> flag_codes.AnswerCodes:
        """Return by filter's answer whether it still holds what was no sample, and whether its own was missing."""
        indices = np.arange(1, is_whole.size + 1)
        last_bad = np.maximum.accumulate(np.where(is_whole, 0, indices))
        since = np.where(last_bad > 0, indices - last_bad, indices + self._since_bad)
        self._since_bad = int(since[-1])
        codes = np.where(since <= self._settling, flag_codes.TRANSIENT, 0).astype(np.uint64)
        codes[~is_whole & (steps > 0)] |= np.uint64(flag_codes.FILTER_BRIDGED)
        return codes

    def _handed_on(self, arrived: Mapping[str, FloatArray], codes: flag_codes.AnswerCodes) -> Answer:
        """Hand on rows whose answer of the filter is there: row n with the answer of row n + delay."""
        both = {**arrived, _HELD: codes.astype(float)}
        if self._kept:
            both = {name: np.concatenate([self._kept[name], values]) for name, values in both.items()}
        ready = max(both[_HELD].size - self._delay, 0)
        late = slice(self._delay, self._delay + ready)
        rows = {
            name: values[:ready] if name in NOT_FILTERED else values[late]
            for name, values in both.items()
            if name != _HELD
        }
        # Whether the filter still holds a gap goes with its answer; whether a reading was missing, with the row itself.
        transient = both[_HELD][late].astype(np.uint64) & np.uint64(flag_codes.TRANSIENT)
        transient |= both[_HELD][:ready].astype(np.uint64) & np.uint64(flag_codes.FILTER_BRIDGED)
        self._kept = {name: values[ready:] for name, values in both.items()}
        if not ready:
            return nothing(self.answers)
        return self._answer_with(rows, transient)

    def _answer_with(self, rows: Mapping[str, FloatArray], codes: flag_codes.AnswerCodes) -> Answer:
        """Answer rows with the filter's codes of each; averages take these along."""
        if CARRIED_CODES in self.inner.optional:
            return self._answered(self.inner.answer({**rows, CARRIED_CODES: codes.astype(float)}))
        self._codes = np.concatenate([self._codes, codes])
        return self._answered(self.inner.answer(rows))

    def _answered(self, found: Answer) -> Answer:
        """Put the filter's codes beside those of the rows that are answered now."""
        reasons = {**found.reasons, **flag_codes.FILTER_WORDS}
        if CARRIED_CODES in self.inner.optional:
            return Answer(found.columns, found.codes, reasons)
        answered, self._codes = self._codes[: found.codes.size], self._codes[found.codes.size :]
        return Answer(found.columns, found.codes | answered, reasons)
