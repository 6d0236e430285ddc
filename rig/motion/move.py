"""Move and arrive: the one way in which an axis is moved, by the engine and by hand.

Absolute targets only, checked before anything is sent; arrival is judged by the machine's own read-back and its
coupling, never by the command; time is bounded, a stall noticed, and a stop that is asked for stops the axis first.

A move that stalls is tried once more from where it came from; a coupling that does not seat, or rests elsewhere, is
approached anew from beside, at most twice: whoever asked is told of each, and only then it is a fault.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Protocol, runtime_checkable

from rig.abilities.abilities import Axis, AxisState, Wait
from rig.abilities.rest import RestLook, moves_on, stands, unrest_in_words
from rig.abilities.starting import TAKEN_UP_S
from rig.cables.cable import CableGuard
from rig.clock import Clock
from rig.crash_points import CrashPoint, crash_point
from rig.defects import defect_text
from rig.errors import DeviceFault, DeviceNonsense, DeviceSilent, NoStop, RequestRefused, RigError, WaitEnded
from rig.motion.last_resort import BY_GUARD, stop_past_a_defect
from rig.threads import at_once

STALL_S = 2.0
"""Rig seconds without progress after which an axis that says it moves is stalled."""
_FIRST_LOOK_S, _LAST_LOOK_S = 0.1, 0.5
_LONGEST_LOOK_S = 0.8
"""Between two looks at an axis on its way: what it reports is answered within a second. The first looks come sooner,
since a command that the line altered shows at once, and so do those at the target, where one would pass it."""
_ALLOWANCE_S = 5.0
_STOP_LIMIT_S = 20.0
_STOP_AGAIN_S = 1.0
_AGAIN = 2
_BESIDE_DEG = 1.0
"""From so far away a machine without teeth approaches anew."""

Tell = Callable[[str], None]


@runtime_checkable
class DoubtsHome(Protocol):
    """An axis that somebody watches who knows where a home search has to end."""

    @property
    def home_doubt(self) -> str:
        """Why the search that ended just now has to be seen twice; empty where it has not."""


@runtime_checkable
class KnowsItsWay(Protocol):
    """An axis that somebody watches who knows where it was sent when it was told to stop."""

    def run_on_deg(self, stands_deg: float) -> float:
        """Return how far it went on after it was told to stop, to where it was sent; 0 where it did not."""


class Stalled(DeviceFault):
    """No progress, or not in time; the axis was told to stop."""


class NotSeenAtRest(DeviceFault):
    """Not every axis is known to stand still after it was told to stop; ``faults``: what failed, by axis."""

    def __init__(self, message: str, faults: str = "") -> None:
        super().__init__(message)
        self.faults = faults


class Missed(DeviceFault):
    """At rest, but lifted, or not where it was sent."""


def move_and_arrive(axis: Axis, target_deg: float, clock: Clock, wait: Wait, tell: Tell = lambda _text: None) -> float:
    """Bring an axis to rest at ``target_deg`` and return its read-back, degrees.

    An axis that is there already, by read-back and seated, is not moved, unless it must be approached from one side.
    ``tell`` hears why a move is made again.
    Raises: RequestRefused (outside limits, off the increment, not homed, before anything moved), DeviceFault (stalled
    twice, not where it was sent, not seated in three attempts; the axis was stopped), WaitEnded (the axis was stopped).
    """
    state = admitted(axis, target_deg)
    if _needs_no_move(axis, state, target_deg):
        return state.position_deg
    try:
        return _approach_until_there(axis, target_deg, state, clock, wait, tell)
    except Stalled as stall:
        return go_back_and_try_again(axis, target_deg, state.position_deg, stall, clock, wait, tell)


def admitted(axis: Axis, target_deg: float) -> AxisState:
    """Return the state of an axis that may be sent to a target. Raises: RequestRefused, DeviceFault; nothing moved."""
    axis.check_target(target_deg)
    axis.check_target(target_deg + axis.approach_deg)
    return trusted_state(axis)


def go_once(axis: Axis, target_deg: float, state: AxisState, clock: Clock, wait: Wait) -> float:
    """Move an admitted axis where it must be moved, and return its read-back at the target, degrees.

    Raises: Stalled and Missed, which may be tried again; DeviceFault, WaitEnded. The axis was stopped.
    """
    if _needs_no_move(axis, state, target_deg):
        return state.position_deg
    return _approach(axis, target_deg, state, clock, wait)


def go_back_and_try_again(
    axis: Axis, target_deg: float, from_deg: float, stall: DeviceFault, clock: Clock, wait: Wait, tell: Tell
) -> float:
    """Move once more after a stall, from where the axis came. Raises: DeviceFault where it stalls again, WaitEnded."""
    state = _retreat(axis, from_deg, stall, clock, wait)
    tell(f"{stall}; it went back to {state.position_deg:g}° and is tried once more")
    try:
        return _approach_until_there(axis, target_deg, state, clock, wait, tell)
    except Stalled as again:
        raise DeviceFault(f"{again}; it stalled twice") from again


def _needs_no_move(axis: Axis, state: AxisState, target_deg: float) -> bool:
    return axis.approach_deg == 0.0 and _has_arrived(axis, state, target_deg)


def _approach_until_there(
    axis: Axis, target_deg: float, state: AxisState, clock: Clock, wait: Wait, tell: Tell
) -> float:
    """Move, and again from beside where the move does not end at rest, seated and on the target."""
    for left in reversed(range(_AGAIN + 1)):
        try:
            return _approach(axis, target_deg, state, clock, wait)
        except Missed as missed:
            beside_deg = _beside(axis, target_deg)
            if left == 0 or beside_deg is None:
                raise
            tell(f"{missed}; it is approached anew from {beside_deg:g}°")
            # It may rest anywhere: a start that the line swallowed leaves it where it was, far from its target.
            state = _lift_to(axis, beside_deg, _state_or_stop(axis).position_deg, clock, wait)
    raise AssertionError("unreachable: the last attempt returns or raises")


def _approach(axis: Axis, target_deg: float, state: AxisState, clock: Clock, wait: Wait) -> float:
    if axis.approach_deg != 0.0:
        state = _go(axis, target_deg + axis.approach_deg, state.position_deg, clock, wait)
    return _go(axis, target_deg, state.position_deg, clock, wait).position_deg


def _retreat(axis: Axis, from_deg: float, stall: DeviceFault, clock: Clock, wait: Wait) -> AxisState:
    """Move back to where the stalled move came from. Raises: DeviceFault where that is not possible."""
    try:
        _see_standstill(axis, clock, _STOP_LIMIT_S)
    except DeviceFault as moving:
        raise DeviceFault(f"{stall}; {moving}") from stall
    state = axis.state()
    if state.fault or not state.is_homed:
        raise DeviceFault(f"{stall}; it cannot be tried again: {state.fault or 'the home is lost'}") from stall
    if abs(state.position_deg - from_deg) <= axis.arrival_tolerance_deg:
        return state
    try:
        return _lift_to(axis, from_deg, state.position_deg, clock, wait)
    except Stalled as again:
        raise DeviceFault(f"{stall}; nor could it go back: {again}") from again


def _beside(axis: Axis, target_deg: float) -> float | None:
    """Return the next tooth inside the limits; None where there is no room."""
    by_deg = axis.increment_deg or _BESIDE_DEG
    for stand_deg in (target_deg - by_deg, target_deg + by_deg):
        with suppress(RequestRefused):
            axis.check_target(stand_deg)
            return stand_deg
    return None


def _lift_to(axis: Axis, stand_deg: float, from_deg: float, clock: Clock, wait: Wait) -> AxisState:
    """Move to a place; whether the axis seats there does not matter: nothing is measured."""
    axis.check_target(stand_deg)
    axis.start_move(stand_deg)
    limit_s = abs(stand_deg - from_deg) / axis.speed_dps * 1.5 + _ALLOWANCE_S
    return _watch(axis, f"move to {stand_deg:g}°", stand_deg, limit_s, clock, wait)


def trusted_state(axis: Axis) -> AxisState:
    """Return the state of an axis that may be moved. Raises: RequestRefused, DeviceFault."""
    state = axis.state()
    if state.fault:
        raise DeviceFault(f"{axis.name}: {state.fault}; nothing moved; clear it at the machine")
    if not state.is_homed:
        raise RequestRefused(
            f"{axis.name}: the axis is not homed, so its position is not known; nothing moved; home it first"
        )
    if state.is_moving:
        raise RequestRefused(f"{axis.name}: the axis is moving already; no further move was started; stop it or wait")
    return state


def home_and_arrive(axis: Axis, clock: Clock, wait: Wait, tell: Tell = lambda _text: None) -> float:
    """Run the reference move and return the read-back at rest, degrees. Raises as :func:`move_and_arrive`.

    Where its end is doubted it is made twice, and has to end at the same place; ``tell`` hears why.
    """
    state = _search_home(axis, clock, wait)
    if doubt := _home_doubt(axis):
        tell(f"{axis.name}: home: {doubt}; it is searched once more and has to end at the same place")
        state = _search_home(axis, clock, wait)
        if doubt := _home_doubt(axis):
            raise DeviceFault(f"{axis.name}: home: {doubt}, for the second time; check the machine, then home it")
    return state.position_deg


def _home_doubt(axis: Axis) -> str:
    return axis.home_doubt if isinstance(axis, DoubtsHome) else ""


def _search_home(axis: Axis, clock: Clock, wait: Wait) -> AxisState:
    try:
        axis.home()
    except RigError:
        with suppress(RigError):
            axis.stop()  # it may have heard what it did not acknowledge
        raise
    wound_deg = axis.home_travel_deg if isinstance(axis, CableGuard) else 0.0
    limit_s = (360.0 + wound_deg) / axis.speed_dps * 1.5 + _ALLOWANCE_S
    state = _watch(axis, "home", None, limit_s, clock, wait)
    if axis.state().is_moving:  # one word of the machine ended it, which the line may have damaged
        state = _watch(axis, "home", None, limit_s, clock, wait)
    if not state.is_homed:
        raise DeviceFault(
            f"{axis.name}: home: the axis came to rest without a home; look for what stopped it, then home again"
        )
    _require_seat(axis, state, "home")
    return state


def stop_all(axes: Mapping[str, Axis], clock: Clock, limit_s: float = _STOP_LIMIT_S) -> None:
    """Stop every axis at once and see them stand still, a second at least; a failing axis keeps no other from its stop.

    One that goes on moving is told again every second: a start that was late, or came twice, undoes a stop. On the way
    out of a defect, or without memory, the stop guard is asked first (:mod:`rig.motion.last_resort`).
    Raises: DeviceFault naming every axis that could not be stopped, still moves, or went on to where it was sent.
    """
    by_guard = BY_GUARD if stop_past_a_defect(axes) else ""
    failures, ran_on = dict[str, str](), dict[str, str]()
    stops = [partial(_stop_axis, axis, clock, limit_s, failures, ran_on) for axis in axes.values()]
    within_s = limit_s + _ALLOWANCE_S
    for name, is_done in zip(axes, at_once(stops, within_s, "the stop of an axis"), strict=True):
        if not is_done:
            failures[name] = f"no answer within {within_s:g} s, or no memory to ask for one"
    if what_failed := {**ran_on, **failures}:
        failed: dict[str, list[str]] = {}
        for name in sorted(what_failed):  # axes on one line fail alike: that is told once
            failed.setdefault(what_failed[name], []).append(name)
        faults = "; ".join(f"{' and '.join(names)}: {failure}" for failure, names in failed.items())
        what = "not every axis is known to stand still" if failures else "not every axis obeyed it"
        sentence = f"stop: {what}: {faults}{by_guard}; use the stop button at the machine"
        raise NotSeenAtRest(sentence, faults) if failures else DeviceFault(sentence)


def _stop_axis(axis: Axis, clock: Clock, limit_s: float, failures: dict[str, str], ran_on: dict[str, str]) -> None:
    """``failures``: of axes that may not stand; ``ran_on``: of those that stand where they were sent all the same."""
    try:
        with suppress(NoStop):  # it may stand all the same; where it goes on, it is refused again there
            axis.stop()
        stands_deg = _see_standstill(axis, clock, limit_s)
        if isinstance(axis, KnowsItsWay) and (run_on_deg := axis.run_on_deg(stands_deg)):
            ran_on[axis.name] = (
                f"went on for {run_on_deg:.3g}° after it was told to stop, to {stands_deg:g}°, where it was sent:"
                " stops do not reach it, or it does not obey them"
            )
    except RigError as error:
        failures[axis.name] = str(error)
    except MemoryError:  # whose defect that is would take memory to find out
        failures[axis.name] = "no memory was left to see it stand"
    except Exception as error:  # noqa: BLE001  the rim of a thread: a defect of a driver is told like any failure
        failures[axis.name] = defect_text(error)


def _see_standstill(axis: Axis, clock: Clock, limit_s: float) -> float:
    """See an axis rest that was told to stop (:mod:`rig.abilities.rest`); return where, degrees.

    Its machine's word that it rests is not enough, since some say so of a rotation: what its read-back shows to go on
    is told again as well.
    """
    started_s = stop_sent_s = clock.monotonic_s()
    looks: list[RestLook] = []
    while True:
        state = axis.state()
        now_s = clock.monotonic_s()
        look = RestLook(state.position_deg, now_s)
        looks = [look] if state.is_moving else [*looks, look]
        if stands(looks, axis.arrival_tolerance_deg):
            return state.position_deg
        if now_s - started_s > limit_s:
            unrest = unrest_in_words(looks, axis.name, axis.arrival_tolerance_deg)
            raise DeviceFault(f"still moving at {state.position_deg:g}°, {limit_s:g} s after the stop{unrest}")
        goes_on = state.is_moving or moves_on(looks, axis.arrival_tolerance_deg)
        if goes_on and now_s - stop_sent_s >= _STOP_AGAIN_S:
            axis.stop()
            stop_sent_s = clock.monotonic_s()
        clock.sleep(min(_FIRST_LOOK_S, clock.slice_s))


def _go(axis: Axis, target_deg: float, from_deg: float, clock: Clock, wait: Wait) -> AxisState:
    task = f"move to {target_deg:g}°"
    _start(axis, target_deg)
    crash_point(CrashPoint.MOVE_SENT)
    limit_s = abs(target_deg - from_deg) / axis.speed_dps * 1.5 + _ALLOWANCE_S
    state = _watch(axis, task, target_deg, limit_s, clock, wait)
    _require_seat(axis, state, task)
    if not _has_arrived(axis, state, target_deg):
        raise Missed(
            f"{axis.name}: {task}: the axis came to rest at {state.position_deg:g}°, allowed within"
            f" {axis.arrival_tolerance_deg:g}° (axes.{axis.name}: arrival_tolerance_deg);"
            " it stands still; check the machine, then home it"
        )
    return state


def _watch(axis: Axis, task: str, target_deg: float | None, limit_s: float, clock: Clock, wait: Wait) -> AxisState:
    """Look until the axis is at rest; stop it when it stalls, takes too long, is at fault or a stop was asked for.

    At rest away from its target just after the start, it may not have taken it up: controllers tell of it late.
    """
    started_s = progressed_s = clock.monotonic_s()
    look_s, last_deg = _FIRST_LOOK_S, None
    while True:
        sent_s = clock.monotonic_s()  # before the question: a slow answer is no lack of progress
        state = _state_or_stop(axis)
        if state.fault:
            raise _stopped(axis, f"{task}: {state.fault}")
        if not state.is_moving and (
            target_deg is None or _has_arrived(axis, state, target_deg) or sent_s - started_s >= TAKEN_UP_S
        ):
            return state
        if state.awaits_operator:
            started_s = progressed_s = clock.monotonic_s()
            _wait_or_stop(axis, _FIRST_LOOK_S, wait)
            continue
        if state.position_deg != last_deg:
            last_deg, progressed_s = state.position_deg, clock.monotonic_s()
        elif sent_s - progressed_s >= STALL_S:
            raise _stalled(axis, f"{task}: no progress in {STALL_S:g} s at {last_deg:g}°, though it says it moves")
        if sent_s - started_s > limit_s:
            raise _stalled(axis, f"{task}: still moving at {last_deg:g}° after {limit_s:.3g} s, the time allowed")
        left_s = look_s if target_deg is None else abs(target_deg - state.position_deg) / axis.speed_dps
        _wait_or_stop(axis, min(max(left_s, _FIRST_LOOK_S), look_s), wait)
        look_s = min(2.0 * look_s, _LAST_LOOK_S if target_deg is None else _LONGEST_LOOK_S)


def _start(axis: Axis, target_deg: float) -> None:
    """Start a move; where the acknowledgement does not come, settle it by asking.

    The target is absolute, so what stands still where it stood never got it, and may be told again.
    """
    try:
        axis.start_move(target_deg)
    except (DeviceSilent, DeviceNonsense):
        state = _state_or_stop(axis)
        if not state.is_moving and not _has_arrived(axis, state, target_deg):
            axis.start_move(target_deg)


def _state_or_stop(axis: Axis) -> AxisState:
    """Return the state of a moving axis; where it cannot be had, stop the axis before that is passed on."""
    try:
        return axis.state()
    except RigError:
        with suppress(RigError):
            axis.stop()
        raise


def _wait_or_stop(axis: Axis, duration_s: float, wait: Wait) -> None:
    try:
        wait(duration_s)
    except WaitEnded:
        axis.stop()
        raise


def _stopped(axis: Axis, what: str) -> DeviceFault:
    axis.stop()
    return DeviceFault(f"{axis.name}: {what}; the axis was told to stop; check the machine, then home it")


def _stalled(axis: Axis, what: str) -> DeviceFault:
    return Stalled(str(_stopped(axis, what)))


def _has_arrived(axis: Axis, state: AxisState, target_deg: float) -> bool:
    at_rest = state.is_seated and state.is_homed and not state.is_moving and not state.fault
    return at_rest and abs(state.position_deg - target_deg) <= axis.arrival_tolerance_deg


def _require_seat(axis: Axis, state: AxisState, task: str) -> None:
    if not state.is_seated:
        raise Missed(
            f"{axis.name}: {task}: at rest at {state.position_deg:g}°, but the coupling is not seated and locked;"
            " nothing can be measured here; check the coupling, then home it"
        )
