"""Laws of the VN-100 codec. Lines: VN-100 user manual UM001, and lines seen on real units in public repositories."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.errors import DeviceNonsense
from rig.wire import vn100 as wire

YMR = (
    b"$VNYMR,+100.949,-007.330,+000.715,-00.0049,-00.2449,+00.5397,-01.258,-00.100,-09.701,"
    b"-00.000018,+00.001122,-00.000551*69\r\n"
)
YMR_VALUES = (100.949, -7.33, 0.715, -0.0049, -0.2449, 0.5397, -1.258, -0.1, -9.701, -0.000018, 0.001122, -0.000551)
IMU = (
    b"$VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322*66\r\n"
)

SEEN = [
    YMR,
    IMU,
    b"$VNRRG,8*4B",  # UM001 3.6.1, request
    b"$VNRRG,08,-114.314,+000.058,-001.773*5F",  # UM001 3.6.1, response
    b"$VNRRG,1*42",
    b"$VNRRG,01,VN-100_v4*47",
    b"$VNRRG,01,VN-100T-CR*32",
    b"$VNRRG,03,066F00383733335843124251*2E",
    b"$VNRRG,04,10*5A",
    b"$VNRRG,07,40*5C",
    b"$VNWRG,07,40*59",
    b"$VNWRG,6,0*5C",
    b"$VNWRG,06,255,0*72",
    b"$VNWRG,5,115200*68",
    b"$VNASY,0*4F",
]


@pytest.mark.parametrize("line", SEEN)
def test_the_checksum_of_lines_seen_on_real_units(line: bytes) -> None:
    assert wire.message(line.strip()[1:-3]).strip() == line.strip()
    assert wire.parse_message(line)[0].startswith("VN")


@pytest.mark.parametrize("line", [b"$VNWRG,5,115200*60", b"$VNRRG,07*6E"])
def test_two_published_lines_are_wrong_and_refused(line: bytes) -> None:
    with pytest.raises(DeviceNonsense, match="the checksum is"):
        wire.parse_message(line)


def test_commands_are_these_bytes() -> None:
    assert wire.message(b"VNRRG,1") == b"$VNRRG,1*42\r\n"
    assert wire.message(b"VNWRG,%d,%d" % (wire.OUTPUT, wire.OFF)) == b"$VNWRG,6,0*5C\r\n"
    assert wire.message(b"VNWRG,%d,115200" % wire.BAUD_RATE) == b"$VNWRG,5,115200*68\r\n"
    assert wire.message(wire.PAUSE) == b"$VNASY,0*4F\r\n"


@pytest.mark.parametrize(("output", "line", "values"), [("YMR", YMR, YMR_VALUES)])
def test_a_streamed_line_is_its_numbers_and_back(output: str, line: bytes, values: tuple[float, ...]) -> None:
    rows = wire.parse_rows(line * 3, output, wire.row_pattern(output))
    np.testing.assert_array_equal(rows.values, [values] * 3)
    assert rows.refused == ()
    assert wire.format_row(output, values) == line
    assert wire.line_bytes(output) == len(line)


def test_the_line_of_the_raw_sensors() -> None:
    rows = wire.parse_rows(IMU, "IMU", wire.row_pattern("IMU"))
    assert rows.values.shape == (1, 11)
    assert rows.values[0, -2:].tolist() == [20.7, 84.322]
    assert wire.format_row("IMU", tuple(rows.values[0])) == IMU
    assert wire.line_bytes("IMU") == len(IMU)


def test_errors_are_hexadecimal_codes() -> None:
    # UM001 3.8: 0x03 invalid checksum, 0x0C insufficient baud rate.
    assert wire.parse_error(["VNERR", "03"]) == "invalid checksum"
    assert wire.parse_error(["VNERR", "0C"]) == "the baud rate is too low for this output and rate"
    assert wire.parse_error(["VNRRG", "01"]) is None


def test_any_checksum_stands_in_a_command_and_never_in_an_answer() -> None:
    # UM001 3.9.1.
    assert wire.parse_message(b"$VNRRG,1*XX", accept_bypass=True) == ["VNRRG", "1"]
    with pytest.raises(DeviceNonsense):
        wire.parse_message(b"$VNRRG,1*XX")


@given(st.integers(0, len(YMR) - 1), st.integers(1, 255))
def test_one_wrong_byte_is_never_another_sample(index: int, flip: int) -> None:
    damaged = bytearray(YMR)
    damaged[index] ^= flip
    rows = wire.parse_rows(bytes(damaged), "YMR", wire.row_pattern("YMR"))
    assert not len(rows.values) or rows.values.tolist() == [list(YMR_VALUES)]  # a lower-case letter changes nothing


@given(st.lists(st.one_of(st.just(YMR), st.binary(max_size=40).map(lambda noise: noise + b"\n"))))
def test_rubbish_between_samples_is_refused_where_it_stood(lines: list[bytes]) -> None:
    rows = wire.parse_rows(b"".join(lines), "YMR", wire.row_pattern("YMR"))
    assert len(rows.values) == lines.count(YMR)
    for refusal in rows.refused:
        assert 0 <= refusal.before <= len(rows.values)


@given(st.binary(max_size=80))
def test_no_bytes_make_another_error_than_nonsense(line: bytes) -> None:
    try:
        parts = wire.parse_message(line)
    except DeviceNonsense:
        return
    assert wire.checksum(",".join(parts).encode("ascii")) == int(line.split(b"*")[-1][:2], 16)
