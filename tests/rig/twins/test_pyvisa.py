"""Somebody else's software speaks to the twins: pyvisa-py through its own Prologix support, over TCP and a pty."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count

import pytest
import pyvisa
from gpib_rig import gpib_rig
from pyvisa.resources import MessageBasedResource

from rig.clock import SystemClock
from rig.errors import DeviceSilent, LinkClosed, RequestRefused
from rig.link.visa import VisaBus
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp
from rig.wire import hp3458a

BOARDS = count(1)
"""pyvisa-py keeps its Prologix boards for the whole process: each test takes one of its own."""


def tcp_resource(server: TwinServer, board: int) -> str:
    host, port = server.address.removeprefix("socket://").split(":")
    return f"PRLGX-TCPIP{board}::{host}::{port}::INTFC"


def pty_resource(server: TwinServer, board: int) -> str:
    return f"PRLGX-ASRL{board}::{server.address}::INTFC"


Way = tuple[Callable[..., TwinServer], Callable[[TwinServer, int], str]]
WAYS = [pytest.param((serve_tcp, tcp_resource), id="tcp"), pytest.param((serve_pty, pty_resource), id="pty")]


@contextmanager
def board_on(way: Way) -> Iterator[tuple[int, pyvisa.ResourceManager]]:
    """A Prologix board of pyvisa-py joined to the twins; the adapter gets the time that a slow reading needs."""
    serve, resource = way
    board = next(BOARDS)
    manager = pyvisa.ResourceManager("@py")
    with serve(gpib_rig().adapter, SystemClock()) as server:
        interface = manager.open_resource(resource(server, board))
        assert isinstance(interface, MessageBasedResource)
        try:
            interface.write("++read_tmo_ms 3000")
            yield board, manager
        finally:
            interface.close()
            manager.close()


@contextmanager
def instrument(manager: pyvisa.ResourceManager, board: int, address: int) -> Iterator[MessageBasedResource]:
    opened = manager.open_resource(f"GPIB{board}::{address}::INSTR")
    assert isinstance(opened, MessageBasedResource)
    opened.timeout = 5000
    try:
        yield opened
    finally:
        opened.close()


@pytest.mark.parametrize("way", WAYS)
def test_pyvisa_identifies_configures_and_reads_the_meter(way: Way) -> None:
    with board_on(way) as (board, manager), instrument(manager, board, 22) as meter:
        meter.write("END ALWAYS;TARM HOLD;INBUF ON;OFORMAT ASCII")
        assert meter.query("ID?") == "HP3458A\r\n"
        assert meter.query("ERRSTR?") == '0,"NO ERROR"\r\n'
        meter.write("DCV 10;NPLC 1;NRDGS 1,AUTO")
        assert [float(part) for part in meter.query("FUNC?").split(",")] == [1.0, 10.0]
        with instrument(manager, board, 9) as scanner:
            assert scanner.query("ID?") == "HP3488A\r\n"
            scanner.write("CLOSE 102")
            assert scanner.query("VIEW 102") == "CLOSED 0\r\n"
        readings = []
        for _ in range(2):
            meter.write("TARM SGL")
            readings.append(float(meter.read()))
        assert readings == pytest.approx([-2.0 + 1e-6, -2.0 + 2e-6], rel=1e-9)


@pytest.mark.parametrize("way", WAYS)
def test_pyvisa_reads_by_talking_after_a_preset(way: Way) -> None:
    # 3458A user's guide: PRESET NORM leaves TRIG SYN, so addressing the meter to talk triggers one reading.
    with board_on(way) as (board, manager), instrument(manager, board, 22) as meter:
        meter.write("PRESET NORM;END ALWAYS")
        assert float(meter.read()) == 0.0  # no channel is closed


def test_a_visa_library_carries_the_same_bus() -> None:
    with board_on((serve_tcp, tcp_resource)) as (board, _):
        bus = VisaBus(f"GPIB{board}", SystemClock(), "@py")
        bus.send(22, b"END ALWAYS;TARM HOLD")
        assert bus.ask(22, b"ID?", hp3458a.parse_identity, idempotent=True) == "HP3458A"
        assert bus.ask(22, b"NPLC?", hp3458a.parse_number, idempotent=True, timeout_s=2.0) == 10.0
        bus.send(22, b"NPLC 1;NRDGS 1;INBUF ON")
        bus.send(22, b"TARM SGL")
        assert bus.read(22, hp3458a.parse_number) == 0.0
        bus.clear(22)
        with pytest.raises(DeviceSilent, match=rf"visa:GPIB{board} address 5: b'ID\?': no answer in time"):
            bus.ask(5, b"ID?", hp3458a.parse_identity, idempotent=False, timeout_s=0.2)
        bus.close()
        with pytest.raises(LinkClosed):
            bus.clear(22)


def test_a_visa_library_that_is_not_there_is_named() -> None:
    with pytest.raises(RequestRefused, match="visa:GPIB0: no VISA library"):
        VisaBus("GPIB0", SystemClock(), "/nowhere/libvisa.so@ivi")
