"""When samples were taken: by a rate that is stated, or by the column time_s."""

from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.errors import OutsideValidity

LONGEST_TURN_S: Final = 1.0
"""Between samples of gyros: what turns within is interpolated. Times in another unit than seconds look longer."""


class SampleClock:
    """The places of rows among evenly spaced samples, by the column time_s where there is one.

    ``longest_s``: intervals that the times may tell; a rate that is stated is taken as it is.
    """

    def __init__(self, rate_hz: float | None, longest_s: float = np.inf) -> None:
        self.interval_s = None if rate_hz is None else 1.0 / rate_hz
        self._longest_s = longest_s
        self._last_s: float | None = None

    def steps(self, time_s: FloatArray | None, rows: int) -> IntArray:
        """Return how many samples each row is behind the one before, 0 where it is not after it, -1 without a time.

        Raises: OutsideValidity where neither a rate nor times tell the interval, or these one that is too long.
        """
        if self.interval_s is None:
            self.interval_s = self._interval_of(time_s)
        if time_s is None:
            return np.ones(rows, dtype=np.int64)
        steps = np.empty(rows, dtype=np.int64)
        last_s = self._last_s
        if last_s is None:
            last_s = float(time_s[np.argmax(np.isfinite(time_s))]) - self.interval_s
        before = np.concatenate([[last_s], time_s[:-1]])
        with np.errstate(invalid="ignore"):
            found = np.rint((time_s - before) / self.interval_s)
        if np.all(found >= 1.0):
            self._last_s = float(time_s[-1])
            return np.asarray(found, dtype=np.int64)
        for row, read_s in enumerate(time_s.tolist()):
            steps[row] = max(round((read_s - last_s) / self.interval_s), 0) if np.isfinite(read_s) else 0
            last_s = read_s if steps[row] else last_s
        self._last_s = last_s
        return steps

    def _interval_of(self, time_s: FloatArray | None) -> float:
        between = np.empty(0) if time_s is None else np.diff(time_s[np.isfinite(time_s)])
        between = between[between > 0.0]
        if not between.size:
            raise OutsideValidity(
                "the interval between samples is not known; nothing was computed; give the sampling rate, or a "
                "column time_s"
            )
        interval_s = float(np.median(between))
        if interval_s > self._longest_s:
            raise OutsideValidity(
                f"time_s: rows lie {interval_s:g} apart (median), read as seconds; allowed is {self._longest_s:g} s at "
                "most, for what turns between two samples of gyros is interpolated; nothing was computed; give time_s "
                "in seconds (a column in milliseconds looks like that), or state the rate (--rate-hz) where gyros were "
                "read so slowly"
            )
        return interval_s
