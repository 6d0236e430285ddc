"""Laws of served twins: clients come and go, one at a time, and closing frees everything."""

import socket
import threading
from collections.abc import Iterator
from contextlib import suppress

import pytest

from rig.clock import ScaledClock, SystemClock
from rig.errors import LinkLost
from rig.link.byte_stream import ByteStream
from rig.link.ports import open_stream
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp


class Echo:
    """Answers every byte at once, and an ``L`` again ten rig seconds later."""

    def __init__(self) -> None:
        self._due = b""
        self._later: list[float] = []

    def receive(self, data: bytes, now_s: float) -> None:
        assert data != b"!", "told to fail"
        self._due += data
        self._later += [now_s + 10.0] * data.count(b"L")

    def transmit(self, now_s: float) -> bytes:
        ready = [due_s for due_s in self._later if due_s <= now_s]
        self._later = [due_s for due_s in self._later if due_s > now_s]
        due, self._due = self._due + b"l" * len(ready), b""
        return due

    def next_event_s(self) -> float | None:
        return min(self._later, default=None)


def _stream(server: TwinServer) -> ByteStream:
    return open_stream(server.address, clock=SystemClock())


def _answer(stream: ByteStream, data: bytes, length: int) -> bytes:
    stream.write(data)
    answer = b""
    deadline_s = SystemClock().monotonic_s() + 5.0
    while len(answer) < length and (more := stream.read(deadline_s)):
        answer += more
    return answer


@pytest.fixture(params=[serve_tcp, serve_pty], ids=["tcp", "pty"])
def server(request: pytest.FixtureRequest) -> Iterator[TwinServer]:
    with request.param(Echo(), SystemClock()) as served:
        yield served


def test_bytes_go_through_unchanged_and_whole(server: TwinServer) -> None:
    every_byte = bytes(range(256)).replace(b"L", b"").replace(b"!", b"") * 40
    stream = _stream(server)
    assert _answer(stream, every_byte, len(every_byte)) == every_byte
    stream.close()


def test_a_client_may_go_and_another_come(server: TwinServer) -> None:
    for number in range(5):
        stream = _stream(server)
        assert _answer(stream, b"%d" % number, 1) == b"%d" % number
        stream.close()


def test_time_is_the_servers_clock() -> None:
    with serve_tcp(Echo(), ScaledClock(100.0)) as server:
        stream = _stream(server)
        assert _answer(stream, b"L", 2) == b"Ll"  # ten rig seconds are a tenth of a second here
        stream.close()


def test_a_second_client_is_turned_away_and_the_first_goes_on() -> None:
    with serve_tcp(Echo(), SystemClock()) as server:
        first = _stream(server)
        assert _answer(first, b"a", 1) == b"a"
        host, port = server.address.removeprefix("socket://").split(":")
        with socket.create_connection((host, int(port)), timeout=5.0) as second:
            assert second.recv(1) == b""
        assert _answer(first, b"b", 1) == b"b"
        first.close()


def test_closing_frees_port_and_thread(server: TwinServer) -> None:
    server.close()
    server.close()
    assert not server.is_serving
    assert not any(thread.name == "twins" for thread in threading.enumerate())
    with pytest.raises(LinkLost):
        _stream(server)


def test_a_twin_that_fails_is_told_when_its_server_closes() -> None:
    server = serve_tcp(Echo(), SystemClock())
    stream = _stream(server)
    with pytest.raises(LinkLost):
        _answer(stream, b"!", 1)
    stream.close()
    with pytest.raises(AssertionError, match="told to fail"):
        server.close()
    assert not server.is_serving


def test_closing_while_a_twin_fails_tells_the_failure_or_nothing() -> None:
    for _ in range(60):
        server = serve_tcp(Echo(), SystemClock())
        stream = _stream(server)
        stream.write(b"!")
        with suppress(AssertionError):  # the twin's own, where its thread came so far
            server.close()  # before, while or after the thread ends by itself
        assert not server.is_serving
        stream.close()
