"""Cables that wind up: an axis that turns on and on, refused before it turns farther than its cables bear.

The machine counts its own angle; what it forgets (power cut, reference move) the memory keeps: how far the cables were
wound when it was last looked at, and that it was about to turn. Where both contradict each other nobody knows
(:mod:`rig.cables.winding`), and nothing turns at a rate until a person has looked and removed what is kept, whatever
moves and homes come between. A reference move of a wound axis first unwinds it.

An axis in position winds no farther than its limits. Turning at a rate does.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import copysign
from typing import Protocol

from rig.abilities.abilities import Axis, AxisState, RateAxis, Stoppable, StopStep, TurnLook, Wait
from rig.abilities.targets import require_home
from rig.cables.cable_memory import CableMemory
from rig.cables.winding import (
    AGREES_DEG,
    TURN_DEG,
    Machine,
    UnseenTurns,
    Winding,
    differs,
    first_look,
    next_look,
    without_home,
)
from rig.clock import Clock
from rig.errors import DeviceFault, RequestRefused, RigError

SPARE_DEG = 30.0
"""Beyond the limit, for the ramp of a stop."""
COUNTS_ON_FROM_ZERO = Machine()


class TurningAxis(Axis, RateAxis, Stoppable, Protocol):
    """Goes to positions and turns at rates, and somebody else can stop it."""


class CableGuard:
    """A :class:`TurningAxis` in front of another one whose cables bear ``wrap_turns`` either way."""

    def __init__(
        self,
        axis: TurningAxis,
        wrap_turns: float,
        memory: CableMemory,
        clock: Clock,
        machine: Machine = COUNTS_ON_FROM_ZERO,
    ) -> None:
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
        self._machine = machine
        self._clock = clock
        self._memory = memory
        self._kept = self._filed = memory.read()
        self._is_followed = False
        """A look of this process found the machine homed, and none since found it otherwise."""
        self._unseen = UnseenTurns()
        self._rate_dps = 0.0
        self._target_deg: float | None = None
        """Of a move that winds or unwinds."""
        self._homes_when_unwound = False

    @property
    def wound_deg(self) -> float:
        """How far the cables are wound, as last known; degrees, signed."""
        return 0.0 if self._kept is None else self._kept.wound_deg

    @property
    def is_in_doubt(self) -> bool:
        """Whether nobody knows how far the cables are wound: :attr:`wound_deg` is what they were once."""
        return self._kept is not None and self._kept.is_lost

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
        if self.is_in_doubt:
            raise RequestRefused(
                f"{self.name}: nobody knows how far its cables are wound: they were {self.wound_deg / TURN_DEG:+.2f}"
                f" revolutions when they were last counted, and since then {self._why_in_doubt}; nothing moved; look at"
                f" them, unwind them by hand, home the axis, then remove {self._memory.location} and start anew"
            )
        require_home(self.name, f"turn by {turn_deg / TURN_DEG:+.2f} revolutions", is_homed=state.is_homed)
        end_deg = self.wound_deg + turn_deg
        if abs(end_deg) > self._limit_deg and abs(end_deg) > abs(self.wound_deg):
            raise RequestRefused(
                f"{self.name}: turn by {turn_deg / TURN_DEG:+.2f} revolutions: the cables are wound"
                f" {self.wound_deg / TURN_DEG:+.2f} revolutions, allowed {self.wrap_turns:g} either way"
                f" (axes.{self.name}: wrap_turns); nothing moved; unwind first: {self.unwinding_plan()}"
            )

    def unwinding_plan(self) -> str:
        """Return how the cables come free again, in words."""
        back = f"{-self.wound_deg / TURN_DEG:+.2f} revolutions"
        if self._machine.wraps:
            rate_dps = copysign(min(self.speed_dps, self.top_rate_dps), -self.wound_deg)
            return (
                f"turn the axis back by {back} (calrig jog --axis {self.name} --rate {rate_dps:g}"
                f" --for {abs(self.wound_deg / rate_dps):.3g}): a move to 0° may go the near way and unwind nothing"
            )
        return (
            f"move the axis to 0° (calrig jog --axis {self.name} --to 0), which turns it back by"
            f" {back} in {abs(self.wound_deg) / self.speed_dps:.0f} s"
        )

    def start_move(self, target_deg: float) -> None:
        self._axis.check_target(target_deg)
        if not self._is_followed:
            self.state()
        kept = self._kept
        if self._is_followed and kept and not kept.is_lost and self._machine.may_wind(kept, target_deg):
            self._target_deg = target_deg
            self._start(lambda: self._axis.start_move(target_deg), self.speed_dps)
        else:
            self._unseen.start(self.speed_dps)
            self._axis.start_move(target_deg)

    def start_rate(self, rate_dps: float) -> None:
        """Start to turn.

        Raises also: RequestRefused where the cables are at their end that way, or nobody knows how far.
        """
        self._axis.check_rate(rate_dps)
        if self._rate_dps == 0.0:
            self.require_room(SPARE_DEG if rate_dps > 0.0 else -SPARE_DEG)
            self._target_deg = None
        self._start(lambda: self._axis.start_rate(rate_dps), rate_dps)
        self._rate_dps = rate_dps

    def turn_look(self, clock: Clock) -> TurnLook:
        """Look at a turning axis.

        Raises also: DeviceFault where the cables are at their end; the axis was told to stop.
        """
        look = self._axis.turn_look(clock)
        self._saw(look.angle_deg, is_at_rest=False)
        return look

    def home(self) -> None:
        """Start the reference move; a wound axis unwinds first.

        Poll :meth:`state` until homed and at rest.
        """
        state = self.state()
        if state.is_homed and self._kept is not None and self._kept.is_turning:
            state = self.state()  # one look does not show that it rests
        if state.is_homed and not self.is_in_doubt and self._machine.is_wound(self.wound_deg):
            self.start_move(0.0)
            self._homes_when_unwound = True
            return
        self._axis.home()

    def state(self) -> AxisState:
        state = self._axis.state()
        self._look(state)
        if self._homes_when_unwound and not state.is_moving and not state.fault:
            self._homes_when_unwound = False
            if not self.is_in_doubt and self._machine.is_wound(self.wound_deg):
                raise DeviceFault(
                    f"{self.name}: home: its cables are wound {self.wound_deg / TURN_DEG:+.2f} revolutions, and a move"
                    f" to 0° did not unwind them; it stands still and was not homed; {self.unwinding_plan()}"
                )
            self._axis.home()
            state = self._axis.state()
            self._look(state)
        if self._homes_when_unwound:
            return AxisState(state.position_deg, True, False, state.is_seated, state.fault, unknown=state.unknown)
        return state

    def stop(self) -> None:
        self._homes_when_unwound = False
        self._axis.stop()
        self._rate_dps = 0.0

    def stop_by_guard(self) -> bool:
        """As of the axis behind it."""
        return bool(self._axis.stop_by_guard())  # type: ignore[attr-defined]

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

    @property
    def _why_in_doubt(self) -> str:
        lost = "the machine lost its count, or turned unseen"
        return f"{lost}: it counts within a turn only" if self._machine.wraps else lost

    def _start(self, send: Callable[[], None], speed_dps: float) -> None:
        """Start what winds or unwinds: it is marked as turning first, and no more where it was refused."""
        assert self._kept is not None
        was_turning = self._kept.is_turning
        if not was_turning:
            self._keep(is_turning=True)
        self._unseen.start(speed_dps)
        try:
            send()
        except RequestRefused:
            if not was_turning:
                self._keep(is_turning=False)
            raise

    def _look(self, state: AxisState) -> None:
        """Take note of a look at the axis, and of its rest. Raises: DeviceFault."""
        before = self._kept
        if not state.is_homed:
            self._is_followed = False
            self._kept = without_home(self._kept, self._machine)
        else:
            self._saw(state.position_deg, is_at_rest=not state.is_moving and self._rate_dps == 0.0)
            if self._kept is not None and self._rests(state, before):
                self._kept = replace(self._kept, is_turning=False)
        if self._memory.is_writable and self._kept is not None and self._is_to_be_filed(state):
            self._write()

    def _rests(self, state: AxisState, before: Winding | None) -> bool:
        """Return whether an axis that was to turn is seen at rest: where it was sent, or twice at one place."""
        if state.is_moving or self._rate_dps != 0.0:
            return False
        stood_deg = (self._target_deg, None if before is None else before.read_deg)
        return any(at_deg is not None and abs(state.position_deg - at_deg) <= AGREES_DEG for at_deg in stood_deg)

    def _is_to_be_filed(self, state: AxisState) -> bool:
        """Return whether the file says less than is known: of a doubt at once, of all else at rest."""
        assert self._kept is not None
        is_news = self._kept.is_lost or not (state.is_moving or self._kept.is_turning)
        return is_news and differs(self._kept, self._filed, self._machine)

    def _saw(self, read_deg: float, *, is_at_rest: bool) -> None:
        """Take note of a trusted read-back. Raises: DeviceFault."""
        if not self._is_followed:
            self._unseen.forget()
        is_lost = self._machine.wraps and self._unseen.is_lost(
            read_deg, self._clock.monotonic_s(), self._rate_dps, is_at_rest=is_at_rest
        )
        follow = next_look if self._is_followed and not is_lost else first_look
        self._kept = follow(self._kept, read_deg, self._machine)
        self._is_followed = True
        if not self._kept.is_lost:
            self._require_not_at_end(self._kept.wound_deg)

    def _require_not_at_end(self, wound_deg: float) -> None:
        """Stop an axis that turns on beyond what its cables bear. Raises: DeviceFault where it did."""
        is_outward = self._rate_dps * wound_deg > 0.0
        if not is_outward or abs(wound_deg) <= self._limit_deg + SPARE_DEG:
            return
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

    def _keep(self, *, is_turning: bool) -> None:
        assert self._kept is not None
        self._kept = replace(self._kept, is_turning=is_turning)
        self._write()

    def _write(self) -> None:
        assert self._kept is not None
        self._memory.write(self._kept)
        self._filed = self._kept
