"""Serves twins on real ports, all by one thread, since they share one world."""

import selectors
import socket
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType

from rig.clock import WAIT_SLICE_S, Clock
from rig.threads import BegunThread
from rig.twins.serving.ports import Port, PtyPort, TcpPort
from rig.twins.twin import Twin

_CONGESTED_S = 0.005
"""How soon a port is tried again whose client does not take its bytes."""
_UNREAD_S = 2.0
"""Seconds of the machine after which bytes that nobody takes are dropped, as a UART drops them."""


class TwinServer:
    """Serves ports until closed. A context manager; ``clock`` is the twins' (rig seconds)."""

    def __init__(self, ports: Sequence[Port], clock: Clock) -> None:
        self.ports = ports
        self._clock = clock
        self._factor = clock.slice_s / WAIT_SLICE_S
        """Rig seconds in a second of the machine."""
        self._selector = selectors.DefaultSelector()
        self._bell, self._ringer = socket.socketpair()
        self._serving = BegunThread(self._serve, "the twins")
        self.failure: BaseException | None = None
        """What ended the thread, if it was not closed: :meth:`close` raises it."""
        self._selector.register(self._bell, selectors.EVENT_READ, None)
        for port in ports:
            port.register(self._selector)
        self._listening = frozenset(self._selector.get_map())
        try:
            self._serving.begin()
        except MemoryError:
            self._free()
            raise

    @property
    def address(self) -> str:
        """Of the only, or the first, port."""
        return self.ports[0].address

    @property
    def is_serving(self) -> bool:
        return self._serving.is_alive

    def close(self) -> None:
        """Stop serving and free the ports; closing twice is harmless. Raises what a twin raised while serving."""
        if self._serving.is_alive:
            with suppress(OSError):  # a twin that failed just now has closed the bell itself
                self._ringer.send(b"!")
        self._serving.join()
        self._ringer.close()
        if self.failure is not None:
            failure, self.failure = self.failure, None
            raise failure

    def __enter__(self) -> "TwinServer":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _serve(self) -> None:
        try:
            while self._turn():
                pass
        except Exception as error:  # noqa: BLE001 the thread's rim: told to whoever closes the server
            self.failure = error
        finally:
            self._free()

    def _free(self) -> None:
        for port in self.ports:
            port.close()
        self._selector.close()
        self._bell.close()

    def _turn(self) -> bool:
        """Look at every port once; return False when the server was closed."""
        events = self._selector.select(self._idle_s())
        now_s = self._clock.monotonic_s()
        if any(key.data is None for key, _ in events):
            return False
        # A client that goes is seen before the one that comes: sockets that accept were registered first, go last.
        for key, _ in sorted(events, key=lambda event: event[0].fd in self._listening):
            key.data.ready(self._selector, key.fileobj, now_s)
        for port in self.ports:
            port.flush(self._clock.monotonic_s(), _UNREAD_S * self._factor)
        return True

    def _idle_s(self) -> float | None:
        """Return how long nothing will be due, in seconds of the machine."""
        if any(port.is_congested for port in self.ports):
            return _CONGESTED_S
        events_s = [event_s for port in self.ports if (event_s := port.twin.next_event_s()) is not None]
        return max(0.0, (min(events_s) - self._clock.monotonic_s()) / self._factor) if events_s else None


def serve_tcp(twin: Twin, clock: Clock) -> TwinServer:
    """Serve a twin on a free TCP port of the loopback interface; ``address`` is ``socket://127.0.0.1:port``."""
    return TwinServer([TcpPort(twin)], clock)


def serve_pty(twin: Twin, clock: Clock) -> TwinServer:
    """Serve a twin on a pseudo-terminal; ``address`` is its device path."""
    return TwinServer([PtyPort(twin)], clock)
