"""Laws of the Maestro's driver: after an error bit no position is believed, arrival is a pulse that reads back."""

import pytest
from motion_bench import MotionBench, motion_bench, settings_of
from pydantic import ValidationError

from rig.devices.maestro import connect
from rig.errors import DeviceFault, DeviceSilent, RequestRefused
from rig.link import faults
from rig.motion.move import home_and_arrive, move_and_arrive
from rig.wire.maestro import SET_ACCELERATION, SET_SPEED, SET_TARGET, Errors


@pytest.mark.parametrize(
    "form",
    [{}, {"device_number": 12}, {"crc": True}, {"device_number": 3, "crc": True, "model": "mini"}],
    ids=["compact", "pololu", "compact with CRC", "pololu with CRC"],
)
def test_every_form_moves_the_servo(form: dict[str, object]) -> None:
    bench = motion_bench("maestro", **form)
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    assert move_and_arrive(bench.pitch, -45.0, bench.clock, bench.clock.sleep) == pytest.approx(-45.0, abs=0.05)
    assert bench.true_deg == pytest.approx(-45.0, abs=0.05)


def test_a_move_is_these_bytes() -> None:
    bench = motion_bench("maestro", acceleration=5, speed_dps=630.0)
    bench.home_all()
    sent: list[bytes] = []
    receive = bench.twin.receive
    bench.twin.receive = lambda data, now_s: (sent.append(data), receive(data, now_s))
    bench.pitch.start_move(0.0)
    # 630 deg/s on 5.56 us/deg is 3500 us/s: speed 140, as the guide's example; target 1500 us is 6000.
    assert bytes.fromhex("87 01 0C 01 89 01 05 00 84 01 70 2E") in sent


@pytest.mark.parametrize("bit", list(Errors))
def test_after_any_error_bit_the_position_is_lost_until_homed(bit: Errors) -> None:
    bench = motion_bench("maestro")
    bench.home_all()
    move_and_arrive(bench.pitch, 60.0, bench.clock, bench.clock.sleep)
    bench.twin.fail(bit, bench.clock.monotonic_s())
    bench.clock.sleep(60.0)
    for axis in bench.axes.values():
        state = axis.state()
        assert not state.is_homed
        assert "sent the servos home" in state.fault
    with pytest.raises(DeviceFault, match="nothing was sent; home the axis"):
        bench.pitch.start_move(10.0)
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == pytest.approx(0.0, abs=0.05)
    assert bench.pitch.state().fault == ""


def _limits_count_with_the_next_target(bench: MotionBench) -> None:
    """A controller that takes a limit of acceleration up with the next target, which no page denies."""
    for channel in bench.twin.channels:
        channel.limit_acceleration = lambda acceleration, now_s, channel=channel: setattr(
            channel, "acceleration", acceleration
        )


def _under_way(acceleration: int, speed_dps: float, *, at_once: bool) -> MotionBench:
    """A servo on its way from -170° to 170°, at about half of it."""
    bench = motion_bench("maestro", acceleration=acceleration, speed_dps=speed_dps)
    if not at_once:
        _limits_count_with_the_next_target(bench)
    bench.home_all()
    move_and_arrive(bench.pitch, -170.0, bench.clock, bench.clock.sleep)
    bench.pitch.start_move(170.0)
    while bench.true_deg < 0.0:
        bench.clock.sleep(0.02)
    return bench


UNDER_ACCELERATION = pytest.mark.parametrize(
    ("acceleration", "speed_dps"), [(0, 40.0), (4, 90.0), (4, 300.0), (1, 200.0)]
)
"""From no limit to one under which half of the way is spent on slowing down."""


@UNDER_ACCELERATION
@pytest.mark.parametrize("at_once", [True, False], ids=["limits count at once", "limits count with the next target"])
def test_a_stop_stops_where_the_servo_is_whatever_its_acceleration(
    acceleration: int, speed_dps: float, at_once: bool
) -> None:
    """Guide p. 43: under a limit of acceleration the speed ramps down only "as position approaches target"."""
    bench = _under_way(acceleration, speed_dps, at_once=at_once)
    told_deg, told_s = bench.true_deg, bench.clock.monotonic_s()
    bench.pitch.stop()
    while bench.clock.monotonic_s() < told_s + 5.0:
        bench.clock.sleep(0.02)
        # What a servo goes in the time of its stop's bytes, and the grain of its pulse.
        assert bench.true_deg == pytest.approx(told_deg, abs=0.05 * speed_dps + 0.1)
    assert not bench.pitch.state().is_moving


def test_a_stop_of_a_servo_that_stands_sends_it_nowhere() -> None:
    bench = motion_bench("maestro", acceleration=4)
    bench.home_all()
    move_and_arrive(bench.pitch, -45.0, bench.clock, bench.clock.sleep)
    sent = _sent(bench)
    bench.pitch.stop()
    assert not _is_sent(sent)


