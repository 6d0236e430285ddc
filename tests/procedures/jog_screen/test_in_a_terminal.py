"""Laws of the jog screen in a real terminal, driven by keys: what is asked happens, and what is lost stops.

Standstill is read from the twin itself: its body's path ends at an instant of the machine's clock.
"""

import csv
import json
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from terminal_window import TerminalWindow
from turning_rig import DRIVE_FOR_ROLL, QUICK_METER, SERVO_FOR_PITCH, STAGE_FOR_ROLL, served

from procedures.errors import ExitStatus
from rig.assembly.simulate import SimulatedRig
from rig.clock import ScaledClock, SystemClock

CALRIG = Path(sys.executable).with_name("calrig")
LEFT, RIGHT, UP, DOWN = "\x1b[D", "\x1b[C", "\x1b[A", "\x1b[B"
TURN = "\x1b[1;2C"
"""Shift and right."""
CLOCK = SystemClock()


def _window(rig: Path, *options: object) -> TerminalWindow:
    return TerminalWindow([CALRIG, "jog", "--rig", rig, *map(str, options)])


def _actions(rig: Path) -> list[dict[str, str]]:
    return [json.loads(line) for line in rig.with_name(f"{rig.stem}.jog.jsonl").read_text().splitlines()]


def test_keys_move_axes_read_channels_hold_the_air_and_write_it_all_down(tmp_path: Path) -> None:
    with (
        served(tmp_path, ScaledClock(30.0), QUICK_METER, STAGE_FOR_ROLL, SERVO_FOR_PITCH) as (_, rig),
        _window(rig) as window,
    ):
        window.wait_for("not homed")
        assert f"held by process {window.process.pid} (jog) since" in window.text
        window.type(RIGHT)
        window.wait_for("pitch: the axis is not homed, so its position is not known; nothing moved")
        window.type("h")
        window.wait_for("pitch: homed, at rest at +0.0000°")
        window.type(DOWN + "h")
        window.wait_for("roll: homed, at rest at +0.0000°")
        window.type(RIGHT)
        window.wait_for("roll: at rest at +1.0000°")
        window.type("--")
        window.wait_for("step\u00a00.1°")
        window.type(LEFT)
        window.wait_for("roll: at rest at +0.9000°")
        window.type("g-30.5\r")
        window.wait_for("roll: at rest at -30.5000°")
        window.type("g500\r")
        window.wait_for("outside the limits, allowed -180 to 180°")
        window.type(UP + "p1600\r")
        window.wait_for("pitch: at rest at +9.2000°")  # 1500 µs is 0°, 2000 µs is 46°: 100 µs are 9.2°
        window.wait_for("1600.00 µs")
        window.type("r")
        window.wait_for("pitch: this axis only goes to positions")
        window.type("c25\r")
        window.wait_for("air: holds 25 °C")
        window.wait_for(lambda text: all(f"dmm.{axis}" in text for axis in "xyz"))
        window.wait_for(lambda text: "—" not in text.split("surroundings")[0])
        window.type("s")
        window.wait_for("snapshot 1 in")
        window.type("q")
        assert window.process.wait(20) == ExitStatus.DONE
    with rig.with_name("ports.snapshots.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert float(row["roll_deg"]) == pytest.approx(-30.5, abs=0.0005)
    assert float(row["dmm.x_v"]) == pytest.approx(0.005 + 2.5 * 0.1599, abs=0.05)  # b + S sin 9.2°
    assert int(row["dmm.x_n"]) >= 2
    kinds = [action["kind"] for action in _actions(rig)]
    assert (kinds[0], kinds[-1]) == ("begin", "end")
    assert {"asked", "done", "refused", "stopped"} <= set(kinds)
    assert {action["pid"] for action in _actions(rig)} == {window.process.pid}


@pytest.fixture
def turning(tmp_path: Path) -> Iterator[tuple[SimulatedRig, Path, TerminalWindow]]:
    """A stage that turns at 5°/s under a lease of its terminal, in real time."""
    with served(tmp_path, CLOCK, QUICK_METER, STAGE_FOR_ROLL) as (simulated, rig), _window(rig) as window:
        window.wait_for("not homed")
        window.type(DOWN + "h")
        window.wait_for("roll: homed")
        window.type("r5\r")
        window.wait_for("measured")
        assert _is_turning(simulated)
        yield simulated, rig, window


def _is_turning(simulated: SimulatedRig) -> bool:
    return simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) != 0.0


def _standstill_s(simulated: SimulatedRig) -> float:
    """The instant at which the stage stands, by the twin."""
    deadline_s = CLOCK.monotonic_s() + 10.0
    while _is_turning(simulated):
        assert CLOCK.monotonic_s() < deadline_s
        CLOCK.sleep(0.01)
    return simulated.world.axes["roll"].still_from_s


def _stops_soon_after(simulated: SimulatedRig, act: Callable[[], object]) -> None:
    begun_s = CLOCK.monotonic_s()
    act()
    assert 0.0 < _standstill_s(simulated) - begun_s < 0.5


