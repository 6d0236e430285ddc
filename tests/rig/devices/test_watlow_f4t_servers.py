"""The F4T's driver against another maker's server: pymodbus' own simulator."""

import asyncio
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from rig.clock import SystemClock
from rig.devices.watlow_f4t import WatlowF4T, WatlowF4TSettings, connect
from rig.errors import DeviceRefused
from rig.link.ports import open_stream

# F4T manual, Modbus appendix: loop 1; low word first.
FLOATS = {2774: -70.0, 2776: 180.0, 2782: 20.0, 2820: 21.5}
MODES = {2730: 10, 2814: 10}


def _words(value: float) -> list[int]:
    high, low = struct.unpack(">HH", struct.pack(">f", value))
    return [low, high]


@contextmanager
def _pymodbus_server() -> Iterator[int]:
    """A free port on which pymodbus' own server holds the registers."""
    registers = [
        SimData(address, values=_words(value), datatype=DataType.REGISTERS) for address, value in FLOATS.items()
    ]
    registers += [SimData(address, values=[mode], datatype=DataType.REGISTERS) for address, mode in MODES.items()]
    ready, loop, ports = threading.Event(), asyncio.new_event_loop(), list[int]()
    servers: list[ModbusTcpServer] = []

    async def serve() -> None:
        device = SimDevice(id=1, simdata=sorted(registers, key=lambda data: data.address))
        server = ModbusTcpServer(device, address=("127.0.0.1", 0))
        servers.append(server)
        await server.serve_forever(background=True)
        ports.append(server.transport.sockets[0].getsockname()[1])
        ready.set()
        await server.serving

    thread = threading.Thread(target=loop.run_until_complete, args=(serve(),))
    thread.start()
    assert ready.wait(10.0)
    try:
        yield ports[0]
    finally:
        asyncio.run_coroutine_threadsafe(servers[0].shutdown(), loop).result(10.0)
        thread.join(10.0)
        loop.close()


@contextmanager
def _chamber(port: int) -> Iterator[WatlowF4T]:
    settings = WatlowF4TSettings(driver="watlow-f4t", values="degc", port=f"socket://127.0.0.1:{port}")
    stream = open_stream(settings.port, clock=SystemClock())
    try:
        yield connect("air", settings, stream)
    finally:
        stream.close()


def test_the_driver_reads_and_writes_a_pymodbus_server() -> None:
    with _pymodbus_server() as port, _chamber(port) as chamber:
        assert "set points from -70 to 180 degC" in chamber.identify()
        assert chamber.temperature_degc() == 21.5
        chamber.hold(-40.25)
        assert chamber.setpoint_degc() == -40.25


def test_a_register_that_its_server_does_not_have_is_told() -> None:
    with _pymodbus_server() as port:
        settings = WatlowF4TSettings(driver="watlow-f4t", values="degc", port=f"socket://127.0.0.1:{port}", loop=2)
        stream = open_stream(settings.port, clock=SystemClock())
        with pytest.raises(DeviceRefused, match="exception 2 "):
            connect("air", settings, stream).identify()
        stream.close()
