"""A servo without pulses has no place: one that gets a place without an order of its own is a breach, as of any axis.

As it was measured: the channel of a target turned over on the line, and a servo that was never homed jumped by 36°
beside one that was; what was told was a stall of the other one, tried once more, and status 0.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from motion_bench import MotionBench, motion_bench

from rig.abilities.abilities import Axis, AxisState
from rig.errors import DeviceFault, MotionBreach
from rig.link.faults import Part
from rig.motion.motion_memory import MotionMemory
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all
from rig.motion.standstill import stop_what_moves
from rig.motion.supervisor import Supervisor
from rig.wire.maestro import SET_TARGET

JUMPED = "roll: moves, though nothing told it to: where it stood was not known, and it is at "


class AnotherChannel:
    """Faults of a line on which the first target of pitch goes to roll."""

    def __init__(self) -> None:
        self.is_over = False

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        pitch, roll = bytes([SET_TARGET, 1]), bytes([SET_TARGET, 2])
        if self.is_over or pitch not in data:
            return (Part(data),)
        self.is_over = True
        return (Part(data.replace(pitch, roll)),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)


class NoPulse:
    """Faults of a line on which some answers about a position say that no pulse is sent."""

    def __init__(self, answers: int) -> None:
        self._answers = answers

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        is_position_of_roll = len(data) == 4  # twice marked, as of the second axis on its line
        if not (is_position_of_roll and self._answers):
            return (Part(data),)
        self._answers -= 1
        return (Part(b"\0\0" + data[2:]),)


def _opened(bench: MotionBench) -> dict[str, Any]:
    supervisor = Supervisor(bench.clock)
    axes: dict[str, Axis] = {name: supervisor.supervise(axis, line="one") for name, axis in bench.axes.items()}
    assert stop_what_moves(axes, bench.clock, MotionMemory()) == []
    return axes


def _strike(bench: MotionBench, faults: object) -> None:
    bench.stream._faults = faults  # type: ignore[assignment]


def _go(bench: MotionBench, axes: dict[str, Any]) -> object:
    return move_and_arrive(axes["pitch"], -40.0, bench.clock, bench.clock.sleep)


def _home(bench: MotionBench, axes: dict[str, Any]) -> object:
    return home_and_arrive(axes["pitch"], bench.clock, bench.clock.sleep)


@pytest.mark.parametrize("begin", [_go, _home])
def test_an_order_that_reaches_a_servo_without_pulses_is_stopped_and_told(
    begin: Callable[[MotionBench, dict[str, Any]], object],
) -> None:
    """Also between the homes at the start of a run."""
    bench = motion_bench("maestro", speed_dps=20.0)
    axes = _opened(bench)
    if begin is _go:
        _home(bench, axes)
    _strike(bench, AnotherChannel())
    began_s = bench.clock.monotonic_s()
    with pytest.raises(MotionBreach, match=JUMPED):
        begin(bench, axes)
    assert bench.clock.monotonic_s() - began_s < 1.5
    assert not any(axis.state().is_moving for axis in axes.values())


@pytest.mark.parametrize("begin", [_go, _home])
def test_an_order_that_reaches_a_servo_without_a_home_is_stopped_and_told(
    begin: Callable[[MotionBench, dict[str, Any]], object],
) -> None:
    """Its pulse is what it was sent: another session left it at 36°, and no hand changes it."""
    bench = motion_bench("maestro", speed_dps=20.0)
    for channel in (1, 2):
        bench.twin.channels[channel].aim(6800, bench.clock.monotonic_s())
    axes = _opened(bench)
    if begin is _go:
        _home(bench, axes)
    _strike(bench, AnotherChannel())
    with pytest.raises(MotionBreach, match=r"roll: (moves|was moved), though nothing told it to: .*36"):
        begin(bench, axes)
    assert not any(axis.state().is_moving for axis in axes.values())


def test_a_servo_that_goes_on_when_its_line_is_opened_is_stopped_and_accused_of_nothing_later() -> None:
    """As a guard slows one whose engine died; it has no home on this connection, and does not say that it moves."""
    bench = motion_bench("maestro", speed_dps=20.0)
    channel, begins_s = bench.twin.channels[2], bench.clock.monotonic_s()
    channel.aim(4000, begins_s)
    channel.limit_speed(1, begins_s)
    channel.aim(8000, begins_s)
    supervisor = Supervisor(bench.clock)
    axes: dict[str, Axis] = {name: supervisor.supervise(axis, line="one") for name, axis in bench.axes.items()}
    (sentence,) = stop_what_moves(axes, bench.clock, MotionMemory())
    assert sentence.startswith("roll: moves, though nothing told it to: stopped, at rest at ")
    assert not channel.is_moving(bench.clock.monotonic_s())
    for axis in axes.values():
        home_and_arrive(axis, bench.clock, bench.clock.sleep)


def test_a_servo_without_pulses_that_jumps_while_it_is_stopped_is_told() -> None:
    bench = motion_bench("maestro", speed_dps=20.0)
    roll = Supervisor(bench.clock).supervise(bench.axes["roll"])
    state, looks = bench.axes["roll"].state, iter(range(100))

    def state_until_it_jumps() -> AxisState:
        if next(looks) == 4:
            bench.twin.channels[2].aim(5000, bench.clock.monotonic_s())
        return state()

    bench.axes["roll"].state = state_until_it_jumps
    with pytest.raises(DeviceFault, match=JUMPED):
        stop_all({"roll": roll}, bench.clock)


def test_a_servo_is_homed_from_no_pulse_and_after_it_lost_them() -> None:
    bench = motion_bench("maestro", speed_dps=20.0)
    axes = _opened(bench)
    for _ in range(2):
        for axis in axes.values():
            home_and_arrive(axis, bench.clock, bench.clock.sleep)
            axes["roll"].state()
        bench.twin.power_cycle(bench.clock.monotonic_s())
        for _ in range(3):
            assert all(axis.state().unknown for axis in axes.values())


@pytest.mark.parametrize("is_homed", [True, False])
def test_an_answer_that_the_line_made_of_no_pulse_is_no_jump(is_homed: bool) -> None:
    bench = motion_bench("maestro")
    if is_homed:
        bench.home_all()
    else:
        bench.twin._go_home(bench.clock.monotonic_s())
    axes = _opened(bench)
    _strike(bench, NoPulse(1))
    assert axes["roll"].state().unknown
    for _ in range(3):
        assert not axes["roll"].state().unknown


def test_a_watchdog_that_was_proved_sends_its_neighbours_home_and_accuses_none() -> None:
    """The error of a controller's time-out sends every servo to its home, those without a watchdog of their own too."""
    bench = motion_bench("maestro", watchdog_s=2.0)
    bench.twin._timeout_s = 2.0
    axes = _opened(bench)
    assert "were noticed" in axes["pitch"].arm_watchdog(bench.clock.sleep)
    assert not axes["roll"].state().unknown
    for axis in axes.values():
        home_and_arrive(axis, bench.clock, bench.clock.sleep)


def test_any_axis_that_nobody_knew_the_place_of_is_held_to_it() -> None:
    """The supervisor's own law: no driver but the servo's says so today."""
    bench = motion_bench("indexing-table")
    bench.home_all()
    roll, is_lost = bench.axes["roll"], [True]
    state = roll.state
    roll.state = lambda: replace(state(), unknown="its scale is not read", is_homed=False) if is_lost[0] else state()
    axes = _opened(bench)
    is_lost[0] = False
    with pytest.raises(MotionBreach, match=JUMPED):
        _go(bench, axes)
