"""Laws of the indexing table's driver: nothing leaves the limits, a start is sent once, doubt is no yes."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from table_bench import table_bench

from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused
from rig.link import faults


def test_a_target_outside_the_limits_is_refused_before_it_is_sent() -> None:
    bench = table_bench(limits_deg=(-45.0, 45.0))
    bench.home_all()
    written = bench.faults.written
    with pytest.raises(
        RequestRefused, match=r"pitch: move to 46°: outside the limits, allowed -45 to 45°.*nothing moved"
    ):
        bench.pitch.start_move(46.0)
    assert bench.faults.written == written


@pytest.mark.parametrize("target_deg", [0.5, 10.0001, -0.999])
def test_a_target_between_two_teeth_is_refused(target_deg: float) -> None:
    bench = table_bench()
    bench.home_all()
    with pytest.raises(RequestRefused, match="stops only at multiples of 1°"):
        bench.pitch.start_move(target_deg)


@pytest.mark.parametrize("target_deg", [math.nan, math.inf, -math.inf])
def test_a_target_that_is_no_number_is_refused(target_deg: float) -> None:
    with pytest.raises(RequestRefused, match="not a number"):
        table_bench().pitch.start_move(target_deg)


def test_an_axis_without_a_home_does_not_move() -> None:
    bench = table_bench()
    with pytest.raises(RequestRefused, match="not homed; nothing moved"):
        bench.pitch.start_move(10.0)
    assert bench.world.axes["pitch"].reached_deg == (0.0, 0.0)


@settings(max_examples=60)
@given(
    low=st.integers(-90, 0),
    high=st.integers(1, 90),
    targets=st.lists(st.one_of(st.floats(-400, 400), st.integers(-200, 200).map(float)), min_size=1, max_size=12),
    sign=st.sampled_from([1, -1]),
    zero_deg=st.integers(-20, 20).map(float),
)
def test_no_request_ever_brings_the_body_outside_the_limits(
    low: int, high: int, targets: list[float], sign: int, zero_deg: float
) -> None:
    bench = table_bench(limits_deg=(float(low), float(high)), sign=sign, zero_deg=zero_deg)
    bench.home_all()
    for target_deg in targets:
        try:
            bench.pitch.start_move(target_deg)
        except RequestRefused:
            continue
        bench.clock.sleep(300.0)
        assert bench.pitch.state().position_deg == pytest.approx(target_deg, abs=1e-4)
    ends_deg = sorted(sign * end + zero_deg for end in (low, high))
    lowest_deg, highest_deg = bench.world.axes["pitch"].reached_deg
    assert min(ends_deg[0], 0.0) <= lowest_deg
    assert highest_deg <= max(ends_deg[1], 0.0)


def test_sign_and_zero_turn_attitude_into_table_angle() -> None:
    bench = table_bench(sign=-1, zero_deg=5.0)
    bench.home_all()
    bench.pitch.start_move(30.0)
    bench.clock.sleep(100.0)
    assert bench.world.axes["pitch"].table_deg(bench.clock.monotonic_s()) == -25.0  # −1 × 30 + 5
    assert bench.pitch.state().position_deg == 30.0


def test_a_lost_acknowledgement_is_settled_by_asking_not_by_sending_again() -> None:
    bench = table_bench()
    bench.home_all()
    bench.faults.reads = {bench.faults.taken + 2: faults.drop}  # state, position, then the acknowledgement
    bench.pitch.start_move(40.0)
    assert bench.pitch.state().is_moving
    bench.clock.sleep(100.0)
    assert bench.pitch.state().position_deg == 40.0


def test_a_lost_command_is_an_error_and_nothing_moves() -> None:
    bench = table_bench()
    bench.home_all()
    bench.faults.writes = {bench.faults.written + 2: faults.drop}
    with pytest.raises(DeviceSilent, match=r"table: no complete reply to b'1 MOVE \+040.0000\\r\\n'"):
        bench.pitch.start_move(40.0)
    bench.clock.sleep(100.0)
    assert bench.world.axes["pitch"].reached_deg == (0.0, 0.0)


def test_a_late_position_is_never_taken_for_the_next_answer() -> None:
    bench = table_bench()
    bench.home_all()
    # The answer to the position question comes 2.5 s late: after the time-out, while the question is asked again.
    bench.faults.reads = {bench.faults.taken + 1: faults.delay(2.5)}
    assert bench.pitch.state().position_deg == 0.0
    bench.pitch.start_move(10.0)
    bench.clock.sleep(100.0)
    assert bench.pitch.state().position_deg == 10.0


def test_the_answer_of_the_other_axis_is_nonsense() -> None:
    bench = table_bench()
    other = faults.replace(b"2 STAT IDLE SEATED LOCKED HOMED\r\n")
    bench.faults.reads = dict.fromkeys(range(bench.faults.taken, bench.faults.taken + 50), other)
    with pytest.raises(DeviceNonsense, match="table: no answer to"):
        bench.pitch.state()


def test_what_the_table_refuses_is_told_in_its_words() -> None:
    bench = table_bench(limits_deg=(-1000.0, 1000.0))
    bench.home_all()
    with pytest.raises(DeviceRefused, match="OUTSIDE TRAVEL"):
        bench.pitch.start_move(400.0)


def test_a_fine_head_goes_to_a_ten_thousandth_of_a_degree() -> None:
    bench = table_bench(increment_deg=0.0001)
    bench.home_all()
    bench.pitch.start_move(12.3456)
    bench.clock.sleep(100.0)
    assert bench.pitch.state().position_deg == 12.3456
    with pytest.raises(RequestRefused, match=r"multiples of 0\.0001°"):
        bench.pitch.start_move(12.34565)


def test_fault_24_a_question_that_the_line_damaged_is_refused_by_the_table_and_asked_again() -> None:
    bench = table_bench()
    bench.home_all()
    next_written = bench.faults.written
    bench.faults.writes = {next_written: faults.flip_bit(3, 0), next_written + 2: faults.flip_bit(3, 0)}
    state = bench.pitch.state()
    assert (state.position_deg, state.is_homed) == (0.0, True)


def test_a_question_that_is_refused_again_and_again_is_a_refusal() -> None:
    bench = table_bench()
    bench.home_all()
    next_written = bench.faults.written
    bench.faults.writes = dict.fromkeys(range(next_written, next_written + 9), faults.flip_bit(3, 0))
    with pytest.raises(
        DeviceRefused, match=r"the table refused AskState.*it may answer another command; look at"
    ) as refused:
        bench.pitch.state()
    assert "nothing moved" not in str(refused.value), "a question does not know that"
    assert bench.faults.written == next_written + 3
