"""Laws of the ESP301's twin, by its lines. Literal lines: ESP300 user's manual, as in the wire facts, section 5.2."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_bench import motion_bench

from rig.twins.esp301 import Esp301Twin


def _said(twin: Esp301Twin, line: bytes, now_s: float) -> bytes:
    twin.receive(line, now_s)
    return twin.transmit(now_s)


def _twin() -> Esp301Twin:
    twin: Esp301Twin = motion_bench("esp301").twin
    assert _said(twin, b"1MO;1OR1;2MO;2OR1\r", 0.0) == b""
    return twin


def test_the_manuals_exchanges() -> None:
    twin = _twin()
    assert _said(twin, b"8PA12.3\r", 10.0) == b""  # commands are silent, wrong ones too
    assert _said(twin, b"TE?\r", 10.0) == b"9\r\n"
    assert _said(twin, b"TE?\r", 10.0) == b"0\r\n"
    assert _said(twin, b"TB?\r", 180.52881) == b"0, 451322, NO ERROR DETECTED\r\n"
    assert _said(twin, b"1MD?\r1SN?\r", 200.0) == b"1\r\n7\r\n"


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (b"1XX\r", b"6"),
        (b"1VA-5\r", b"7"),
        (b"9TP\r", b"9"),
        (b"PA10\r", b"37"),
        (b"1PA\r", b"38"),
        (b"2PA400\r", b"206"),
        (b"2PA-400\r", b"207"),
        (b"1MF;1PA10\r", b"113"),
    ],
)
def test_errors_have_the_manuals_numbers(line: bytes, code: bytes) -> None:
    twin = _twin()
    assert _said(twin, line, 100.0) == b""
    assert _said(twin, b"TE?\r", 100.0) == code + b"\r\n"


def test_the_queue_holds_ten_and_gives_the_oldest_first() -> None:
    twin = _twin()
    _said(twin, b"1XX\r" + b"8PA1\r" * 10, 100.0)  # the eleventh pushes the first out
    assert _said(twin, b"TE?\r" * 11, 100.0) == b"9\r\n" * 10 + b"0\r\n"


def test_it_ramps_to_its_target_in_the_time_that_speed_and_acceleration_take() -> None:
    twin = _twin()
    _said(twin, b"1VA10;1AC20;1PA30\r", 100.0)
    # 0.5 s and 2.5 deg to reach 10 deg/s, the same to brake, 25 deg between: 3.5 s.
    assert _said(twin, b"1TP?\r", 100.5) == b"2.500000\r\n"
    assert _said(twin, b"1TP?;1MD?\r", 103.4) == b"29.900000\r\n0\r\n"
    assert _said(twin, b"1TP?;1MD?\r", 103.5001) == b"30.000000\r\n1\r\n"


def test_a_stop_brakes_and_ends_a_home_search_with_error_20() -> None:
    bench = motion_bench("esp301")
    twin = bench.twin
    _said(twin, b"1MO;1OR1\r", 0.0)
    _said(twin, b"1PA100\r", 50.0)
    _said(twin, b"1ST\r", 55.0)
    assert _said(twin, b"TE?\r", 60.0) == b"0\r\n"
    assert _said(twin, b"1MD?\r", 60.0) == b"1\r\n"
    _said(twin, b"1OR1\r", 100.0)
    _said(twin, b"1ST\r", 101.0)
    assert _said(twin, b"TE?\r", 110.0) == b"120\r\n"


def test_a_power_cycle_switches_the_motors_off_and_lies_about_the_position() -> None:
    bench = motion_bench("esp301")
    _said(bench.twin, b"1MO;1OR1\r", 0.0)
    _said(bench.twin, b"1PA30\r", 50.0)
    bench.twin.power_cycle(100.0)
    assert _said(bench.twin, b"1TP?;1MO?\r", 100.0) == b"0.000000\r\n0\r\n"
    assert bench.world.axes["pitch"].table_deg(100.0) == 30.0


def test_commands_may_come_byte_by_byte() -> None:
    twin = _twin()
    said = b"".join(_said(twin, bytes([byte]), 100.0) for byte in b"1PA5\r1MD?\r")
    assert said == b"0\r\n"


@given(st.lists(st.binary(max_size=30), max_size=8))
def test_rubbish_never_breaks_it(rubbish: list[bytes]) -> None:
    twin = _twin()
    for piece in rubbish:
        _said(twin, piece, 100.0)
    _said(twin, b"\r", 100.0)
    assert _said(twin, b"VE?\r", 300.0).endswith(b"ESP301 Version 3.01\r\n")
