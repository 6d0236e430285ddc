"""A check says of the order of turns and levels what the result of their run says, at any rig."""

from pathlib import Path

import pytest
from motion_runs import motion_run

from procedures.check.check_report import check
from procedures.kinds.read import read_procedure

ONE_RATE = {r"(pitch|yaw|roll)_dps = .*": r"\1_dps = [90.0]", r"dwell_s = .*": "dwell_s = 4.0"}
SHORT = {r"samples = \d+": "samples = 20"}
TWICE = {r"replications = \d": "replications = 2"}


def _said(texts: tuple[str, ...]) -> list[str]:
    return [text for text in texts if "go together" in text]


@pytest.mark.parametrize(
    ("model", "is_one_rate", "is_told"),
    [
        ("gyro", False, False),
        ("gyro", True, True),
        ("linear", False, False),
        ("linear", True, False),  # levels of a line, which lie in no laying
    ],
)
def test_one_rate_about_an_axis_in_both_senses_is_told_beforehand_as_afterwards(
    model: str, is_one_rate: bool, is_told: bool, tmp_path: Path
) -> None:
    changes = {r'model = ".*"': f'model = "{model}"', **TWICE, **(ONE_RATE if is_one_rate else {})}
    made = motion_run(tmp_path, "rate-table", "rates", changes)
    foreseen = _said(check(made.rig, read_procedure(made.folder / "procedure.toml")).forecast.reservations)
    assert bool(foreseen) == is_told
    for sensor in made.solved().sensors.values():
        assert sensor.calibration is not None
        for axis in sensor.calibration.axes.values():
            assert _said(axis.warnings) == foreseen


@pytest.mark.parametrize(("order", "is_told"), [("raster", True), ("there-and-back", True), ("forward-reverse", False)])
def test_levels_in_one_order_are_told_and_the_order_that_is_named_is_not(
    order: str, is_told: bool, tmp_path: Path
) -> None:
    """Each axis up and down: there and back has the two in one order, every replication."""
    made = motion_run(tmp_path, "servo-mechanism", "accelerometer", {r'order = ".*"': f'order = "{order}"', **SHORT})
    foreseen = _said(check(made.rig, read_procedure(made.folder / "procedure.toml")).forecast.reservations)
    assert bool(foreseen) == is_told
    assert all("forward-reverse" in text for text in foreseen)
    for sensor in made.solved().sensors.values():
        assert sensor.calibration is not None
        for axis in sensor.calibration.axes.values():
            assert _said(axis.warnings) == foreseen
