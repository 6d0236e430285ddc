import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.errors import DeviceNonsense
from rig.wire import hp3458a as wire


def test_a_reading_is_a_whole_line() -> None:
    # Shapes of the 3458A user's guide and of an LTX test program: sign or space, digit, point, nine digits, exponent.
    assert wire.parse_number(b" 1.000000120E+00") == 1.00000012
    assert wire.parse_number(b"-1.234567890E-03") == -1.23456789e-3


def test_a_reading_is_read_by_value_and_not_by_column() -> None:
    assert wire.parse_number(b"200.000000E-03") == 0.2  # APER? of a real meter
    for line in (b"1.00000012", b"+1.00000012E0", b"  1.00000012E+00", b"1.00000012e+00"):
        assert wire.parse_number(line) == 1.00000012


def test_overload_is_the_mark_of_the_guide() -> None:
    # 3458A user's guide: overload in ASCII is plus or minus 1.0E+38.
    assert abs(wire.parse_number(b" 1.000000000E+38")) > wire.LARGEST_READING_V
    assert wire.parse_number(b"-1.000000000E+38") < -wire.LARGEST_READING_V


@pytest.mark.parametrize(
    "line",
    [b"", b" ", b"nan", b"inf", b"1_0", b"1.0E+00 ", b"1.0,2.0", b"1,5", b"0x1", b"1.0E+001", b"--1", b".E1", b"OVLD"],
)
def test_what_is_no_number_is_refused(line: bytes) -> None:
    with pytest.raises(DeviceNonsense):
        wire.parse_number(line)


@given(st.binary(max_size=24))
def test_no_bytes_make_a_wrong_number(line: bytes) -> None:
    try:
        value = wire.parse_number(line)
    except DeviceNonsense:
        return
    assert math.isfinite(value)
    assert value == float(line.decode("ascii"))


@given(st.floats(-1000.0, 1000.0))
def test_the_meter_s_format_keeps_nine_digits_behind_the_point(value_v: float) -> None:
    line = wire.format_reading(value_v)
    assert len(line) == 18  # as the LTX program counts: sixteen characters, CR, LF
    assert wire.parse_number(line.removesuffix(b"\r\n")) == pytest.approx(value_v, rel=6e-10, abs=1e-98)


def test_both_spellings_of_the_identity_are_accepted() -> None:
    # HP and Agilent firmware answers HP3458A; the Keysight manual prints Keysight 3458A.
    assert wire.parse_identity(b"HP3458A") == "HP3458A"
    assert wire.parse_identity(b"Keysight 3458A") == "Keysight 3458A"


@pytest.mark.parametrize("line", [b"HP3457A", b"HP3458", b"HP3458AA", b"", b"HEWLETT-PACKARD,34401A,0,1"])
def test_another_instrument_is_refused(line: bytes) -> None:
    with pytest.raises(DeviceNonsense, match="3458A"):
        wire.parse_identity(line)


def test_error_strings_are_those_of_the_guide() -> None:
    # 3458A user's guide, ERRSTR?: 0,"NO ERROR" and 102,"TRIGGER TOO FAST".
    assert wire.parse_error(b'0,"NO ERROR"') == (0, "NO ERROR")
    assert wire.parse_error(b'102,"TRIGGER TOO FAST"') == (102, "TRIGGER TOO FAST")
    assert wire.format_error(0) == b'0,"NO ERROR"'
    assert wire.format_error(4) == b'102,"TRIGGER TOO FAST"'
    assert wire.format_error(4 | 8) == b'102,"TRIGGER TOO FAST"'  # the lowest bit first


def test_functions_and_counts_are_pairs() -> None:
    # 3458A user's guide: FUNC? tells function and range, NRDGS? count and event.
    assert wire.parse_pair(b"1,10") == (1.0, 10.0)
    # As read from a real meter: NRDGS? and FUNC? on the 10 V and the 0.1 V range.
    assert [wire.parse_pair(line) for line in (b"1, 1", b"1, 10", b"1, .1")] == [(1.0, 1.0), (1.0, 10.0), (1.0, 0.1)]
    assert wire.parse_pair(b"20,1") == (20.0, 1.0)
    for line in (b"1", b"1,", b",1", b"1,2,3", b"1;2"):
        with pytest.raises(DeviceNonsense):
            wire.parse_pair(line)


def test_mathematics_are_told_by_one_number_or_two() -> None:
    # 3458A user's guide, MATH: two operations may run, OFF 0, NULL 7, SCALE 11.
    answers = {b"0": 0.0, b"0,0": 0.0, b"7": 7.0, b"7,0": 7.0, b"0,11": 11.0, b"7,11": 7.0}
    assert {line: wire.parse_operations(line) for line in answers} == answers
    for line in (b"", b"0,", b"0,0,0", b"OFF"):
        with pytest.raises(DeviceNonsense):
            wire.parse_operations(line)


def test_the_status_byte_is_that_of_the_guide() -> None:
    # 3458A user's guide, STB?: bit 7 data available, bit 4 ready, bit 5 error, bit 3 power-on.
    status = wire.Status
    assert (status.DATA, status.READY, status.ERROR, status.POWER_ON, status.SERVICE) == (128, 16, 32, 8, 64)


@given(st.binary(max_size=30))
def test_no_bytes_make_another_error_than_nonsense(line: bytes) -> None:
    for parse in (wire.parse_error, wire.parse_pair, wire.parse_identity, wire.parse_reading):
        try:
            parse(line)
        except DeviceNonsense:
            continue
