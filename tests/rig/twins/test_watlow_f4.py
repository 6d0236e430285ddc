"""Laws of the chamber's twin. Frames: wire facts, section 4 (computed from the Modbus rule, two seen on the wire)."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymodbus import FramerType
from pymodbus.client import ModbusSerialClient, ModbusTcpClient

from rig.clock import Clock, SystemClock
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp
from rig.twins.watlow_f4 import WatlowF4Twin

FRAMES = {
    "read the process value": ("01 03 00 64 00 01 C5 D5", "01 03 02 00 FD 79 C5"),  # 25.3 °C
    "write -20.5 by function 16": ("01 10 01 2C 00 01 02 FF 33 B0 D9", "01 10 01 2C 00 01 C1 FC"),
    "write -20.5 by function 6": ("01 06 01 2C FF 33 48 1A", "01 06 01 2C FF 33 48 1A"),
    "an address that is none": ("01 03 7F FF 00 01 AD EE", "01 83 02 C0 F1"),
}


class Room:
    """An environment that holds what it is told."""

    def __init__(self) -> None:
        self.held_degc: list[float] = []

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return 25.3

    def setpoint_degc(self, environment: str) -> float:
        return self.held_degc[-1] if self.held_degc else 20.0

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        self.held_degc.append(setpoint_degc)


def _answer(twin: WatlowF4Twin, frame: bytes, now_s: float = 0.0) -> bytes:
    twin.receive(frame, now_s)
    return twin.transmit(now_s)


@pytest.mark.parametrize(("question", "answered"), FRAMES.values(), ids=list(FRAMES))
def test_published_frames(question: str, answered: str) -> None:
    assert _answer(WatlowF4Twin("air", Room()), bytes.fromhex(question)) == bytes.fromhex(answered)


def test_both_ways_of_writing_reach_the_room() -> None:
    room = Room()
    twin = WatlowF4Twin("air", room)
    _answer(twin, bytes.fromhex("01 10 01 2C 00 01 02 FF 33 B0 D9"))
    _answer(twin, bytes.fromhex("01 06 01 2C FF 33 48 1A"))
    assert room.held_degc == [-20.5, -20.5]


def test_a_frame_may_come_byte_by_byte() -> None:
    twin = WatlowF4Twin("air", Room())
    said = b"".join(_answer(twin, bytes([byte])) for byte in bytes.fromhex("01 03 00 64 00 01 C5 D5"))
    assert said == bytes.fromhex("01 03 02 00 FD 79 C5")


@pytest.mark.parametrize(
    "frame",
    ["01 03 00 64 00 01 C5 D6", "02 03 00 64 00 01 C5 E6"],
    ids=["wrong checksum", "another unit"],
)
def test_what_is_not_for_it_is_not_answered(frame: str) -> None:
    twin = WatlowF4Twin("air", Room())
    assert _answer(twin, bytes.fromhex(frame)) == b""
    # After a silence the line is as new.
    assert _answer(twin, bytes.fromhex("01 03 00 64 00 01 C5 D5"), 5.0) == bytes.fromhex("01 03 02 00 FD 79 C5")


def test_another_function_is_refused_by_exception_1() -> None:
    # Function 4 (input registers), checksum by the rule; answer 84 with code 1.
    assert _answer(WatlowF4Twin("air", Room()), bytes.fromhex("01 04 00 64 00 01 70 15")).startswith(b"\x01\x84\x01")


@given(st.binary(max_size=60))
def test_rubbish_changes_nothing(rubbish: bytes) -> None:
    room = Room()
    twin = WatlowF4Twin("air", room)
    _answer(twin, rubbish)
    assert room.held_degc == []
    assert _answer(twin, bytes.fromhex("01 03 00 64 00 01 C5 D5"), 60.0) == bytes.fromhex("01 03 02 00 FD 79 C5")


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty], ids=["tcp", "pty"])
def test_another_peoples_client_reads_and_writes_it(serve: Callable[[WatlowF4Twin, Clock], TwinServer]) -> None:
    """pymodbus' own synchronous client, RTU frames."""
    room = Room()
    with serve(WatlowF4Twin("air", room), SystemClock()) as server, _pymodbus_client(server.address) as client:
        assert client.read_holding_registers(100, count=1, device_id=1).registers == [253]
        assert client.read_holding_registers(606, count=1, device_id=1).registers == [1]
        assert not client.write_register(300, 0xFF33, device_id=1).isError()
        assert not client.write_registers(300, [255], device_id=1).isError()
        assert client.read_holding_registers(1, count=1, device_id=1).exception_code == 2
        assert client.write_register(300, 5000, device_id=1).exception_code == 3
    assert room.held_degc == [-20.5, 25.5]


def _pymodbus_client(address: str) -> ModbusTcpClient | ModbusSerialClient:
    if address.startswith("socket://"):
        host, port = address.removeprefix("socket://").split(":")
        return ModbusTcpClient(host, port=int(port), framer=FramerType.RTU, retries=0)
    return ModbusSerialClient(address, framer=FramerType.RTU, baudrate=9600, retries=0)
