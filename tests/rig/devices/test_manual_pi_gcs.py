"""What the C-863 manual and the maker's own client show of GCS 2.0, put to driver and twin: docs/devices/pi-gcs.md."""

import pytest
from motion_bench import MotionBench, motion_bench

from rig.devices.pi_gcs import PiGcsSettings, connect
from rig.errors import DeviceRefused, RequestRefused
from rig.link.memory import MemoryStream
from rig.twins.pi_gcs import PiGcsTwin
from rig.wire import pi_gcs as wire


def _said(bench: MotionBench, data: bytes) -> bytes:
    now_s = bench.clock.monotonic_s()
    bench.twin.receive(data, now_s)
    answer: bytes = bench.twin.transmit(now_s)
    return answer


def test_after_power_up_servo_and_reference_are_off() -> None:
    # EPICS ReadMe: "Some PIStages needs to be referenced after controller power up."
    bench = motion_bench("pi-gcs")
    assert _said(bench, b"SVO? 1\nFRF? 1\n") == b"1=0\n1=0\n"
    assert not bench.pitch.state().is_homed


def test_a_move_without_servo_or_reference_is_error_5_and_nothing_moves() -> None:
    # M863 p. 207: "Unallowable move attempted on unreferenced axis, or move attempted with servo off"
    bench = motion_bench("pi-gcs")
    assert _said(bench, b"MOV 1 12.5\nERR?\n") == b"5\n"
    assert _said(bench, b"ERR?\n") == b"0\n"  # reading takes it away
    bench.home_all()
    _said(bench, b"SVO 1 0\n")
    with pytest.raises(DeviceRefused, match="error 5, unallowable move attempted on unreferenced axis"):
        bench.pitch.start_move(10.0)
    assert bench.true_deg == pytest.approx(0.0)
    assert "servo is off" in bench.pitch.state().fault


def test_a_stop_sets_error_10_which_is_the_sign_that_it_was_obeyed() -> None:
    # M863 p. 207: "Controller was stopped by command"
    bench = motion_bench("pi-gcs")
    bench.home_all()
    bench.pitch.start_move(90.0)
    bench.clock.sleep(3.0)
    _said(bench, b"\x18")
    assert _said(bench, b"ERR?\n") == b"10\n"
    bench.clock.sleep(3.0)
    assert not bench.pitch.state().is_moving
    bench.pitch.start_move(90.0)
    bench.clock.sleep(3.0)
    bench.pitch.stop()
    assert _said(bench, b"ERR?\n") == b"0\n"


def test_an_error_left_by_somebody_else_is_not_laid_on_the_next_command() -> None:
    # PIP: the controller keeps one error, until it is asked for.
    bench = motion_bench("pi-gcs")
    bench.home_all()
    _said(bench, b"NONSENSE 1\n")
    bench.pitch.start_move(5.0)
    bench.clock.sleep(10.0)
    assert bench.true_deg == pytest.approx(5.0)


def test_answers_are_those_seen_on_the_wire() -> None:
    # PIP: POS? 1 -> 1=12.500000; several axes: every line but the last ends with space LF; #5 hexadecimal.
    bench = motion_bench("pi-gcs")
    bench.home_all()
    bench.pitch.start_move(12.5)
    assert _said(bench, b"\x05") == b"1\n"
    bench.clock.sleep(20.0)
    assert _said(bench, b"\x05") == b"0\n"
    assert _said(bench, b"POS? 1\n") == b"1=12.500000\n"
    assert _said(bench, b"POS?\n") == b"1=12.500000 \n2=0.000000\n"
    assert _said(bench, b"ONT? 1\n") == b"1=1\n"
    bench.axes["roll"].start_move(10.0)
    assert _said(bench, b"\x05") == b"2\n"


def test_a_stage_that_counts_in_millimetres_is_refused() -> None:
    bench = motion_bench("pi-gcs")
    for stage in bench.twin.stages.values():
        stage.unit = "MM"
    for work in (bench.pitch.identify, bench.pitch.home):
        with pytest.raises(DeviceRefused, match="the stage counts in MM, need degrees"):
            work()
    assert bench.twin.error == wire.NO_ERROR
    assert motion_bench("pi-gcs", states_unit=False).pitch.identify().endswith("axis 1")


def test_a_unit_that_changes_during_a_run_is_found_before_the_next_start() -> None:
    bench = motion_bench("pi-gcs")
    bench.home_all()
    for stage in bench.twin.stages.values():
        stage.unit = "MM"
    with pytest.raises(DeviceRefused, match="the stage counts in MM, need degrees"):
        bench.pitch.start_move(5.0)


def test_a_parameter_may_be_named_in_decimal_digits() -> None:
    # PIPython 2.11 on the wire: SPA? 1 117442049, which is 0x7000601.
    bench = motion_bench("pi-gcs")
    assert _said(bench, b"SPA? 1 117442049\nSPA? 1 0x7000601\n") == b"1 117442049=DEG\n1 0x7000601=DEG\n"
    assert wire.parse_unit(b"1 117442049=DEG", "1") == wire.parse_unit(b"1 0x7000601=deg", "1") == "DEG"
    assert _said(bench, b"SAI? ALL\n") == b"1 \n2\n"


def test_travel_that_ends_inside_the_limits_of_the_file_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rig.twins.pi_gcs.TRAVEL_DEG", (-100.0, 100.0))
    bench = motion_bench("pi-gcs")
    with pytest.raises(RequestRefused, match="the controller's own limits end the travel at -100 and 100°"):
        bench.pitch.home()


