"""Several pieces of work at once, each written as if it were alone: whoever waits lets the others go on.

Exactly one of them runs at a moment, so what they share (a line, a supervisor, a virtual clock) meets no two callers.
Time passes in the wait of the caller alone, who sees a stop there. Where one fails, or the wait is ended, the waits of
all others raise :class:`rig.errors.WaitEnded`: each leaves its device as it does at any stop.
"""

from _thread import allocate_lock
from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

from rig.clock import Clock
from rig.errors import WaitEnded
from rig.threads import BegunThread

Done = TypeVar("Done")
LetTimePass = Callable[[float], None]


def side_by_side(
    works: Mapping[str, Callable[[LetTimePass], Done]], clock: Clock, wait: LetTimePass
) -> dict[str, Done]:
    """Do every work and return what each returns, in their order; they begin in that order.

    Raises: the first error of any, MemoryError where no thread can be had, and what ``wait`` raises; all others have
    ended by then.
    """
    lanes: dict[str, _Lane[Done]] = {}
    try:
        for name, work in works.items():
            lanes[name] = _Lane(name, work, clock)
        while under_way := [lane for lane in lanes.values() if lane.is_under_way]:
            lane = min(under_way, key=lambda lane_under_way: lane_under_way.due_s)
            if (ahead_s := lane.due_s - clock.monotonic_s()) > 0.0:
                wait(ahead_s)
            lane.go_on()
            if lane.error is not None:
                raise lane.error
    finally:
        for lane in lanes.values():
            lane.end()
    return {name: lane.returned[0] for name, lane in lanes.items()}


class _Lane(Generic[Done]):
    """One work on a thread of its own, which runs only between :meth:`go_on` and its next wait."""

    def __init__(self, name: str, work: Callable[[LetTimePass], Done], clock: Clock) -> None:
        self.due_s = clock.monotonic_s()
        """When it wants to go on, rig seconds."""
        self.is_under_way = True
        self.returned: list[Done] = []
        self.error: BaseException | None = None
        self._is_to_end = False
        self._work, self._clock = work, clock
        self._turn, self._handed_back = allocate_lock(), allocate_lock()  # to give one back needs no memory
        self._turn.acquire()
        self._handed_back.acquire()
        self._thread = BegunThread(self._run, f"what is done side by side: {name}")
        self._thread.begin()

    def go_on(self) -> None:
        """Let it run until it waits or is done."""
        self._turn.release()
        self._handed_back.acquire()

    def end(self) -> None:
        """End it by its next waits, if it is under way."""
        self._is_to_end = True
        while self.is_under_way:
            self.go_on()
        self._thread.join()

    def _run(self) -> None:
        self._turn.acquire()
        try:
            if not self._is_to_end:
                self.returned.append(self._work(self._wait))
        except BaseException as error:  # noqa: BLE001  the rim of a thread: its caller raises it
            self.error = error
        finally:
            self.is_under_way = False
            self._handed_back.release()

    def _wait(self, duration_s: float) -> None:
        self.due_s = self._clock.monotonic_s() + duration_s
        self._handed_back.release()
        self._turn.acquire()
        if self._is_to_end:
            raise WaitEnded("what ran beside it has ended")