@pytest.mark.thorough
def test_a_rate_goes_on_while_its_terminal_answers_and_ends_within_half_a_second_of_anything_else(
    turning: tuple[SimulatedRig, Path, TerminalWindow],
) -> None:
    simulated, _, window = turning
    CLOCK.sleep(1.0)
    assert _is_turning(simulated)
    _stops_soon_after(simulated, lambda: window.type(" "))
    for lose in (
        lambda: window.type("g12 "),
        window.freeze,
    ):  # the space bar while a number is typed; a line that hangs
        window.wait_for(lambda text: "at rest" in text.splitlines()[0])
        window.type("r5\r")
        window.wait_for("measured")
        _stops_soon_after(simulated, lose)
    assert "roll: stop: the terminal did not answer for 0.3 s" in window.wait_for("did not answer")
    assert window.process.poll() is None


LOSSES: dict[str, Callable[[TerminalWindow], object]] = {
    "the window is closed": TerminalWindow.hang_up,
    "the shell hangs up": lambda window: window.process.send_signal(signal.SIGHUP),
    "the program is told to end": lambda window: window.process.send_signal(signal.SIGTERM),
    "the program is told to quit": lambda window: window.process.send_signal(signal.SIGQUIT),
}
QUICK = ("the window is closed", "the program is told to quit")


@pytest.mark.parametrize(
    "loss", [name if name in QUICK else pytest.param(name, marks=pytest.mark.soak) for name in LOSSES]
)
def test_a_rate_ends_with_the_session_within_half_a_second_and_the_session_says_so(
    turning: tuple[SimulatedRig, Path, TerminalWindow], loss: str
) -> None:
    simulated, rig, window = turning
    _stops_soon_after(simulated, lambda: LOSSES[loss](window))
    assert window.process.wait(20) == ExitStatus.ABORTED
    assert _actions(rig)[-1]["kind"] == "end"
    assert _actions(rig)[-1]["lost"]


@pytest.mark.thorough
def test_a_held_key_turns_for_as_long_as_it_repeats(tmp_path: Path) -> None:
    with served(tmp_path, CLOCK, QUICK_METER, STAGE_FOR_ROLL) as (simulated, rig), _window(rig) as window:
        window.wait_for("not homed")
        window.type(DOWN + "h")
        window.wait_for("roll: homed")
        window.type(TURN)  # a keyboard waits before it repeats
        window.wait_for("turning")
        CLOCK.sleep(0.3)
        for _ in range(20):
            window.type(TURN)
            CLOCK.sleep(0.05)
            assert _is_turning(simulated)
        released_s = CLOCK.monotonic_s()
        assert _standstill_s(simulated) - released_s < 0.5
        window.wait_for("roll: stop: the key was released")
        turned = simulated.world.axes["roll"].table_deg(CLOCK.monotonic_s())
        assert 1.2 < turned < 2.5  # 1°/s for its 1.3 s and what the lease allows


def test_a_rig_that_a_run_owns_is_refused_with_its_owner(tmp_path: Path) -> None:
    from rig.lines.lock import acquire

    with (
        served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (_, rig),
        acquire([str(rig)], "run night-12"),
        _window(rig) as window,
    ):
        window.wait_for_words("(run night-12) since")
        assert window.process.wait(10) == ExitStatus.FAILED


@pytest.mark.thorough
def test_a_plain_rate_ends_with_its_terminal_as_well(tmp_path: Path) -> None:
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (simulated, rig):
        with TerminalWindow([CALRIG, "jog", "--rig", rig, "--axis", "roll", "--home"]) as window:
            assert window.process.wait(20) == ExitStatus.DONE
        with TerminalWindow([CALRIG, "jog", "--rig", rig, "--axis", "roll", "--rate", "5", "--for", "60"]) as window:
            while not _is_turning(simulated):
                assert window.process.poll() is None
                CLOCK.sleep(0.01)
            CLOCK.sleep(0.5)
            _stops_soon_after(simulated, window.hang_up)
            assert window.process.wait(20) == ExitStatus.ABORTED


@pytest.mark.soak
def test_fault_56_a_killed_screen_leaves_its_drive_to_stop_by_itself_within_its_time_out(tmp_path: Path) -> None:
    with served(tmp_path, CLOCK, QUICK_METER, DRIVE_FOR_ROLL) as (simulated, rig), _window(rig) as window:
        window.wait_for("roll: watchdog of 2 s: ")
        window.wait_for("s were noticed")
        window.type(DOWN + "h")
        window.wait_for("roll: homed")
        window.type("r5\r")
        window.wait_for("measured")
        CLOCK.sleep(3.0)
        assert _is_turning(simulated), "a machine that hears its host goes on"
        killed_s = CLOCK.monotonic_s()
        window.process.kill()
        assert 0.0 < _standstill_s(simulated) - killed_s < 2.5
