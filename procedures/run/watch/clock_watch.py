"""Steps of the wall clock and suspensions of the machine, told from three clocks that should go together.

The wall clock and the boot clock go on while the machine sleeps, the monotonic clock does not; only the wall clock is
ever set. So boot − monotonic shows a suspension and wall − boot a step.
"""

from dataclasses import dataclass

from rig.clock import Clock, ScaledClock, SystemClock, VirtualClock

TOLERANCE_S = 1.0
LONGEST_GAP_S = 20.0
"""Between two looks; a wait looks ten times a second, and no question to a device takes so long."""


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


class GapWatch:
    """Looks how long it was since the last look: a process that is frozen (SIGSTOP, a debugger) or starved does not
    look, and no clock shows that afterwards.
    """

    def __init__(self, clock: Clock) -> None:
        """In virtual time a wait passes at once: nothing can be told of it."""
        self._clock = None if isinstance(clock, VirtualClock) else SystemClock()
        self._last_s = 0.0 if self._clock is None else self._clock.monotonic_s()

    def look(self) -> float:
        """Real seconds without a look, where they are more than a wait or a slow device explains; else 0."""
        if self._clock is None:
            return 0.0
        before_s, self._last_s = self._last_s, self._clock.monotonic_s()
        gap_s = self._last_s - before_s
        return gap_s if gap_s > LONGEST_GAP_S else 0.0


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
        """(wall − boot, boot − monotonic)."""
        boot_s = self._clock.boottime_s()
        return self._clock.now_utc().timestamp() - boot_s, boot_s - self._clock.monotonic_s()
