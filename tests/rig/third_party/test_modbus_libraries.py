"""Other people's Modbus libraries at both ends of our lines, and the fault of one that ours is built against (f5)."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import minimalmodbus
import pytest
from motion_bench import DRIVERS, settings_of
from pymodbus import FramerType
from pymodbus.client import ModbusSerialClient
from pymodbus.exceptions import ModbusException
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice
from pyModbusTCP.server import ModbusServer

from rig.clock import SystemClock
from rig.devices import watlow_f4, watlow_f4t
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.devices.watlow_f4t import WatlowF4TSettings
from rig.errors import DeviceNonsense, DeviceSilent
from rig.link.exchange import Patience
from rig.link.modbus import ModbusRtu
from rig.link.ports import open_stream
from rig.twins.serving.servers import serve_pty

TIMEOUT_S = 0.3
F4 = {0: 5270, 100: 253, 200: 0, 300: 200, 600: 1, 602: 64836, 603: 1800, 606: 1, 608: 0, 901: 1}
"""An F4 at 25.3 °C, set points from -70 to 180 °C."""


class SlowSlave:
    """A slave by literal frames that answers one question after the other: register n holds n, one answer is late."""

    def __init__(self, late_register: int, late_s: float) -> None:
        self._late_register = late_register
        self._late_s = late_s
        self._free_s = 0.0
        self._due: list[tuple[float, bytes]] = []

    def receive(self, data: bytes, now_s: float) -> None:
        register = int.from_bytes(data[2:4], "big")
        takes_s = self._late_s if register == self._late_register else 0.0
        self._free_s = max(self._free_s, now_s) + takes_s
        self._late_register = -1 if takes_s else self._late_register
        self._due.append((self._free_s, _checked(bytes([1, 3, 2]) + data[2:4])))

    def transmit(self, now_s: float) -> bytes:
        ready = b"".join(data for due_s, data in self._due if due_s <= now_s)
        self._due = [(due_s, data) for due_s, data in self._due if due_s > now_s]
        return ready

    def next_event_s(self) -> float | None:
        return min((due_s for due_s, _ in self._due), default=None)


def _checked(body: bytes) -> bytes:
    """With the Modbus checksum: polynomial A001 reflected, start FFFF, low byte first (serial line guide V1.02)."""
    crc = 0xFFFF
    for byte in body:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0xA001 if crc & 1 else 0)
    return body + crc.to_bytes(2, "little")


def test_fault_33_bare_pymodbus_gives_one_register_the_value_of_another() -> None:
    """The reason for a conversation of our own: no error, register 20 reads as register 10."""
    with serve_pty(SlowSlave(10, TIMEOUT_S + 0.15), SystemClock()) as server:
        client = ModbusSerialClient(server.address, framer=FramerType.RTU, timeout=TIMEOUT_S, retries=0)
        assert client.connect()
        with suppress(ModbusException):
            assert client.read_holding_registers(10, count=1, device_id=1).isError()
        found = client.read_holding_registers(20, count=1, device_id=1)
        assert not found.isError()
        assert found.registers == [10]
        client.close()


def test_fault_33_our_conversation_on_the_same_line_never_does() -> None:
    with serve_pty(SlowSlave(10, TIMEOUT_S + 0.15), SystemClock()) as server:
        stream = open_stream(server.address, clock=SystemClock())
        patience = Patience(timeout_s=TIMEOUT_S, quiet_s=0.2, attempts=1)
        master = ModbusRtu(stream, 1, patience=patience)
        master.set_sentinel(606, 606)
        with pytest.raises(DeviceSilent):
            master.read_holding(10)
        messages = []
        for register in (20, 30, 40):
            with suppress(DeviceNonsense, DeviceSilent):
                messages.append((register, master.read_holding(register)))
        assert messages
        assert all(values == (register,) for register, values in messages)
        stream.close()


@contextmanager
def _pymodbus_server(registers: dict[int, int], framer: FramerType) -> Iterator[str]:
    """A free port of pymodbus' own server; the address of the line to it."""
    data = [
        SimData(location, values=[value], datatype=DataType.REGISTERS) for location, value in sorted(registers.items())
    ]
    ready, loop, ports = threading.Event(), asyncio.new_event_loop(), list[int]()
    servers: list[ModbusTcpServer] = []

    async def serve() -> None:
        server = ModbusTcpServer(SimDevice(id=1, simdata=data), framer=framer, address=("127.0.0.1", 0))
        servers.append(server)
        await server.serve_forever(background=True)
        ports.append(server.transport.sockets[0].getsockname()[1])
        ready.set()
        await server.serving

    thread = threading.Thread(target=loop.run_until_complete, args=(serve(),))
    thread.start()
    assert ready.wait(10.0)
    try:
        yield f"socket://127.0.0.1:{ports[0]}"
    finally:
        asyncio.run_coroutine_threadsafe(servers[0].shutdown(), loop).result(10.0)
        thread.join(10.0)
        loop.close()


