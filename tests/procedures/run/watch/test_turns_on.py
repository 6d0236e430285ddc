"""The safe state of a run whose line breaks while an axis turns at a rate: it would turn on for good."""

from pathlib import Path

import pytest
from cut_line import cut_line
from small_run import bench
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from procedures.run.watch.safe_state import make_safe
from rig.assembly.open_rig import open_rig
from rig.clock import SystemClock
from rig.description.read import read_rig
from rig.errors import RigError
from rig.motion.move import home_and_arrive

CLOCK = SystemClock()


def test_an_axis_whose_adapter_was_unplugged_while_it_turned_is_stopped_when_it_is_back(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    plan = bench(tmp_path / "run").plan
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (simulated, rig_file):
        address = simulated.addresses["axes.roll"]
        with cut_line(address) as line:
            rig_file.write_text(rig_file.read_text(encoding="utf-8").replace(address, line.address), encoding="utf-8")
            with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
                home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
                rig.axes["roll"].start_rate(10.0)  # type: ignore[attr-defined]
                line.cut(refusals=2)
                safe = make_safe(rig, plan)
                assert (safe.failures, set(safe.positions_deg)) == ((), set(rig.axes))
                assert simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) == 0.0


def test_an_axis_that_turns_while_every_line_is_out_is_stopped_when_its_own_is_back(tmp_path: Path) -> None:
    """A run that is held for it is given up: its lines were closed, and the meter's stays away."""
    (tmp_path / "run").mkdir()
    plan = bench(tmp_path / "run").plan
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (simulated, rig_file):
        roll = simulated.addresses["axes.roll"]
        meter = simulated.addresses["readouts.dmm"].removeprefix("prologix+").partition("#")[0]
        with cut_line(roll) as line, cut_line(meter) as dead:
            text = rig_file.read_text(encoding="utf-8").replace(roll, line.address).replace(meter, dead.address)
            rig_file.write_text(text, encoding="utf-8")
            with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
                home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
                rig.axes["roll"].start_rate(10.0)  # type: ignore[attr-defined]
                line.cut(refusals=4)
                dead.cut(refusals=1_000_000)
                with pytest.raises(RigError):
                    rig.reconnect()
                safe = make_safe(rig, plan, is_open=False)
                assert (safe.failures, set(safe.positions_deg)) == ((), set(rig.axes))
                assert "roll turned when its line was lost" in safe.reopened
                assert simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) == 0.0