def test_an_absolute_encoder_needs_no_home() -> None:
    # EPICS ReadMe: "The correct absolute position is known to the controller immediately after power up."
    bench = motion_bench("pi-gcs", reference="none")
    for stage in bench.twin.stages.values():
        stage.servo.home(bench.clock.monotonic_s())
    bench.clock.sleep(100.0)
    bench.pitch.home()
    bench.pitch.start_move(20.0)
    bench.clock.sleep(60.0)
    assert bench.true_deg == pytest.approx(20.0)


def test_a_zero_that_another_program_put_elsewhere_is_refused_until_the_axis_is_homed() -> None:
    # M863 p. 144: "This position value is used internally as offset for the calculation of the current axis position",
    # and it is reset to zero by switching on and rebooting, and during referencing.
    bench = motion_bench("pi-gcs")
    bench.home_all()
    bench.pitch.start_move(30.0)
    bench.clock.sleep(60.0)
    assert _said(bench, b"DFH 1\nPOS? 1\nDFH? 1\nFRF? 1\n") == b"1=0.000000\n1=30.000000\n1=1\n"
    with pytest.raises(
        DeviceRefused, match=r"the zero of axis 1 at 30° \(DFH\?\), need 0: .*nothing moved; home the axis"
    ):
        bench.pitch.start_move(0.0)
    bench.clock.sleep(60.0)
    assert bench.true_deg == pytest.approx(30.0)
    bench.axes["roll"].start_move(5.0)  # its own zero is where it was
    bench.home_all()
    assert _said(bench, b"DFH? 1\n") == b"1=0.000000\n"
    bench.pitch.start_move(30.0)
    bench.clock.sleep(60.0)
    assert bench.true_deg == pytest.approx(30.0)


def test_a_moved_zero_of_an_absolute_encoder_is_refused_until_the_controller_restarts() -> None:
    bench = motion_bench("pi-gcs", reference="none")
    stage = bench.twin.stages["1"]
    stage.servo.home(0.0)
    bench.clock.sleep(200.0)
    bench.pitch.home()
    bench.pitch.start_move(30.0)
    bench.clock.sleep(60.0)
    _said(bench, b"DFH 1\n")
    with pytest.raises(DeviceRefused, match=r"nothing moved; restart the controller"):
        bench.pitch.home()
    bench.twin.power_cycle(bench.clock.monotonic_s())
    assert _said(bench, b"DFH? 1\n") == b"1=0.000000\n"


def test_an_axis_that_is_told_its_position_is_not_believed_until_it_is_homed_again() -> None:
    # M863 p. 181: POS "Sets the current position of the axis (does not cause motion)", "It is only possible to set the
    # current position with POS when the referencing method "0" is selected, see RON", and "An axis is considered to be
    # "referenced" when the position has been set with POS".
    bench = motion_bench("pi-gcs")
    bench.home_all()
    bench.pitch.start_move(30.0)
    bench.clock.sleep(60.0)
    assert _said(bench, b"POS 1 5.0\nPOS? 1\nRON? 1\n") == b"1=30.000000\n1=1\n"  # refused
    assert _said(bench, b"RON 1 0\nPOS 1 5.0\nPOS? 1\nRON? 1\nFRF? 1\nDFH? 1\n") == (
        b"1=5.000000\n1=0\n1=1\n1=0.000000\n"
    )
    with pytest.raises(DeviceRefused, match=r"axis 1 to be told its position \(RON\? 0\), need 1: .*nothing moved"):
        bench.pitch.start_move(0.0)
    with pytest.raises(
        DeviceRefused, match=r"\(RON\? 0\), need 1: .*nothing moved; send RON 1 1 by the controller's own"
    ):
        bench.pitch.home()
    bench.clock.sleep(60.0)
    assert bench.true_deg == pytest.approx(30.0)
    bench.axes["roll"].start_move(5.0)
    _said(bench, b"RON 1 1\n")
    bench.home_all()
    bench.pitch.start_move(20.0)
    bench.clock.sleep(60.0)
    assert bench.true_deg == pytest.approx(20.0)


@pytest.mark.parametrize("unknown", [{"DFH?"}, {"RON?"}])
def test_what_a_controller_does_not_know_is_asked_once(monkeypatch: pytest.MonkeyPatch, unknown: set[str]) -> None:
    # M863 p. 207: error 2, unknown command; a question that is unknown is not answered.
    bench = motion_bench("pi-gcs")
    answer = bench.twin._value
    monkeypatch.setattr(bench.twin, "_value", lambda word, *more: None if word in unknown else answer(word, *more))
    bench.home_all()
    for target_deg in (5.0, 10.0):
        before_s = bench.clock.monotonic_s()
        bench.pitch.start_move(target_deg)
        waited_s = bench.clock.monotonic_s() - before_s
        assert (waited_s > 1.0) == (target_deg == 5.0 and unknown == {"DFH?"})  # RON? was asked at home
        bench.clock.sleep(20.0)
        assert bench.true_deg == pytest.approx(target_deg)


def test_axes_may_have_letters_for_names() -> None:
    # EPICS: default "1" on GCS 2.0, "A" on GCS 1; names are letters, digits or words.
    bench = motion_bench("pi-gcs")
    common = {"driver": "pi-gcs", "port": "twin", "limits_deg": (-90.0, 90.0), "speed_dps": 5.0}
    settings = PiGcsSettings.model_validate({**common, "axis": 2, "axis_id": "ROT"})
    twin = PiGcsTwin({2: ("ROT", "pitch")}, bench.world)
    axis = connect({"pitch": settings}, MemoryStream(twin, bench.clock, "pi"))["pitch"]
    axis.home()
    bench.clock.sleep(10.0)
    axis.start_move(30.0)
    assert axis.state().is_moving  # bit 1: the second of the controller's list
    bench.clock.sleep(60.0)
    assert bench.true_deg == pytest.approx(30.0)
