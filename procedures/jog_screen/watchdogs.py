"""Watchdogs of the machines that turn, while the jog screen is open: what stops them when this computer itself dies.

Every lease ends with the process that keeps it. So an axis that turns and has ``watchdog_s`` is proven to notice a
silent host before anything may move; the looks of the bench are what it hears from then on.
"""

from collections.abc import Callable

from rig.abilities.abilities import Wait, Watchdog
from rig.assembly.open_rig import Rig
from rig.clock import WAIT_SLICE_S
from rig.errors import RigError, WaitEnded
from rig.motion import jog

LEAST_S = 1.0
"""Machine seconds: looks are several times as frequent."""


class TurningWatchdogs:
    """``tell`` hears what stops each turning axis, and what does not."""

    def __init__(self, rig: Rig, tell: Callable[[str], None]) -> None:
        self._rig = rig
        self._tell = tell
        self._armed: list[str] = []

    def arm(self, wait: Wait) -> None:
        """Arm the watchdog of every axis that turns. Nothing may speak meanwhile. Raises: WaitEnded."""
        for name, axis in self._rig.axes.items():
            if jog.top_rate_dps(self._rig, name) > 0.0:
                self._tell(f"{name}: {self._armed_by(name, axis, wait)}")

    def disarm(self) -> None:
        """Disarm the watchdogs of axes that stand; one that does not answer will report a silence.

        Homing resets it.
        """
        for name in self._armed:
            axis = self._rig.axes[name]
            try:
                axis.disarm_watchdog()  # type: ignore[attr-defined]
            except RigError as error:
                self._tell(f"{name}: its watchdog could not be let go: {error}")
        self._armed.clear()

    def _armed_by(self, name: str, axis: object, wait: Wait) -> str:
        """Arm the watchdog of an axis and return, in words, what stops it."""
        pace = self._rig.clock.slice_s / WAIT_SLICE_S
        if not isinstance(axis, Watchdog) or axis.watchdog_s is None:
            return "no watchdog (axes: watchdog_s): it turns on if this computer dies"
        if axis.watchdog_s / pace < LEAST_S:
            return f"its watchdog of {axis.watchdog_s:g} s is too short at {pace:g} times real time: not armed"
        try:
            outcome = axis.arm_watchdog(wait)
        except WaitEnded:
            raise
        except RigError as error:
            return f"its watchdog is not armed: {error}"
        self._armed.append(name)
        return outcome
