"""Steps of the wall clock and suspensions of the machine, told from three clocks that should go together.

The wall clock and the boot clock go on while the machine sleeps, the monotonic clock does not; only the wall clock is
ever set. So boot − monotonic shows a suspension and wall − boot a step.
"""

from dataclasses import dataclass

from rig.clock import Clock, ScaledClock, SystemClock

TOLERANCE_S = 1.0


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
