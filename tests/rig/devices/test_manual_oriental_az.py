"""What the maker's pages and a public driver with page numbers say of the AZ: docs/devices/oriental-az.md."""

import pytest
from motion_bench import MotionBench, motion_bench

from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, RequestRefused
from rig.motion.move import home_and_arrive
from rig.twins.oriental_az import OrientalAzTwin
from rig.wire import oriental_az as wire

READ_SIGNALS = "01 03 01 78 00 02 45 EE"


def _said(bench: MotionBench, frame: str) -> bytes:
    twin: OrientalAzTwin = bench.twin
    now_s = bench.clock.monotonic_s()
    twin.receive(bytes.fromhex(frame), now_s)
    return twin.transmit(now_s)


def _homed(**settings: object) -> MotionBench:
    bench = motion_bench("oriental-az", **settings)
    bench.home_all()
    return bench


def test_home_end_goes_off_when_an_operation_starts_and_abspen_stays() -> None:
    # HP-5142 p. 194: "The HOME-END output is … turned OFF when operation is started"; "The ABSPEN output is turned ON
    # when the coordinates are set". Frames: docs/devices/oriental-az.md, "Internal output signals" (computed).
    bench = _homed()
    assert _said(bench, READ_SIGNALS) == bytes.fromhex("01 03 04 00 03 04 10 09 3F")
    bench.pitch.start_move(40.0)
    assert _said(bench, READ_SIGNALS) == bytes.fromhex("01 03 04 00 02 00 40 5A 03")
    bench.clock.sleep(60.0)
    assert _said(bench, READ_SIGNALS) == bytes.fromhex("01 03 04 00 02 04 10 58 FF")


def test_a_second_move_is_not_refused_for_a_home_that_is_no_longer_the_place() -> None:
    bench = _homed()
    for target_deg in (40.0, -30.0, 0.0, 20.0):
        bench.pitch.start_move(target_deg)
        bench.clock.sleep(60.0)
        assert bench.pitch.state().is_homed
        assert bench.pitch.state().position_deg == target_deg


def test_coordinates_that_are_not_set_are_no_home() -> None:
    bench = motion_bench("oriental-az")
    assert _said(bench, READ_SIGNALS) == bytes.fromhex("01 03 04 00 00 04 10 F9 3F")
    with pytest.raises(RequestRefused, match="not homed"):
        bench.pitch.start_move(5.0)


def test_a_drive_without_these_registers_is_told_by_its_outputs_and_keeps_its_home() -> None:
    bench = motion_bench("oriental-az", signals="outputs")
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == 0.0
    for target_deg in (40.0, -30.0):
        bench.pitch.start_move(target_deg)
        bench.clock.sleep(60.0)
        assert bench.pitch.state().is_homed
    bench.twin.units[1].alarm = 0x30
    assert bench.pitch.state().fault == "alarm 0x30"
    bench.pitch.reset_alarm()
    assert not bench.pitch.state().is_homed  # after an alarm the latch is no proof


def test_what_the_outputs_mean_is_asked_for_where_the_registers_are_missing() -> None:
    bench = motion_bench("oriental-az")
    bench.twin.units[1].has_signals = False
    with pytest.raises(DeviceNonsense, match=r"0x178.*signals = 'outputs'.*axes\.pitch"):
        bench.pitch.identify()


@pytest.mark.parametrize(("bits", "name"), [(wire.STOP, "STOP"), (wire.FREE, "FREE")])
def test_an_input_that_another_program_left_on_keeps_ready_off_and_nothing_is_sent(bits: int, name: str) -> None:
    # "while on, READY stays off: write 0 again"; "a bit left on from another program stays on" (CL2).
    bench = _homed()
    bench.twin.units[1].write(wire.INPUTS, wire.words(bits), bench.clock.monotonic_s())
    with pytest.raises(DeviceRefused, match=rf"not READY .*inputs left on: {name}.*nothing moved"):
        bench.pitch.start_move(5.0)
    bench.clock.sleep(10.0)
    assert bench.true_deg == 0.0


def test_a_start_that_was_acknowledged_and_ignored_is_a_fault() -> None:
    # CL2: "Modbus commands can be silently ignored and also not trip an alarm, e.g. move_to raises no errors".
    bench = _homed()
    bench.pitch.start_move(8.0)
    bench.clock.sleep(60.0)
    bench.twin.units[1].ignores_starts = True
    for start in (lambda: bench.pitch.start_move(5.0), lambda: bench.pitch.start_rate(5.0), bench.pitch.home):
        with pytest.raises(DeviceFault, match="acknowledged, but the motor does not start"):
            start()
    assert bench.true_deg == 8.0


