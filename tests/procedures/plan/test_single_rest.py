"""A plan of one long rest is known by its steps: no kind is asked for by name."""

from pathlib import Path

import pytest
from motion_runs import motion_run

PLANS = [
    ("servo-mechanism", "drift", True),
    ("servo-mechanism", "accelerometer", False),
    ("servo-mechanism", "gyro", False),
    ("servo-mechanism", "magnetometer", False),
    ("rate-table", "harmonic", False),
    ("rate-table", "ramp", False),
    ("rate-table", "rates", False),
]


@pytest.mark.parametrize(("rig", "procedure", "is_rest"), PLANS)
@pytest.mark.parametrize("replications", [1, 3])
def test_only_a_long_rest_at_one_attitude_has_no_dwell_of_another_point(
    tmp_path: Path, rig: str, procedure: str, is_rest: bool, replications: int
) -> None:
    plan = motion_run(tmp_path, rig, procedure, {r"replications = \d": f"replications = {replications}"}).plan
    assert plan.is_single_rest is is_rest
