"""Laws of the Maestro's bytes. Literal packets: Pololu Maestro user's guide, pages 42, 43, 52 to 58 (wire facts,
section 1); CRC bytes by the guide's rule; the captured ones are another people's client on the wire."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire import maestro as wire
from rig.wire.maestro import Errors, MaestroCodec, Request
from rig.wire.maestro_reader import Heard, MaestroReader, MiniSsc

COMPACT, POLOLU = MaestroCodec(), MaestroCodec(device=12)
SEVERAL_TARGETS = Request(wire.SET_MULTIPLE_TARGETS, (2, 3, *wire.number(0), *wire.number(6000)))
PACKETS = [
    (wire.set_target(0, 6000), "84 00 70 2E", "AA 0C 04 00 70 2E"),
    (wire.set_speed(5, 140), "87 05 0C 01", "AA 0C 07 05 0C 01"),
    (wire.set_acceleration(1, 5), "89 01 05 00", "AA 0C 09 01 05 00"),
    (wire.get_position(0), "90 00", "AA 0C 10 00"),
    (Request(wire.GET_MOVING_STATE), "93", "AA 0C 13"),
    (Request(wire.GET_ERRORS), "A1", "AA 0C 21"),
    (Request(wire.GO_HOME), "A2", "AA 0C 22"),
    (
        Request(wire.SET_MULTIPLE_TARGETS, (2, 3, *wire.number(0), *wire.number(6000))),
        "9F 02 03 00 00 70 2E",
        "AA 0C 1F 02 03 00 00 70 2E",
    ),
    (Request(wire.STOP_SCRIPT), "A4", "AA 0C 24"),
    (Request(wire.RESTART_SCRIPT, (3,)), "A7 03", "AA 0C 27 03"),
    (Request(wire.RESTART_SCRIPT_WITH, (3, *wire.number(300))), "A8 03 2C 02", "AA 0C 28 03 2C 02"),
    (Request(wire.GET_SCRIPT_STATUS), "AE", "AA 0C 2E"),
    (Request(wire.SET_PWM, (*wire.number(2400), *wire.number(4800))), "8A 60 12 40 25", "AA 0C 0A 60 12 40 25"),
    # Captured: 1500.25 us, and acceleration 4 on channel 0.
    (wire.set_target(0, 6001), "84 00 71 2E", "AA 0C 04 00 71 2E"),
    (wire.set_acceleration(0, 4), "89 00 04 00", "AA 0C 09 00 04 00"),
]
CRCS = [
    (COMPACT, wire.set_target(0, 6000), 0x2B),
    (POLOLU, wire.set_target(0, 6000), 0x22),
    (COMPACT, wire.set_speed(5, 140), 0x59),
    (COMPACT, wire.set_acceleration(1, 5), 0x19),
    (COMPACT, wire.get_position(0), 0x65),
    (COMPACT, Request(wire.GET_ERRORS), 0x1B),
]


@pytest.mark.parametrize(("request_", "compact", "pololu"), PACKETS, ids=[packet[1] for packet in PACKETS])
def test_a_command_is_these_bytes_in_both_forms(request_: Request, compact: str, pololu: str) -> None:
    for codec, packet in ((COMPACT, bytes.fromhex(compact)), (POLOLU, bytes.fromhex(pololu))):
        assert codec.encode(request_) == packet
        assert MaestroReader().take(packet) == [request_]


def test_the_guides_crc() -> None:
    assert wire.crc7(bytes.fromhex("83 01")) == 0x17


@pytest.mark.parametrize(("codec", "request_", "crc"), CRCS)
def test_a_crc_follows_where_it_is_switched_on(codec: MaestroCodec, request_: Request, crc: int) -> None:
    packet = MaestroCodec(codec.device, has_crc=True).encode(request_)
    assert packet == codec.encode(request_) + bytes([crc])
    assert MaestroReader(has_crc=True).take(packet) == [request_]


def test_a_wrong_crc_is_an_error_and_no_command() -> None:
    assert MaestroReader(has_crc=True).take(bytes.fromhex("84 00 70 2E 2C")) == [Errors.CRC]


def test_replies_are_plain_bytes() -> None:
    assert wire.decode_word(bytes.fromhex("70 17")) == 6000
    assert wire.encode_word(6000) == bytes.fromhex("70 17")


def test_the_third_form_has_no_crc_and_whole_bytes() -> None:
    assert MaestroReader(has_crc=True).take(bytes.fromhex("FF 03 FE")) == [MiniSsc(3, 254)]


@pytest.mark.parametrize("value", [-1, 16384])
def test_a_number_that_does_not_fit_is_refused(value: int) -> None:
    with pytest.raises(ValueError, match="14 bits"):
        wire.set_target(0, value)


@pytest.mark.parametrize(
    ("packet", "heard"),
    [
        ("84 00 A1", [Errors.PROTOCOL, Request(wire.GET_ERRORS)]),  # cut short by the next command
        ("81", [Errors.PROTOCOL]),  # no such command
        ("05", [Errors.PROTOCOL]),  # data without a command
        ("AA 0D 04 00 70 2E", []),  # another device on the line
        ("AA 0D 04 00 70 2E 90 00", [wire.get_position(0)]),
    ],
)
def test_what_is_no_command_is_an_error_bit(packet: str, heard: list[Heard]) -> None:
    assert MaestroReader().take(bytes.fromhex(packet)) == heard


def test_a_micro_knows_no_command_of_the_mini() -> None:
    assert Errors.PROTOCOL in MaestroReader(is_mini=False).take(bytes.fromhex("9F 01 03 70 2E"))


@given(st.binary(max_size=80), st.booleans())
def test_bytes_are_heard_alike_whole_and_one_by_one(data: bytes, has_crc: bool) -> None:
    whole = MaestroReader(has_crc=has_crc).take(data)
    reader = MaestroReader(has_crc=has_crc)
    assert [heard for byte in data for heard in reader.take(bytes([byte]))] == whole


@given(st.binary(max_size=40))
def test_after_rubbish_the_next_whole_command_is_heard(rubbish: bytes) -> None:
    reader = MaestroReader()
    reader.take(rubbish)
    # The third form swallows any two bytes; two questions are more than it can swallow.
    heard = reader.take(bytes.fromhex("A1 A1 A1"))
    assert heard[-1] == Request(wire.GET_ERRORS)


def test_error_bits_have_names() -> None:
    assert wire.error_words(Errors(0b100101000)) == "crc, timeout, program counter"
