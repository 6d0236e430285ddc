"""Time as an argument: the only module of calrig that imports :mod:`time`.

Three clocks answer to one protocol. :class:`SystemClock` is the machine's. :class:`ScaledClock` runs the
rig's seconds faster than the wall's (twins over real ports at a factor). :class:`VirtualClock` jumps: a sleep
takes no real time, so a night's campaign rehearses in seconds and always the same way.
"""

import sys
import time
from datetime import UTC, datetime, timedelta
from typing import Protocol

WAIT_SLICE_S = 0.1
"""Longest real time between two looks for a stop request."""


class Clock(Protocol):
    """What every waiting part of calrig is given instead of :mod:`time`."""

    slice_s: float
    """Longest single sleep, in rig seconds, that still looks for a stop in time."""
    factor: float
    """Rig seconds that pass while :meth:`now_utc` goes on by one."""

    def monotonic_s(self) -> float:
        """Return rig seconds since an arbitrary start; never steps back."""

    def boottime_s(self) -> float:
        """Return seconds as :meth:`monotonic_s` does, but counting time spent suspended."""

    def now_utc(self) -> datetime:
        """Return the wall clock, aware, UTC."""

    def sleep(self, duration_s: float) -> None:
        """Let ``duration_s`` rig seconds pass."""


class SystemClock:
    """The machine's own clocks."""

    slice_s = WAIT_SLICE_S
    factor = 1.0

    def monotonic_s(self) -> float:
        return time.monotonic()

    def boottime_s(self) -> float:
        if sys.platform == "linux" and hasattr(time, "CLOCK_BOOTTIME"):
            return time.clock_gettime(time.CLOCK_BOOTTIME)
        return time.monotonic()

    def now_utc(self) -> datetime:
        return datetime.now(UTC)

    def sleep(self, duration_s: float) -> None:
        if duration_s > 0.0:
            time.sleep(duration_s)


class ScaledClock:
    """Rig seconds that pass ``factor`` times as fast as the wall's.

    ``now_utc`` stays the wall clock: a time stamp in a record is never invented.
    """

    def __init__(self, factor: float) -> None:
        if not factor > 0.0:
            raise ValueError(f"time factor must be positive, got {factor}")
        self.factor = factor
        self.slice_s = WAIT_SLICE_S * factor

    def monotonic_s(self) -> float:
        return time.monotonic() * self.factor

    def boottime_s(self) -> float:
        return SystemClock().boottime_s() * self.factor

    def now_utc(self) -> datetime:
        return datetime.now(UTC)

    def sleep(self, duration_s: float) -> None:
        if duration_s > 0.0:
            time.sleep(duration_s / self.factor)


class VirtualClock:
    """A clock that jumps: ``sleep`` advances it at once and costs no real time."""

    slice_s = float("inf")
    factor = 1.0

    def __init__(self, start_utc: datetime) -> None:
        self._start_utc = start_utc
        self._elapsed_s = 0.0
        self._suspended_s = 0.0
        self._wall_step_s = 0.0

    def monotonic_s(self) -> float:
        return self._elapsed_s

    def boottime_s(self) -> float:
        return self._elapsed_s + self._suspended_s

    def now_utc(self) -> datetime:
        return self._start_utc + timedelta(seconds=self._elapsed_s + self._suspended_s + self._wall_step_s)

    def sleep(self, duration_s: float) -> None:
        if duration_s > 0.0:
            self._elapsed_s += duration_s

    def begin_no_earlier(self, utc: datetime) -> None:
        """Begin where something ended that is dated already, as a run that is resumed, if that is to come."""
        self._start_utc = max(self._start_utc, utc)

    def step_wall(self, step_s: float) -> None:
        """Step the wall clock, as an operator or NTP would; rig seconds do not notice."""
        self._wall_step_s += step_s

    def suspend(self, duration_s: float) -> None:
        """Suspend the machine: boot time passes, monotonic time does not."""
        self._suspended_s += duration_s
