"""When samples were taken: by a rate that is stated, or by the column time_s."""

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.errors import OutsideValidity


class SampleClock:
    """The places of rows among evenly spaced samples, by the column time_s where there is one."""

    def __init__(self, rate_hz: float | None) -> None:
        self.interval_s = None if rate_hz is None else 1.0 / rate_hz
        self._last_s: float | None = None

    def steps(self, time_s: FloatArray | None, rows: int) -> IntArray:
        """Return how many samples each row is behind the one before, 0 where it is not after it, -1 without a time.

        Raises: OutsideValidity where neither a rate nor times tell the interval.
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
        return float(np.median(between))
