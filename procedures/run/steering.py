"""Steering: every wait of a run looks here for requests and signals, at least every tenth of a second.

``abort`` ends the wait at once; ``pause`` and ``stop`` are remembered until the dwell is done. The first SIGINT is a
stop, the second an abort, and so is SIGQUIT. SIGTERM, as a shutdown sends it, is a stop that does not wait for the
dwell. SIGHUP (the terminal closed) ends nothing: it is told, and the run goes on. A signal that was ignored when the
run began (``nohup``) stays ignored. Signals only leave a mark, so none can interrupt a commit or the stop of the axes.
"""

import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from math import inf
from types import FrameType

from procedures.journal.requests.spool import Request, Spool, Taken
from procedures.records.states import State
from procedures.run.ending import Ending
from rig.clock import Clock
from rig.errors import WaitEnded
from rig.system_parts import ENDS, present

_REST_S = 0.05
HANG_UP = present("SIGHUP")
_TERMINATES = present("SIGTERM", "SIGBREAK")
"""SIGBREAK is how Windows asks: Ctrl-Break, and a console that is closed."""
JOB_CONTROL = present("SIGTSTP", "SIGTTIN", "SIGTTOU")
_SENDER_OF = {
    "SIGINT": "Ctrl-C",
    "SIGQUIT": "Ctrl-\\",
    "SIGTERM": "told to end, as by a shutdown, systemd or kill",
    "SIGBREAK": "Ctrl-Break, or the console was closed",
}


def _ignore() -> None:
    return None


