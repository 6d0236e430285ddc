"""An axis that turns at a rate on a line that broke: it turns on until somebody reaches it again.

A move ends at its target by itself. What turns ends by nothing but a stop, and an adapter that was unplugged, or a
connection that was reset, mostly is back within seconds.
"""

from collections.abc import Mapping
from typing import Protocol

from rig.abilities.abilities import Axis
from rig.clock import Clock
from rig.errors import LinkClosed, LinkLost, RigError
from rig.motion.motion_memory import MotionMemory

BACK_S, BETWEEN_OPENINGS_S = 30.0, 0.5
"""So long the line is waited for before people are told, and between two attempts to open it."""


class ReopenedRig(Protocol):
    """What is needed of :class:`rig.assembly.open_rig.Rig`."""

    @property
    def axes(self) -> Mapping[str, Axis]: ...
    @property
    def clock(self) -> Clock: ...
    @property
    def motion(self) -> MotionMemory: ...
    def reconnect(self) -> None: ...
    def sign_of_life(self) -> None: ...


def out_of_reach(rig: ReopenedRig) -> str:
    """Say of an axis that was told to turn, and was not seen at rest since, that its port is gone; else nothing."""
    for name, axis in rig.axes.items():
        try:
            if rig.motion.known(name).is_turn:
                axis.state()
        except (LinkLost, LinkClosed) as error:
            return str(error)
        except Exception:  # noqa: BLE001, S112  its stop has failed as well, and that is told
            continue
    return ""


def open_in_time(rig: ReopenedRig) -> str:
    """Open every line again until such an axis answers, within its time; return what failed to the last, or nothing."""
    until_s = rig.clock.monotonic_s() + BACK_S
    while failure := _opened(rig):
        if rig.clock.monotonic_s() >= until_s:
            return failure
        rig.sign_of_life()
        rig.clock.sleep(BETWEEN_OPENINGS_S)
    return ""


def unknown_behind(strangers: Mapping[str, str]) -> str:
    """Say that axes may turn, where other devices answered the stop than those that were told to turn."""
    return (
        f"not every axis is known to stand still: {'; '.join(strangers.values())}; use the stop button at the machine"
    )


def _opened(rig: ReopenedRig) -> str:
    try:
        rig.reconnect()
    except RigError as error:
        return str(error)
    return out_of_reach(rig)
