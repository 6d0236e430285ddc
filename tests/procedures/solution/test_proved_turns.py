"""A slip that the visits of a run prove over all sensors blames no sensor beside the table, in the shortest of runs.

Twelve attitudes, twice: twelve degrees of freedom are left to tell what differs between the replications, too few for
a package to look for changes by itself.
"""

from pathlib import Path

import pytest
from turned_table import TWO, several_sensors, slips
from unattended_run import UnattendedRun, asks, run_unattended

from procedures.delivery.deliver import solve_run
from procedures.records.states import State


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
