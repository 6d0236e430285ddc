"""The motion supervisor: the one door through which every axis of an open rig is told anything and looked at.

It remembers what each axis was told last and judges every look by that (:mod:`rig.motion.expectation`). What an axis
does that it was not told is asked once more, since a line can turn a digit over; then that axis and every other one
that moves is stopped and :class:`rig.errors.MotionBreach` is raised, which nobody may answer with another attempt.

A command that the line altered may reach another axis: while one moves, those that should stand are looked at too.
"""

from collections.abc import Callable
from contextlib import suppress
from threading import RLock
from typing import Any, TypeVar

from rig.abilities.abilities import AimedStop, Axis, AxisState, TurnLook, Wait
from rig.clock import Clock
from rig.errors import DeviceRefused, DeviceSilent, LinkLost, MotionBreach, RequestRefused, RigError
from rig.motion.expectation import (
    Bounds,
    Homing,
    Moving,
    Seen,
    Standing,
    Stopping,
    Task,
    Turning,
    Unknown,
    Watched,
    after_home,
    broken_off,
    expecting_home,
    expecting_move,
    expecting_stop,
    expecting_turn,
    judge,
    run_on_deg,
    unseen,
)
from rig.motion.given_abilities import give_abilities
from rig.motion.home_limits import require_home_inside, require_inside
from rig.motion.motion_memory import MotionMemory
from rig.motion.silence import silence_s
from rig.motion.warden import Warden

OTHERS_S = 1.0
"""Between two looks at axes that should stand while another one moves."""
_UNDER_WAY = (Moving, Homing, Turning)
Answer = TypeVar("Answer")


class Supervisor:
    """Of all axes of one rig, over all openings of its lines. Every look is a sign of life for its ``warden``, if any.

    ``memory``: outlives the connection.
    """

    def __init__(self, clock: Clock, warden: Warden | None = None, memory: MotionMemory | None = None) -> None:
        self._clock = clock
        self.warden = warden
        self.memory = memory or MotionMemory()
        self._axes: dict[str, SupervisedAxis] = {}
        self._ways: dict[str, tuple[int, int]] = {}

    def supervise(
        self, axis: Axis, home_deg: float | None = 0.0, line: str = "", wrap_turns: float | None = None
    ) -> "SupervisedAxis":
        """Return the axis as everybody else may have it. ``home_deg``: where homing ends, None where it moves nothing.

        ``line``: on which it is spoken to; axes on one line have the same, unless empty. ``wrap_turns``: its cables'.
        """
        supervised = SupervisedAxis(axis, self._clock, self, home_deg, line)
        supervised.wrap_turns = wrap_turns
        self._axes[axis.name] = supervised
        self._ways.pop(axis.name, None)
        return supervised

    def look_at_others(self, moving: "SupervisedAxis", *, only_unknown: bool = False) -> None:
        """Look at the axes that should stand; one that does not answer is left to whoever needs it.

        Raises: MotionBreach, and DeviceSilent or LinkLost of one on the line of an axis that is under way: that one
        would not answer either, and to ask it too would leave it unseen for as long again.
        """
        for axis in self._axes.values():
            if axis is not moving and axis.is_to_be_seen(only_unknown=only_unknown):
                try:
                    axis.look(must_stand=True)
                except MotionBreach:
                    raise
                except RigError as error:
                    axis.is_silent = True
                    shares_line = axis in self.on_line_of(moving)
                    if shares_line and moving.is_under_way and isinstance(error, DeviceSilent | LinkLost):
                        raise

    def expect_motion(self, starting: "SupervisedAxis", way: tuple[int, int] | None) -> None:
        """See that a guard is there. ``way``: of :class:`AimedStop`. Raises: GuardLost, WaitEnded."""
        if self.warden is not None:
            self._ways.pop(starting.name, None)
            if way is not None:
                self._ways[starting.name] = way
            self.warden.expect_motion(sorted({*self._not_standing(), starting.name}), self._ways)
            self._heed()

    def beat(self, seen: "SupervisedAxis") -> None:
        """Give a sign of life; heed the guard at a look at an axis that moves. Raises: GuardLost, WaitEnded."""
        if self.warden is not None:
            self.warden.beat(self._not_standing(), silence_s([(it.task, it.wrap_turns) for it in self._axes.values()]))
            if seen.is_under_way:
                self._heed()

    def on_line_of(self, axis: "SupervisedAxis") -> list["SupervisedAxis"]:
        """Return it and those that hear what it is told."""
        return [other for other in self._axes.values() if other is axis or (axis.line and other.line == axis.line)]

    def stop_by_guard(self) -> bool:
        return self.warden is not None and self.warden.stop_now()

    def is_stopped_past_us(self) -> bool:
        """Return whether the guard told axes to stop: an answer may then be that of a stop."""
        return self.warden is not None and bool(self.warden.why_stop())

    def _heed(self) -> None:
        if self.warden is not None and (trouble := self.warden.take_trouble()) is not None:
            self._stop_all_under_way()
            raise trouble

    def _not_standing(self) -> list[str]:
        return sorted(name for name, axis in self._axes.items() if axis.may_move)

    def _stop_all_under_way(self) -> None:
        for axis in self._axes.values():
            if axis.is_under_way:
                with suppress(RigError):
                    axis.stop()

    def refuse(self, culprit: "SupervisedAxis", breach: str) -> MotionBreach:
        """Stop the axis and all others that are under way; returns what to raise."""
        outcome = "it was told to stop"
        try:
            culprit.stop()
        except RigError as error:
            outcome = f"it could not be told to stop: {error}; use the stop button at the machine"
        self._stop_all_under_way()
        return MotionBreach(
            f"{culprit.name}: {breach} (axes.{culprit.name}: limits_deg, speed_dps, arrival_tolerance_deg); {outcome};"
            " see who or what moved it, then home it; one that you turned by hand needs no more than that"
        )


