"""Watchdogs of the machines while a run lasts: proven before the axes are homed, fed at every look, let go at the end.

The journal says of every axis what stops it when this computer dies, and whether the stop guard can when only calrig
does; where nothing does, it says that.
"""

from collections.abc import Callable, Mapping
from math import inf

from procedures.run.dwell.measure import OpenRig
from rig.abilities.abilities import Wait, Watchdog
from rig.abilities.unstoppable import why_unstoppable
from rig.errors import DeviceFault, RigError

KIND = "watchdog"
FEEDS = 4.0
"""Times within a time-out that a machine is spoken to."""


class Watchdogs:
    """Of the axes of one rig. ``record`` journals an event."""

    def __init__(self, rig: OpenRig, record: Callable[[str, Mapping[str, object]], None]) -> None:
        self._rig = rig
        self._record = record
        self._armed: dict[str, Watchdog] = {}
        self._fed_s: dict[str, float] = {}

    def arm(self, wait: Wait) -> None:
        """Prove those that the rig file declares; nothing may move. Raises: DeviceFault, WaitEnded.

        Nobody is fed meanwhile: machines of one line may hear what is said to another, and one that notices the silence
        in which another is proven has what it lost put right by the home that follows.
        """
        self.forget()
        proven: dict[str, Watchdog] = {}
        for name, axis in self._rig.axes.items():
            if isinstance(axis, Watchdog) and axis.watchdog_s is not None:
                outcome = axis.arm_watchdog(wait)
                proven[name] = axis
            else:
                outcome = "no watchdog: a move that was started ends at its target, a rate goes on"
            outcome = "; ".join(filter(None, (outcome, why_unstoppable(axis, name))))
            self._record(KIND, {"axis": name, "is_armed": name in proven, "told": outcome})
        self._armed = proven

    def feed(self) -> float:
        """Speak to those that were not spoken to for a while; rig seconds until it must be done again.

        Raises: DeviceSilent, DeviceNonsense, LinkLost; DeviceFault where one is armed no more, which is recorded.
        """
        now_s, within_s = self._rig.clock.monotonic_s(), inf
        for name, axis in tuple(self._armed.items()):
            assert axis.watchdog_s is not None
            every_s = axis.watchdog_s / FEEDS
            if now_s - self._fed_s.get(name, -inf) >= every_s:
                self._fed_s[name] = now_s
                self._feed(name, axis)
            within_s = min(within_s, every_s)
        return within_s

    def _feed(self, name: str, axis: Watchdog) -> None:
        try:
            axis.feed_watchdog()
        except DeviceFault as error:
            del self._armed[name]
            self._record(KIND, {"axis": name, "is_armed": False, "told": str(error)})
            raise

    def forget(self) -> None:
        """Forget what is armed: the lines are gone, nobody can be fed, and the machines will stop by themselves."""
        self._armed.clear()
        self._fed_s.clear()

    def disarm(self) -> None:
        """Disarm the watchdogs of axes that stand; one that does not answer reports a silence that is none.

        By the line that is open now: the stop before may have opened one anew that was lost.
        """
        for name in self._armed:
            axis = self._rig.axes[name]
            assert isinstance(axis, Watchdog)
            try:
                axis.disarm_watchdog()
            except RigError as error:
                self._record(KIND, {"axis": name, "is_armed": True, "told": f"could not be let go: {error}"})
        self.forget()
