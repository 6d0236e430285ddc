"""Laws of the ESP301's lines. Literal lines: ESP300 user's manual (TB, PA, TP), as in the wire facts, section 5.2."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire import esp301 as wire
from rig.wire.esp301 import Command, ErrorRecord


def test_commands_are_these_bytes() -> None:
    assert wire.encode(wire.ask("TP", 1)) == b"1TP?\r"
    assert wire.encode(wire.ask("TB")) == b"TB?\r"
    assert wire.encode(Command("MO", 2), Command("OR", 2, "1")) == b"2MO;2OR1\r"
    assert wire.encode(wire.set_value("PA", 1, 12.345)) == b"1PA12.345000\r"


def test_a_target_keeps_its_digits() -> None:
    # The trap of %g: 123.456789 became 123.457 on the wire of another library.
    assert wire.encode(wire.set_value("PA", 1, 123.456789)) == b"1PA123.456789\r"
    assert wire.encode(wire.set_value("PA", 1, -0.0)) == b"1PA0.000000\r"
    assert wire.encode(wire.set_value("PA", 1, 1e-7)) == b"1PA0.000000\r"


@given(st.floats(-1e5, 1e5))
def test_every_number_reads_back_within_half_a_millionth(value: float) -> None:
    (command,) = wire.decode_commands(wire.encode(wire.set_value("PA", 3, value))[:-1])
    assert command is not None
    assert (command.letters, command.axis) == ("PA", 3)
    assert abs(float(command.value) - value) <= 0.5000001e-6


def test_the_manuals_error_records() -> None:
    # TB? -> 0, 451322, NO ERROR DETECTED
    assert wire.decode_error(b"0, 451322, NO ERROR DETECTED") == ErrorRecord(0, 451322, "NO ERROR DETECTED")
    record = wire.decode_error(b"213, 451339, AXIS-2 MOTOR NOT ENABLED")
    assert record is not None
    assert (record.axis, record.is_empty) == (2, False)
    assert wire.encode_error(ErrorRecord(0, 451322, "NO ERROR DETECTED")) == b"0, 451322, NO ERROR DETECTED\r\n"


@pytest.mark.parametrize(
    ("line", "value"),
    [(b"12.345", 12.345), (b"-0.5", -0.5), (b"+3", 3.0), (b"  7 ", 7.0), (b".25", 0.25), (b"4.", 4.0)],
)
def test_a_number_is_a_plain_number(line: bytes, value: float) -> None:
    assert wire.decode_number(line) == value


@pytest.mark.parametrize("line", [b"", b"1e5", b"nan", b"inf", b"1_0", b"12.345 6", b"12,5", b"1.2.3", b"\xb2", b"-"])
def test_what_is_no_plain_number_is_none(line: bytes) -> None:
    assert wire.decode_number(line) is None


@given(st.binary(max_size=40))
def test_arbitrary_bytes_are_decoded_or_refused_and_never_infinite(line: bytes) -> None:
    number = wire.decode_number(line)
    assert number is None or math.isfinite(number)
    assert wire.decode_flag(line) in (None, True, False)
    wire.decode_error(line)
    wire.decode_version(line)
    wire.decode_commands(line)


def test_several_commands_in_a_line_are_taken_apart() -> None:
    assert wire.decode_commands(b"1pa 10; 2TP?;;VE?;9!") == [
        Command("PA", 1, "10"),
        Command("TP", 2, "?"),
        Command("VE", None, "?"),
        None,
    ]


def test_only_an_esp_tells_such_a_version() -> None:
    assert wire.decode_version(b"ESP300 Version 3.01") == "ESP300 Version 3.01"
    assert wire.decode_version(b"12.345") is None
    assert wire.decode_version(b"SMC100") is None
