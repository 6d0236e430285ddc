"""Laws of move and arrive, on the table's twin and, for faults a table has no words for, on an axis that lies."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import chain, repeat

import pytest
from table_bench import TableBench, table_bench, virtual_clock

from rig.abilities.abilities import AxisState
from rig.clock import VirtualClock
from rig.errors import DeviceFault, LinkLost, RequestRefused, WaitEnded
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all


def _homed(**pitch: object) -> TableBench:
    bench = table_bench(**pitch)
    bench.home_all()
    return bench


def _go(bench: TableBench, target_deg: float) -> float:
    return move_and_arrive(bench.pitch, target_deg, bench.clock, bench.clock.sleep)


def test_a_move_ends_at_rest_on_the_target() -> None:
    bench = _homed()
    assert _go(bench, 30.0) == 30.0
    state = bench.pitch.state()
    assert (state.is_moving, state.is_seated) == (False, True)


def test_a_move_takes_little_longer_than_the_machine() -> None:
    bench = _homed()
    started_s = bench.clock.monotonic_s()
    _go(bench, 90.0)
    # 0.5 s to lift, 90° at 5 °/s, 0.8 s to seat.
    assert bench.clock.monotonic_s() - started_s == pytest.approx(0.5 + 18.0 + 0.8, abs=0.6)


@pytest.mark.parametrize("shows_s", [0.005, 0.05, 0.15, 0.4])
def test_a_controller_that_tells_late_of_a_start_is_sent_once(shows_s: float) -> None:
    """EPICS waits 0.05 s behind a Parker 6K's GO: "Delay after START_MOTION before a status update is possible"."""
    bench = _homed()
    twin_axis = bench.twin.axes[1]
    twin_axis._times = replace(twin_axis._times, shows_s=shows_s)
    sent: list[float] = []
    move = twin_axis.move
    twin_axis.move = lambda target_deg, now_s: (sent.append(target_deg), move(target_deg, now_s))[1]  # type: ignore[method-assign]
    assert _go(bench, 30.0) == 30.0
    assert sent == [30.0]


def test_an_axis_that_is_there_is_not_moved() -> None:
    bench = _homed()
    _go(bench, 30.0)
    written = bench.faults.written
    _go(bench, 30.0)
    assert bench.faults.written - written == 2  # it is only asked for state and position


def test_a_one_sided_approach_comes_from_its_side() -> None:
    bench = _homed(approach_deg=-3.0)
    _go(bench, 10.0)
    _go(bench, 5.0)
    assert bench.world.axes["pitch"].reached_deg == (0.0, 10.0)
    assert _go(bench, 0.0) == 0.0
    assert bench.world.axes["pitch"].reached_deg == (-3.0, 10.0)


def test_an_axis_that_is_there_is_approached_again_where_it_has_a_side() -> None:
    """It may have come to its place from the other side."""
    bench = _homed(approach_deg=-3.0)
    _go(bench, 10.0)
    sent: list[float] = []
    move = bench.twin.axes[1].move
    bench.twin.axes[1].move = lambda target_deg, now_s: (sent.append(target_deg), move(target_deg, now_s))[1]  # type: ignore[method-assign]
    assert _go(bench, 10.0) == 10.0
    assert sent == [7.0, 10.0]


def test_an_approach_outside_the_limits_is_refused_before_anything_moves() -> None:
    bench = _homed(approach_deg=-3.0, limits_deg=(-10.0, 10.0))
    with pytest.raises(RequestRefused, match="move to -12°: outside the limits"):
        _go(bench, -9.0)
    assert bench.world.axes["pitch"].reached_deg == (0.0, 0.0)


def test_an_axis_without_a_home_is_refused() -> None:
    with pytest.raises(RequestRefused, match="not homed"):
        _go(table_bench(), 10.0)


def test_home_finds_the_home() -> None:
    bench = table_bench()
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == 0.0
    assert bench.pitch.state().is_homed