class SupervisedAxis:
    """An axis behind the supervisor. It has the abilities of the axis that it stands for, and no others."""

    def __init__(self, axis: Axis, clock: Clock, supervisor: Supervisor, home_deg: float | None, line: str) -> None:
        self.name = axis.name
        self.line = line
        self.limits_deg = axis.limits_deg
        self.increment_deg = axis.increment_deg
        self.speed_dps = axis.speed_dps
        self.approach_deg = axis.approach_deg
        self.arrival_tolerance_deg = axis.arrival_tolerance_deg
        self.wrap_turns: float | None = None
        self.is_silent = False
        """Its last look failed."""
        self._axis: Any = axis
        self._clock = clock
        self._supervisor = supervisor
        self._home_deg = home_deg
        self._declared = Bounds(axis.limits_deg, axis.speed_dps, axis.arrival_tolerance_deg, home_deg or 0.0)
        self._bounds = self._declared
        """The same with what is known of its home."""
        self._watched = Watched()
        self._broken_off: Moving | None = None
        """The move that the last stop broke off, until another order is given."""
        self._orders = 0
        """Counts what the axis was told: a look that an order overtook is not judged."""
        self._others_due_s = 0.0
        self._turn = RLock()
        watched = (self._start_rate, self._start_sweep, self._turn_look, self._arm_watchdog)
        give_abilities(self, axis, {member.__name__.removeprefix("_"): member for member in watched})

    @property
    def task(self) -> Task:
        return self._watched.task

    @property
    def is_under_way(self) -> bool:
        return isinstance(self._watched.task, _UNDER_WAY)

    @property
    def may_move(self) -> bool:
        return isinstance(self._watched.task, (*_UNDER_WAY, Stopping))

    @property
    def home_doubt(self) -> str:
        """Why the home search that ended just now has to be seen twice; empty where it has not."""
        return self._watched.task.doubt if isinstance(self._watched.task, Standing) else ""

    def is_to_be_seen(self, *, only_unknown: bool) -> bool:
        """Return whether it should stand while another one moves, and answers."""
        wanted = (Unknown, Stopping) if only_unknown else (Unknown, Stopping, Standing)
        return isinstance(self._watched.task, wanted) and not self.is_silent

    def identify(self) -> str:
        return str(self._axis.identify())

    def check_target(self, target_deg: float) -> None:
        self._axis.check_target(target_deg)

    def start_move(self, target_deg: float) -> None:
        """As of the axis. Raises also: MotionBreach."""
        self._axis.check_target(target_deg)
        self._before_start(target_deg)
        # Expected before it is sent: a start that raises may have been heard, and only what is under way is stopped.
        self._expect(expecting_move(self._watched, target_deg, self.speed_dps), f"move to {target_deg:g}°")
        self._start(lambda: self._axis.start_move(target_deg), target_deg)

    def home(self) -> None:
        """As of the axis. Raises also: MotionBreach."""
        require_home_inside(self, self._home_deg)
        try:  # whether it stands, and has a zero that may not move
            self.look(must_stand=True)
        except MotionBreach:
            raise
        except RigError:
            pass  # one in alarm is homed all the same
        if self._home_deg is None:  # it goes on being held to where it stands
            self._axis.home()
            require_inside(self, self.look())
            return
        self._supervisor.look_at_others(self, only_unknown=True)
        self._supervisor.expect_motion(self, self._way(self._home_deg))
        self._expect(expecting_home(self._watched), "search its home")
        self._start(self._axis.home)

    def stop(self) -> None:
        """As of the axis."""
        with self._turn:
            self._orders += 1
            self._broken_off = broken_off(self._watched, self._clock.monotonic_s()) or self._broken_off
            self._watched = expecting_stop(self._watched)
        self._axis.stop()

    def stop_by_guard(self) -> bool:
        """Have this axis and every other one stopped by the stop guard, which needs no memory of this process."""
        return self._supervisor.stop_by_guard()

    def run_on_deg(self, stands_deg: float) -> float:
        """Return how far it went on after it was told to stop, to where it was sent; 0 where it did not."""
        return 0.0 if self._broken_off is None else run_on_deg(self._broken_off, stands_deg, self.arrival_tolerance_deg)

    def state(self) -> AxisState:
        """Look, as of the axis.

        Raises also: MotionBreach, where it or an axis that should stand does what it was not told; then it was told
        to stop.
        """
        was_under_way = self.is_under_way
        state = self.look()
        # Who sets an axis by hand may take hours: the others stand meanwhile.
        if was_under_way or state.awaits_operator:
            self._look_at_others_now_and_then()
        return state

    def look(self, *, must_stand: bool = False) -> AxisState:
        """Look at this axis alone. ``must_stand``: as of :func:`judge`. Raises as :meth:`state`."""

        def ask() -> tuple[AxisState, Seen | None]:
            sent_s = self._clock.monotonic_s()
            state: AxisState = self._axis.state()
            self.is_silent = False
            if state.fault or state.awaits_operator:
                return state, None
            return state, Seen.of(state, sent_s, self._clock.monotonic_s())

        return self._judged(ask, must_stand=must_stand)

    def _turn_look(self, clock: Clock) -> TurnLook:
        def ask() -> tuple[TurnLook, Seen | None]:
            look: TurnLook = self._axis.turn_look(clock)
            return look, Seen(look.angle_deg, look.taken_s - look.uncertainty_s, look.taken_s + look.uncertainty_s)

        look = self._judged(ask)
        self._look_at_others_now_and_then()
        return look

    def _start_rate(self, rate_dps: float) -> None:
        self._axis.check_rate(rate_dps)
        self._before_start()
        self._expect(expecting_turn(self._watched, rate_dps), f"turn at {rate_dps:g} °/s", is_turn=True)
        self._start(lambda: self._axis.start_rate(rate_dps))

    def _start_sweep(self, target_deg: float, rate_dps: float) -> None:
        self._axis.check_target(target_deg)
        self._before_start(target_deg)
        task = f"move to {target_deg:g}° at {abs(rate_dps):g} °/s"
        self._expect(expecting_move(self._watched, target_deg, abs(rate_dps)), task)
        self._start(lambda: self._axis.start_sweep(target_deg, rate_dps), target_deg)

    def _arm_watchdog(self, wait: Wait) -> str:
        """Positions may be lost by it, and servos may go to their homes, all of one controller."""
        unknown = Watched(Unknown(may_move=True))
        self._expect(unknown, "prove its watchdog, which may send it elsewhere")
        outcome: str = self._axis.arm_watchdog(wait)
        for axis in self._supervisor.on_line_of(self):
            axis._expect(unknown)
        return outcome

    def _judged(self, ask: Callable[[], tuple[Answer, Seen | None]], *, must_stand: bool = False) -> Answer:
        """Ask, and where the answer breaks what is expected, once more.

        A digit that the line turned over is no motion.
        """
        self._supervisor.beat(self)
        breach = ""
        for _ in range(2):
            orders = self._orders
            answer, seen = ask()
            with self._turn:
                # An order went out while the answer was on its way: it may be of before or of after.
                if orders != self._orders:
                    return answer
                if seen is None:
                    watched, breach = unseen(self._watched), ""
                else:
                    watched, breach = judge(self._bounds, self._watched, seen, must_stand=must_stand)
                if not breach:
                    if isinstance(self._watched.task, Homing) and isinstance(watched.task, Standing):
                        self._bounds = after_home(self._bounds, watched.task.at_deg)
                    self._watched = watched
                    self._remember(seen)
                    return answer
        # A search that went wrong leaves no zero: what was known of the home is not known now.
        if isinstance(self._watched.task, Homing):
            self._bounds = self._declared
        self._expect(Watched())
        self._remember(seen)
        raise self._supervisor.refuse(self, breach)

    def _start(self, send: Callable[[], object], target_deg: float | None = None) -> None:
        """Where a start is not acknowledged, another axis may have heard it, or this one may hear it yet."""
        memory = self._supervisor.memory
        memory.awaits_answer(self.name, self._clock.now_utc(), target_deg, self._bounds.standing_deg)
        try:
            send()
        except RequestRefused:
            memory.withdrawn(self.name)
            raise
        except DeviceRefused:
            memory.answered(self.name)
            raise
        except RigError:
            with suppress(DeviceSilent, LinkLost):
                self._supervisor.look_at_others(self)
            raise
        if not self._supervisor.is_stopped_past_us():
            memory.answered(self.name)

    def _way(self, target_deg: float | None) -> tuple[int, int] | None:
        is_led = target_deg is not None and isinstance(self._axis, AimedStop)
        return self._axis.stop_way(target_deg) if is_led else None

    def _before_start(self, target_deg: float | None = None) -> None:
        """Where it starts from must be known, and where the others stand."""
        if isinstance(self._watched.task, Unknown | Stopping):
            self.look(must_stand=True)
        self._supervisor.look_at_others(self, only_unknown=True)
        # Last: a look may wait for a silent line, and who asked for a stop meanwhile is heeded before a byte goes.
        self._supervisor.expect_motion(self, self._way(target_deg))

    def _remember(self, seen: Seen | None) -> None:
        """Note a look for who has to know of it when no further one is possible."""
        if seen is not None and seen.is_known:
            at_rest = isinstance(self._watched.task, Standing)
            now_utc, is_moving = self._clock.now_utc(), bool(seen.is_moving)
            self._supervisor.memory.saw(self.name, seen.position_deg, now_utc, is_at_rest=at_rest, is_moving=is_moving)

    def _expect(self, watched: Watched, order: str = "", *, is_turn: bool = False) -> None:
        """``order``: what may move the axis and is about to be sent, for a sentence."""
        with self._turn:
            self._orders += 1
            self._watched, self._broken_off = watched, None
            if order:
                self._supervisor.memory.sent(self.name, order, is_turn=is_turn)
            # The new order may have reached another axis: all are looked at with the next look.
            self._others_due_s = 0.0

    def _look_at_others_now_and_then(self) -> None:
        now_s = self._clock.monotonic_s()
        if now_s >= self._others_due_s:
            self._others_due_s = now_s + OTHERS_S
            self._supervisor.look_at_others(self)
