"""TCP as a line of bytes. Small messages leave at once (no Nagle delay), a vanished peer is noticed.

pyserial's ``socket://`` sets no TCP_NODELAY and reads byte by byte; this one reads what is there.
"""

import select
import socket

from rig.clock import WAIT_SLICE_S, Clock
from rig.errors import LinkClosed, LinkLost, RequestRefused
from rig.link.byte_stream import cause_of, named

READ_SIZE = 65536


class SocketStream:
    """``socket://host:port``."""

    def __init__(self, url: str, clock: Clock, connect_timeout_s: float = 5.0, owner: str = "") -> None:
        self.name = named(url, owner)
        self.clock = clock
        host, port = split_address(url)
        try:
            self._socket = socket.create_connection((host, port), timeout=connect_timeout_s)
        except OSError as error:
            raise LinkLost(
                f"{self.name}: no connection within {connect_timeout_s:g} s: {cause_of(error)}; nothing was sent;"
                " check the address, the network and that the device is on"
            ) from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        self._is_closed = False

    def write(self, data: bytes) -> None:
        self._require_open()
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise self._lost(error) from error

    def read(self, deadline_s: float) -> bytes:
        self._require_open()
        while True:
            left_s = deadline_s - self.clock.monotonic_s()
            if self._is_readable(min(max(left_s, 0.0), WAIT_SLICE_S)):
                return self._receive()
            if left_s <= 0.0:
                return b""

    def discard_input(self) -> bytes:
        self._require_open()
        waiting = b""
        while self._is_readable(0.0):
            waiting += self._receive()
        return waiting

    def descriptor(self) -> int:
        """Return what the system knows the line by."""
        return self._socket.fileno()

    def close(self) -> None:
        self._is_closed = True
        self._socket.close()

    def _is_readable(self, timeout_s: float) -> bool:
        return bool(select.select([self._socket], [], [], timeout_s)[0])

    def _receive(self) -> bytes:
        try:
            data = self._socket.recv(READ_SIZE)
        except OSError as error:
            raise self._lost(error) from error
        if not data:
            raise self._lost("the other side closed the connection")
        return data

    def _lost(self, cause: object) -> LinkLost:
        return LinkLost(
            f"{self.name}: connection lost: {cause_of(cause)}; what was sent last is in doubt; check cable and power"
        )

    def _require_open(self) -> None:
        if self._is_closed:
            raise LinkClosed(f"{self.name}: used after it was closed; nothing was sent; open it again")


def split_address(url: str) -> tuple[str, int]:
    """Return the host and port of ``socket://host:port``. Raises: RequestRefused."""
    host, colon, port = url.removeprefix("socket://").rstrip("/").rpartition(":")
    if not (colon and host and port.isdecimal() and 0 < int(port) < 65536):
        raise RequestRefused(f"{url}: not a TCP address (allowed: socket://host:port, 1 to 65535); nothing was opened")
    return host.strip("[]"), int(port)
