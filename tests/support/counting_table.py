"""A table that turns on and on, from physics: its true angle is what winds the cables, whatever it tells of itself.

It counts from where power came on, and from its zero once it has searched it, the near way. It forgets its zero
without power. Its read-back goes on beyond a turn, or begins again there; one that begins again goes to positions the
near way. What a process knows of it ends with the process: :class:`Driver`.
"""

from collections.abc import Callable, Sequence

from rig.abilities import rates
from rig.abilities.abilities import AxisState, StopStep, TurnLook
from rig.abilities.targets import require_home
from rig.cables.winding import nearest_deg
from rig.clock import VirtualClock
from rig.devices.rate_table import Unwound
from rig.errors import LinkLost, RequestRefused

SPEED_DPS, TOP_RATE_DPS = 60.0, 90.0


class CountingTable:
    """The machine. ``wraps``: it tells angles within a turn only."""

    def __init__(self, clock: VirtualClock, *, wraps: bool) -> None:
        self.wraps = wraps
        self._clock = clock
        self._true_deg = self._origin_deg = self._rate_dps = 0.0
        self._target_deg: float | None = None
        self._is_homing = self.is_homed = False
        self._stepped_s = clock.monotonic_s()

    @property
    def true_deg(self) -> float:
        """How far the cables are wound."""
        self._step()
        return self._true_deg

    @property
    def shown_deg(self) -> float:
        counted_deg = self.true_deg - self._origin_deg
        return counted_deg % 360.0 if self.wraps else counted_deg

    @property
    def is_moving(self) -> bool:
        self._step()
        return self._target_deg is not None or self._rate_dps != 0.0

    def go(self, shown_deg: float) -> None:
        counted_deg = self.true_deg - self._origin_deg
        self._rate_dps = 0.0
        self._target_deg = self._origin_deg + (nearest_deg(shown_deg, counted_deg) if self.wraps else shown_deg)

    def turn(self, rate_dps: float) -> None:
        self._step()
        self._target_deg, self._rate_dps = None, rate_dps

    def home(self) -> None:
        self._step()
        self._rate_dps, self.is_homed, self._is_homing = 0.0, False, True
        self._target_deg = nearest_deg(0.0, self._true_deg)  # its zero is a mark on the body

    def stop(self) -> None:
        self._step()
        self._rate_dps, self._target_deg, self._is_homing = 0.0, None, False

    def power_cycle(self) -> None:
        self.stop()
        self.is_homed, self._origin_deg = False, self._true_deg

    def unwind_by_hand(self) -> None:
        """Turn it back to where the cables hang free; its encoder counts along."""
        self.stop()
        self._true_deg = 0.0

    def _step(self) -> None:
        now_s = self._clock.monotonic_s()
        passed_s, self._stepped_s = now_s - self._stepped_s, now_s
        if self._target_deg is None:
            self._true_deg += self._rate_dps * passed_s
            return
        left_deg, most_deg = self._target_deg - self._true_deg, SPEED_DPS * passed_s
        if abs(left_deg) > most_deg:
            self._true_deg += most_deg if left_deg > 0.0 else -most_deg
            return
        self._true_deg, self._target_deg = self._target_deg, None
        if self._is_homing:
            self._is_homing, self.is_homed, self._origin_deg = False, True, self._true_deg


class Driver:
    """What one process knows of the table: a :class:`rig.cables.cable.TurningAxis`. ``on_rate`` hears of each rate."""

    name, increment_deg, approach_deg, arrival_tolerance_deg = "yaw", 0.0, 0.0, 0.01
    speed_dps, top_rate_dps = SPEED_DPS, TOP_RATE_DPS

    def __init__(
        self,
        table: CountingTable,
        clock: VirtualClock,
        limits_deg: tuple[float, float],
        on_rate: Callable[[float], None] = lambda _rate_dps: None,
    ) -> None:
        self.limits_deg = limits_deg
        self.is_dead = False
        """Its process was killed: whatever is still asked of it here reaches nothing."""
        self._machine = table
        self._on_rate = on_rate
        self._unwound = Unwound(clock) if table.wraps else None
        self._unwrap = self._unwound or float

    @property
    def _table(self) -> CountingTable:
        if self.is_dead:
            raise LinkLost("killed")
        return self._machine

    def identify(self) -> str:
        return "counting table"

    def stop_steps(self) -> Sequence[StopStep]:
        return ()

    def check_target(self, target_deg: float) -> None:
        if not self.limits_deg[0] <= target_deg <= self.limits_deg[1]:
            raise RequestRefused(f"yaw: {target_deg:g}° is outside the limits")

    def check_rate(self, rate_dps: float) -> None:
        rates.check_rate(self.name, rate_dps, self.top_rate_dps)

    def start_move(self, target_deg: float) -> None:
        require_home(self.name, "move", is_homed=self._table.is_homed)
        self._table.go(target_deg)

    def start_rate(self, rate_dps: float) -> None:
        require_home(self.name, "turn", is_homed=self._table.is_homed)
        self._on_rate(rate_dps)
        self._table.turn(rate_dps)

    def turn_look(self, clock: VirtualClock) -> TurnLook:
        return rates.look(lambda: self._unwrap(self._table.shown_deg), clock)

    def home(self) -> None:
        self._table.home()

    def state(self) -> AxisState:
        is_moving, shown_deg = self._table.is_moving, self._unwrap(self._table.shown_deg)
        if self._unwound is not None and not is_moving:
            self._unwound.stand()
        return AxisState(shown_deg, is_moving, self._table.is_homed, is_seated=True, fault="")

    def stop(self) -> None:
        self._table.stop()
