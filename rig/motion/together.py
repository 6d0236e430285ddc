"""Axes on their way at the same time, where the rig file declares that they cannot meet.

Each goes its way as :func:`rig.motion.move.move_and_arrive` takes it, behind the supervisor, which watches the corridor
of every one. Whatever stops one stops all. What then may be tried again is tried one axis after the other: a stall may
be an obstacle, and that one of the axes is it is not excluded.
"""

from collections.abc import Collection, Mapping
from functools import partial

from rig.abilities.abilities import Axis, AxisState, Wait
from rig.clock import Clock
from rig.motion.move import Missed, Stalled, Tell, admitted, go_back_and_try_again, go_once, move_and_arrive, stop_all
from rig.side_by_side import side_by_side


def move_all(
    axes: Mapping[str, Axis],
    targets_deg: Mapping[str, float],
    together: Collection[str],
    clock: Clock,
    wait: Wait,
    tell: Tell = lambda _text: None,
) -> dict[str, float]:
    """Bring every axis to rest at its target and return the read-backs, degrees, in the order of the targets.

    Those that are named ``together`` go first and at once, the others then one after the other, in the order given.
    Raises as :func:`rig.motion.move.move_and_arrive`; no axis is then on its way.
    """
    beside = {name: target_deg for name, target_deg in targets_deg.items() if name in together}
    arrived = _move_at_once(axes, beside, clock, wait, tell) if len(beside) > 1 else {}
    for name, target_deg in targets_deg.items():
        if name not in arrived:
            arrived[name] = move_and_arrive(axes[name], target_deg, clock, wait, tell)
    return {name: arrived[name] for name in targets_deg}


def _move_at_once(
    axes: Mapping[str, Axis], targets_deg: Mapping[str, float], clock: Clock, wait: Wait, tell: Tell
) -> dict[str, float]:
    """Move them at once; nothing moves unless every one may. What stalls or misses is seen to alone, behind a stop."""
    start = {name: admitted(axes[name], target_deg) for name, target_deg in targets_deg.items()}
    stalls: dict[str, Stalled] = {}

    def go(name: str, state: AxisState, wait_beside: Wait) -> float:
        try:
            return go_once(axes[name], targets_deg[name], state, clock, wait_beside)
        except Stalled as stall:
            stalls[name] = stall
            raise

    try:
        return side_by_side({name: partial(go, name, state) for name, state in start.items()}, clock, wait)
    except (Stalled, Missed) as trouble:
        stop_all({name: axes[name] for name in targets_deg}, clock)
        tell(f"{trouble}; the axes that moved with it were stopped too, and each goes on alone")
    found = {
        name: go_back_and_try_again(axes[name], targets_deg[name], start[name].position_deg, stall, clock, wait, tell)
        for name, stall in stalls.items()
    }
    others = {name: target_deg for name, target_deg in targets_deg.items() if name not in found}
    return found | {
        name: move_and_arrive(axes[name], target_deg, clock, wait, tell) for name, target_deg in others.items()
    }