def test_a_stop_during_a_move_stops_the_axis_first() -> None:
    bench = _homed()
    ends_s = bench.clock.monotonic_s() + 4.0

    def wait(duration_s: float) -> None:
        bench.clock.sleep(min(duration_s, 0.1))
        if bench.clock.monotonic_s() > ends_s:
            raise WaitEnded("stop")

    with pytest.raises(WaitEnded):
        move_and_arrive(bench.pitch, 170.0, bench.clock, wait)
    bench.clock.sleep(5.0)
    state = bench.pitch.state()
    assert not state.is_moving
    assert state.position_deg < 25.0


def _go_telling(bench: TableBench, target_deg: float) -> tuple[float, list[str]]:
    messages: list[str] = []
    return move_and_arrive(bench.pitch, target_deg, bench.clock, bench.clock.sleep, messages.append), messages


def test_a_coupling_that_does_not_seat_is_seated_anew_twice_and_then_a_fault() -> None:
    bench = _homed()
    bench.twin.axes[1].seats = False
    moved = bench.world.axes["pitch"].reached_deg
    with pytest.raises(DeviceFault, match="pitch: move to 30°: at rest at 30°, but the coupling is not seated"):
        _go(bench, 30.0)
    assert moved == (0.0, 0.0)
    assert bench.world.axes["pitch"].reached_deg == (0.0, 30.0)


def test_a_coupling_that_seats_at_the_second_attempt_is_told_of_and_used() -> None:
    bench = _homed()
    table = bench.twin.axes[1]
    table.seats = False
    messages: list[str] = []

    def tell(sentence: str) -> None:
        messages.append(sentence)
        table.seats = True

    assert move_and_arrive(bench.pitch, 30.0, bench.clock, bench.clock.sleep, tell) == 30.0
    (sentence,) = messages
    assert "the coupling is not seated and locked" in sentence
    assert sentence.endswith("it is approached anew from 29°")


