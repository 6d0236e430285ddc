"""In which order the rows stand in a file decides nothing: their labels and times do."""

from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import rows_of_package

from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

SMALL = {"pitch_count": 7, "roll_count": 6, "replications": 4}
PLAIN, ESTIMATED = CalibrationRequest(), CalibrationRequest(temperature="estimate")


def _told(rows: Observations, request: CalibrationRequest) -> dict[tuple[str, str, str], float]:
    return {
        (axis, finding.kind, str(finding.details.get("test"))): finding.p_value
        for axis, solved in calibrate(rows, request).axes.items()
        for finding in solved.findings
        if finding.p_value is not None
    }


@pytest.mark.parametrize(("scene", "size", "request_of_scene", "design"), [
    ("clean", 0.0, PLAIN, {**SMALL, "order": "there-and-back"}),
    ("clean", 0.0, PLAIN, {**SMALL, "order": "random"}),
    ("after-effect", 10.0, PLAIN, {**SMALL, "order": "raster-and-back"}),
    ("temperature-curvature", 1.0, ESTIMATED, {}),
])  # fmt: skip
def test_rows_in_the_order_of_time_or_mixed_have_the_findings_of_rows_in_the_order_of_points(
    scene: str, size: float, request_of_scene: CalibrationRequest, design: dict
) -> None:
    """A run's rows stand in the order of time, the studies' by point: memories were tested otherwise, and terms."""
    rows = rows_of_package(campaigns(scene, size, np.random.default_rng(3), 1, **design))
    by_point = _told(rows, request_of_scene)
    assert rows.time_s is not None
    for order in (np.argsort(rows.time_s), np.random.default_rng(1).permutation(rows.rows)):
        assert _told(_sorted(rows, order), request_of_scene) == pytest.approx(by_point, rel=1e-6, abs=1e-300)


def _sorted(rows: Observations, order: np.ndarray) -> Observations:
    columns = {name: values[order] for name, values in vars(rows).items() if isinstance(values, np.ndarray)}
    return replace(rows, **columns, outputs={axis: values[order] for axis, values in rows.outputs.items()})
