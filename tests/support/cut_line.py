"""A TCP line that can be cut: a relay before a twin, which hangs up when told and is there again later."""

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress


class CutLine:
    """Relays ``address``; :meth:`cut` hangs up on everybody and turns away the next callers.

    What it ``says`` goes to every caller from then on, again and again, beside what is relayed.
    """

    def __init__(self, address: str) -> None:
        self.lead_to(address)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"
        self._pairs: list[socket.socket] = []
        self._lock = threading.Lock()
        self._refusals = 0
        self.says = b""
        self.callers = 0
        self.heard = bytearray()
        """What callers sent."""
        self.is_single = False
        """It turns a caller away while another one is connected, as some device servers do."""

    def cut(self, refusals: int) -> None:
        with self._lock:
            self._refusals = refusals
            for end in self._pairs:
                _hang_up(end)
            self._pairs.clear()

    def lead_to(self, address: str) -> None:
        """Relay to ``socket://host:port`` from the next caller on."""
        host, _, port = address.removeprefix("socket://").rpartition(":")
        self._target = host, int(port)

    def serve(self) -> None:
        while True:
            try:
                caller, _ = self._listener.accept()
            except OSError:
                return
            self.callers += 1
            with self._lock:
                if self._refusals or (self.is_single and any(map(_is_there, self._pairs[::2]))):
                    self._refusals -= self._refusals > 0
                    _hang_up(caller)
                    continue
                twin = socket.create_connection(self._target)
                self._pairs += [caller, twin]
                if self.says:
                    threading.Thread(target=_talk, args=(caller, self.says), daemon=True).start()
            for ends in ((caller, twin, self.heard), (twin, caller, bytearray())):
                threading.Thread(target=_relay, args=ends, daemon=True).start()

    def close(self) -> None:
        _hang_up(self._listener)
        self.cut(0)


def _hang_up(end: socket.socket) -> None:
    with suppress(OSError):  # it may be gone already
        end.shutdown(socket.SHUT_RDWR)
    end.close()


def _is_there(caller: socket.socket) -> bool:
    try:
        return caller.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False


def _talk(caller: socket.socket, says: bytes) -> None:
    pause = threading.Event()
    with suppress(OSError):
        while not pause.wait(0.02):
            caller.sendall(says)


def _relay(source: socket.socket, sink: socket.socket, heard: bytearray) -> None:
    try:
        while data := source.recv(4096):
            heard += data
            sink.sendall(data)
    except OSError:
        return
    finally:
        _hang_up(sink)


@contextmanager
def cut_line(address: str) -> Iterator[CutLine]:
    """A line in front of ``socket://host:port``."""
    line = CutLine(address)
    thread = threading.Thread(target=line.serve)
    thread.start()
    try:
        yield line
    finally:
        line.close()
        thread.join()
