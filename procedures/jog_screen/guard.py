"""Who stops axes while everybody else is busy: a thread of its own that looks at leases and at the stop button.

It does not ask the thread that owns the devices, which may be waiting for one of them: it tells every axis to stop,
each in a thread of its own, so that a silent line keeps no other axis from its stop. The owner then sees them stand.
"""

from collections.abc import Callable, Mapping
from threading import Event, Thread

from procedures.jog_screen.lease import RateLease
from rig.clock import Clock
from rig.devices.abilities import Axis
from rig.errors import RigError

LOOK_S = 0.03
_AGAIN_S = 0.5


class Guard:
    """``axes`` gives the axes as they are open now; ``tell`` hears what was stopped and what could not be."""

    def __init__(self, axes: Callable[[], Mapping[str, Axis]], clock: Clock, tell: Callable[[str], None]) -> None:
        self._axes = axes
        self._clock = clock
        self._tell = tell
        self._leases: dict[str, RateLease] = {}
        self._why_stop = ""
        self._is_reported = False
        self._lost = ""
        self._bell, self._closing = Event(), Event()
        self._thread = Thread(target=self._watch, name="jog-guard", daemon=True)
        self._thread.start()

    @property
    def is_stopping(self) -> bool:
        """A stop was asked for and the owner of the devices has not seen all axes stand yet."""
        return bool(self._why_stop or self._lost)

    @property
    def lost(self) -> str:
        """Why the operator is gone; empty while he is there."""
        return self._lost

    def stop(self, why: str) -> None:
        """Stop every axis now."""
        self._why_stop = self._why_stop or why
        self._bell.set()

    def lose(self, why: str) -> None:
        """Stop every axis for good: the operator is gone. Safe in a signal handler: it only leaves a mark."""
        self._lost = self._lost or why

    def stood_still(self) -> None:
        """Allow motion again, unless the operator is gone: the owner has seen every axis stand."""
        self._why_stop, self._is_reported = "", False
        self._leases.clear()

    def grant(self, axis: str, *, is_held: bool) -> None:
        self._leases[axis] = RateLease(self._clock, is_held=is_held)

    def answer(self) -> None:
        """Renew every lease: the terminal answered."""
        for lease in list(self._leases.values()):
            lease.answer()

    def press(self, axis: str) -> bool:
        """Renew the lease of an axis whose key came again; return whether there is such a lease."""
        lease = self._leases.get(axis)
        if lease is not None:
            lease.press()
        return lease is not None

    @property
    def has_leases(self) -> bool:
        return bool(self._leases)

    def has_lease(self, axis: str) -> bool:
        return axis in self._leases

    def end_lease(self, axis: str) -> None:
        """Remove the lease of an axis that turns no longer."""
        self._leases.pop(axis, None)

    def close(self) -> None:
        self._closing.set()
        self._bell.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._closing.is_set():
            self._bell.wait(LOOK_S)
            self._bell.clear()
            why = self._lost or self._why_stop
            if why and not self._is_reported:
                self._is_reported = True
                self._stop_axes(list(self._axes()), why)
            for axis, lease in list(self._leases.items()):
                if not why and (over := lease.why_over()):
                    self._leases.pop(axis, None)
                    self._stop_axes([axis], over)

    def _stop_axes(self, names: list[str], why: str) -> None:
        self._tell(f"{' and '.join(names)}: stop: {why}")
        for name in names:
            Thread(target=self._stop_one, args=(name,), name=f"jog-stop-{name}", daemon=True).start()

    def _stop_one(self, name: str) -> None:
        """Until the axis took it: whoever asked may not be there any more to ask again."""
        is_reported = False
        while not self._closing.is_set():
            try:
                self._axes()[name].stop()
            except RigError as error:
                if not is_reported:
                    self._tell(f"{name}: not known to have stopped: {error}; use the stop button at the machine")
                is_reported = True
                self._closing.wait(_AGAIN_S)
            else:
                return
