"""Laws of the Maestro's twin. Times and units: Pololu Maestro user's guide, pages 32, 39, 42, 43, 56, 58."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_bench import motion_bench, settings_of, world_of

from rig.twins.maestro import ChannelSettings, MaestroTwin
from rig.wire.maestro import Errors, MaestroCodec, set_acceleration, set_speed, set_target

CODEC = MaestroCodec()


def _said(twin: MaestroTwin, packet: str, now_s: float) -> bytes:
    twin.receive(bytes.fromhex(packet), now_s)
    return twin.transmit(now_s)


def _twin(**settings: object) -> MaestroTwin:
    world = world_of(settings_of("maestro"))
    return MaestroTwin({}, world, **settings)  # type: ignore[arg-type]


def _position_us(twin: MaestroTwin, now_s: float) -> float:
    return int.from_bytes(_said(twin, "90 00", now_s), "little") / 4.0


def test_a_new_controller_sends_no_pulses_and_has_no_errors() -> None:
    twin = _twin()
    assert _said(twin, "90 00", 0.0) == b"\x00\x00"
    assert _said(twin, "A1", 0.0) == b"\x00\x00"
    assert _said(twin, "AE", 0.0) == b"\x01"  # no script runs


def test_the_guides_target_reads_back() -> None:
    twin = _twin()
    _said(twin, "84 00 70 2E", 0.0)
    assert _said(twin, "90 00", 0.0) == bytes.fromhex("70 17")
    _said(twin, "84 00 00 00", 1.0)
    assert _said(twin, "90 00", 1.0) == b"\x00\x00"  # target 0 stops the pulses


def _go(twin: MaestroTwin, speed: int, acceleration: int, target_us: float, now_s: float) -> None:
    for request in (
        set_speed(0, speed),
        set_acceleration(0, acceleration),
        set_target(0, round(4 * target_us)),
    ):
        twin.receive(CODEC.encode(request), now_s)


def test_speed_140_goes_350_us_in_100_ms() -> None:
    twin = _twin()
    _go(twin, 0, 0, 1000.0, 0.0)
    _go(twin, 140, 0, 1350.0, 10.0)
    assert _position_us(twin, 10.05) == pytest.approx(1175.0, abs=0.25)
    assert _position_us(twin, 10.0999) < 1350.0
    assert _position_us(twin, 10.1001) == 1350.0


def test_speed_1_takes_forty_seconds_and_speed_4_ten() -> None:
    for speed, duration_s in ((1, 40.0), (4, 10.0)):
        twin = _twin()
        _go(twin, 0, 0, 1000.0, 0.0)
        _go(twin, speed, 0, 2000.0, 10.0)
        assert _position_us(twin, 10.0 + duration_s - 0.01) < 2000.0
        assert _position_us(twin, 10.0 + duration_s + 0.01) == 2000.0


def test_acceleration_1_takes_about_three_seconds_and_4_is_1250_us_per_s2() -> None:
    twin = _twin()
    _go(twin, 0, 0, 1000.0, 0.0)
    _go(twin, 0, 1, 2000.0, 10.0)
    assert _position_us(twin, 12.5) < 2000.0
    assert _position_us(twin, 13.7) == 2000.0
    twin = _twin()
    _go(twin, 0, 0, 1000.0, 0.0)
    _go(twin, 0, 4, 2000.0, 10.0)
    assert _position_us(twin, 10.4) == pytest.approx(1000.0 + 0.5 * 1250.0 * 0.4**2, abs=0.25)


def test_on_a_mini_the_units_follow_the_period() -> None:
    twin = _twin(model="mini", period_ms=5)
    _go(twin, 0, 0, 1000.0, 0.0)
    _go(twin, 4, 0, 2000.0, 10.0)  # 1 us per 5 ms: 200 us/s
    assert _position_us(twin, 12.5) == pytest.approx(1500.0, abs=0.25)


def test_targets_are_brought_inside_the_channels_limits() -> None:
    twin = _twin(settings=ChannelSettings(low=4 * 1100, high=4 * 1900))
    _go(twin, 0, 0, 2200.0, 0.0)
    assert _position_us(twin, 0.0) == 1900.0
    _go(twin, 0, 0, 600.0, 0.0)
    assert _position_us(twin, 0.0) == 1100.0


def test_any_error_sends_every_servo_home_and_reading_clears_it() -> None:
    twin = _twin()
    _go(twin, 0, 0, 1900.0, 0.0)
    _said(twin, "84 00 A1", 1.0)  # an unfinished command
    assert _position_us(twin, 1.0) == 1500.0
    twin = _twin()
    for errors in (Errors.TIMEOUT, Errors.CRC):
        twin.fail(errors, 1.0)
    assert _said(twin, "A1", 1.0) == bytes([40, 0])
    assert _said(twin, "A1", 1.0) == b"\x00\x00"


def test_homes_may_be_off() -> None:
    twin = _twin(settings=ChannelSettings(home=0))
    _go(twin, 0, 0, 1900.0, 0.0)
    _said(twin, "A2", 1.0)
    assert _said(twin, "90 00", 1.0) == b"\x00\x00"


def test_the_micros_moving_state_lies_and_the_minis_does_not() -> None:
    for model, found in (("micro", b"\x00"), ("mini", b"\x01")):
        twin = _twin(model=model)
        _go(twin, 0, 0, 1000.0, 0.0)
        _go(twin, 1, 0, 2000.0, 10.0)
        assert _said(twin, "93", 11.0) == found
        assert _said(twin, "93", 60.0) == b"\x00"


def test_several_targets_and_the_third_form() -> None:
    twin = _twin(model="mini")
    _said(twin, "9F 02 03 00 00 70 2E", 0.0)
    assert (_said(twin, "90 03", 0.0), _said(twin, "90 04", 0.0)) == (b"\x00\x00", bytes.fromhex("70 17"))
    _said(twin, "FF 00 7F", 0.0)
    assert _position_us(twin, 0.0) == 1500.0
    _said(twin, "FF 00 FE", 0.0)
    assert _position_us(twin, 0.0) == pytest.approx(1500.0 + 476.25, abs=0.25)


def test_a_channel_that_is_none_is_a_protocol_error() -> None:
    twin = _twin()
    assert _said(twin, "90 06", 0.0) == b""
    assert _said(twin, "A1", 0.0) == bytes([Errors.PROTOCOL, 0])


def test_a_controller_that_detects_its_baud_rate_hears_nothing_before_the_start_byte() -> None:
    twin = _twin(detects_baud=True)
    assert _said(twin, "A1 A1", 0.0) == b""
    assert _said(twin, "AA 0C 21", 0.0) == b"\x00\x00"  # guide, 5.c: it can be the first byte of a Pololu command
    twin.power_cycle(1.0)
    assert _said(twin, "A1", 1.0) == b""


def test_a_start_byte_alone_is_an_unfinished_command_to_a_controller_that_knows_its_rate() -> None:
    """The guide, 4.e: a command interrupted by another is a protocol error, and any error sends every servo home."""
    twin = _twin(detects_baud=True)
    _said(twin, "AA 0C 21", 0.0)
    _go(twin, 0, 0, 1900.0, 0.0)
    _said(twin, "AA", 1.0)
    assert _said(twin, "A1", 1.0) == bytes([Errors.PROTOCOL, 0])
    assert _position_us(twin, 1.0) == 1500.0


def test_the_servos_body_follows_its_pulse() -> None:
    bench = motion_bench("maestro")
    bench.home_all()
    bench.pitch.start_move(90.0)
    bench.clock.sleep(100.0)
    assert bench.true_deg == pytest.approx(90.0, abs=0.05)
    assert bench.world.axes["pitch"].rate_dps(bench.clock.monotonic_s()) == 0.0


@given(st.lists(st.binary(max_size=30), max_size=8))
def test_rubbish_never_breaks_it(rubbish: list[bytes]) -> None:
    twin = _twin()
    for piece in rubbish:
        twin.receive(piece, 1.0)
    twin.receive(bytes.fromhex("A1 A1 A1"), 2.0)
    twin.transmit(2.0)
    assert _said(twin, "A1", 2.0) == b"\x00\x00"
