"""Laws of axes that move together: at once, no slower than the slowest, and whatever stops one stops all."""

import re
from dataclasses import dataclass, field

import pytest
from motion_bench import MotionBench, motion_bench

from rig.errors import DeviceFault, MotionBreach, RequestRefused, WaitEnded
from rig.link.faults import Part
from rig.motion.move import home_and_arrive, stop_all
from rig.motion.supervisor import SupervisedAxis, Supervisor
from rig.motion.together import move_all

FAMILIES = ("indexing-table", "esp301", "maestro", "oriental-az", "pi-gcs", "rate-table", "zaber")
TARGETS = {"pitch": 30.0, "roll": -60.0}
BOTH = ("pitch", "roll")


@dataclass
class Wire:
    """What went out on the line of both axes, in order; ``becomes`` alters an order on its way."""

    altered: tuple[bytes, bytes] = (b"", b"")
    sent: list[bytes] = field(default_factory=list)

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        order, becomes = self.altered
        self.sent.append(data)
        return (Part(data.replace(order, becomes) if order else data),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)

    def first(self, start: bytes) -> int:
        return next((index for index, data in enumerate(self.sent) if data.startswith(start)), -1)


def _supervised(bench: MotionBench) -> dict[str, SupervisedAxis]:
    supervisor = Supervisor(bench.clock)
    axes = {name: supervisor.supervise(axis) for name, axis in bench.axes.items()}
    for axis in axes.values():
        home_and_arrive(axis, bench.clock, bench.clock.sleep)
    return axes


def _table(altered: tuple[bytes, bytes] = (b"", b"")) -> tuple[MotionBench, dict[str, SupervisedAxis], Wire]:
    bench = motion_bench("indexing-table")
    axes, wire = _supervised(bench), Wire(altered)
    bench.stream._faults = wire  # type: ignore[assignment]
    return bench, axes, wire


def _places_deg(bench: MotionBench) -> dict[str, float]:
    return {name: bench.world.axes[name].table_deg(bench.clock.monotonic_s()) for name in BOTH}


def _stands(bench: MotionBench) -> bool:
    bench.clock.sleep(5.0)
    before = _places_deg(bench)
    bench.clock.sleep(5.0)
    return _places_deg(bench) == before and not any(axis.state().is_moving for axis in bench.axes.values())


@pytest.mark.parametrize("driver", FAMILIES)
def test_axes_that_move_together_arrive_where_they_arrive_alone_in_the_time_of_the_slowest(driver: str) -> None:
    took_s = {}
    for together in (BOTH, ()):
        bench = motion_bench(driver)
        axes = _supervised(bench)
        began_s = bench.clock.monotonic_s()
        arrived = move_all(axes, TARGETS, together, bench.clock, bench.clock.sleep)
        took_s[together] = bench.clock.monotonic_s() - began_s
        assert list(arrived) == list(TARGETS)
        assert arrived == pytest.approx(TARGETS, abs=0.1)
        assert _places_deg(bench) == pytest.approx(TARGETS, abs=0.1)
    assert took_s[()] - took_s[BOTH] == pytest.approx(30.0 / 5.0, abs=2.5)  # the way of the shorter, at 5 deg/s


def test_the_second_is_told_to_move_while_the_first_is_under_way_and_both_turn_at_once() -> None:
    bench, axes, wire = _table()
    turning = []

    def wait(duration_s: float) -> None:
        before = _places_deg(bench)
        bench.clock.sleep(duration_s)
        turning.append({name for name, place_deg in _places_deg(bench).items() if place_deg != before[name]})

    move_all(axes, TARGETS, BOTH, bench.clock, wait)
    assert {"pitch", "roll"} in turning
    assert {"pitch"} not in turning
    first, second = wire.first(b"1 MOVE"), wire.first(b"2 MOVE")
    assert 0 <= first < second
    assert second - first < 12  # a look at each in between, not a way


