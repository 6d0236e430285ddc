"""Laws of the SCPI codec. Literal lines: 34970A user's guide (scan list, blocks), 34970A/34972A command reference."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.errors import DeviceNonsense
from rig.wire import scpi


def test_the_scan_list_of_the_guide() -> None:
    # 34970A user's guide, ROUTe:SCAN?: after ROUT:SCAN (@101:103), and with an empty list.
    assert scpi.parse_scan_list(b"#214(@101,102,103)") == (101, 102, 103)
    assert scpi.parse_scan_list(b"#13(@)") == ()
    assert scpi.format_block(b"(@101,102,103)") == b"#214(@101,102,103)"
    assert scpi.format_block(b"(@)") == b"#13(@)"


def test_channel_lists_of_both_units() -> None:
    assert scpi.parse_channel_list("(@101:103)") == (101, 102, 103)
    assert scpi.parse_channel_list("(@1001)") == (1001,)
    assert scpi.parse_channel_list("(@101:103,205)") == (101, 102, 103, 205)
    assert scpi.channel_list([1001, 2040]) == b"(@1001,2040)"


def test_readings_of_the_guide() -> None:
    # 34970A/34972A command reference, R? with two readings: a block of readings.
    block = scpi.parse_block(b"#231+2.87536000E-04,+3.18131400E-03")
    assert scpi.parse_readings(block) == (2.87536e-04, 3.181314e-03)
    assert scpi.parse_readings(b"+2.61920000E+01") == (26.192,)
    assert scpi.format_reading(26.192) == b"+2.61920000E+01"


def test_the_overload_mark_keeps_its_sign() -> None:
    # 34970A/34972A command reference: ±9.9E+37 from the remote interface.
    assert scpi.parse_readings(b"+9.90000000E+37,-9.90000000E+37") == (scpi.OVERLOAD, -scpi.OVERLOAD)
    assert scpi.format_reading(-scpi.OVERLOAD) == b"-9.90000000E+37"
    assert scpi.OVERLOAD > scpi.LARGEST_READING


def test_errors_of_the_queue() -> None:
    # 34980A: the empty queue; SCPI-99 volume 2, error -113.
    assert scpi.parse_error(b'+0,"No error"') == scpi.NO_ERROR
    assert scpi.parse_error(b'-113,"Undefined header"') == (-113, "Undefined header")
    assert scpi.format_error(*scpi.NO_ERROR) == b'+0,"No error"'


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (-330, "Self-test failed"),
        (-313, "Calibration memory lost"),  # SCPI-99 vol. 2, 21.8.11
        (742, "Cal checksum failed, dc voltage"),
        (604, "Self-test: A/D sync stuck"),  # 34401A user's guide, chapter 5
        (514, "DC calibration data lost"),  # Keithley 2000 user's manual, appendix B
    ],
)
def test_what_a_unit_says_of_itself_is_harmful(number: int, text: str) -> None:
    assert scpi.is_harmful(number, text)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (-113, "Undefined header"),
        (-222, "Data out of range"),
        (-350, "Too many errors"),
        (-410, "Query INTERRUPTED"),
        (513, "RS-232 overrun error"),
        (550, "Command not allowed in local"),
    ],
)
def test_what_it_was_told_wrongly_is_not(number: int, text: str) -> None:
    assert not scpi.is_harmful(number, text)


def test_identities_seen_in_the_field() -> None:
    assert scpi.parse_identity(b"HEWLETT-PACKARD,34970A,0,13-2-2")[1] == "34970A"
    assert scpi.parse_identity(b"Agilent Technologies,34980A,MY53151561,2.51-2.43-2.07-1.05")[1] == "34980A"
    assert scpi.parse_identity(b"HEWLETT-PACKARD,34901A,0,1.0")[1] == "34901A"  # SYST:CTYP? 100
    assert scpi.parse_identity(b"HEWLETT-PACKARD,0,0,0")[1] == "0"  # an empty slot


def test_a_header_goes_on_where_the_one_before_it_stood() -> None:
    # SCPI-99 volume 1, 6.2.4: header path of a compound message.
    message = 'FORM:READ:CHAN ON;TIME OFF;:TRIG:COUN 3;*CLS;SOUR IMM;:DISP:TEXT "a;b"'
    assert list(scpi.split_message(message)) == [
        ("FORM:READ:CHAN", "ON"),
        ("FORM:READ:TIME", "OFF"),
        ("TRIG:COUN", "3"),
        ("*CLS", ""),
        ("TRIG:SOUR", "IMM"),
        ("DISP:TEXT", '"a;b"'),
    ]


@pytest.mark.parametrize(
    "line",
    [b"+2.6192E+0", b"+2.61920000E+1", b"+2.61920000", b"", b"nan", b"+2,61920000E+01", b"OL"],
)
def test_a_reading_that_lost_a_character_is_no_reading(line: bytes) -> None:
    with pytest.raises(DeviceNonsense):
        scpi.parse_readings(line)


@pytest.mark.parametrize(
    "line", [b"#214(@101,102,103", b"#214(@101,102,103) ", b"#2", b"#0", b"(@101)", b"#x3(@)", b""]
)
def test_a_block_that_is_not_whole_is_none(line: bytes) -> None:
    with pytest.raises(DeviceNonsense):
        scpi.parse_scan_list(line)


@pytest.mark.parametrize("text", ["(@103:101)", "(@101:)", "(@1)", "(@101,)", "@101", "(@10101)", "(@100:9999)"])
def test_what_is_no_channel_list(text: str) -> None:
    with pytest.raises(DeviceNonsense):
        scpi.parse_channel_list(text)


@given(st.floats(min_value=-300.0, max_value=300.0))
def test_a_reading_survives_the_wire(volts: float) -> None:
    ((read_v, channel),) = scpi.parse_named_readings(scpi.format_reading(volts) + b",101")
    assert channel == 101
    assert math.isclose(read_v, volts, rel_tol=6e-9, abs_tol=1e-97)


@given(st.lists(st.integers(100, 9999), max_size=60))
def test_a_scan_list_survives_the_wire(channels: list[int]) -> None:
    assert scpi.parse_scan_list(scpi.format_block(scpi.channel_list(channels))) == tuple(channels)


@given(st.binary(max_size=40) | st.text(alphabet='+-0123456789.E,#(@):"', max_size=30).map(str.encode))
def test_no_bytes_make_another_error_than_nonsense(line: bytes) -> None:
    parsers = (scpi.parse_scan_list, scpi.parse_number, scpi.parse_whole, scpi.parse_readings, scpi.parse_error)
    for parse in (*parsers, scpi.parse_named_readings, scpi.parse_identity, scpi.parse_block):
        try:
            value = parse(line)
        except DeviceNonsense:
            continue
        assert value is not None
    list(scpi.split_message(line.decode("latin-1")))
