"""What the dwell before keeps across an axis, and what settles after moves of the slower axis, against physics."""

from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import Campaign, campaigns
from solved_campaigns import columns_of, coverage, rows_of
from solved_campaigns import solved as solved_columns

from ams.analysis.diagnostics.beliefs import SETTLING
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest

ACROSS = "at the dwell before"
AFTER = "settling after every move of the slower axis"


def _solved(drawn: Campaign) -> list[Calibration]:
    rows, axes = rows_of(drawn), drawn.setup.axes
    outputs = {axis: columns_of(drawn, axis) for axis in axes}
    return [
        calibrate(replace(rows, outputs={axis: outputs[axis][:, index] for axis in axes}), CalibrationRequest())
        for index in range(drawn.campaigns)
    ]


def _told(solved: Calibration, axis: str, test: str) -> list[Finding]:
    return [
        finding
        for finding in solved.axes[axis].findings
        if finding.is_significant and str(finding.details.get("test", "")).endswith(test)
    ]


@pytest.mark.parametrize("design", [{}, {"pitch_count": 7, "roll_count": 8, "replications": 4}])
def test_a_channel_that_keeps_some_of_the_one_before_is_told_by_name_with_its_size(design: dict[str, int]) -> None:
    """10 ppm of z in x turned k_x by 1.5″ where 0.5″ was stated, and was sound or "contained"."""
    for solved in _solved(campaigns("carry-over", 30.0, np.random.default_rng(11), 6, **design)):
        (told,) = _told(solved, "x", ACROSS)
        assert told.details["test"] == "force along z at the dwell before"
        size, u = (float(told.details[name] or 0.0) for name in ("size", "standard_uncertainty"))
        along = float(np.linalg.norm(solved.axes["z"].primary[1:4]))
        assert abs(size) == pytest.approx(30e-6 * along, abs=4.0 * u)
        assert solved.verdict == "not usable"
        assert not any("it is contained" in f.text for f in solved.axes["x"].findings if f.kind == "lack-of-fit")
        assert not _told(solved, "y", ACROSS)


def test_what_the_channel_before_leaves_at_the_first_dwells_is_no_settling() -> None:
    """Before the first dwell of a replication the channel read the last of the one before."""
    for solved in _solved(campaigns("carry-over", 500.0, np.random.default_rng(11), 6)):
        assert _told(solved, "x", ACROSS)
        assert not _told(solved, "x", SETTLING)


def test_what_settles_after_moves_of_the_slower_axis_is_told_where_it_moves_the_offset() -> None:
    """0.8″ at the first dwell of every row left 30 % of the offsets within what was stated, and no finding."""
    drawn = campaigns("after-pitch-moves", 10.0, np.random.default_rng(12), 10)
    for solved in _solved(drawn):
        assert any(_told(solved, axis, AFTER) for axis in "xyz")
        assert solved.verdict == "not usable"


def test_an_order_drawn_anew_makes_chance_of_what_the_channel_before_leaves() -> None:
    drawn = campaigns("carry-over", 30.0, np.random.default_rng(13), 60, order="random")
    held = coverage(drawn, solved_columns(drawn), np.random.default_rng(14))
    assert min(held.sensitivities, held.prediction) >= 0.9


def test_a_raster_without_a_slow_axis_has_no_moves_to_settle_after() -> None:
    drawn = campaigns("clean", 0.0, np.random.default_rng(14), 1, order="random")
    made = {str(finding.details.get("test")) for finding in _solved(drawn)[0].axes["x"].findings}
    assert AFTER not in made
    again = campaigns("clean", 0.0, np.random.default_rng(14), 1)
    assert AFTER in {str(finding.details.get("test")) for finding in _solved(again)[0].axes["x"].findings}
