"""Cables that wind up: an axis that turns on and on, refused before it turns farther than its cables bear.

The machine counts its own angle; what it forgets (power cut, reference move) the memory keeps: how far the cables were
wound when it was last looked at, and that it was about to turn. Where both contradict each other nobody knows, and
nothing turns at a rate until a person has looked. A reference move of a wound axis first unwinds it.

An axis in position never winds: its targets lie within its limits. Turning at a rate does.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from rig.clock import Clock
from rig.devices.abilities import Axis, AxisState, RateAxis, Stoppable, StopStep, TurnLook, Wait
from rig.devices.cable_memory import CableMemory, Winding
from rig.errors import DeviceFault, RequestRefused, RigError

TURN_DEG = 360.0
AGREES_DEG = 1.0
"""A read-back that is as close to the remembered one is the same count."""
SPARE_DEG = 30.0
"""Beyond the limit, for the ramp of a stop."""


class TurningAxis(Axis, RateAxis, Stoppable, Protocol):
    """Goes to positions and turns at rates, and somebody else can stop it."""


class CableGuard:
    """A :class:`TurningAxis` in front of another one whose cables bear ``wrap_turns`` either way."""

    def __init__(self, axis: TurningAxis, wrap_turns: float, memory: CableMemory) -> None:
        self.name = axis.name
        self.limits_deg = axis.limits_deg
        self.increment_deg = axis.increment_deg
        self.speed_dps = axis.speed_dps
        self.approach_deg = axis.approach_deg
        self.arrival_tolerance_deg = axis.arrival_tolerance_deg
        self.top_rate_dps = axis.top_rate_dps
        self.watchdog_s: float | None = getattr(axis, "watchdog_s", None)
        self.wrap_turns = wrap_turns
        self._axis = axis
        self._memory = memory
        self._kept = memory.read()
        self._offset_deg: float | None = None
        """Winding less read-back; None before the machine was asked, or where nobody knows."""
        self._rate_dps = 0.0
        self._homes_when_unwound = False

    @property
    def wound_deg(self) -> float:
        """How far the cables are wound, as last known; degrees, signed."""
        return 0.0 if self._kept is None else self._kept.wound_deg

    @property
    def home_travel_deg(self) -> float:
        """How far a reference move may turn beyond one revolution."""
        unknown = self._kept is not None and (self._kept.is_lost or self._kept.is_turning)
        return self._limit_deg if unknown else abs(self.wound_deg)

    @property
    def home_doubt(self) -> str:
        """As of the axis behind it."""
        return getattr(self._axis, "home_doubt", "")

    def identify(self) -> str:
        return self._axis.identify()

    def stop_steps(self) -> Sequence[StopStep]:
        return self._axis.stop_steps()

    def check_target(self, target_deg: float) -> None:
        self._axis.check_target(target_deg)

    def check_rate(self, rate_dps: float) -> None:
        self._axis.check_rate(rate_dps)

    def require_room(self, turn_deg: float) -> None:
        """Refuse a turn of so many degrees (signed) from here that the cables do not bear.

        Raises: RequestRefused.
        """
        state = self.state()
        if state.is_homed and self._offset_deg is None:
            raise RequestRefused(
                f"{self.name}: its cables were wound {self.wound_deg / TURN_DEG:+.2f} revolutions, and the machine has"
                " lost its count since, so nobody knows how far they are wound now; nothing moved; look at them,"
                f" unwind them by hand, then remove {self._memory.location}"
            )
        end_deg = self.wound_deg + turn_deg
        if abs(end_deg) > self._limit_deg and abs(end_deg) > abs(self.wound_deg):
            raise RequestRefused(
                f"{self.name}: turn by {turn_deg / TURN_DEG:+.2f} revolutions: the cables are wound"
                f" {self.wound_deg / TURN_DEG:+.2f} revolutions, allowed {self.wrap_turns:g} either way"
                f" (axes.{self.name}: wrap_turns); nothing moved; unwind first: {self.unwinding_plan()}"
            )

    def unwinding_plan(self) -> str:
        """Return how the cables come free again, in words."""
        return (
            f"move the axis to 0° (calrig jog --axis {self.name} --to 0), which turns it back by"
            f" {-self.wound_deg / TURN_DEG:+.2f} revolutions in {abs(self.wound_deg) / self.speed_dps:.0f} s"
        )

    def start_move(self, target_deg: float) -> None:
        self._axis.check_target(target_deg)
        if abs(self.wound_deg) > TURN_DEG / 2.0:
            self._keep(is_turning=True)
        self._axis.start_move(target_deg)

    def start_rate(self, rate_dps: float) -> None:
        """Start to turn.

        Raises also: RequestRefused where the cables are at their end that way, or nobody knows how far.
        """
        self._axis.check_rate(rate_dps)
        if self._rate_dps == 0.0:
            self.require_room(SPARE_DEG if rate_dps > 0.0 else -SPARE_DEG)
            self._keep(is_turning=True)
        self._axis.start_rate(rate_dps)
        self._rate_dps = rate_dps

    def turn_look(self, clock: Clock) -> TurnLook:
        """Look at a turning axis.

        Raises also: DeviceFault where the cables are at their end; the axis was told to stop.
        """
        look = self._axis.turn_look(clock)
        self._saw(look.angle_deg)
        return look

    def home(self) -> None:
        """Start the reference move; a wound axis unwinds first.

        Poll :meth:`state` until homed and at rest.
        """
        state = self.state()
        if state.is_homed and self._offset_deg is not None and abs(self.wound_deg) > TURN_DEG / 2.0:
            self.start_move(0.0)
            self._homes_when_unwound = True
            return
        if not state.is_homed and self._kept is not None:
            lost = self._kept.is_lost or self._kept.is_turning
            self._offset_deg = None
            self._kept = Winding(self._kept.wound_deg, self._kept.read_deg, is_turning=False, is_lost=lost)
            self._memory.write(self._kept)
        self._axis.home()

    def state(self) -> AxisState:
        state = self._axis.state()
        if self._homes_when_unwound and not state.is_moving and not state.fault:
            self._homes_when_unwound = False
            self._saw(state.position_deg)
            self._axis.home()
            state = self._axis.state()
        if self._homes_when_unwound:
            return AxisState(state.position_deg, True, False, state.is_seated, state.fault)
        if state.is_homed:
            self._saw(state.position_deg)
            if not state.is_moving and self._offset_deg is not None and (self._kept is None or self._kept.is_turning):
                self._keep(is_turning=False)
        return state

    def stop(self) -> None:
        self._homes_when_unwound = False
        self._axis.stop()
        self._rate_dps = 0.0

    def arm_watchdog(self, wait: Wait) -> str:
        outcome: str = self._axis.arm_watchdog(wait)  # type: ignore[attr-defined]
        return outcome

    def feed_watchdog(self) -> None:
        self._axis.feed_watchdog()  # type: ignore[attr-defined]

    def disarm_watchdog(self) -> None:
        self._axis.disarm_watchdog()  # type: ignore[attr-defined]

    @property
    def _limit_deg(self) -> float:
        return self.wrap_turns * TURN_DEG

    def _saw(self, read_deg: float) -> None:
        """Take note of a trusted read-back. Raises: DeviceFault."""
        if self._offset_deg is None:
            self._offset_deg = self._offset_from(read_deg)
            if self._offset_deg is None:
                return
        wound_deg = read_deg + self._offset_deg
        self._kept = Winding(wound_deg, read_deg, self._kept is not None and self._kept.is_turning)
        is_outward = self._rate_dps * wound_deg > 0.0
        if is_outward and abs(wound_deg) > self._limit_deg + SPARE_DEG:
            try:
                self._axis.stop()
            except RigError as error:
                raise DeviceFault(
                    f"{self.name}: could not be stopped with its cables at their end: {error}; use the stop button"
                ) from error
            raise DeviceFault(
                f"{self.name}: the cables are wound {wound_deg / TURN_DEG:+.2f} revolutions, allowed"
                f" {self.wrap_turns:g} either way (axes.{self.name}: wrap_turns); the axis was told to stop; unwind:"
                f" {self.unwinding_plan()}"
            )

    def _offset_from(self, read_deg: float) -> float | None:
        """Compare the first trusted read-back of this process with what was kept; return the offset, None if unknown.

        The same count: it goes on from there, however far it has turned meanwhile. Another count of an axis that
        rested unwound: it was homed anew. Anything else nobody knows.
        """
        kept = self._kept
        if kept is None:
            return 0.0
        if kept.is_lost:
            return None
        if kept.is_turning or abs(read_deg - kept.read_deg) <= AGREES_DEG:
            return kept.wound_deg - kept.read_deg
        return 0.0 if abs(kept.wound_deg) <= TURN_DEG / 2.0 else None

    def _keep(self, *, is_turning: bool) -> None:
        kept = self._kept or Winding(0.0, 0.0, is_turning)
        self._kept = replace(kept, is_turning=is_turning)
        self._memory.write(self._kept)
