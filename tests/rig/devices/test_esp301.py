"""Laws of the ESP301's driver: silent commands are checked, a home is trusted only while nothing speaks against it."""

import pytest
from motion_bench import motion_bench

from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused
from rig.link import faults
from rig.motion.move import home_and_arrive, move_and_arrive


def test_every_command_is_followed_by_the_error_queue() -> None:
    bench = motion_bench("esp301")
    bench.home_all()
    bench.twin.axes[1].high_deg = 20.0  # somebody narrows the controller's limit at its front panel
    with pytest.raises(
        DeviceRefused, match=r"pitch: the controller refused '1PA30\.000000': error 106 AXIS-1 POSITIVE SOFTWARE LIMIT"
    ):
        bench.pitch.start_move(30.0)


def test_an_old_error_is_not_taken_for_the_answer_to_a_new_command() -> None:
    bench = motion_bench("esp301")
    bench.home_all()
    bench.twin.report(204, bench.clock.monotonic_s())
    bench.pitch.start_move(10.0)
    assert bench.axes["roll"].state().fault == "error 204 AXIS-2 ERROR"
    assert bench.pitch.state().fault == ""


def test_the_home_is_lost_with_the_power() -> None:
    bench = motion_bench("esp301")
    bench.home_all()
    bench.clock.sleep(100.0)
    bench.twin.power_cycle(bench.clock.monotonic_s())
    for axis in bench.twin.axes.values():
        axis.is_on = True  # a controller set to switch its motors on by itself
    assert not bench.pitch.state().is_homed
    with pytest.raises(RequestRefused, match="not homed"):
        bench.pitch.start_move(10.0)
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == 0.0


def test_the_home_is_lost_with_the_motor() -> None:
    bench = motion_bench("esp301")
    bench.home_all()
    bench.twin.axes[1].is_on = False  # somebody at the controller's front panel
    assert not bench.pitch.state().is_homed
    bench.twin.axes[1].is_on = True
    assert not bench.pitch.state().is_homed


def test_a_home_search_that_is_stopped_leaves_no_home() -> None:
    bench = motion_bench("esp301", homed_before=True)
    bench.twin.axes[1].is_on = True
    bench.twin.axes[1].servo.home(0.0)
    bench.clock.sleep(1.0)
    bench.pitch.start_move(90.0)
    bench.clock.sleep(60.0)
    bench.pitch.home()
    bench.clock.sleep(2.0)
    bench.pitch.stop()
    bench.clock.sleep(10.0)
    assert not bench.pitch.state().is_homed


def test_a_vouched_home_is_used_while_the_motor_is_on() -> None:
    bench = motion_bench("esp301", homed_before=True)
    assert not bench.pitch.state().is_homed  # its motor is off
    bench = motion_bench("esp301", homed_before=True)
    bench.twin.axes[1].is_on = True
    bench.twin.axes[1].servo.home(0.0)
    bench.clock.sleep(1.0)
    assert move_and_arrive(bench.pitch, 10.0, bench.clock, bench.clock.sleep) == 10.0


def test_a_controller_that_counts_in_another_unit_is_refused() -> None:
    bench = motion_bench("esp301")
    bench.twin.axes[1].unit = 2
    with pytest.raises(RequestRefused, match=r"pitch: the controller counts this axis in unit 2 \(SN\), allowed 7"):
        bench.pitch.home()
    assert not bench.twin.axes[1].is_on


def test_limits_of_the_controller_inside_those_of_the_file_are_refused() -> None:
    bench = motion_bench("esp301")
    bench.twin.axes[1].low_deg = -90.0
    with pytest.raises(RequestRefused, match=r"end the travel at -90 and 360°, inside those of the file, -180 to"):
        bench.pitch.home()


def test_a_speed_that_is_not_taken_is_a_fault() -> None:
    bench = motion_bench("esp301")
    bench.pitch.state()
    found = bench.faults.taken + 3  # SH?, TB? before, TB? after, then VA?
    bench.faults.reads = {found: faults.replace(b"3.000000\r\n")}
    with pytest.raises(DeviceFault, match="speed 5 °/s was sent, but reads back 3 °/s"):
        bench.pitch.home()


def test_a_move_is_sent_once_even_if_the_queue_cannot_be_read() -> None:
    bench = motion_bench("esp301")
    bench.home_all()
    bench.pitch.start_move(20.0)
    bench.clock.sleep(20.0)
    sent: list[bytes] = []
    receive = bench.twin.receive
    bench.twin.receive = lambda data, now_s: (sent.append(data), receive(data, now_s))
    # State (five questions), unit, zero and the queue before the command are answered, nothing after it.
    bench.faults.reads = dict.fromkeys(range(bench.faults.taken + 8, bench.faults.taken + 60), faults.drop)
    with pytest.raises(DeviceSilent):
        bench.pitch.start_move(30.0)
    assert sent.count(b"1PA30.000000\r") == 1


def test_a_late_position_is_never_taken_for_the_next_answer() -> None:
    bench = motion_bench("esp301")
    bench.home_all()
    bench.pitch.start_move(30.0)
    bench.clock.sleep(60.0)
    bench.faults.reads = {bench.faults.taken + 1: faults.delay(1.5)}  # TP?, answered while it is asked again
    assert bench.pitch.state().position_deg == 30.0
    assert bench.axes["roll"].state().position_deg == 0.0


def test_another_device_is_told_by_its_nonsense() -> None:
    bench = motion_bench("esp301")
    bench.faults.reads = dict.fromkeys(range(100), faults.replace(b"@01 0 OK IDLE -- 0\r\n"))
    with pytest.raises(DeviceNonsense, match="no ESP300, ESP301 or ESP302 answers to VE"):
        bench.pitch.identify()


def test_the_identity_tells_the_controllers_limits() -> None:
    text = motion_bench("esp301").pitch.identify()
    assert text == "ESP301 Version 3.01, axis 1, own limits -360 to 360 deg"


def test_a_motor_that_is_switched_off_while_its_line_is_up_is_a_fault_until_it_is_homed() -> None:
    """As it was seen: MF at the panel, and `1MO;1OR1` half a second later beside whoever had switched it off."""
    bench = motion_bench("esp301")
    bench.home_all()
    bench.twin.axes[1].is_on = False
    assert bench.pitch.state().fault == "the motor was switched off, not by calrig"
    with pytest.raises(DeviceFault, match="switched off, not by calrig; nothing moved"):
        bench.pitch.start_move(10.0)
    bench.twin.axes[1].is_on = True  # at the panel as well: that takes nothing back
    assert bench.pitch.state().fault
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == 0.0, "as a person asks for it"
    assert not bench.pitch.state().fault


def test_a_motor_without_power_was_not_switched_off_by_anybody() -> None:
    bench = motion_bench("esp301")
    bench.home_all()
    bench.clock.sleep(100.0)
    bench.twin.power_cycle(bench.clock.monotonic_s())
    state = bench.pitch.state()
    assert (state.is_homed, state.fault) == (False, "")
    assert not bench.axes["roll"].state().fault