def test_an_axis_that_missed_its_target_by_far_has_the_time_for_the_whole_way_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A start that was acknowledged and swallowed leaves it where it was; 149° at 5 °/s are no second and a half."""
    bench = _homed()
    start_move, starts = bench.pitch.start_move, chain((False,), repeat(True))
    monkeypatch.setattr(bench.pitch, "start_move", lambda target_deg: next(starts) and start_move(target_deg))
    arrived_deg, found = _go_telling(bench, 150.0)
    assert arrived_deg == 150.0
    (sentence,) = found
    assert "came to rest at 0°" in sentence
    assert sentence.endswith("it is approached anew from 149°")


def test_an_axis_that_stalls_is_stopped_after_two_seconds_and_tried_once_more() -> None:
    bench = _homed()
    bench.world.axes["pitch"].stall(1000.0)
    messages: list[str] = []

    def tell(sentence: str) -> None:
        messages.append(sentence)
        bench.world.axes["pitch"].stall(1000.0)

    with pytest.raises(DeviceFault, match=r"no progress in 2 s at 29°, though it says it moves; .* stalled twice"):
        move_and_arrive(bench.pitch, 30.0, bench.clock, bench.clock.sleep, tell)
    assert len(messages) == 1


def test_an_axis_that_stalls_once_goes_back_and_arrives_at_the_second_attempt() -> None:
    bench = _homed()
    _go(bench, 10.0)
    bench.world.axes["pitch"].stall(1000.0)
    arrived_deg, found = _go_telling(bench, 30.0)
    assert arrived_deg == 30.0
    assert "it went back to 10° and is tried once more" in found[0]


def test_an_axis_that_is_too_slow_is_stopped_when_its_time_is_over() -> None:
    bench = _homed()
    bench.world.axes["pitch"].speed_dps = 0.5
    with pytest.raises(DeviceFault, match=r"still moving at .* after 14 s, the time allowed"):  # 30/5 × 1.5 + 5 s
        _go(bench, 30.0)


@dataclass
class LyingAxis:
    """An axis whose next states are a script: what a machine with a fault would say."""

    states: Callable[[int], AxisState]
    name: str = "pitch"
    limits_deg: tuple[float, float] = (-90.0, 90.0)
    increment_deg: float = 1.0
    speed_dps: float = 5.0
    approach_deg: float = 0.0
    arrival_tolerance_deg: float = 0.001
    looks: int = 0
    calls: list[str] = field(default_factory=list)

    def identify(self) -> str:
        return "liar"

    def home(self) -> None:
        self.calls.append("home")

    def check_target(self, target_deg: float) -> None:
        self.calls.append("check")

    def start_move(self, target_deg: float) -> None:
        self.calls.append("move")

    def state(self) -> AxisState:
        self.looks += 1
        return self.states(self.looks)

    def stop(self) -> None:
        self.calls.append("stop")


RESTING = AxisState(position_deg=0.0, is_moving=False, is_homed=True, is_seated=True, fault="")


def _scripted(after_the_start: AxisState) -> LyingAxis:
    return LyingAxis(lambda look: RESTING if look == 1 else after_the_start)


def test_an_axis_that_rests_elsewhere_has_not_arrived() -> None:
    axis, clock = _scripted(replace(RESTING, position_deg=29.0)), virtual_clock()
    with pytest.raises(DeviceFault, match=r"came to rest at 29°, allowed within 0\.001°"):
        move_and_arrive(axis, 30.0, clock, clock.sleep)


def test_a_fault_during_the_move_stops_it() -> None:
    axis, clock = _scripted(replace(RESTING, is_moving=True, fault="limit switch")), virtual_clock()
    with pytest.raises(DeviceFault, match="pitch: move to 30°: limit switch; the axis was told to stop"):
        move_and_arrive(axis, 30.0, clock, clock.sleep)
    assert axis.calls[-1] == "stop"


def test_a_faulty_or_moving_axis_is_not_started() -> None:
    clock = virtual_clock()
    for state, kind in (
        (replace(RESTING, fault="hot"), DeviceFault),
        (replace(RESTING, is_moving=True), RequestRefused),
    ):
        axis = LyingAxis(lambda look, state=state: state)  # type: ignore[misc]
        with pytest.raises(kind):
            move_and_arrive(axis, 30.0, clock, clock.sleep)
        assert "move" not in axis.calls


def test_a_home_that_finds_none_is_a_fault() -> None:
    axis, clock = LyingAxis(lambda look: replace(RESTING, is_homed=False)), virtual_clock()
    with pytest.raises(DeviceFault, match="came to rest without a home"):
        home_and_arrive(axis, clock, clock.sleep)


def test_stop_all_sees_every_axis_stand_still() -> None:
    bench = _homed()
    for axis in bench.axes.values():
        axis.start_move(90.0)
    bench.clock.sleep(4.0)
    stop_all(bench.axes, bench.clock)
    assert not any(axis.state().is_moving for axis in bench.axes.values())
    assert all(0.0 < axis.state().position_deg < 90.0 for axis in bench.axes.values())


class _BrokenAxis(LyingAxis):
    def stop(self) -> None:
        raise LinkLost("roll: unplugged")


def test_one_word_of_rest_does_not_end_a_search_for_the_home() -> None:
    """The line may damage it: the axis is seen once more, and goes on."""
    moving = replace(RESTING, is_moving=True, is_homed=False)
    searched = LyingAxis(lambda look: RESTING if look == 2 or look > 6 else replace(moving, position_deg=0.1 * look))
    clock = virtual_clock()
    begun_s = clock.monotonic_s()
    home_and_arrive(searched, clock, clock.sleep)
    assert searched.looks > 6
    assert clock.monotonic_s() - begun_s > 0.5


def test_an_axis_that_cannot_be_stopped_keeps_no_other_from_its_stop() -> None:
    clock = VirtualClock(virtual_clock().now_utc())
    good, bad = LyingAxis(lambda look: RESTING), _BrokenAxis(lambda look: RESTING, name="roll")
    with pytest.raises(DeviceFault, match=r"not every axis is known to stand still: roll: roll: unplugged"):
        stop_all({"roll": bad, "pitch": good}, clock)
    assert good.calls == ["stop"]


def test_an_axis_that_moves_on_after_its_stop_is_told() -> None:
    drifting = LyingAxis(lambda look: replace(RESTING, position_deg=0.01 * look))
    with pytest.raises(DeviceFault, match=r"still moving at .* 20 s after the stop"):
        stop_all({"pitch": drifting}, virtual_clock())
