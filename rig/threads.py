"""Threads that begin in time or are known not to have begun, and work that is done at once where threads can be had.

``threading.Thread.start`` waits without a limit until the new thread says that it began. One that dies before that,
since its first allocation fails, keeps whoever started it for ever: nothing that stops an axis, and nothing that is
started while one moves, may be started so. Locks of the interpreter need no memory to be taken and given back.
"""

import _thread
from _thread import LockType, allocate_lock, start_new_thread
from collections.abc import Callable, Sequence

from rig.clock import SystemClock

BEGIN_S = 2.0
"""A thread that did not begin within this is not waited for. Less than the silence after which a stop guard acts."""
HAND_OVER_S = 0.25
"""Work of which no thread took hold within this is done by who wanted it done at once."""
ENDLESS_S = -1.0


class BegunThread:
    """A piece of work that one thread takes hold of: a new one, or whoever does it himself. It never outlives us."""

    def __init__(self, work: Callable[[], object], name: str) -> None:
        self.name = name
        self._work = work
        self._claim, self._began, self._ended = allocate_lock(), allocate_lock(), allocate_lock()
        self._began.acquire()
        self._ended.acquire()
        self.is_done = False
        """The work returned; one that raised is not done."""

    def begin(self) -> None:
        """Begin, and see that it began. Raises: MemoryError where no thread can be had; then nothing was done."""
        if not self.offer() or (not self.has_begun(BEGIN_S) and self.claim()):
            raise MemoryError(f"no thread could be begun for {self.name}: no memory is left, or no further thread")

    def offer(self) -> bool:
        """Ask for a thread that takes hold of the work, and wait for nothing; False where none can be had."""
        try:
            start_new_thread(self._run, ())
        except (RuntimeError, MemoryError):
            return False
        return True

    def has_begun(self, within_s: float) -> bool:
        return self._waited(self._began, within_s)

    def claim(self) -> bool:
        """Take hold of the work, unless somebody has: then no thread does it any more."""
        return self._claim.acquire(blocking=False)

    def do_here(self) -> None:
        """Do work that was claimed, in this thread. It raises nothing: what failed is not done."""
        try:
            self.is_done = _done(self._work)
        finally:
            self._ended.release()

    def join(self, within_s: float = ENDLESS_S) -> bool:
        """Wait until the work ended; return whether it has."""
        return self._waited(self._ended, within_s)

    @property
    def is_alive(self) -> bool:
        """Whether the work is still to end."""
        return self._ended.locked()

    def _run(self) -> None:
        if not self.claim():
            return
        self._began.release()
        try:
            self._work()
            self.is_done = True
        finally:
            self._ended.release()

    @staticmethod
    def _waited(lock: LockType, within_s: float) -> bool:
        if not lock.acquire(timeout=within_s):
            return False
        lock.release()
        return True


def begun(work: Callable[[], object], name: str) -> BegunThread:
    """Return a piece of work that a thread of its own does. Raises: MemoryError where none can be had."""
    piece = BegunThread(work, name)
    piece.begin()
    return piece


def at_once(works: Sequence[Callable[[], object]], within_s: float, name: str) -> list[bool]:
    """Do every work at once, each in a thread of its own; return which are done within that time, of each.

    Where threads cannot be had (no memory, no further thread), who calls does them one after the other.
    """
    try:
        pieces = [BegunThread(work, name) for work in works]
    except MemoryError:
        return [_done(work) for work in works]
    have_begun = [piece.offer() and piece.has_begun(HAND_OVER_S) for piece in pieces]  # in their order
    for piece, has_begun in zip(pieces, have_begun, strict=True):
        if not has_begun and piece.claim():
            piece.do_here()
    clock = SystemClock()
    until_s = clock.monotonic_s() + within_s
    return [piece.join(max(until_s - clock.monotonic_s(), 0.0)) and piece.is_done for piece in pieces]


def thread_count() -> int:
    """Return how many threads of Python this process has, those included that :mod:`threading` knows nothing of."""
    return _thread._count() + 1  # it leaves out the first


def _done(work: Callable[[], object]) -> bool:
    """Do a work and return whether it did not fail: whoever asked tells that, and does the others too."""
    try:
        work()
    except Exception:  # noqa: BLE001  the next one has to be done too
        return False
    return True
