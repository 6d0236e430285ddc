"""Laws of the axis that an operator sets: one question at a time, no stale answer, no guess."""

import pytest
from motion_bench import motion_bench, settings_of
from table_bench import virtual_clock

from rig.devices.manual import connect
from rig.errors import DeviceFault, DeviceNonsense, RequestRefused, WaitEnded
from rig.link.memory import MemoryStream
from rig.motion.move import home_and_arrive, move_and_arrive


def test_an_operator_may_take_all_day() -> None:
    bench = motion_bench("manual")
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    bench.world.axes["pitch"].speed_dps = 0.01  # 90 deg take two and a half hours; the file says 18 s
    assert move_and_arrive(bench.pitch, 90.0, bench.clock, bench.clock.sleep) == 90.0
    assert bench.clock.monotonic_s() > 9000.0


def test_a_typed_angle_is_the_position_and_is_judged_as_any() -> None:
    bench = motion_bench("manual", arrival_tolerance_deg=0.05)
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    bench.twin.answer = "29.97"
    assert move_and_arrive(bench.pitch, 30.0, bench.clock, bench.clock.sleep) == 29.97
    bench.twin.answer = "59.9"
    with pytest.raises(DeviceFault, match=r"came to rest at 59\.9°, allowed within 0\.05°"):
        move_and_arrive(bench.pitch, 60.0, bench.clock, bench.clock.sleep)


def test_an_answer_that_is_no_angle_is_asked_again() -> None:
    bench = motion_bench("manual")
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    request = bench.faults.written
    bench.twin.answer = "done"
    bench.pitch.start_move(30.0)
    for _ in range(3):
        bench.clock.sleep(60.0)
        assert bench.pitch.state().awaits_operator
    assert bench.faults.written == request + 4
    bench.twin.answer = ""
    bench.clock.sleep(60.0)
    bench.pitch.state()  # the last "done", typed before
    bench.clock.sleep(60.0)
    assert bench.pitch.state().position_deg == 30.0


def test_an_operator_who_cannot_is_believed() -> None:
    bench = motion_bench("manual")
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    bench.twin.answer = "No"
    with pytest.raises(DeviceFault, match="the operator could not set the axis"):
        move_and_arrive(bench.pitch, 30.0, bench.clock, bench.clock.sleep)
    assert not bench.pitch.state().is_homed


class _TypedAhead:
    """Someone who has pressed Enter long before anything is asked."""

    def __init__(self) -> None:
        self.typed = b"\n"

    def receive(self, data: bytes, now_s: float) -> None:
        return None

    def transmit(self, now_s: float) -> bytes:
        typed, self.typed = self.typed, b""
        return typed

    def next_event_s(self) -> float | None:
        return None


def test_what_was_typed_before_the_question_is_no_answer() -> None:
    person = _TypedAhead()
    axes = connect(settings_of("manual"), MemoryStream(person, virtual_clock(), "terminal"))
    axes["pitch"].home()
    assert axes["pitch"].state().awaits_operator
    person.typed = b"\n"
    assert axes["pitch"].state().is_homed


def test_one_question_at_a_time() -> None:
    bench = motion_bench("manual")
    bench.pitch.home()
    with pytest.raises(RequestRefused, match="roll: the operator is asked something else"):
        bench.axes["roll"].home()


def test_a_stop_withdraws_the_question_and_the_position_is_lost() -> None:
    bench = motion_bench("manual")
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)

    def wait(duration_s: float) -> None:
        bench.clock.sleep(duration_s)
        if bench.clock.monotonic_s() > 30.0:
            raise WaitEnded("stop")

    with pytest.raises(WaitEnded):
        move_and_arrive(bench.pitch, 180.0, bench.clock, wait)
    bench.clock.sleep(600.0)
    state = bench.pitch.state()
    assert (state.is_moving, state.is_homed) == (False, False)


def test_a_line_that_babbles_is_no_person() -> None:
    bench = motion_bench("manual")
    bench.pitch.home()
    bench.twin.answer = "x" * 2000
    bench.clock.sleep(60.0)
    with pytest.raises(DeviceNonsense, match="is a person at this line"):
        bench.pitch.state()
