"""A network between a browser or a page and the console: it can be cut, and it can be slow."""

import socket
from contextlib import suppress
from threading import Event, Thread

from rig.clock import SystemClock

CLOCK = SystemClock()
_GREETING, _REQUEST, _PORT = 3, 5, 2
"""Bytes of SOCKS 5 (RFC 1928) to a host by its name, as browsers ask: the last of a request is how long that is."""


class Wire:
    """Every connection goes to one target; with ``is_proxy`` it begins as that of a browser to a SOCKS 5 proxy."""

    def __init__(self, target: tuple[str, int], *, is_proxy: bool = False) -> None:
        self._target = target
        self._is_proxy = is_proxy
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address: tuple[str, int] = self.listener.getsockname()
        self.is_cut = Event()
        self.delay_s = 0.0
        """Of every piece of bytes, either way."""
        Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with suppress(OSError):  # closed at the end
            while True:
                connection, _ = self.listener.accept()
                Thread(target=self._connect, args=(connection,), daemon=True).start()

    def _connect(self, connection: socket.socket) -> None:
        with suppress(OSError):
            if self._is_proxy and not self._has_request(connection):
                connection.close()
                return
            other = socket.create_connection(self._target)
            for source, sink in ((connection, other), (other, connection)):
                Thread(target=self._pass, args=(source, sink), daemon=True).start()

    def _has_request(self, connection: socket.socket) -> bool:
        """Hear a browser; False for another host, such as one that it asks whether there is a newer browser."""
        connection.recv(_GREETING)
        connection.sendall(b"\x05\x00")
        request = connection.recv(_REQUEST, socket.MSG_WAITALL)
        if not request:  # opened ahead of need, and given up
            return False
        host = connection.recv(request[-1], socket.MSG_WAITALL).decode()
        connection.recv(_PORT, socket.MSG_WAITALL)
        connection.sendall(b"\x05\x00\x00\x01\x7f\x00\x00\x01\x00\x00")
        return host == self._target[0]

    def _pass(self, source: socket.socket, sink: socket.socket) -> None:
        with source, sink, suppress(OSError):
            while data := source.recv(65536):
                if not self.is_cut.is_set():
                    CLOCK.sleep(self.delay_s)
                    sink.sendall(data)
