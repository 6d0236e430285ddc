"""Laws of the AZ's twin, by frames and by other people's clients. Literal frames: wire facts, section 6."""

from collections.abc import Callable

import minimalmodbus
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_bench import motion_bench
from pymodbus import FramerType
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.framer.rtu import FramerRTU

from rig.clock import Clock, ScaledClock
from rig.twins.oriental_az import OrientalAzTwin
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp

START = (
    "01 10 00 58 00 10 20 00000000 00000002 00001388 000003E8 000003E8 000003E8 000003E8 00000001 F7 61",
    "01 10 00 58 00 10 40 16",
)
READ_POSITION, READ_STATUS = "01 03 00 CC 00 02 04 34", "01 03 00 7F 00 01 B5 D2"
STOP = "01 10 00 7C 00 02 04 00 00 00 20 F5 06"


def _said(twin: OrientalAzTwin, frame: str, now_s: float) -> bytes:
    twin.receive(bytes.fromhex(frame), now_s)
    return twin.transmit(now_s)


def _twin() -> OrientalAzTwin:
    twin: OrientalAzTwin = motion_bench("oriental-az").twin
    for unit in twin.units.values():
        unit.servo.home(0.0)
    return twin


def _position(twin: OrientalAzTwin, now_s: float) -> int:
    reply = _said(twin, READ_POSITION, now_s)
    assert reply[:3] == bytes.fromhex("01 03 04")
    return int.from_bytes(reply[3:7], "big", signed=True)


def test_the_worked_frames() -> None:
    twin = _twin()
    assert _said(twin, START[0], 100.0) == bytes.fromhex(START[1])
    assert _said(twin, READ_STATUS, 101.0)[3:5] == bytes.fromhex("20 00")  # MOVE; HOME-END went off with the start
    # 5000 steps at 1 kHz and 1 kHz/s: 1 s and 500 steps to ramp, the same to brake, 4 s between.
    assert _position(twin, 101.0) == 500
    assert _position(twin, 106.001) == 5000
    assert _said(twin, READ_STATUS, 107.0)[3:5] == bytes.fromhex("40 20")  # IN-POS and READY


READ_SILENCE, ARM_5_S = "01 03 13 8A 00 02", "01 10 13 8A 00 02 04 00 00 13 88"
READ_SIGNALS = "01 03 01 78 00 02 45 EE"


def test_power_that_fails_takes_what_was_written_by_modbus_and_leaves_the_place() -> None:
    """Facts: parameters that were written are in RAM; the ABZO encoder keeps the coordinates, ABSPEN stays on.

    At rest elsewhere, coordinates valid, HOME-END off: 01 03 04 00 02 04 10 58 FF.
    """
    twin = _twin()
    _said(twin, _with_crc(ARM_5_S), 99.0)
    assert _said(twin, _with_crc(READ_SILENCE), 99.5)[3:7] == bytes.fromhex("00 00 13 88")
    _said(twin, START[0], 100.0)
    at = _position(twin, 102.0)
    assert 0 < at < 5000
    twin.power_cycle(102.0)
    assert _said(twin, _with_crc(READ_SILENCE), 103.0)[3:7] == bytes(4)
    assert _position(twin, 200.0) == at  # it stands where it was, and nobody is waited for
    assert _said(twin, READ_SIGNALS, 200.0) == bytes.fromhex("01 03 04 00 02 04 10 58 FF")
    _said(twin, START[0], 201.0)
    assert _position(twin, 300.0) == at + 5000


def _with_crc(frame: str) -> str:
    data = bytes.fromhex(frame)
    return (data + FramerRTU.compute_CRC(data).to_bytes(2, "big")).hex()


def test_an_increment_adds_to_what_was_commanded() -> None:
    twin = _twin()
    _said(twin, START[0], 100.0)
    _said(twin, START[0], 200.0)
    assert _position(twin, 300.0) == 10000


def test_the_worked_stop_brakes() -> None:
    twin = _twin()
    _said(twin, START[0], 100.0)
    assert _said(twin, STOP, 102.0)[:6] == bytes.fromhex("01 10 00 7C 00 02")
    assert _position(twin, 104.0) == _position(twin, 200.0) == 2000  # 1500 at full speed, 500 to brake


def test_what_it_does_not_know_it_refuses() -> None:
    twin = _twin()
    # Unknown register 0x1000, checksum by the rule; answer 83 with code 2.
    assert _said(twin, "01 03 10 00 00 01 80 CA", 0.0)[:3] == bytes.fromhex("01 83 02")


def test_another_unit_on_the_line_does_not_answer_for_it() -> None:
    twin = _twin()
    _said(twin, START[0], 100.0)
    assert [round(unit.servo.position_deg(200.0) / 0.01) for unit in twin.units.values()] == [5000, 0]


def test_an_alarm_stops_nothing_new_from_starting_until_it_is_reset() -> None:
    twin = _twin()
    twin.units[1].alarm = 0x30
    _said(twin, START[0], 100.0)
    assert _position(twin, 200.0) == 0


@given(st.binary(max_size=60))
def test_rubbish_moves_nothing(rubbish: bytes) -> None:
    twin = _twin()
    twin.receive(rubbish, 50.0)
    twin.transmit(50.0)
    assert _position(twin, 1000.0) == 0


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty], ids=["tcp", "pty"])
def test_pymodbus_drives_it(serve: Callable[[OrientalAzTwin, Clock], TwinServer]) -> None:
    clock = ScaledClock(100.0)
    data = [0, 0, 0, 1, 0, 4500, 0, 3000, 0, 3000, 0, 3000, 0, 1000, 0, 1]
    with serve(_twin_of_now(clock), clock) as server, _pymodbus_client(server.address) as client:
        assert not client.write_registers(0x58, data, device_id=1).isError()
        while client.read_holding_registers(0x7F, count=1, device_id=1).registers[0] & 1 << 13:
            clock.sleep(1.0)
        assert client.read_holding_registers(0xCC, count=2, device_id=1).registers == [0, 4500]
        assert client.read_holding_registers(0x1000, count=1, device_id=1).exception_code == 2


def test_minimalmodbus_drives_it() -> None:
    clock = ScaledClock(100.0)
    with serve_pty(_twin_of_now(clock), clock) as server:
        unit = minimalmodbus.Instrument(server.address, 1, close_port_after_each_call=False)
        unit.serial.timeout = 2.0
        unit.write_registers(0x58, [0, 0, 0, 1, 0xFFFF, 0xEE6C, 0, 3000, 0, 3000, 0, 3000, 0, 1000, 0, 1])
        while unit.read_register(0x7F) & 1 << 13:
            clock.sleep(1.0)
        assert unit.read_long(0xCC, signed=True) == -4500
        unit.serial.close()


def _twin_of_now(clock: Clock) -> OrientalAzTwin:
    twin: OrientalAzTwin = motion_bench("oriental-az").twin
    for unit in twin.units.values():
        unit.servo.home(clock.monotonic_s())
    return twin


def _pymodbus_client(address: str) -> ModbusTcpClient | ModbusSerialClient:
    if address.startswith("socket://"):
        host, port = address.removeprefix("socket://").split(":")
        return ModbusTcpClient(host, port=int(port), framer=FramerType.RTU, retries=0)
    return ModbusSerialClient(address, framer=FramerType.RTU, baudrate=115200, retries=0)