def test_without_a_declaration_the_second_waits_for_the_first_to_be_seated() -> None:
    bench, axes, _ = _table()

    def wait(duration_s: float) -> None:
        bench.clock.sleep(duration_s)
        indices = _places_deg(bench)
        assert indices["roll"] == 0.0 or indices["pitch"] == 30.0

    move_all(axes, TARGETS, (), bench.clock, wait)


@pytest.mark.parametrize("driver", FAMILIES)
@pytest.mark.parametrize(("from_deg", "is_told"), [(15.0, True), (80.0, True), (87.0, False)])
def test_an_axis_that_goes_on_to_its_target_after_its_stop_is_told_as_that(
    driver: str, from_deg: float, is_told: bool
) -> None:
    """The drive acknowledges the stop, and it is lost; at rest where it was sent it looks like one that obeyed.

    The way is 90° at 5°/s. Of one that is nearly there nothing can be said.
    """
    bench = motion_bench(driver)
    for axis in bench.axes.values():  # a stop of PI's controller is one of all its axes
        axis.stop = lambda: None
    axes = _supervised(bench)
    axes["pitch"].start_move(90.0)
    while (seen_deg := axes["pitch"].state().position_deg) < from_deg:
        bench.clock.sleep(0.1)
    axes["pitch"].stop()  # the one that breaks the move off; that of the safe state comes behind it
    if not is_told:
        stop_all(axes, bench.clock)
        return
    with pytest.raises(DeviceFault, match=r"stop: not every axis obeyed it: pitch: went on for [\d.]+° after") as told:
        stop_all(axes, bench.clock)
    on_deg = float(re.findall(r"on for (\S+)°", str(told.value))[0])
    assert on_deg == pytest.approx(90.0 - seen_deg, abs=0.6)  # it turned on between look and stop
    assert "after it was told to stop, to 90°, where it was sent" in str(told.value)


@pytest.mark.parametrize("driver", FAMILIES)
@pytest.mark.parametrize("after_s", [0.3, 3.0, 9.0, 16.0, 30.0])
def test_of_an_axis_that_obeys_its_stop_nothing_is_told(driver: str, after_s: float) -> None:
    bench = motion_bench(driver)
    axes = _supervised(bench)
    axes["pitch"].start_move(90.0)
    bench.clock.sleep(after_s)
    axes["pitch"].state()
    axes["pitch"].stop()
    stop_all(axes, bench.clock)
    assert _stands(bench)


def test_a_stop_stops_every_axis_that_is_under_way() -> None:
    bench, axes, wire = _table()
    ends_s = bench.clock.monotonic_s() + 3.0

    def wait(duration_s: float) -> None:
        bench.clock.sleep(min(duration_s, 0.1))
        if bench.clock.monotonic_s() > ends_s:
            raise WaitEnded("stop", "anna")

    with pytest.raises(WaitEnded, match="stop, asked for by anna"):
        move_all(axes, TARGETS, BOTH, bench.clock, wait)
    assert min(wire.first(b"1 STOP"), wire.first(b"2 STOP")) > 0
    assert _stands(bench)
    assert max(abs(place_deg) for place_deg in _places_deg(bench).values()) < 20.0


@pytest.mark.parametrize(
    ("altered", "culprit"),
    [((b"1 MOVE +030", b"1 MOVE +170"), "pitch"), ((b"2 MOVE -060", b"2 MOVE +060"), "roll")],
)
def test_an_axis_that_leaves_its_corridor_stops_both_and_nothing_is_tried_again(
    altered: tuple[bytes, bytes], culprit: str
) -> None:
    bench, axes, wire = _table(altered)
    with pytest.raises(MotionBreach, match=f"{culprit}: left its way"):
        move_all(axes, TARGETS, BOTH, bench.clock, bench.clock.sleep)
    assert sum(data.count(b"MOVE") for data in wire.sent) == 2
    assert _stands(bench)


