import os
import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import pytest
from gpib_rig import gpib_rig

from rig.clock import SystemClock
from rig.errors import LinkClosed, LinkLost, RequestRefused, RigBusy
from rig.link.byte_stream import ByteStream
from rig.link.ports import open_stream
from rig.twins.serving.servers import serve_pty, serve_tcp

CLOCK = SystemClock()


@contextmanager
def opened(url: str) -> Iterator[ByteStream]:
    stream = open_stream(url, clock=CLOCK)
    try:
        yield stream
    finally:
        stream.close()


@contextmanager
def accepted() -> Iterator[tuple[ByteStream, socket.socket]]:
    """A stream and the other end of its connection."""
    with ExitStack() as held:
        server = held.enter_context(socket.create_server(("127.0.0.1", 0)))
        stream = held.enter_context(opened(f"socket://127.0.0.1:{server.getsockname()[1]}"))
        peer = held.enter_context(server.accept()[0])
        yield stream, peer


@contextmanager
def pseudo_terminal() -> Iterator[tuple[str, Callable[[], None]]]:
    """Path of the device, and how to unplug it."""
    master, slave = os.openpty()
    with ExitStack() as held:
        other_side = held.enter_context(os.fdopen(master, "rb", buffering=0))
        held.callback(os.close, slave)
        yield os.ttyname(slave), other_side.close


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty])
def test_bytes_go_out_and_come_back(serve: object) -> None:
    with serve(gpib_rig().adapter, CLOCK) as server, opened(server.address) as stream:  # type: ignore[operator]
        assert stream.name == server.address
        stream.write(b"++ver\n")
        answer = b""
        while not answer.endswith(b"\n"):
            piece = stream.read(CLOCK.monotonic_s() + 5.0)
            assert piece
            answer += piece
        assert answer == b"Prologix GPIB-USB Controller version 6.107\r\n"


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty])
def test_silence_ends_at_the_deadline(serve: object) -> None:
    with serve(gpib_rig().adapter, CLOCK) as server, opened(server.address) as stream:  # type: ignore[operator]
        deadline_s = CLOCK.monotonic_s() + 0.05
        assert stream.read(deadline_s) == b""
        assert 0.0 <= CLOCK.monotonic_s() - deadline_s < 0.2
        assert stream.discard_input() == b""


def test_what_waits_is_taken_at_once() -> None:
    with accepted() as (stream, peer):
        peer.sendall(b"stale")
        assert stream.read(CLOCK.monotonic_s() + 5.0) == b"stale"
        peer.sendall(b"x" * 1000)
        first = stream.read(CLOCK.monotonic_s() + 5.0)
        assert first + stream.discard_input() in (b"x" * 1000, first)


def test_small_messages_leave_at_once() -> None:
    with accepted() as (stream, _):
        assert stream._socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) != 0  # type: ignore[attr-defined]


def test_a_peer_that_hangs_up_is_a_lost_link_with_the_port_s_name() -> None:
    with accepted() as (stream, peer):
        peer.close()
        with pytest.raises(LinkLost, match=r"socket://127\.0\.0\.1:\d+: connection lost: the other side closed"):
            stream.read(CLOCK.monotonic_s() + 5.0)


def test_nobody_at_the_address_is_a_lost_link() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(LinkLost, match=f"socket://127.0.0.1:{port}: no connection within"):
        open_stream(f"socket://127.0.0.1:{port}", clock=CLOCK)


@pytest.mark.parametrize("url", ["socket://", "socket://host", "socket://host:0", "socket://host:99999", "socket://:1"])
def test_what_is_no_address_is_refused(url: str) -> None:
    with pytest.raises(RequestRefused, match="not a TCP address"):
        open_stream(url, clock=CLOCK)


def test_a_missing_device_is_named() -> None:
    with pytest.raises(LinkLost, match=r"/dev/no-such-port: cannot be opened: .* check the cable and the path"):
        open_stream("/dev/no-such-port", clock=CLOCK)


def test_a_url_that_nobody_knows_is_refused() -> None:
    with pytest.raises(RequestRefused, match="carrier-pigeon://loft: not a port"):
        open_stream("carrier-pigeon://loft", clock=CLOCK)


def test_a_device_is_opened_once() -> None:
    busy = pytest.raises(RigBusy, match="another program has this port open")
    with pseudo_terminal() as (path, _), opened(path), busy:
        open_stream(path, clock=CLOCK)


@pytest.mark.parametrize("use", ["write", "read", "discard_input"])
def test_fault_21_an_unplugged_port_is_a_lost_link_however_it_shows_itself(use: str) -> None:
    # Measured on a pseudo-terminal: SerialException, bare OSError and termios.error all occur; is_open stays true.
    with pseudo_terminal() as (path, unplug), opened(path) as stream:
        unplug()
        calls = {
            "write": lambda: stream.write(b"x"),
            "read": lambda: stream.read(CLOCK.monotonic_s() + 1.0),
            "discard_input": stream.discard_input,
        }
        with pytest.raises(LinkLost, match=f"{path}: the port is gone or broken"):
            calls[use]()


def test_a_closed_port_says_so() -> None:
    with pseudo_terminal() as (path, _):
        stream = open_stream(path, clock=CLOCK)
        stream.close()
        stream.close()
        with pytest.raises(LinkClosed):
            stream.write(b"x")
    with accepted() as (stream, _):
        stream.close()
        with pytest.raises(LinkClosed):
            stream.read(0.0)


def test_a_pseudo_terminal_stands_in_for_a_line_with_parity() -> None:
    """It has none itself, and every time it is configured with one it answers that the argument is invalid."""
    with pseudo_terminal() as (path, _):
        for _ in range(2):
            stream = open_stream(path, clock=CLOCK, parity="E")
            for left_s in (0.01, 0.02):
                assert stream.read(CLOCK.monotonic_s() + left_s) == b""
            stream.close()
