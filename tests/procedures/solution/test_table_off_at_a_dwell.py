"""A run whose table stood off at one dwell, in and out: all packages carry one finding, and no axis is blamed."""

import shlex
from pathlib import Path

from turned_table import several_sensors, slips
from unattended_run import UnattendedRun, run_unattended

from procedures.delivery.deliver import solve_run
from procedures.records.states import State


def test_a_table_in_and_out_is_told_once_with_one_command(tmp_path: Path) -> None:
    bench = several_sensors(tmp_path, 3, procedure=())
    unattended = UnattendedRun(tmp_path / "run", after={9: slips("roll", 0.02), 10: slips("roll", -0.02)})
    assert run_unattended(bench, unattended).state is State.FINISHED
    solved = solve_run(unattended.run_dir)
    texts = set()
    for sensor in solved.sensors.values():
        assert sensor.calibration is not None
        assert sensor.calibration.verdict == "not usable"
        for axis in sensor.calibration.axes.values():
            significant = [finding for finding in axis.findings if finding.is_significant]
            assert [finding.kind for finding in significant] == ["table-rotation"]
            texts |= {finding.text for finding in significant}
    (text,) = texts
    assert "all three sensors show it, so it is not the sensors" in text
    assert "about roll at step" in text
    run = shlex.quote(str(unattended.run_dir))
    assert text.count("calrig void") == text.count(f"calrig void {run} --from ") == 1
    assert text.count("calrig redo") == text.count(f"calrig redo {run} --replication ") > 0
