"""A line that breaks while an axis turns at a rate: it is opened again, and the axis stopped, before anything ends."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from cut_line import CutLine, cut_line
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import SimulatedRig
from rig.clock import SystemClock
from rig.description.read import read_rig
from rig.errors import DeviceFault, LinkLost
from rig.motion.jog import turn_for
from rig.motion.move import home_and_arrive
from rig.motion.out_of_reach import open_in_time, out_of_reach

CLOCK = SystemClock()
RATE_DPS = 10.0
REFUSALS = 2
FOR_GOOD = 1_000_000


@contextmanager
def _at_a_line_that_breaks(folder: Path) -> Iterator[tuple[Rig, CutLine, SimulatedRig]]:
    """Roll, homed, over TCP."""
    with served(folder, CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (simulated, rig_file):
        address = simulated.addresses["axes.roll"]
        with cut_line(address) as line:
            rig_file.write_text(rig_file.read_text(encoding="utf-8").replace(address, line.address), encoding="utf-8")
            with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
                home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
                yield rig, line, simulated


def _rate_dps(simulated: SimulatedRig) -> float:
    return simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s())


def test_an_axis_whose_line_is_reset_while_it_turns_by_hand_is_stopped_when_the_line_is_back(tmp_path: Path) -> None:
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):

        def wait(duration_s: float) -> None:
            rig.clock.sleep(duration_s)
            line.cut(REFUSALS)

        with pytest.raises(LinkLost, match="what was sent last is in doubt"):
            turn_for(rig, "roll", RATE_DPS, 60.0, wait)
        assert _rate_dps(simulated) == 0.0
        assert line.callers > REFUSALS


def test_a_line_that_does_not_come_back_is_waited_for_so_long_and_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rig.motion.out_of_reach.BACK_S", 1.0)
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):

        def wait(duration_s: float) -> None:
            rig.clock.sleep(duration_s)
            line.cut(FOR_GOOD)

        with pytest.raises(DeviceFault, match=r"roll: .*; use the stop button at the machine"):
            turn_for(rig, "roll", RATE_DPS, 60.0, wait)
        assert out_of_reach(rig)
        assert _rate_dps(simulated) == RATE_DPS, "nobody reaches it"
        line.cut(0)
        assert open_in_time(rig) == ""
        assert not out_of_reach(rig)
        rig.axes["roll"].stop()


def test_a_line_that_breaks_while_every_axis_stands_is_not_waited_for(tmp_path: Path) -> None:
    with _at_a_line_that_breaks(tmp_path) as (rig, line, _):
        line.cut(FOR_GOOD)
        with pytest.raises(LinkLost):
            rig.axes["roll"].state()
        assert not out_of_reach(rig)
