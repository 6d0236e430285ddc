"""An axis that turns at a rate on a line that broke: it turns on until somebody reaches it again.

A move ends at its target by itself. What turns ends by nothing but a stop, and an adapter that was unplugged, or a
connection that was reset, mostly is back within seconds. So a stop that does not reach it waits for its line.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol, TypeVar

from rig.abilities.abilities import Axis
from rig.clock import Clock
from rig.errors import DeviceFault, LinkClosed, LinkLost
from rig.motion.motion_memory import MotionMemory
from rig.motion.move import stop_all

BACK_S, BETWEEN_OPENINGS_S = 30.0, 0.5
"""So long the line is waited for before people are told, and between two attempts to open it."""
Stopped = TypeVar("Stopped")


class ReopenedRig(Protocol):
    """What is needed of :class:`rig.assembly.open_rig.Rig`."""

    @property
    def axes(self) -> Mapping[str, Axis]: ...
    @property
    def clock(self) -> Clock: ...
    @property
    def motion(self) -> MotionMemory: ...
    def open_lost(self, until_s: float) -> str: ...
    def stranger_axes(self, names: Iterable[str]) -> Mapping[str, str]: ...
    def sign_of_life(self) -> None: ...


@dataclass(frozen=True, slots=True)
class LostLine:
    """The line of an axis that turned, which was out when the axis was told to stop, and what came of it."""

    lost: str
    """What the port said."""
    turning: tuple[str, ...]
    """The axes that were told to turn, and were not seen at rest since."""
    waited_s: float
    unopened: str = ""
    """Why no such axis was reached in time; empty where all were."""


def stopped_in_reach(
    rig: ReopenedRig, stop: Callable[[str], Stopped], has_failed: Callable[[Stopped], bool], *, is_open: bool = True
) -> tuple[Stopped, LostLine | None]:
    """Stop; where that fails and an axis turns on a line that is out, wait until it is open again and stop once more.

    Nothing is asked before the first stop. ``stop``: gets why lines could not be opened, empty where they could.
    ``is_open``: False where lines were left closed: what fails then is tried once more over lines that are opened.
    Return what the last stop came to, and the line where one was waited for.
    """
    stopped = stop("")
    if not has_failed(stopped):
        return stopped, None
    if not (lost := out_of_reach(rig)):
        return (stopped if is_open else stop(rig.open_lost(rig.clock.monotonic_s() + BACK_S))), None
    turning, since_s = tuple(name for name in rig.axes if rig.motion.known(name).is_turn), rig.clock.monotonic_s()
    unopened = open_in_time(rig)
    waited_s = rig.clock.monotonic_s() - since_s
    return stop(unopened), LostLine(lost, turning, waited_s, unopened)


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
    """Open lost lines until every such axis can be reached, within their time; return what keeps one away, or nothing.

    Other lines that are lost are opened behind those of the axes, and keep none of them waiting.
    """
    until_s = rig.clock.monotonic_s() + BACK_S
    while True:
        failure = rig.open_lost(until_s)
        if not (lost := out_of_reach(rig)):
            return ""
        if rig.clock.monotonic_s() >= until_s:
            return failure or lost
        rig.sign_of_life()
        rig.clock.sleep(BETWEEN_OPENINGS_S)


def stop_known(rig: ReopenedRig, names: Iterable[str]) -> None:
    """Stop axes and see them stand, and that nobody else answered it. Raises: DeviceFault."""
    axes = {name: rig.axes[name] for name in names}
    stop_all(axes, rig.clock)
    if strangers := rig.stranger_axes(axes):
        raise DeviceFault(unknown_behind(strangers))


def unknown_behind(strangers: Mapping[str, str]) -> str:
    """Say that axes may turn, where other devices answered the stop than those that were told to turn."""
    return (
        f"not every axis is known to stand still: {'; '.join(strangers.values())}; use the stop button at the machine"
    )