def test_a_move_of_no_length_is_no_ignored_one() -> None:
    # "READY going off is the sign of acceptance; a move of zero length shows neither."
    bench = _homed()
    bench.pitch.start_move(0.0)
    assert bench.pitch.state().position_deg == 0.0


@pytest.mark.parametrize(("is_on", "expected"), [(True, None), (True, False), (False, True)])
def test_the_wrap_function_is_read_and_compared(is_on: bool, expected: bool | None) -> None:
    # Remembered: on as delivered, positions jump at half a turn. Read, not assumed.
    bench = motion_bench("oriental-az", wrap=expected, top_rate_dps=None if expected else 180.0)
    bench.twin.units[1].wraps = is_on
    with pytest.raises(DeviceRefused, match=r"wrap function is (on|off).*axes\.pitch: wrap"):
        bench.pitch.identify()


def test_a_drive_that_wraps_only_positions() -> None:
    bench = motion_bench("oriental-az", wrap=True, top_rate_dps=None)
    bench.twin.units[1].wraps = True
    assert "wrap on" in bench.pitch.identify()
    with pytest.raises(ValueError, match="wrap"):
        motion_bench("oriental-az", wrap=True, top_rate_dps=180.0)


def test_a_drive_that_does_not_tell_its_wrap_needs_it_in_the_file() -> None:
    bench = motion_bench("oriental-az")
    bench.twin.units[1].has_parameters = False
    with pytest.raises(DeviceNonsense, match=r"does not tell .*wrap = false.*axes\.pitch"):
        bench.pitch.identify()
    known = motion_bench("oriental-az", wrap=False)
    known.twin.units[1].has_parameters = False
    assert "wrap off by the rig file" in known.pitch.identify()


@pytest.mark.parametrize("code", [3, 5, 6])
def test_a_drive_that_is_busy_is_not_one_that_does_not_tell_its_wrap(code: int) -> None:
    # A wrap that the file says is off and the drive has on: positions jump at half a turn.
    bench = motion_bench("oriental-az", wrap=False)
    bench.twin.units[1].wraps = True
    bench.twin.slaves[1].refusals = {wire.PARAMETERS: code}
    with pytest.raises(DeviceRefused, match=f"exception {code}"):
        bench.pitch.identify()
    bench.twin.slaves[1].refusals = {wire.SIGNALS: code}
    with pytest.raises(DeviceRefused, match=f"exception {code}"):
        bench.pitch.state()


def test_the_electronic_gear_is_told_and_compared() -> None:
    assert "gear 1/1" in motion_bench("oriental-az").pitch.identify()
    bench = motion_bench("oriental-az", electronic_gear=(10, 1))
    with pytest.raises(DeviceRefused, match=r"electronic gear is 1/1, the rig file says 10/1 .*step_deg"):
        bench.pitch.identify()


def test_the_direction_that_counts_upward_is_told_and_compared() -> None:
    assert "direction 1" in motion_bench("oriental-az", motor_direction=1).pitch.identify()
    bench = motion_bench("oriental-az", motor_direction=0)
    with pytest.raises(
        DeviceRefused, match=r"rotation direction is 1, the rig file says 0 \(axes\.pitch: motor_direction"
    ):
        bench.pitch.home()
    assert bench.true_deg == 0.0


@pytest.mark.parametrize("change", [{"wraps": True}, {"gear": (10, 1)}, {"direction": 0}])
def test_what_somebody_sets_otherwise_during_a_run_is_found_before_the_next_start(change: dict[str, object]) -> None:
    bench = _homed()
    bench.pitch.start_move(5.0)
    bench.clock.sleep(60.0)
    for name, value in change.items():
        setattr(bench.twin.units[1], name, value)
    with pytest.raises((DeviceRefused, DeviceFault), match=r"wrap function is on|gear 1/1, .* (gear 10/1|direction 0)"):
        bench.pitch.start_move(10.0)
    assert bench.true_deg == pytest.approx(5.0, abs=0.02)


def test_software_limits_inside_the_files_are_refused() -> None:
    # HM p. 404: 0386h software overtravel (1 = deceleration stop), 0388h and 038Ah the limits in steps.
    bench = motion_bench("oriental-az")
    bench.twin.units[1].software_limits = (-9000, 9000)
    with pytest.raises(DeviceRefused, match=r"software limits .*-90 to 90° .*limits_deg"):
        bench.pitch.identify()
