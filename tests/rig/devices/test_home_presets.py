"""What a controller counts at its home is a setting of its own, which another program may have changed.

The angle of the table itself, which no controller tells, is the outside answer.
"""

from collections.abc import Callable
from typing import Any

import pytest
from motion_bench import MotionBench, motion_bench

from rig.errors import FileContradicted

MICROSTEP_DEG = 0.000234375


def _by_esp301(bench: MotionBench, preset_deg: float) -> None:
    bench.twin.receive(b"1SH%.6f\r" % preset_deg, bench.clock.monotonic_s())


def _by_zaber(bench: MotionBench, preset_deg: float) -> None:
    line = b"/1 1 set limit.home.preset %d\n" % round(preset_deg / MICROSTEP_DEG)
    bench.twin.receive(line, bench.clock.monotonic_s())
    bench.twin.transmit(bench.clock.monotonic_s())


ANOTHER_PROGRAM: dict[str, Callable[[MotionBench, float], None]] = {"esp301": _by_esp301, "zaber": _by_zaber}
both = pytest.mark.parametrize("driver", sorted(ANOTHER_PROGRAM))


def _home_is_said_to_be(bench: MotionBench) -> float:
    bench.pitch.home()
    bench.clock.sleep(200.0)
    state: Any = bench.pitch.state()
    assert state.is_homed
    return float(state.position_deg)


@both
def test_a_home_moves_nothing_where_the_zero_was_moved(driver: str) -> None:
    bench = motion_bench(driver)
    bench.home_all()
    bench.pitch.start_move(30.0)
    bench.clock.sleep(100.0)
    ANOTHER_PROGRAM[driver](bench, 2.25)
    for order in (bench.pitch.home, lambda: bench.pitch.start_move(10.0)):
        with pytest.raises(
            FileContradicted, match=r"counts its home as 2\.25° \((SH|limit\.home\.preset)\).*nothing moved"
        ):
            order()
        bench.clock.sleep(100.0)
        assert bench.true_deg == pytest.approx(30.0, abs=MICROSTEP_DEG)


@both
def test_a_preset_that_the_file_states_is_where_angles_are_counted_from(driver: str) -> None:
    bench = motion_bench(driver, home_preset_deg=2.25)
    assert _home_is_said_to_be(bench) == pytest.approx(2.25, abs=MICROSTEP_DEG)
    assert bench.true_deg == 0.0
    bench.pitch.start_move(12.25)
    bench.clock.sleep(100.0)
    assert bench.true_deg == pytest.approx(10.0, abs=2 * MICROSTEP_DEG)
    ANOTHER_PROGRAM[driver](bench, 0.0)
    with pytest.raises(FileContradicted, match=r"counts its home as 0°.*the rig file says 2\.25 "):
        bench.pitch.home()


@both
def test_it_is_compared_when_the_controller_is_identified(driver: str) -> None:
    bench = motion_bench(driver)
    ANOTHER_PROGRAM[driver](bench, -0.75)
    with pytest.raises(FileContradicted, match=r"-0\.75°"):
        bench.pitch.identify()


@both
def test_a_machine_homed_over_a_preset_reads_it_there(driver: str) -> None:
    """The manuals' sentence: where home is found, the counter becomes the preset."""
    bench = motion_bench(driver)
    bench.home_all()
    ANOTHER_PROGRAM[driver](bench, 2.25)
    lines = {"esp301": (b"1MO;1OR1\r", b"1TP\r"), "zaber": (b"/1 1 home\n", b"/1 1 get pos\n")}[driver]
    bench.twin.receive(lines[0], bench.clock.monotonic_s())
    bench.clock.sleep(60.0)
    bench.twin.transmit(bench.clock.monotonic_s())
    bench.twin.receive(lines[1], bench.clock.monotonic_s())
    reply = bench.twin.transmit(bench.clock.monotonic_s())
    counted = {"esp301": b"2.250000", "zaber": b"%d" % round(2.25 / MICROSTEP_DEG)}[driver]
    assert counted in reply
    assert bench.true_deg == 0.0


def test_a_stage_without_a_home_sensor_has_no_preset_to_compare() -> None:
    bench = motion_bench("zaber")
    for stage in bench.twin.axes.values():
        del stage.settings["limit.home.preset"]
    bench.twin.stages[1].servo.home(0.0)
    bench.clock.sleep(10.0)
    assert "Zaber device" in bench.pitch.identify()
