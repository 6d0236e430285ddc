"""Laws of the F4T's twin. Frames: wire facts, section 4 (the RTU write), Modbus TCP headers by hand; third parties."""

import struct

import minimalmodbus
from hypothesis import given
from hypothesis import strategies as st
from pyModbusTCP.client import ModbusClient

from rig.clock import SystemClock
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.serving.servers import serve_tcp
from rig.twins.watlow_f4t import WatlowF4TTwin


class Room:
    """An environment that holds what it is told."""

    def __init__(self) -> None:
        self.held_degc: list[float] = []

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return 25.0

    def setpoint_degc(self, environment: str) -> float:
        return self.held_degc[-1] if self.held_degc else 20.0

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        self.held_degc.append(setpoint_degc)


WRITE_25_RTU = bytes.fromhex("01 10 0A DE 00 02 04 00 00 41 C8 30 19")
READ_PV_TCP = bytes.fromhex("12 34 00 00 00 06 01 03 0B 04 00 02")
PV_TCP = bytes.fromhex("12 34 00 00 00 07 01 03 04 00 00 41 C8")


def _tcp(room: Room | None = None) -> ModbusSlave:
    return ModbusSlave(WatlowF4TTwin("air", room or Room()), framing="tcp")


def _answer(slave: ModbusSlave, data: bytes, now_s: float = 0.0) -> bytes:
    slave.receive(data, now_s)
    return slave.transmit(now_s)


def test_the_published_write_reaches_the_room() -> None:
    room = Room()
    slave = ModbusSlave(WatlowF4TTwin("air", room))
    # The acknowledgement of function 16 is address and count; its checksum by the rule.
    assert _answer(slave, WRITE_25_RTU).startswith(bytes.fromhex("01 10 0A DE 00 02"))
    assert room.held_degc == [25.0]


def test_a_read_by_tcp_carries_the_transaction_back() -> None:
    assert _answer(_tcp(), READ_PV_TCP) == PV_TCP


def test_two_requests_in_one_piece_are_two_answers() -> None:
    assert _answer(_tcp(), READ_PV_TCP * 2) == PV_TCP * 2


def test_a_frame_may_come_byte_by_byte() -> None:
    slave = _tcp()
    assert b"".join(_answer(slave, bytes([byte])) for byte in READ_PV_TCP) == PV_TCP


def test_a_register_that_is_none_is_refused() -> None:
    text = bytes.fromhex("00 01 00 00 00 06 01 03 00 01 00 02")
    assert _answer(_tcp(), text) == bytes.fromhex("00 01 00 00 00 03 01 83 02")


def test_a_block_across_values_is_read_at_once() -> None:
    # 2774 and 2776: -70.0 is C28C 0000, 180.0 is 4334 0000; low word first.
    text = bytes.fromhex("00 01 00 00 00 06 01 03 0A D6 00 04")
    assert _answer(_tcp(), text)[9:] == bytes.fromhex("00 00 C2 8C 00 00 43 34")


@given(st.binary(max_size=80))
def test_rubbish_changes_nothing(rubbish: bytes) -> None:
    for framing in ("rtu", "tcp"):
        room = Room()
        slave = ModbusSlave(WatlowF4TTwin("air", room), framing=framing)  # type: ignore[arg-type]
        _answer(slave, rubbish)
        assert room.held_degc == [] or framing == "tcp"  # TCP has no checksum: a whole write is a write
    assert _answer(slave, READ_PV_TCP, 60.0) == PV_TCP


def _float(registers: list[int]) -> float:
    low, high = registers
    value: float = struct.unpack(">f", struct.pack(">HH", high, low))[0]
    return value


def _address(url: str) -> tuple[str, int]:
    host, port = url.removeprefix("socket://").split(":")
    return host, int(port)


def test_pymodbus_reads_and_writes() -> None:
    from pymodbus.client import ModbusTcpClient

    room = Room()
    with serve_tcp(_tcp(room), SystemClock()) as server:
        host, port = _address(server.address)
        with ModbusTcpClient(host, port=port, timeout=5) as client:
            read = client.read_holding_registers(2820, count=2, device_id=1)
            data_type = client.DATATYPE.FLOAT32
            assert client.convert_from_registers(read.registers, data_type, word_order="little") == 25.0
            words = client.convert_to_registers(-40.25, data_type, word_order="little")
            assert not client.write_registers(2782, words, device_id=1).isError()
            assert client.read_holding_registers(1, count=2, device_id=1).exception_code == 2
    assert room.held_degc == [-40.25]


def test_pymodbustcp_reads_and_writes() -> None:
    room = Room()
    with serve_tcp(_tcp(room), SystemClock()) as server:
        host, port = _address(server.address)
        client = ModbusClient(host=host, port=port, unit_id=1, timeout=5.0)
        assert _float(client.read_holding_registers(2820, 2)) == 25.0
        assert client.write_multiple_registers(2782, [0x0000, 0xC221])
        client.close()
    assert room.held_degc == [-40.25]


def test_minimalmodbus_reads_and_writes() -> None:
    from rig.twins.serving.servers import serve_pty

    room = Room()
    with serve_pty(ModbusSlave(WatlowF4TTwin("air", room)), SystemClock()) as server:
        instrument = minimalmodbus.Instrument(server.address, 1)
        instrument.serial.timeout = 2.0
        order = minimalmodbus.BYTEORDER_LITTLE_SWAP
        assert instrument.read_float(2820, byteorder=order) == 25.0
        instrument.write_float(2782, -40.25, byteorder=order)
        instrument.serial.close()
    assert room.held_degc == [-40.25]


def test_after_bytes_that_are_no_frame_the_next_frame_is_answered() -> None:
    slave = _tcp()
    assert _answer(slave, b"\x00\x01\x00\x00\xff\xff\x01\x03") == b""
    assert _answer(slave, READ_PV_TCP, 0.1) == PV_TCP
    assert _answer(slave, READ_PV_TCP[:7], 1.0) == b""
    assert _answer(slave, READ_PV_TCP, 5.0) == PV_TCP  # the unfinished one is forgotten
