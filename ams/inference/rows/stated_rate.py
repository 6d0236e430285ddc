"""A sampling rate that is stated beside times that tell another: refused in words, as soon as it shows.

Rows are placed by the stated interval: where theirs is another one, rates are integrated over times that are not
theirs, turn too far, and no row shows it. Every step from row to row is one interval, a wide one as many as it comes
closest to, so that samples that never came do not count; errors of single times, by resolution and jitter, cancel but
for those of the first and the last.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.inference.rows.angle_stream import AngleStream, Answer

ALLOWED: Final = 2e-3
"""By which the two rates may differ, relative: what a clock and a rounded rate do."""
ALLOWED_INTERVALS: Final = 2.0
"""By which first and last time may be wrong together, as times that are rounded and jitter are."""
LEAST_STEPS: Final = 20
"""Before which a stream is not judged."""
_LONGEST_GAP: Final = 10.5
"""Intervals between two rows, beyond which a step does not tell how many they were."""
_WIDE: Final = 1.75
"""Intervals from which on a step is more than one of them."""
_PLAIN: Final = 1.25
"""Intervals up to which a step is surely one."""
_LEAST_PLAIN: Final = 0.05
"""Share of such steps among all; with fewer it is not losses that make the others wide."""
_JITTER: Final = 0.1
"""Of steps, in intervals: from there on a wide one is as likely a late time as a sample that is missing."""


class StatedRate:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` before another one, which counts by ``rate_hz``."""

    def __init__(self, inner: AngleStream, rate_hz: float) -> None:
        self.inner, self.rate_hz = inner, rate_hz
        self._last_s: FloatArray = np.empty(0)
        """(0,) or (1,) time of the row before."""
        self._forward = self._steps = self._doubles = self._plain = self._single = 0
        """Steps that do not go back in time, of these the counted ones, those to the same time, and those of about one
        interval by either bound."""
        self._passed = 0.0
        """What all took that do not go back, in stated intervals."""
        self._intervals = self._took = self._squares = 0.0
        """Intervals that the counted ones stand for, what they took, and how far single ones lie from one, squared."""

    @property
    def needed(self) -> tuple[str, ...]:
        return self.inner.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*self.inner.optional, "time_s")))

    @property
    def answers(self) -> tuple[str, ...]:
        return self.inner.answers

    @property
    def answers_at_once(self) -> bool:
        return self.inner.answers_at_once

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles that further rows settle. Raises: OutsideValidity where their times tell another rate."""
        time_s = readings.get("time_s")
        if time_s is not None and time_s.size:
            self._count(time_s)
            self._refuse_from(LEAST_STEPS)
        return self.inner.answer(readings)

    def finish(self) -> Answer:
        """Return the angles still due. Raises: as :meth:`answer`, of few rows as well."""
        self._refuse_from(1)
        return self.inner.finish()

    def _count(self, time_s: FloatArray) -> None:
        """Take the steps between (n,) further times."""
        took = np.diff(np.concatenate([self._last_s, time_s])) * self.rate_hz
        self._last_s = time_s[-1:]
        took = took[took >= 0.0]
        self._forward += took.size
        self._passed += float(took.sum())
        took = took[took < _LONGEST_GAP]
        is_single = took < _WIDE
        self._steps += took.size
        self._doubles += int(np.count_nonzero(took == 0.0))
        self._plain += int(np.count_nonzero(took < _PLAIN))
        self._single += int(np.count_nonzero(is_single))
        self._intervals += float(np.where(is_single, 1.0, np.rint(took)).sum())
        self._took += float(took.sum())
        self._squares += float(np.square(took[is_single] - 1.0).sum())

    def _refuse_from(self, least: int) -> None:
        """Raise OutsideValidity where so many steps contradict the stated rate."""
        if self._forward < least or self._is_kept():
            return
        steps, took = (self._intervals, self._took) if self._has_plain else (self._forward, self._passed)
        found_hz = self.rate_hz * steps / took if took else np.inf
        raise OutsideValidity(
            f"sampling rate: {self.rate_hz:g} Hz is stated (--rate-hz), time_s tells {found_hz:.5g} Hz (of the first "
            f"{self._forward + 1} rows): what is computed by the wrong one is wrong by as much; nothing more was "
            "computed; leave the stated rate out, and time_s counts, or correct it; where time_s is wrong, in seconds "
            "or not, leave that column out"
        )

    def _is_kept(self) -> bool:
        """Return whether the steps are of the stated interval."""
        if not self._has_plain:
            return False
        counts = [self._intervals, self._intervals - self._doubles]
        if self._squares > _JITTER**2 * self._single:
            counts.append(float(self._steps))
        return any(abs(self._took - count) <= ALLOWED * count + ALLOWED_INTERVALS for count in counts)

    @property
    def _has_plain(self) -> bool:
        """Whether some steps are surely single ones."""
        return self._plain >= _LEAST_PLAIN * self._forward
