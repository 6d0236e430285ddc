"""Who stops axes while everybody else is busy: a thread of its own that looks at leases and at the stop button.

It does not ask the thread that owns the devices, which may be waiting for one of them: it tells every axis to stop,
each in a thread of its own, so that a silent line keeps no other axis from its stop. The owner then sees them stand.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from threading import Event, Lock

from procedures.jog_screen.lease import PAGE, TERMINAL, MotionLease
from procedures.jog_screen.values import AT_TERMINAL, Asker
from rig.abilities.abilities import Axis
from rig.clock import Clock
from rig.errors import RigError
from rig.threads import HAND_OVER_S, BegunThread, begun

LOOK_S = 0.03
_AGAIN_S = 0.5


def _in_a_thread(work: Callable[[], None]) -> None:
    piece = BegunThread(work, "a stop")
    if not (piece.offer() and piece.has_begun(HAND_OVER_S)) and piece.claim():
        piece.do_here()


class Guard:
    """``axes`` gives the axes as they are open now; ``tell`` hears what was stopped and what could not be.

    A lease belongs to an axis and to who asked: a page that hangs is not kept alive by another one that answers.
    """

    def __init__(
        self,
        axes: Callable[[], Mapping[str, Axis]],
        clock: Clock,
        tell: Callable[[str], None],
        begin: Callable[[Callable[[], None]], None] = _in_a_thread,
    ) -> None:
        self._axes = axes
        self._clock = clock
        self._tell = tell
        self._begin = begin
        self.why_stop: Callable[[], str] = lambda: ""
        """Asked at every look, while the owner of the devices may be waiting for one: why every axis is to be stopped.

        One turns where nobody sees it, somebody asked for it past this process, or nobody would stop them any more.
        """
        self._leases: dict[tuple[str, str], _Granted] = {}
        """By axis and client."""
        self._why_stop = ""
        self._is_reported = False
        self._lost = ""
        self._lock = Lock()
        self._bell, self._closing = Event(), Event()
        self._watching: BegunThread | None = None

    def start(self) -> None:
        """Begin to watch. Raises: MemoryError where no thread can be had: then nobody may move anything."""
        self._watching = begun(self._watch, "the guard of the bench")

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
        with self._lock:
            self._why_stop = self._why_stop or why
        self._bell.set()

    def lose(self, why: str) -> None:
        """Stop every axis for good: the operator is gone. Safe in a signal handler: it only leaves a mark."""
        self._lost = self._lost or why

    def stood_still(self) -> None:
        """Allow motion again, unless the operator is gone: the owner has seen every axis stand."""
        with self._lock:  # a look that is half done would take the next stop for one that was told
            self._leases.clear()
            self._why_stop, self._is_reported = "", bool(self._lost) and self._is_reported  # for good: told once

    def grant(
        self, axis: str, asker: Asker, *, is_held: bool = False, is_move: bool = False, seen_s: float | None = None
    ) -> None:
        """Let an axis move for as long as who asked renews it. ``is_move``: where it ends, every axis is stopped.

        The end of a rate stops its axis alone; a move that is cut off has to be given up by who watches it, too.
        """
        lease = MotionLease(self._clock, is_held=is_held, whose=PAGE if asker.is_page else TERMINAL, seen_s=seen_s)
        self._leases[axis, asker.client] = _Granted(lease, is_move)

    def answer(self, client: str = AT_TERMINAL.client, seen_s: float | None = None) -> None:
        """Renew the leases of one who answered, as of the moment at which he was there: now where none is given."""
        for (_, whose), granted in list(self._leases.items()):
            if whose == client:
                granted.lease.answer(seen_s)

    def press(self, axis: str, client: str = AT_TERMINAL.client) -> bool:
        """Renew the lease of an axis whose key came again; return whether there is such a lease."""
        granted = self._leases.get((axis, client))
        if granted is not None:
            granted.lease.press()
        return granted is not None

    def leave(self, client: str, why: str) -> None:
        """End every lease of one who left."""
        for (_, whose), granted in list(self._leases.items()):
            if whose == client:
                granted.lease.end(why)
        self._bell.set()

    def let_go(self, client: str, but: str = "") -> bool:
        """End what turns by one who holds nothing, or one axis (``but``) alone; return whether something ended."""
        ended = [
            granted.lease
            for (axis, whose), granted in list(self._leases.items())
            if whose == client and not granted.is_move and axis != but
        ]
        for lease in ended:
            lease.end("the button was released")
        if ended:
            self._bell.set()
        return bool(ended)

    @property
    def has_leases(self) -> bool:
        return bool(self._leases)

    def has_lease(self, axis: str, client: str | None = None) -> bool:
        """Return whether an axis may move by somebody's lease, or by that of one client."""
        return any(
            page == axis and client in (None, whose) and not granted.lease.why_over()
            for (page, whose), granted in list(self._leases.items())
        )

    def end_lease(self, axis: str, client: str) -> None:
        """Remove the lease of an axis that moves no longer."""
        self._leases.pop((axis, client), None)

    def close(self) -> None:
        self._closing.set()
        self._bell.set()
        if self._watching is not None:
            self._watching.join()

    def _watch(self) -> None:
        while not self._closing.is_set():
            self._bell.wait(LOOK_S)
            self._bell.clear()
            self.look()

    def look(self) -> None:
        """Stop what has to be stopped by now."""
        found = "" if self.is_stopping else self.why_stop()
        with self._lock:
            self._why_stop = self._why_stop or found
            due = self._due()
        for names, why in due:
            self._tell(f"{' and '.join(names)}: stop: {why}")
            for name in names:
                self._begin(partial(self._stop_axis, name))

    def _due(self) -> list[tuple[list[str], str]]:
        """Return which axes are to be told to stop, and why; each stop is told once."""
        due: list[tuple[list[str], str]] = []
        why = self._lost or self._why_stop
        for (axis, client), granted in list(self._leases.items()) if not why else ():
            if over := granted.lease.why_over():
                self._leases.pop((axis, client), None)
                if granted.is_move:
                    why = self._why_stop = self._why_stop or f"{axis}: {over}"
                else:
                    due.append(([axis], over))
        if why and not self._is_reported:
            self._is_reported = True
            due.append((list(self._axes()), why))
        return due

    def _stop_axis(self, name: str) -> None:
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


@dataclass(frozen=True, slots=True)
class _Granted:
    lease: MotionLease
    is_move: bool
