"""A line of bytes inside the process: what is written reaches the other side at once, what it answers comes when due.

Reading lets the clock run to the moment the other side names, so with a virtual clock a night's conversation takes
as long as its arithmetic. Faults of the line are a passed-in collaborator (:mod:`rig.link.faults`).
"""

from dataclasses import dataclass, field
from typing import Protocol

from rig.clock import Clock
from rig.errors import LinkClosed
from rig.link.faults import LinkFaults, Part


class Peer(Protocol):
    """The other side of a line: bytes in, bytes out, time as an argument (rig seconds). No port and no thread."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take ``data``, which arrived at ``now_s``."""

    def transmit(self, now_s: float) -> bytes:
        """Return everything due by ``now_s`` that was not taken yet; ``b""`` when nothing is."""

    def next_event_s(self) -> float | None:
        """Return when :meth:`transmit` should be asked again, later than it was last asked.

        None when nothing is pending.
        """


@dataclass(slots=True)
class Way:
    """One direction of a faulty line: parts under way with their times of arrival."""

    parts: list[tuple[float, bytes]] = field(default_factory=list)
    stalled_until_s: float = float("-inf")

    def enter(self, parts: tuple[Part, ...], now_s: float) -> None:
        for part in parts:
            due_s = max(now_s + part.delay_s, self.stalled_until_s)
            if part.stalls:
                self.stalled_until_s = due_s
            self.parts.append((due_s, part.data))

    def leave(self, now_s: float) -> list[bytes]:
        arrived = [data for due_s, data in self.parts if due_s <= now_s]
        self.parts = [(due_s, data) for due_s, data in self.parts if due_s > now_s]
        return arrived


class MemoryStream:
    """A :class:`rig.link.byte_stream.ByteStream` to a peer in this process."""

    def __init__(self, peer: Peer, clock: Clock, name: str, faults: LinkFaults | None = None) -> None:
        self.name = name
        self.clock = clock
        self._peer = peer
        self._faults = faults
        self._outbound = Way()
        self._inbound = Way()
        self._is_closed = False

    def write(self, data: bytes) -> None:
        self._require_open()
        now_s = self.clock.monotonic_s()
        if self._faults is None:
            self._peer.receive(data, now_s)
            return
        self._outbound.enter(self._faults.on_write(data), now_s)
        self._deliver_outbound(now_s)

    def read(self, deadline_s: float) -> bytes:
        self._require_open()
        while True:
            now_s = self.clock.monotonic_s()
            if data := self._take(now_s):
                return data
            if now_s >= deadline_s:
                return b""
            self.clock.sleep(self._next_look_s(now_s, deadline_s) - now_s)

    def discard_input(self) -> bytes:
        self._require_open()
        return self._take(self.clock.monotonic_s())

    def close(self) -> None:
        self._is_closed = True

    def _require_open(self) -> None:
        if self._is_closed:
            raise LinkClosed(f"{self.name}: used after it was closed; nothing was sent; open it again")

    def _take(self, now_s: float) -> bytes:
        if self._faults is None:
            return self._peer.transmit(now_s)
        self._deliver_outbound(now_s)
        if data := self._peer.transmit(now_s):
            self._inbound.enter(self._faults.on_read(data), now_s)
        return b"".join(self._inbound.leave(now_s))

    def _deliver_outbound(self, now_s: float) -> None:
        for data in self._outbound.leave(now_s):
            self._peer.receive(data, now_s)

    def _next_look_s(self, now_s: float, deadline_s: float) -> float:
        event_s = self._peer.next_event_s()
        assert event_s is None or event_s > now_s, f"{self.name}: the other side named {event_s} s at {now_s} s"
        pending = [due_s for way in (self._inbound, self._outbound) for due_s, _ in way.parts]
        return min([deadline_s, *pending] if event_s is None else [deadline_s, event_s, *pending])
