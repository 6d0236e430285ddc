"""Steps of the wall clock and suspensions of the machine, told from three clocks that should go together.

The wall clock and the boot clock go on while the machine sleeps, the monotonic clock does not; only the wall clock is
ever set. So boot − monotonic shows a suspension and wall − boot a step.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from rig.clock import Clock, ScaledClock, SystemClock, VirtualClock

TOLERANCE_S = 1.0
LONGEST_GAP_S = 20.0
"""Between two looks; a wait looks ten times a second, and no question that is answered takes so long."""


@dataclass(frozen=True, slots=True)
class ClockChange:
    """Since the last look; seconds."""

    step_s: float
    suspended_s: float

    @property
    def is_step(self) -> bool:
        return abs(self.step_s) > TOLERANCE_S

    @property
    def is_suspension(self) -> bool:
        return self.suspended_s > TOLERANCE_S


@dataclass(frozen=True, slots=True)
class Gap:
    """A time without a look."""

    gap_s: float
    unanswered: Mapping[str, int]
    """Line to the questions that found no answer in it."""

    @property
    def text(self) -> str:
        if not self.unanswered:
            return f"this process did not run for {self.gap_s:.0f} s: stopped by a signal, or starved"
        lines = ", ".join(f"{name} ({count})" for name, count in self.unanswered.items())
        return (
            f"nothing was looked at for {self.gap_s:.0f} s: questions had no answer on {lines};"
            " or this process was stopped by a signal in the middle of one"
        )


class GapWatch:
    """Looks how long it was since the last look: a process that is frozen (SIGSTOP, a debugger) or starved does not
    look, nor does one that waits for lines that do not answer, and no clock shows that afterwards.
    """

    def __init__(self, clock: Clock, silences: Callable[[], Mapping[str, int]] = dict) -> None:
        """In virtual time a wait passes at once: nothing can be told of it.

        ``silences``: line to the questions without an answer since it was opened.
        """
        self._clock = None if isinstance(clock, VirtualClock) else SystemClock()
        self._silences = silences
        self._last_s = 0.0 if self._clock is None else self._clock.monotonic_s()
        self._silent = dict(silences())

    def look(self) -> Gap | None:
        """Return the time without a look, where it is more than a wait or a slow device explains."""
        if self._clock is None:
            return None
        before_s, self._last_s = self._last_s, self._clock.monotonic_s()
        silent, self._silent = self._silent, dict(self._silences())
        gap_s = self._last_s - before_s
        if gap_s <= LONGEST_GAP_S:
            return None
        # A line that was opened anew meanwhile counts from 0.
        new = {
            name: now - silent.get(name, 0) if now >= silent.get(name, 0) else now for name, now in self._silent.items()
        }
        return Gap(gap_s, {name: count for name, count in new.items() if count})


class ClockWatch:
    """Looks at the machine's own clocks (a scaled rig has no other)."""

    def __init__(self, clock: Clock) -> None:
        self._clock: Clock = SystemClock() if isinstance(clock, ScaledClock) else clock
        self._last = self._offsets()

    def look(self) -> ClockChange:
        wall_s, boot_s = self._last
        self._last = self._offsets()
        return ClockChange(self._last[0] - wall_s, self._last[1] - boot_s)

    def _offsets(self) -> tuple[float, float]:
        """Return (wall − boot, boot − monotonic)."""
        boot_s = self._clock.boottime_s()
        return self._clock.now_utc().timestamp() - boot_s, boot_s - self._clock.monotonic_s()
