"""A proxy before a machine on TCP: what came and when, by the machine's clock; faults between the two when told."""

import socket
import threading
from contextlib import suppress
from dataclasses import dataclass, field

from rig.clock import Clock, SystemClock
from rig.link.faults import LinkFaults, Part


@dataclass
class RecordingProxy:
    """``target``: host and port of the machine; ``clock``: in whose seconds faults delay."""

    target: tuple[str, int]
    clock: Clock = field(default_factory=SystemClock)
    faults: LinkFaults | None = None
    heard: list[tuple[float, bytes]] = field(default_factory=list)
    ends: list[socket.socket] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"socket://127.0.0.1:{self.listener.getsockname()[1]}"
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def first_s(self, stop: bytes, since_s: float) -> float | None:
        """When the bytes came first after a moment, seconds after it."""
        return next((at_s - since_s for at_s, data in list(self.heard) if at_s >= since_s and stop in data), None)

    def close(self) -> None:
        for end in [self.listener, *list(self.ends)]:
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()
        self.thread.join(5.0)

    def _serve(self) -> None:
        while True:
            try:
                caller, _ = self.listener.accept()
            except OSError:
                return
            machine = socket.create_connection(self.target)
            for end in (caller, machine):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.ends += [caller, machine]
            threading.Thread(target=self._between, args=(caller, machine), daemon=True).start()

    def _between(self, caller: socket.socket, machine: socket.socket) -> None:
        """Both ways until both have ended."""
        answers = threading.Thread(target=self._relay, args=(machine, caller, False), daemon=True)
        answers.start()
        self._relay(caller, machine, True)
        answers.join()
        for end in (caller, machine):
            self.ends.remove(end)
            end.close()

    def _relay(self, source: socket.socket, sink: socket.socket, is_question: bool) -> None:
        with suppress(OSError):
            while data := source.recv(4096):
                if is_question:
                    self.heard.append((self.clock.monotonic_s(), data))
                for part in self._parts(data, is_question):
                    if part.delay_s > 0.0:
                        threading.Thread(target=self._later, args=(part, sink), daemon=True).start()
                    else:
                        sink.sendall(part.data)
        with suppress(OSError):
            sink.shutdown(socket.SHUT_RDWR)

    def _parts(self, data: bytes, is_question: bool) -> tuple[Part, ...]:
        if self.faults is None:
            return (Part(data),)
        return self.faults.on_write(data) if is_question else self.faults.on_read(data)

    def _later(self, part: Part, sink: socket.socket) -> None:
        self.clock.sleep(part.delay_s)
        with suppress(OSError):
            sink.sendall(part.data)


class Hung:
    """Faults of a line on which the machine's answers come no more; it hears what it is told."""

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return ()