def test_an_axis_that_is_moved_by_somebody_else_stops_both_that_move() -> None:
    """A third axis is not there; the one that stands is moved past the supervisor behind its own arrival."""
    bench, axes, _ = _table()
    began_s = bench.clock.monotonic_s()

    def wait(duration_s: float) -> None:
        bench.clock.sleep(duration_s)
        if 9.0 < bench.clock.monotonic_s() - began_s < 10.0:
            bench.axes["pitch"].start_move(90.0)

    with pytest.raises(MotionBreach, match="pitch: moves, though nothing told it to"):
        move_all(axes, TARGETS, BOTH, bench.clock, wait)
    assert _stands(bench)


def test_an_obstacle_in_the_way_of_one_stops_both_and_each_goes_on_alone() -> None:
    bench, axes, wire = _table()
    bench.world.axes["pitch"].stall(1000.0)
    messages: list[str] = []
    at_the_stop: list[dict[str, float]] = []

    def tell(sentence: str) -> None:
        messages.append(sentence)
        at_the_stop.append(_places_deg(bench))
        bench.world.axes["pitch"].stall(0.0)

    def wait(duration_s: float) -> None:
        bench.clock.sleep(duration_s)

    assert move_all(axes, TARGETS, BOTH, bench.clock, wait, tell) == TARGETS
    assert "pitch: move to 30°: no progress in 2 s" in messages[0]
    assert messages[0].endswith("the axes that moved with it were stopped too, and each goes on alone")
    assert "went back to 0° and is tried once more" in messages[1]
    assert at_the_stop[0] == at_the_stop[1] | {"pitch": at_the_stop[0]["pitch"]}  # roll waits while pitch goes back
    assert -50.0 < at_the_stop[0]["roll"] < -5.0
    assert wire.first(b"2 STOP") > 0


def test_an_obstacle_that_stays_is_a_fault_after_the_second_attempt_and_roll_stands() -> None:
    bench, axes, _ = _table()
    bench.world.axes["pitch"].stall(1000.0)
    with pytest.raises(DeviceFault, match=r"stalled twice|nor could it go back"):
        move_all(axes, TARGETS, BOTH, bench.clock, bench.clock.sleep, lambda _: bench.world.axes["pitch"].stall(1e4))
    assert _stands(bench)


def test_a_coupling_that_does_not_seat_is_approached_anew_alone() -> None:
    bench, axes, _ = _table()
    table = bench.twin.axes[2]
    table.seats = False
    messages: list[str] = []

    def tell(sentence: str) -> None:
        messages.append(sentence)
        table.seats = True

    assert move_all(axes, TARGETS, BOTH, bench.clock, bench.clock.sleep, tell) == TARGETS
    assert "roll: move to -60°: at rest at -60°, but the coupling is not seated" in messages[0]


def test_a_target_that_one_may_not_reach_moves_none() -> None:
    bench, axes, wire = _table()
    with pytest.raises(RequestRefused, match="roll: move to 190°: outside the limits"):
        move_all(axes, {"pitch": 30.0, "roll": 190.0}, BOTH, bench.clock, bench.clock.sleep)
    assert wire.first(b"1 MOVE") < 0


@pytest.mark.parametrize("together", [BOTH, ()])
def test_axes_that_are_there_are_not_moved(together: tuple[str, ...]) -> None:
    bench, axes, wire = _table()
    move_all(axes, {"pitch": 0.0, "roll": 0.0}, together, bench.clock, bench.clock.sleep)
    assert not any(b"MOVE" in data for data in wire.sent)


def test_each_is_approached_from_its_own_side() -> None:
    bench = motion_bench("indexing-table", approach_deg=-3.0)
    axes = _supervised(bench)
    assert move_all(axes, TARGETS, BOTH, bench.clock, bench.clock.sleep) == TARGETS
    assert [bench.world.axes[name].reached_deg for name in BOTH] == [(0.0, 30.0), (-63.0, 0.0)]
