"""What moves when lines were just opened is stopped and told, before anything is asked of it.

Whoever had the rig before may have left an axis turning: a process or a computer that died, another program, a command
that reached its machine late. Its reference move might not be heard while it turns, and another axis would be led past
it. The machine's own word is not enough, since some have none for a rotation: two looks are compared.
"""

from collections.abc import Mapping

from rig.abilities.abilities import Axis, AxisState
from rig.abilities.rest import band_deg
from rig.clock import Clock
from rig.errors import MotionBreach, RigError
from rig.motion.expectation import MARGIN_DEG, STANDING_TOLERANCES
from rig.motion.motion_memory import KnownMotion, MotionMemory
from rig.motion.move import stop_all

BETWEEN_LOOKS_S = 0.5


def stop_what_moves(axes: Mapping[str, Axis], clock: Clock, memory: MotionMemory) -> list[str]:
    """Stop every axis that moves, see it stand, and return a sentence for each, and for each that is not where it was.

    ``memory``: of the connection before. An axis that does not answer, or waits for its operator, is left alone.
    Raises: MotionBreach where one moved outside its limits, DeviceFault where one goes on; all were told to stop.
    """
    left = {name: memory.known(name) for name in axes}
    first = _states(axes)
    _let_pass(BETWEEN_LOOKS_S, clock)
    seen = {name: (state, first.get(name, state)) for name, state in _states(axes).items()}
    moving = {name: state for name, (state, before) in seen.items() if _moves(axes[name], state, before)}
    if not moving:
        return _displaced(axes, {name: state for name, (state, _) in seen.items()}, left)
    stop_all({name: axes[name] for name in moving}, clock)
    at_rest = _states(axes)
    sentences = [_stopped(name, at_rest.get(name, state), left[name]) for name, state in moving.items()]
    if outside := [name for name, state in moving.items() if _is_outside(axes[name], state, left[name])]:
        allowed = "; ".join(_allowed(axes[name], moving[name]) for name in outside)
        raise MotionBreach(
            f"{'; '.join(sentences)}; {allowed}; see who or what moved it and what was wound up, then home it"
        )
    resting = {name: state for name, state in at_rest.items() if name not in moving}
    return [*sentences, *_displaced(axes, resting, left)]


def _states(axes: Mapping[str, Axis]) -> dict[str, AxisState]:
    """Return the state of every axis that answers and waits for no operator."""
    found = {}
    for name, axis in axes.items():
        try:
            state = axis.state()
        except MotionBreach:
            raise
        except RigError:
            continue  # whoever needs it meets the same, and tells of it
        if not state.awaits_operator:
            found[name] = state
    return found


def _let_pass(duration_s: float, clock: Clock) -> None:
    ends_s = clock.monotonic_s() + duration_s
    while (left_s := ends_s - clock.monotonic_s()) > 0.0:
        clock.sleep(min(left_s, clock.slice_s))


def _moves(axis: Axis, state: AxisState, before: AxisState) -> bool:
    if state.unknown:  # a servo that lost its pulse went nowhere that anybody could say
        return state.is_moving
    return state.is_moving or abs(state.position_deg - before.position_deg) > band_deg(axis.arrival_tolerance_deg)


def _is_outside(axis: Axis, state: AxisState, left: KnownMotion) -> bool:
    """Return whether it moved where nothing of ours leads it. A rate that was ours may; without a home nobody knows."""
    return state.is_homed and not is_inside(axis, state.position_deg) and not left.is_turn


def is_inside(axis: Axis, position_deg: float) -> bool:
    """Return whether an axis is inside its limits, or so little beyond them as one that settles there."""
    low_deg, high_deg = axis.limits_deg
    margin_deg = MARGIN_DEG + axis.arrival_tolerance_deg
    return low_deg - margin_deg <= position_deg <= high_deg + margin_deg


def _stopped(name: str, state: AxisState, left: KnownMotion) -> str:
    before = f" (it had been told to {left.may_be_moved_by} before)" if left.may_be_moved_by else ""
    at_rest = state.unknown or f"at rest at {state.position_deg:g}°"
    return f"{name}: moves, though nothing told it to{before}: stopped, {at_rest}"


def _allowed(axis: Axis, state: AxisState) -> str:
    low_deg, high_deg = axis.limits_deg
    limits = f"allowed {low_deg:g} to {high_deg:g}° (axes.{axis.name}: limits_deg)"
    return f"{axis.name} moved outside its limits: at {state.position_deg:g}°, {limits}"


def _displaced(
    axes: Mapping[str, Axis], at_rest: Mapping[str, AxisState], left: Mapping[str, KnownMotion]
) -> list[str]:
    return [sentence for name, state in at_rest.items() if (sentence := _displacement(axes[name], state, left[name]))]


def _displacement(axis: Axis, state: AxisState, left: KnownMotion) -> str:
    within_deg = STANDING_TOLERANCES * axis.arrival_tolerance_deg
    if not left.is_at_rest or left.at_deg is None:
        return ""
    if state.unknown:
        return f"{axis.name}: left at rest at {left.at_deg:g}°; now {state.unknown}"
    if abs(state.position_deg - left.at_deg) <= within_deg:
        return ""
    return (
        f"{axis.name}: left at rest at {left.at_deg:g}°, it reads {state.position_deg:g}° now, allowed within"
        f" {within_deg:g}°: it was moved while nobody could see it, or its machine lost its count"
    )