def test_the_f4s_driver_reads_and_writes_a_pymodbus_server() -> None:
    with _pymodbus_server(F4, FramerType.RTU) as address:
        settings = WatlowF4Settings(driver="watlow-f4", port=address)
        stream = open_stream(address, clock=SystemClock())
        chamber = watlow_f4.connect("air", settings, stream)
        assert chamber.temperature_degc() == 25.3
        chamber.hold(-20.5)
        assert chamber.setpoint_degc() == -20.5
        stream.close()


def test_the_azs_driver_starts_an_operation_on_a_pymodbus_server() -> None:
    """Its server moves nothing: what is seen is that the frames are Modbus, to the last register."""
    registers = dict.fromkeys([*range(0x58, 0x68), *range(0x7C, 0x82), *range(0xCC, 0xD2)], 0)
    # Full current; coordinates set, MOVE on (so that a start seems taken up) and READY; gear 1/1, no limits, no wrap.
    registers |= {0x65: 1000, 0x178: 2, 0x179: 1 << 4 | 1 << 6, **dict.fromkeys(range(0x17A, 0x180), 0)}
    registers |= dict.fromkeys(range(0x380, 0x390), 0) | {0x381: 1, 0x383: 1, 0x386: 0xFFFF, 0x387: 0xFFFF}
    with _pymodbus_server(registers, FramerType.RTU) as address:
        stream = open_stream(address, clock=SystemClock())
        axes = settings_of("oriental-az", axis=1)
        pitch = DRIVERS["oriental-az"].connect({"pitch": axes["pitch"]}, stream)["pitch"]
        state = pitch.state()
        assert (state.is_homed, state.position_deg, state.fault) == (True, 0.0, "")
        pitch.start_move(45.0)
        master = ModbusRtu(stream, 1)
        # Kind 1, 4500 steps, 500 Hz, 2000 Hz/s twice, 100 %, trigger 1.
        assert master.read_holding(0x58, 16) == (0, 0, 0, 1, 0, 4500, 0, 500, 0, 2000, 0, 2000, 0, 1000, 0, 1)
        stream.close()


def test_the_f4ts_driver_reads_and_writes_a_pymodbustcp_server() -> None:
    server = ModbusServer(host="127.0.0.1", port=0, no_block=True)
    # -70, 180, 20 and 21.5 degC as floats, low word first: C28C 0000, 4334 0000, 41A0 0000, 41AC 0000; automatic.
    for location, words in {
        2774: [0x0000, 0xC28C],
        2776: [0x0000, 0x4334],
        2782: [0x0000, 0x41A0],
        2820: [0x0000, 0x41AC],
        2730: [10],
        2814: [10],
    }.items():
        server.data_bank.set_holding_registers(location, words)
    server.start()
    try:
        port = server._service.server_address[1]
        settings = WatlowF4TSettings(driver="watlow-f4t", values="degc", port=f"socket://127.0.0.1:{port}")
        stream = open_stream(settings.port, clock=SystemClock())
        chamber = watlow_f4t.connect("air", settings, stream)
        assert chamber.temperature_degc() == 21.5
        chamber.hold(-40.25)
        assert server.data_bank.get_holding_registers(2782, 2) == [0x0000, 0xC221]
        stream.close()
    finally:
        server.stop()


def test_minimalmodbus_reads_and_writes_the_f4() -> None:
    """It writes one register by function 16."""
    from rig.twins.watlow_f4 import WatlowF4Twin

    held_degc: list[float] = []

    class Room:
        def read_temperature_degc(self, environment: str, now_s: float) -> float:
            return 25.3

        def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
            held_degc.append(setpoint_degc)

        def setpoint_degc(self, environment: str) -> float:
            return 20.0

    with serve_pty(WatlowF4Twin("air", Room()), SystemClock()) as server:
        unit = minimalmodbus.Instrument(server.address, 1, close_port_after_each_call=False)
        unit.serial.timeout = 2.0
        assert unit.read_register(100, 1, signed=True) == 25.3
        unit.write_register(300, -20.5, 1, signed=True)
        unit.serial.close()
    assert held_degc == [-20.5]