def _sent(bench: MotionBench, byte_s: float = 0.0) -> list[bytes]:
    """Keep what the controller is sent from here on; each piece takes ``byte_s`` on the line."""
    sent: list[bytes] = []
    receive = bench.twin.receive

    def heard(data: bytes, now_s: float) -> None:
        sent.append(data)
        receive(data, now_s)
        bench.clock.sleep(byte_s)

    bench.twin.receive = heard
    return sent


def _is_sent(sent: list[bytes]) -> bool:
    return any(byte in data for data in sent for byte in (SET_TARGET, SET_ACCELERATION, SET_SPEED))


@pytest.mark.parametrize("struck", [None, 2, 3])
def test_a_stop_over_a_line_that_was_just_opened_sends_a_servo_that_stands_nowhere(struck: int | None) -> None:
    """As it was measured: its place was sent as its target, twice; the line altered both alike, and it went by 40°."""
    bench = motion_bench("maestro")
    bench.home_all()
    pitch = connect(settings_of("maestro"), bench.stream)["pitch"]
    pitch.state()
    sent = _sent(bench)
    if struck is not None:  # one answer of the second look
        bench.faults.reads = {bench.faults.taken + struck: faults.flip_bit(1, 2)}
    pitch.stop()
    assert sent
    assert not _is_sent(sent)


@pytest.mark.parametrize(("speed", "acceleration"), [(1, 0), (0, 1), (1, 1), (8, 0)])
def test_a_stop_over_a_line_that_was_just_opened_stops_a_servo_that_creeps_or_has_just_begun(
    speed: int, acceleration: int
) -> None:
    """Its slowest is 25 µs of pulse a second; two answers may come so soon behind each other that they are the same."""
    bench = motion_bench("maestro")
    bench.home_all()
    pitch = connect(settings_of("maestro"), bench.stream)["pitch"]
    pitch.state()  # the line is trusted, and nothing slows the servo before it is asked
    channel, now_s = bench.twin.channels[1], bench.clock.monotonic_s()
    channel.limit_speed(speed, now_s)
    channel.limit_acceleration(acceleration, now_s)
    channel.aim(9000, now_s)
    pitch.stop()
    stopped_deg = bench.true_deg
    assert stopped_deg < 4.0
    bench.clock.sleep(10.0)
    assert bench.true_deg == pytest.approx(stopped_deg, abs=0.1)


def test_a_stop_of_a_servo_whose_answers_differ_waits_for_nothing() -> None:
    bench = motion_bench("maestro", speed_dps=40.0)
    bench.home_all()
    bench.pitch.start_move(90.0)
    pitch = connect(settings_of("maestro"), bench.stream)["pitch"]
    pitch.state()
    sent, began_s = _sent(bench, 0.01), bench.clock.monotonic_s()
    pitch.stop()
    assert _is_sent(sent)
    assert bench.clock.monotonic_s() - began_s < 0.1


@UNDER_ACCELERATION
def test_what_the_guard_sends_first_slows_a_servo_at_once(acceleration: int, speed_dps: float) -> None:
    """25 µs of pulse a second, 4.5° a second here, and not the speed that it had."""
    bench = _under_way(acceleration, speed_dps, at_once=True)
    told_deg = bench.true_deg
    bench.stream.write(bench.pitch.stop_steps()[0].send)
    bench.clock.sleep(2.0)
    assert told_deg <= bench.true_deg <= told_deg + 2.0 * 4.5 + 0.1


def test_an_error_during_a_move_ends_it() -> None:
    bench = motion_bench("maestro")
    bench.home_all()
    fails_s = bench.clock.monotonic_s() + 5.0

    def wait(duration_s: float) -> None:
        bench.clock.sleep(min(duration_s, 0.1))
        if fails_s <= bench.clock.monotonic_s() < fails_s + 0.15:
            bench.twin.fail(Errors.TIMEOUT, bench.clock.monotonic_s())

    with pytest.raises(DeviceFault, match="pitch: move to 90°: the controller reported timeout"):
        move_and_arrive(bench.pitch, 90.0, bench.clock, wait)


def test_an_error_between_command_and_look_is_told_at_once() -> None:
    bench = motion_bench("maestro", crc=True)
    bench.home_all()
    bench.faults.writes = {bench.faults.written + 3: faults.flip_bit(6, 0)}  # errors, position, errors, then the move
    with pytest.raises(DeviceFault, match="the controller reports crc: every servo went to its home"):
        bench.pitch.start_move(30.0)


def test_a_target_that_is_never_reached_is_a_stall() -> None:
    bench = motion_bench("maestro")
    bench.home_all()
    bench.twin.channels[1].settings = type(bench.twin.channels[1].settings)(high=6200)  # clamped: 9 deg
    with pytest.raises(DeviceFault, match=r"no progress in 2 s"):
        move_and_arrive(bench.pitch, 60.0, bench.clock, bench.clock.sleep)


