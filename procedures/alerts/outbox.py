"""Messages on their way: each in a thread of its own, or, where none can be had, in one that was begun early.

Whoever waits for them in the end delivers what no thread took: a person is to be told, and nothing else is left to do.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from queue import SimpleQueue

from procedures.alerts.channels import NotDelivered, without_secrets
from rig.clock import Clock
from rig.threads import HAND_OVER_S, BegunThread, begun

MOST_UNDER_WAY = 8
"""Messages at once that wait for a server; more are not sent and said to be lost."""
HEARTBEAT = "heartbeat"


class Outbox:
    """``deadline_s``: so long one message may take. ``secrets``: what no outcome may hold."""

    def __init__(self, clock: Clock, deadline_s: float, secrets: Sequence[str]) -> None:
        self._clock, self._deadline_s, self._secrets = clock, deadline_s, secrets
        self._under_way: list[tuple[str, BegunThread]] = []
        self._untaken: SimpleQueue[BegunThread | None] = SimpleQueue()
        """What got no thread of its own; None ends the one that stands by."""
        self._is_standing_by = False
        self._outcomes: deque[Mapping[str, object]] = deque()
        self._last_failure = ""

    def stand_by(self) -> None:
        """Begin the thread now that delivers what gets none later. Raises: MemoryError where none can be had."""
        begun(self._take, "alerts")
        self._is_standing_by = True

    def send(self, what: str, deliver: Callable[[], None]) -> None:
        """Have a message delivered; it waits for no server."""
        self._under_way = [(name, piece) for name, piece in self._under_way if piece.is_alive]
        if len(self._under_way) >= MOST_UNDER_WAY:
            self._note(what, f"{MOST_UNDER_WAY} messages are under way already; this one was not sent")
            return
        piece = BegunThread(partial(self._delivered, what, deliver), f"the message {what!r}")
        self._under_way.append((what, piece))
        if not (piece.offer() and piece.has_begun(HAND_OVER_S)):
            self._untaken.put(piece)

    def deliver_here(self) -> None:
        """Deliver what nobody took, in this thread, within the deadline of one message and that of the last.

        The newest first: it says where the run stands, and an old one may hang until its deadline. Heartbeats last.
        """
        until_s = self._clock.monotonic_s() + self._deadline_s
        newest_first = self._under_way[::-1]
        for what, piece in sorted(newest_first, key=lambda under_way: under_way[0] == HEARTBEAT):
            if not piece.claim():
                continue
            if self._clock.monotonic_s() < until_s:
                piece.do_here()
            else:
                self._under_way.remove((what, piece))
                self._note(what, "no thread could be begun for it, and those before it took all the time there was")

    def close(self) -> None:
        """Deliver what nobody took, and wait for what is under way, at most its deadline."""
        self.deliver_here()
        if self._is_standing_by:
            self._is_standing_by = False
            self._untaken.put(None)
        ends_s = self._clock.monotonic_s() + self._deadline_s
        self.join(lambda: max(ends_s - self._clock.monotonic_s(), 0.0))

    def join(self, left_s: Callable[[], float]) -> None:
        """Wait for what is under way, for each as long as is left by then."""
        for _, piece in self._under_way:
            piece.join(left_s())

    def outcomes(self) -> list[Mapping[str, object]]:
        """Return what became of messages since the last call."""
        return [self._outcomes.popleft() for _ in range(len(self._outcomes))]

    def _take(self) -> None:
        while (piece := self._untaken.get()) is not None:
            if piece.claim():
                piece.do_here()

    def _delivered(self, what: str, deliver: Callable[[], None]) -> None:
        try:
            deliver()
        except NotDelivered as error:
            self._note(what, str(error))
        except Exception as error:  # noqa: BLE001  the rim of a thread: whatever a service does, the run goes on
            self._note(what, f"{type(error).__name__}: {error}")
        else:
            self._note(what, "")

    def _note(self, what: str, failure: str) -> None:
        """Good heartbeats are not journalled, and a failure that repeats only once."""
        is_beat = what == HEARTBEAT
        if is_beat and failure == self._last_failure:
            return
        if is_beat:
            self._last_failure = failure
        self._outcomes.append({"what": what, "failed": without_secrets(failure, self._secrets)})
