"""Laws of the AZ's driver: an operation is one frame, sent once; homed and moving are the drive's own outputs."""

import pytest
from motion_bench import MotionBench, motion_bench

from rig.abilities.rates import measured_rate
from rig.errors import DeviceFault, DeviceNonsense, DeviceSilent, RequestRefused
from rig.link import faults
from rig.motion.move import home_and_arrive


def _sent(bench: MotionBench) -> list[bytes]:
    """What the twin hears from now on."""
    heard: list[bytes] = []
    receive = bench.twin.receive

    def listen(data: bytes, now_s: float) -> None:
        heard.append(data)
        receive(data, now_s)

    bench.twin.receive = listen
    return heard


def _starts(sent: list[bytes]) -> list[bytes]:
    return [frame for frame in sent if frame[1:4] == bytes.fromhex("10 00 58")]


def test_a_move_is_one_frame_that_starts_it() -> None:
    bench = motion_bench("oriental-az", speed_dps=10.0, acceleration_dps2=10.0)
    bench.home_all()
    sent = _sent(bench)
    bench.pitch.start_move(50.0)
    # As the worked frame but absolute: 5000 steps, 1 kHz, 1 kHz/s, 100 %, trigger all.
    data = "00000000 00000001 00001388 000003E8 000003E8 000003E8 000003E8 00000001"
    assert _starts(sent)[-1][:-2] == bytes.fromhex("01 10 00 58 00 10 20" + data)
    bench.clock.sleep(60.0)
    assert bench.pitch.state().position_deg == 50.0


def test_a_lost_acknowledgement_is_settled_by_asking_not_by_sending_again() -> None:
    bench = motion_bench("oriental-az")
    bench.home_all()
    bench.pitch.start_move(0.0)
    sent = _sent(bench)
    bench.faults.reads = {bench.faults.taken + 3: faults.drop}  # set-up; signals; current; the operation
    bench.pitch.start_move(40.0)
    assert _starts(sent) == [sent[3]]
    bench.clock.sleep(60.0)
    assert bench.pitch.state().position_deg == 40.0


def test_a_damaged_acknowledgement_is_settled_by_asking_too() -> None:
    bench = motion_bench("oriental-az")
    bench.home_all()
    bench.faults.reads = {bench.faults.taken + 3: faults.flip_bit(3, 1)}
    bench.pitch.start_move(40.0)
    bench.clock.sleep(60.0)
    assert bench.pitch.state().position_deg == 40.0


def test_a_lost_start_is_an_error_and_nothing_moves() -> None:
    bench = motion_bench("oriental-az")
    bench.home_all()
    bench.faults.writes = {bench.faults.written + 3: faults.drop}
    with pytest.raises(DeviceSilent, match="function 16, register 88"):
        bench.pitch.start_move(40.0)
    bench.clock.sleep(100.0)
    assert bench.true_deg == 0.0


def test_home_is_an_input_that_is_released_again() -> None:
    bench = motion_bench("oriental-az")
    sent = _sent(bench)
    bench.pitch.home()
    assert [frame[4:-2] for frame in sent if frame[1] == 0x10] == [
        bytes.fromhex("00 02 04 00 00 00 10"),
        bytes.fromhex("00 02 04 00 00 00 00"),
    ]


def test_the_worked_stop_is_sent() -> None:
    bench = motion_bench("oriental-az")
    bench.home_all()
    sent = _sent(bench)
    bench.pitch.stop()
    assert sent[-2] == bytes.fromhex("01 10 00 7C 00 02 04 00 00 00 20 F5 06")


def test_an_alarm_is_a_fault_and_nothing_is_started() -> None:
    bench = motion_bench("oriental-az")
    bench.home_all()
    bench.twin.units[1].alarm = 0x30
    assert bench.pitch.state().fault == "alarm 0x30"
    assert bench.axes["roll"].state().fault == ""
    sent = _sent(bench)
    for start in (lambda: bench.pitch.start_move(5.0), bench.pitch.home, lambda: bench.pitch.start_rate(5.0)):
        with pytest.raises(DeviceFault, match="alarm 0x30; nothing moved"):
            start()
    assert not [frame for frame in sent if frame[1] == 0x10]
    bench.pitch.reset_alarm()
    assert bench.pitch.state().fault == ""


def test_an_axis_without_a_home_neither_moves_nor_turns() -> None:
    bench = motion_bench("oriental-az")
    for start in (lambda: bench.pitch.start_move(5.0), lambda: bench.pitch.start_rate(5.0)):
        with pytest.raises(RequestRefused, match="not homed"):
            start()
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == 0.0


def test_a_rate_is_measured_from_position_and_time() -> None:
    bench = motion_bench("oriental-az", sign=-1)
    bench.home_all()
    bench.pitch.start_rate(90.0)
    bench.clock.sleep(10.0)
    first = bench.pitch.turn_look(bench.clock)
    bench.clock.sleep(40.0)
    measured = measured_rate(first, bench.pitch.turn_look(bench.clock))
    # A frame waits 30 ms before it is sent: the look's time is known to half of that.
    assert abs(measured.rate_dps - 90.0) <= measured.uncertainty_dps + 0.001
    assert measured.uncertainty_dps < 0.1
    assert measured.turned_deg > 3500.0
    bench.pitch.stop()
    bench.clock.sleep(10.0)
    assert not bench.pitch.state().is_moving


def test_the_bits_of_the_status_are_settings() -> None:
    bench = motion_bench("oriental-az", signals="outputs", home_end_bit=14)
    bench.clock.sleep(1.0)
    assert bench.pitch.state().is_homed  # bit 14 of the twin is in-position


def test_a_drive_with_the_other_word_order_is_refused_before_anything_moves() -> None:
    """HM-60262E p. 253 allows four combinations of word and byte order."""
    bench = motion_bench("oriental-az")
    bench.twin.units[1].low_word_first = True
    with pytest.raises(DeviceNonsense, match=r"the other word order; nothing moved; set its parameter"):
        bench.pitch.identify()