def test_a_servo_without_pulses_is_not_homed() -> None:
    bench = motion_bench("maestro")
    bench.home_all()
    bench.twin.channels[1].aim(0, bench.clock.monotonic_s())
    assert not bench.pitch.state().is_homed
    assert bench.axes["roll"].state().is_homed


def test_a_running_script_is_refused() -> None:
    bench = motion_bench("maestro")
    bench.twin.is_script_running = True
    with pytest.raises(DeviceFault, match="a script runs on the controller"):
        bench.pitch.home()
    assert bench.pitch.identify() == "Maestro (micro), channel 1, script running"


def test_a_silent_controller_is_silent_and_no_target_is_sent_again() -> None:
    bench = motion_bench("maestro")
    bench.home_all()
    sent: list[bytes] = []
    receive = bench.twin.receive
    bench.twin.receive = lambda data, now_s: (sent.append(data), receive(data, now_s))
    bench.faults.reads = dict.fromkeys(range(bench.faults.taken + 3, bench.faults.taken + 60), faults.drop)
    with pytest.raises(DeviceSilent, match="maestro: no complete reply"):
        bench.pitch.start_move(30.0)
    assert len([data for data in sent if b"\x84\x01" in data]) == 1


@pytest.mark.parametrize("device_number", [None, 5])
def test_a_controller_that_detects_its_rate_moves_no_servo_when_the_line_is_opened_again(
    device_number: int | None,
) -> None:
    """The rate is told by the first byte of whole commands: alone it is an error, which sends every servo home."""
    bench = motion_bench("maestro", detect_baud=True, device_number=device_number)
    assert bench.faults.written == 0
    bench.home_all()
    move_and_arrive(bench.pitch, 30.0, bench.clock, bench.clock.sleep)
    mark = bench.pitch.home_mark()
    settings = settings_of("maestro", detect_baud=True, device_number=device_number)
    second = connect(settings, bench.stream)["pitch"]
    assert second.home_mark() == mark
    assert second.identify() == bench.pitch.identify()
    assert bench.true_deg == pytest.approx(30.0, abs=0.05)
    assert bench.pitch.state().is_homed


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ({"points": [[1500.0, 0.0]]}, "two or more"),
        ({"pulse_limits_us": [992.0, 2000.0]}, r"limits_deg reach -180°, a pulse of 500 µs, allowed 992 to 2000"),
        ({"speed_dps": 4.0}, r"one unit of the servo's speed is 4\.5 °/s"),
        ({"acceleration": 256}, "less than or equal to 255"),
    ],
)
def test_settings_that_cannot_work_are_refused(wrong: dict[str, object], expected: str) -> None:
    with pytest.raises(ValidationError, match=expected):
        settings_of("maestro", **wrong)


def test_no_servo_is_sent_anywhere_before_it_was_homed() -> None:
    bench = motion_bench("maestro")
    with pytest.raises(RequestRefused, match="not homed"):
        bench.pitch.start_move(10.0)
    assert bench.twin.channels[1].position(0.0) == 0


def test_the_micros_moving_state_is_never_asked() -> None:
    """The guide, page 58: on the Micro it may say 0 while a servo moves."""
    bench = motion_bench("maestro", model="micro")
    requests: list[bytes] = []
    receive = bench.twin.receive

    def listen(data: bytes, now_s: float) -> None:
        requests.append(data)
        receive(data, now_s)

    bench.twin.receive = listen
    bench.pitch.identify()
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    move_and_arrive(bench.pitch, 90.0, bench.clock, bench.clock.sleep)
    bench.pitch.stop()
    assert len(requests) > 10
    assert not any(0x93 in packet for packet in requests)


def test_fault_51_after_a_brown_out_of_the_controller_no_servo_has_a_position() -> None:
    """It starts anew: no pulses, no limits of speed, and its error register empty."""
    bench = motion_bench("maestro")
    bench.home_all()
    move_and_arrive(bench.pitch, 60.0, bench.clock, bench.clock.sleep)
    bench.twin.power_cycle(bench.clock.monotonic_s())
    for axis in bench.axes.values():
        assert not axis.state().is_homed
        with pytest.raises(RequestRefused, match="not homed; nothing moved"):
            axis.start_move(10.0)
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == pytest.approx(0.0, abs=0.05)
    assert move_and_arrive(bench.pitch, 60.0, bench.clock, bench.clock.sleep) == pytest.approx(60.0, abs=0.05)


def test_fault_51_a_brown_out_in_mid_move_ends_it() -> None:
    bench = motion_bench("maestro")
    bench.home_all()
    fails_s = bench.clock.monotonic_s() + 5.0

    def wait(duration_s: float) -> None:
        bench.clock.sleep(min(duration_s, 0.1))
        if fails_s <= bench.clock.monotonic_s() < fails_s + 0.15:
            bench.twin.power_cycle(bench.clock.monotonic_s())

    with pytest.raises(RequestRefused, match="the axis is not homed; nothing moved; home it first"):
        move_and_arrive(bench.pitch, 90.0, bench.clock, wait)
    assert not bench.pitch.state().is_homed