class Steering:
    """What was asked of the run so far; called, it is the :class:`rig.abilities.abilities.Wait` of every device."""

    def __init__(
        self,
        spool: Spool,
        clock: Clock,
        idle_clock: Clock,
        record: Callable[[Taken], None],
        pulse: Callable[[], float] = lambda: inf,
        hung_up: Callable[[], None] = _ignore,
        state_sequence: Callable[[], int] | None = None,
    ) -> None:
        self._spool = spool
        self._clock = clock
        self._idle_clock = idle_clock
        """Real seconds: a person's answer takes them even where the rig's time is virtual."""
        self._record = record
        self._pulse = pulse
        """Told at every look that the engine lives; says within how many rig seconds it must be told again."""
        self._pulse_within_s = inf
        self._hung_up = hung_up
        """Told, at the next look, that the terminal was closed."""
        self._state_sequence = state_sequence
        """Of the state in which the run is; None where no state is known and every request is taken."""
        self._obeyed: set[tuple[str, str]] = set()
        """Kind and key of every request that was obeyed."""
        self._heard_utc: dict[str, datetime] = {}
        """By kind, of the newest request."""
        self._signals: deque[int] = deque()
        self._interrupts = 0
        self.pause: Request | None = None
        self.stop: Request | None = None
        self.abort: Request | None = None
        self.terminated: Request | None = None
        """A stop that does not wait for the dwell."""
        self.continued: Request | None = None
        """The newest ``continue``; whoever waits for one clears it first."""

    def __call__(self, duration_s: float) -> None:
        """Let rig time pass. Raises: WaitEnded as soon as the axes are to stop at once."""
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
            self._take_signal(signal.Signals(self._signals.popleft()))
        for taken in self._spool.take():
            self._take(taken)
            self._spool.remove(taken)
        if self.abort is not None:
            raise WaitEnded("abort", self.abort.by)
        if self.terminated is not None:
            raise WaitEnded("stop at once", self.terminated.by)

    def hear(self) -> None:
        """Take what was asked meanwhile of a run that ends already; what cannot be recorded is heard all the same."""
        with suppress(Exception):  # the rim: a request that cannot be taken keeps no run from its safe state
            self.look()

    @property
    def at_once(self) -> Ending | None:
        """How a wait that ended at once ends the run: aborted, or stopped where the process was told to end."""
        if self.abort is not None:
            return self._ending(State.ABORTED, self.abort)
        return None if self.terminated is None else self._ending(State.STOPPED, self.terminated)

    @property
    def behind_the_dwell(self) -> Ending | None:
        """How a stop that waits for the dwell ends the run."""
        return None if self.stop is None else self._ending(State.STOPPED, self.stop)

    def _ending(self, state: State, request: Request) -> Ending:
        return Ending(state, request.text, request.by, requested_utc=self._heard_utc.get(request.kind))

    @property
    def _slice_s(self) -> float:
        return min(self._clock.slice_s, self._pulse_within_s)

    def discard_pending(self, since: datetime | None) -> None:
        """Journal the requests that a dead process left behind without obeying them, but for words.

        What was asked ``since`` this process owns the run was asked of it.
        """
        for taken in self._spool.take():
            request = taken.request
            if request is None or request.kind in ("note", "ack") or _is_newer(request, since):
                self._take(taken)
            else:
                self._record(Taken(taken.file, request, "asked of the process before this one"))
            self._spool.remove(taken)

    def on_signal(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002  the signature of a handler
        """Leave a mark; the next look acts."""
        self._signals.append(number)

    def _take(self, taken: Taken) -> None:
        taken = self._judged(taken)
        try:
            self._record(taken)
        finally:  # a disk that refuses it ends the run, and who asked for what is told all the same
            if not taken.complaint:
                self._heed(taken.request)

    def _heed(self, request: Request | None) -> None:
        if request is not None:
            self._heard_utc[request.kind] = self._clock.now_utc()
        match request:
            case Request(kind="pause"):
                self.pause = request
            case Request(kind="continue"):
                self.pause = None
                self.continued = request
            case Request(kind="stop"):
                self.stop = request
            case Request(kind="abort"):
                self.abort = request

    def _judged(self, taken: Taken) -> Taken:
        """Return it with what speaks against it: asked in view of another state, or taken already."""
        request = taken.request
        if request is None or taken.complaint:
            return taken
        if request.key and (request.kind, request.key) in self._obeyed:
            return Taken(taken.file, request, f"{request.kind} with the key {request.key} was taken already")
        complaint = "" if self._state_sequence is None else request.complaint(self._state_sequence())
        if not complaint and request.key:
            self._obeyed.add((request.kind, request.key))
        return Taken(taken.file, request, complaint)

    def _take_signal(self, number: signal.Signals) -> None:
        if number in HANG_UP:
            self._hung_up()
            return
        self._interrupts += number is signal.SIGINT
        is_stop = number in _TERMINATES or (number is signal.SIGINT and self._interrupts == 1)
        at_utc = self._idle_clock.now_utc().isoformat()
        request = Request("stop" if is_stop else "abort", f"signal {number.name}", at_utc, _SENDER_OF[number.name])
        if number in _TERMINATES:
            self.terminated = request
        self._take(Taken("", request))


def _is_newer(request: Request, since: datetime | None) -> bool:
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
    heeded = [number for number in ENDS if signal.getsignal(number) is not signal.SIG_IGN]
    outer_hang_up = {number: signal.getsignal(number) for number in HANG_UP}

    def on_hang_up(number: int, frame: FrameType | None) -> None:
        steering.on_signal(number, frame)
        outer = outer_hang_up[signal.Signals(number)]
        if callable(outer):  # what the command does about its own screen
            outer(number, frame)

    handlers = dict.fromkeys(HANG_UP, on_hang_up)
    before = {number: signal.signal(number, handlers.get(number, steering.on_signal)) for number in heeded}
    try:
        with job_control_ignored():
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def job_control_ignored() -> Iterator[None]:
    """While a rig is open, no key and no background may freeze the process that watches its axes.

    Ignored for good, and not by a handler: a read in the background would ask for the signal again and again.
    """
    before = {number: signal.signal(number, signal.SIG_IGN) for number in JOB_CONTROL}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
