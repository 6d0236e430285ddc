"""What turns when lines are opened is stopped and told first; what is nobody's while another axis moves is a breach."""

from dataclasses import replace

import pytest
from command_strikes import FAMILIES
from motion_bench import MotionBench, motion_bench

from rig.abilities.abilities import Axis
from rig.clock import Clock
from rig.errors import MotionBreach, RequestRefused
from rig.motion.motion_memory import MotionMemory
from rig.motion.move import home_and_arrive, move_and_arrive
from rig.motion.standstill import stop_what_moves
from rig.motion.supervisor import Supervisor

MACHINES = [driver for driver in FAMILIES if driver != "manual"]


def _opened(bench: MotionBench, memory: MotionMemory | None = None, line: str = "") -> dict[str, Axis]:
    supervisor = Supervisor(bench.clock, memory=memory)
    return {name: supervisor.supervise(axis, line=line) for name, axis in bench.axes.items()}


@pytest.mark.parametrize("driver", MACHINES)
def test_an_axis_that_moves_when_its_line_is_opened_is_stopped_and_told(driver: str) -> None:
    """As it was seen: it was looked at while another axis was homed, 83, 93 … 115°, and let go on without a word."""
    bench = motion_bench(driver)
    bench.home_all()
    bench.axes["roll"].start_move(90.0)  # by who had it before
    bench.clock.sleep(4.0)
    axes = _opened(bench)
    (told,) = stop_what_moves(axes, bench.clock, MotionMemory())
    rest_deg = axes["roll"].state().position_deg
    assert told == f"roll: moves, though nothing told it to: stopped, at rest at {rest_deg:g}°"
    assert 5.0 < rest_deg < 60.0
    bench.clock.sleep(30.0)
    assert axes["roll"].state().position_deg == pytest.approx(rest_deg, abs=0.02)
    for axis in axes.values():  # a start from there is a healthy one
        home_and_arrive(axis, bench.clock, bench.clock.sleep)


@pytest.mark.parametrize("driver", MACHINES)
def test_machines_at_rest_are_neither_stopped_nor_told_of(driver: str) -> None:
    bench = motion_bench(driver)
    assert stop_what_moves(_opened(bench), bench.clock, MotionMemory()) == [], "as delivered, without a home"
    bench.home_all()
    assert stop_what_moves(_opened(bench), bench.clock, MotionMemory()) == []


def test_an_axis_that_turns_and_says_that_it_rests_is_stopped_by_two_looks() -> None:
    """Some machines have no word for a rotation that was begun before."""
    bench = motion_bench("zaber")
    bench.home_all()
    bench.axes["roll"].start_move(90.0)
    bench.clock.sleep(4.0)
    roll = bench.axes["roll"]
    state = roll.state
    roll.state = lambda: replace(state(), is_moving=False)
    (told,) = stop_what_moves({"roll": roll}, bench.clock, MotionMemory())
    assert told.startswith("roll: moves, though nothing told it to: stopped, at rest at")
    rest_deg = state().position_deg
    bench.clock.sleep(30.0)
    assert state().position_deg == pytest.approx(rest_deg, abs=0.02)


@pytest.mark.parametrize("first", ["home", "move"])
def test_an_axis_that_begins_to_move_after_the_opening_is_a_breach_of_the_next_motion(first: str) -> None:
    """As it was seen: an order that came late rode to 170° beside the other's reference move; status 0."""
    bench = motion_bench("zaber")
    bench.home_all()
    axes = _opened(bench)
    assert stop_what_moves(axes, bench.clock, MotionMemory()) == []
    bench.axes["roll"].start_move(170.0)
    bench.clock.sleep(0.5)
    with pytest.raises(MotionBreach, match="roll: moves, though nothing told it to"):
        _begin(axes["pitch"], first, bench.clock)
    bench.clock.sleep(3.0)
    assert not any(axis.state().is_moving for axis in bench.axes.values())
    assert bench.axes["roll"].state().position_deg < 20.0


@pytest.mark.parametrize("name", ["pitch", "roll"])
def test_what_was_never_looked_at_and_moves_is_a_breach_of_the_next_motion(name: str) -> None:
    """Of an axis that did not answer at the opening, and of programs that never looked."""
    bench = motion_bench("oriental-az")
    bench.home_all()
    axes = _opened(bench)
    bench.axes[name].start_move(170.0)
    bench.clock.sleep(0.5)
    with pytest.raises(MotionBreach, match=f"{name}: moves, though nothing told it to: it is at"):
        home_and_arrive(axes["pitch"], bench.clock, bench.clock.sleep)
    bench.clock.sleep(3.0)
    assert not bench.axes[name].state().is_moving


