"""Steering: every wait of a run looks here for requests and signals, at least every tenth of a second.

``abort`` ends the wait at once; ``pause`` and ``stop`` are remembered until the dwell is done. The first SIGINT is a
stop, the second an abort, SIGTERM is an abort, SIGHUP (the terminal closed) is a stop; a signal that was ignored when
the run began (``nohup``) stays ignored. Signals only leave a mark, so none can interrupt a commit or
the stop of the axes.
"""

import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from math import inf
from types import FrameType

from procedures.journal.spool import Kind, Request, Spool, Taken
from rig.clock import Clock
from rig.errors import WaitEnded

_REST_S = 0.05
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Steering:
    """What was asked of the run so far; called, it is the :class:`rig.devices.abilities.Wait` of every device."""

    def __init__(
        self,
        spool: Spool,
        clock: Clock,
        idle_clock: Clock,
        record: Callable[[Taken], None],
        pulse: Callable[[], float] = lambda: inf,
    ) -> None:
        self._spool = spool
        self._clock = clock
        self._idle_clock = idle_clock
        """Real seconds: a person's answer takes them even where the rig's time is virtual."""
        self._record = record
        self._pulse = pulse
        """Told at every look that the engine lives; says within how many rig seconds it must be told again."""
        self._pulse_within_s = inf
        self._signals: deque[int] = deque()
        self._interrupts = 0
        self.pause: Request | None = None
        self.stop: Request | None = None
        self.abort: Request | None = None
        self.continued: Request | None = None
        """The newest ``continue``; whoever waits for one clears it first."""

    def __call__(self, duration_s: float) -> None:
        """Let rig time pass. Raises: WaitEnded as soon as an abort was asked for."""
        self.look()
        ends_s = self._clock.monotonic_s() + duration_s
        while (left_s := ends_s - self._clock.monotonic_s()) > (slice_s := self._slice_s):
            self._clock.sleep(slice_s)
            self.look()
        self._clock.sleep(left_s)

    def rest(self) -> float:
        """Let a little real time pass while a person decides; returns it. Raises: WaitEnded."""
        self.look()
        self._idle_clock.sleep(_REST_S)
        return _REST_S

    def look(self) -> None:
        """Take what was asked meanwhile. Raises: WaitEnded."""
        self._pulse_within_s = self._pulse()
        while self._signals:
            self._take(Taken("", self._of_signal(self._signals.popleft())))
        for taken in self._spool.take():
            self._take(taken)
            self._spool.remove(taken)
        if self.abort is not None:
            raise WaitEnded(f"abort, asked for by {self.abort.by}")

    @property
    def _slice_s(self) -> float:
        return min(self._clock.slice_s, self._pulse_within_s)

    def discard_pending(self, since: datetime | None) -> None:
        """Journal the requests that a dead process left behind without obeying them, but for words.

        What was asked ``since`` this process owns the run was asked of it.
        """
        for taken in self._spool.take():
            request = taken.request
            if request is None or request.kind in ("note", "ack") or _is_asked_since(request, since):
                self._take(taken)
            else:
                self._record(Taken(taken.file, request, "asked of the process before this one"))
            self._spool.remove(taken)

    def on_signal(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002  the signature of a handler
        """Leave a mark; the next look acts."""
        self._signals.append(number)

    def _take(self, taken: Taken) -> None:
        self._record(taken)
        match taken.request:
            case Request(kind="pause"):
                self.pause = taken.request
            case Request(kind="continue"):
                self.pause = None
                self.continued = taken.request
            case Request(kind="stop"):
                self.stop = taken.request
            case Request(kind="abort"):
                self.abort = taken.request

    def _of_signal(self, number: int) -> Request:
        self._interrupts += number == signal.SIGINT
        is_gentle = number == signal.SIGHUP or (number == signal.SIGINT and self._interrupts == 1)
        kind: Kind = "stop" if is_gentle else "abort"
        return Request(kind, f"signal {signal.Signals(number).name}", self._idle_clock.now_utc().isoformat())


def _is_asked_since(request: Request, since: datetime | None) -> bool:
    try:
        return since is not None and datetime.fromisoformat(request.at_utc) >= since
    except (ValueError, TypeError):
        return False


@contextmanager
def signals_steer(steering: Steering) -> Iterator[None]:
    """Signals go to ``steering`` while inside; in any thread but the main one they are left alone."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heeded = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, steering.on_signal) for number in heeded}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
