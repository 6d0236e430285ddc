"""Aborts at any moment of a servo's move, by a guard beside an engine that polls the same line at 9600 baud."""

import threading
from pathlib import Path

import numpy as np
import pytest
from timed_servos import CLOCK, TimedServos, timed_servos

from rig.assembly.open_rig import Rig, open_rig
from rig.description.read import read_rig
from rig.errors import WaitEnded
from rig.guard.ask import of_rig, stop
from rig.guard.outcomes import SLOWED, STOOD
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all

RIG = """
[rig]
name = "two servos"
gravity_mps2 = 9.80665

[twin]
seed = 1
time = "real"
"""
SERVO = """
[axes.{name}]
driver = "maestro"
port = "{port}"
axis = {channel}
limits_deg = [-90.0, 90.0]
speed_dps = 45.0
points = [[1000.0, -90.0], [2000.0, 90.0]]
"""
READOUT = """
[readouts.daq]
driver = "scpi-daq"
model = "34970A"
resource = "twin"
channels = { x = { channel = 101, range_v = 10.0 } }

[sensors.P1]
model = "single-axis package"
channels = { x = "daq.x" }
nominal_sensitivity_v_per_g = 2.5

[twin.truth.P1.x]
offset_v = 0.0
sensitivity_v_per_g = 2.5
coning_deg = 0.0
azimuth_deg = 0.0
noise_v = 0.00002
"""
TOLERANCE, LAG = 4, 200
"""Quarter-microseconds: of the ends of a way, and how far a slowed servo goes in two seconds of a busy machine."""
QUARTERS_PER_DEG = 4000.0 / 180.0


def _targets_are_of(served: TimedServos, since: int, from_deg: float, to_deg: float) -> None:
    """Every Set Target since is the order, or of a servo that is there, on its way; the other one is told nothing."""
    ends = [6000 + deg * QUARTERS_PER_DEG for deg in (from_deg, to_deg)]
    (order, *stops) = served.targets[since:]
    assert (order[0], order[1]) == (1, round(ends[1]))
    for channel, target, pulse in stops:
        assert channel == 1, served.targets[since:]
        assert min(ends) - TOLERANCE <= target <= max(ends) + TOLERANCE, served.targets[since:]
        assert abs(target - pulse) <= LAG, served.targets[since:]
    assert stops, "nothing stopped it"


def _aborted(rig: Rig, rig_file: Path, to_deg: float, after_s: float) -> dict[str, str]:
    """Move roll, and have it stopped from elsewhere at some moment of its move; what the guard sent."""
    answers: list[dict[str, str] | None] = []

    def ask() -> None:
        CLOCK.sleep(after_s)
        (guard,) = of_rig(str(rig_file))
        answers.append(stop(guard, None, "ann"))

    thread = threading.Thread(target=ask)
    thread.start()
    with pytest.raises(WaitEnded, match="and roll to go at the lowest speed until this program stopped it"):
        move_and_arrive(rig.axes["roll"], to_deg, rig.clock, rig.clock.sleep)
    thread.join()
    stop_all(rig.axes, rig.clock)
    (told,) = answers
    assert told is not None
    return told


@pytest.mark.parametrize("latency_s", [0.0, pytest.param(0.04, marks=pytest.mark.thorough)])
def test_fault_94_an_abort_in_a_servos_move_sends_no_servo_where_nobody_asked(tmp_path: Path, latency_s: float) -> None:
    """Detected: while the engine lives the guard never reads.
    Response: the guard slows what moves, and the engine, which has the line, stops it where it is.
    """
    chance = np.random.default_rng(127)
    with timed_servos(latency_s) as served:
        servos = "".join(
            SERVO.format(name=name, port=served.path, channel=channel) for channel, name in enumerate(("pitch", "roll"))
        )
        rig_file = tmp_path / "rig.toml"
        rig_file.write_text(RIG + servos + READOUT, encoding="utf-8")
        with open_rig(read_rig(rig_file), rig_file=rig_file, purpose="test") as rig:
            for axis in rig.axes.values():
                home_and_arrive(axis, rig.clock, rig.clock.sleep)
            for number in range(6):
                from_deg = move_and_arrive(rig.axes["roll"], 0.0, rig.clock, rig.clock.sleep)
                since, to_deg = len(served.targets), -80.0 if number % 2 else 80.0
                told = _aborted(rig, rig_file, to_deg, float(chance.uniform(0.2, 0.9)))
                assert told == {"pitch": STOOD, "roll": SLOWED}
                _targets_are_of(served, since, from_deg, to_deg)
