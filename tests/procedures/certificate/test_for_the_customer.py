"""What a certificate says of a finding: what the data show of the item, and no command of the laboratory."""

from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.calibration.calibrate import calibrate
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from procedures.certificate.page import for_the_customer
from procedures.common_mode.ways_out import ACCEPTED


def _significant(scene: str, size: float) -> list[Finding]:
    """Return what is found in a run whose steps and name are known, so that findings have whole commands."""
    drawn = campaigns(scene, size, np.random.default_rng(5), 1)
    outputs = {axis: columns_of(drawn, axis)[:, 0] for axis in drawn.setup.axes}
    rows = rows_of(drawn)
    rows = replace(rows, outputs=outputs, step=np.arange(1, rows.rows + 1), run="runs/a")
    solved = calibrate(rows, CalibrationRequest(nominal_axes={axis: axis for axis in outputs}))
    return [finding for axis in solved.axes.values() for finding in axis.findings if finding.is_significant]


@pytest.mark.parametrize(("scene", "size"), [("wrong-dwell", 100.0), ("slip-roll", 72.0), ("slip-pitch", 72.0)])
def test_findings_of_a_run_stand_on_a_certificate_without_commands(scene: str, size: float) -> None:
    found = [finding for finding in _significant(scene, size) if "calrig " in finding.text]
    assert found
    for finding in found:
        said = for_the_customer(finding.text)
        assert "calrig " not in said
        assert "NAME" not in said
        assert said.count("(") == said.count(")")
        assert said[:60] == finding.text[:60]


def test_a_way_out_is_left_out_and_what_is_in_doubt_stays() -> None:
    text = (
        "All three sensors read 200 ppm more: the meter (gain of dmm); in doubt are the 20 dwells of steps 29 to 48: "
        "to measure them again put the meter right, then calrig void runs/a --from 29 --operator NAME --reason TEXT, "
        f"and calrig resume runs/a; {ACCEPTED}"
    )
    assert for_the_customer(text) == (
        "All three sensors read 200 ppm more: the meter (gain of dmm); in doubt are the 20 dwells of steps 29 to 48"
    )
