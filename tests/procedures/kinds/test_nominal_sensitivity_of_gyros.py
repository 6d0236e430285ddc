"""Laws of what is declared of gyros in volts: sensitivity and polarity of a data sheet are held against the turns."""

from pathlib import Path

import pytest
from motion_runs import motion_run

from procedures.solution.request import SolvedSensor

FEW = {
    "replications = .*": "replications = 2",
    "dwell_s = .*": "dwell_s = 2.0",
    r"(pitch|yaw|roll)_dps = .*": r"\g<1>_dps = [40.0]",
}


def _solved(folder: Path, declared: str, model: str) -> SolvedSensor:
    rig = {"nominal_sensitivity_v_per_dps = .*": f"nominal_sensitivity_v_per_dps = {declared}"}
    run = motion_run(folder, "rate-table", "rates", {**FEW, 'model = "gyro"': f'model = "{model}"'}, rig)
    return run.solved().sensors["ENC03J"]


def _told(sensor: SolvedSensor) -> dict[str, str]:
    assert sensor.calibration is not None
    return {
        label: finding.fact
        for label, axis in sensor.calibration.axes.items()
        for finding in axis.findings
        if finding.kind == "axis-contradicted"
    }


@pytest.mark.parametrize("model", ["gyro", "linear"])
def test_a_gyro_is_held_to_sensitivity_and_polarity_of_its_data_sheet_axis_by_axis(tmp_path: Path, model: str) -> None:
    told = _told(_solved(tmp_path, "{ x = 1.25, y = -1.25, z = 0.00125 }", model))
    assert set(told) == {"y", "z"}
    assert "polarity reversed" in told["y"]
    assert "nominal_sensitivity_v_per_dps" in told["z"]
    assert "millivolts" in told["z"]