def _begin(axis: Axis, first: str, clock: Clock) -> None:
    if first == "home":
        home_and_arrive(axis, clock, clock.sleep)
    else:
        move_and_arrive(axis, 90.0, clock, clock.sleep)


def test_an_axis_that_goes_on_after_it_rested_behind_its_stop_is_a_breach_of_the_next_motion() -> None:
    bench = motion_bench("oriental-az")
    bench.home_all()
    axes = _opened(bench)
    assert stop_what_moves(axes, bench.clock, MotionMemory()) == []
    axes["roll"].start_move(90.0)
    bench.clock.sleep(1.0)
    axes["roll"].stop()
    bench.clock.sleep(3.0)
    assert not axes["roll"].state().is_moving
    bench.axes["roll"].start_move(170.0)
    bench.clock.sleep(0.5)
    with pytest.raises(MotionBreach, match=r"roll: moves, though nothing told it to: it rested at .* behind its stop"):
        move_and_arrive(axes["pitch"], 90.0, bench.clock, bench.clock.sleep)


def test_an_axis_that_moves_outside_its_limits_is_a_breach_and_stands() -> None:
    """As it was seen: first look 229°, limits ±180°; it was homed all the same, and turned on to 670°."""
    bench = motion_bench("oriental-az")
    bench.home_all()
    bench.axes["roll"].start_rate(20.0)
    bench.clock.sleep(12.0)
    axes = _opened(bench)
    with pytest.raises(MotionBreach, match=r"roll moved outside its limits: at 2.*allowed -180 to 180° .*limits_deg"):
        stop_what_moves(axes, bench.clock, MotionMemory())
    assert not axes["roll"].state().is_moving


def test_a_servo_that_lost_its_pulse_is_told_of_without_a_number_and_keeps_the_last_that_was_known() -> None:
    """Its controller lost power for a moment; the pulse of no length would be read as the end of the travel."""
    bench, memory = motion_bench("maestro"), MotionMemory()
    axes = _opened(bench, memory)
    home_and_arrive(axes["pitch"], bench.clock, bench.clock.sleep)
    left_deg = memory.known("pitch").at_deg
    bench.twin.power_cycle(bench.clock.monotonic_s())
    (told,) = stop_what_moves(_opened(bench, memory), bench.clock, memory)
    assert told == f"pitch: left at rest at {left_deg:g}°; now no pulse is sent, position not known"
    assert memory.known("pitch").at_deg == left_deg
    assert memory.known("roll").at_deg is None, "it never had a pulse"


def test_a_rate_that_was_ours_is_stopped_and_told_wherever_it_is() -> None:
    """A line that was lost in a run of rates: what turns on at them has no limits of positions."""
    bench, memory = motion_bench("oriental-az"), MotionMemory()
    bench.home_all()
    before = _opened(bench, memory)
    before["roll"].start_rate(20.0)  # type: ignore[attr-defined]
    bench.clock.sleep(12.0)
    (told,) = stop_what_moves(_opened(bench, memory), bench.clock, memory)
    assert "roll: moves, though nothing told it to (it had been told to turn at 20 °/s before): stopped" in told


@pytest.mark.parametrize("driver", ["zaber", "oriental-az", "indexing-table"])
def test_a_position_that_is_not_where_the_axis_was_left_before_a_loss_is_told(driver: str) -> None:
    bench, memory = motion_bench(driver), MotionMemory()
    bench.home_all()
    for axis in _opened(bench, memory).values():
        move_and_arrive(axis, 90.0, bench.clock, bench.clock.sleep)
    assert stop_what_moves(_opened(bench, memory), bench.clock, memory) == []
    bench.axes["roll"].start_move(45.0)  # while nobody could see it
    bench.clock.sleep(30.0)
    (told,) = stop_what_moves(_opened(bench, memory), bench.clock, memory)
    assert told.startswith("roll: left at rest at 90°, it reads 45° now")


def test_one_that_is_silent_keeps_no_other_from_its_stop() -> None:
    bench = motion_bench("oriental-az")
    bench.home_all()
    bench.axes["roll"].start_move(90.0)
    bench.clock.sleep(1.0)
    axes = _opened(bench)

    def refuse() -> None:
        raise RequestRefused("pitch: no answer")

    axes["pitch"].state = refuse  # type: ignore[method-assign,assignment]
    (told,) = stop_what_moves(axes, bench.clock, MotionMemory())
    assert told.startswith("roll: moves")
