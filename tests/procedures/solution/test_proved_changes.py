"""What visits prove of table or meter over all sensors blames no sensor beside them, in the shortest of runs.

Twelve attitudes, twice: twelve degrees of freedom are left to tell what differs between the replications, too few for
a package to look for changes by itself.
"""

from dataclasses import replace
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from turned_table import TWO, several_sensors, slips
from unattended_run import UnattendedRun, asks, run_unattended

from procedures.delivery.deliver import solve_run
from procedures.records.states import State
from rig.devices.abilities import Burst


@pytest.mark.parametrize(("axis", "by_deg", "after"), [("pitch", 0.02, 16), ("roll", 0.005, 13)])
def test_no_sensor_is_blamed_for_a_slip_that_the_visits_prove(
    tmp_path: Path, axis: str, by_deg: float, after: int
) -> None:
    bench = several_sensors(tmp_path, 3, procedure=TWO[:1])
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("continue")}, after={after: slips(axis, by_deg)})
    assert run_unattended(bench, unattended).state is State.FINISHED
    for name, sensor in solve_run(unattended.run_dir).sensors.items():
        assert sensor.calibration is not None
        assert sensor.calibration.verdict == "not usable"
        for label, solved_axis in sensor.calibration.axes.items():
            significant = [finding for finding in solved_axis.findings if finding.is_significant]
            assert [finding.kind for finding in significant] == ["table-rotation"], (name, label, significant)
            assert f"about {axis} between visits" in significant[0].text


@pytest.mark.parametrize(("channels", "by"), [(9 * 12, 1.0005), (9 * 12 + 4, 0.9998)])
def test_neither_sensors_nor_table_are_blamed_for_a_gain_of_the_meter_that_the_visits_prove(
    tmp_path: Path, channels: int, by: float
) -> None:
    """From one channel on, in the middle of a dwell as well: six check dwells, six of the design and a visit before."""

    def turned_up(number: int, burst: Burst) -> Burst:
        return replace(burst, samples=burst.samples * by) if number >= channels else burst

    bench = several_sensors(tmp_path, 3, procedure=TWO[:1])
    unattended = UnattendedRun(tmp_path / "run")
    state = run_unattended(bench, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=turned_up)).state
    assert state is State.FINISHED
    for name, sensor in solve_run(unattended.run_dir).sensors.items():
        assert sensor.calibration is not None
        for label, solved_axis in sensor.calibration.axes.items():
            significant = [finding for finding in solved_axis.findings if finding.is_significant]
            assert {finding.kind for finding in significant} == {"meter-gain"}, (name, label, significant)
            assert "the meter (gain of dmm)" in significant[0].text
