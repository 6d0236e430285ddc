"""Laws of ``[acceptance]``: a limit is judged, or the plan that would not judge it is refused before anything moves."""

from pathlib import Path

import pytest
from motion_runs import EXAMPLES
from planning_files import procedure_file, rig_file

from procedures.check.check_report import check
from procedures.errors import PlanError
from procedures.kinds.read import read_procedure
from rig.description.read import read_rig

LIMITS = "[acceptance]\npitch_limit_deg = 0.01\nroll_limit_deg = 0.02\n"
ONE_AXIS = (
    ('model = "three-axis package"', 'model = "single-axis package"'),
    ('channels = { x = "dmm.x", y = "dmm.y", z = "dmm.z" }\nnom', 'channels = { x = "dmm.x" }\nnom'),
)
YAW = """
[axes.yaw]
driver = "zaber"
port = "socket://127.0.0.1:3"
microstep_deg = 0.000234375
speed_dps = 5.0
limits_deg = [-90.0, 90.0]
"""
ANOTHER_PACKAGE = """
[sensors.SN2]
model = "single-axis package"
channels = { x = "dmm.t" }
nominal_sensitivity_v_per_g = 2.5
"""


def complaint(folder: Path, more_of_rig: str, more_of_procedure: str = "", *changes: tuple[str, str]) -> str:
    with pytest.raises(PlanError) as refused:
        check(rig_file(folder, *changes, more=more_of_rig), procedure_file(folder, more=more_of_procedure))
    return str(refused.value)


def test_packages_of_three_axes_in_pitch_and_roll_are_held_to_both(tmp_path: Path) -> None:
    report = check(rig_file(tmp_path, more=LIMITS), procedure_file(tmp_path))
    assert not any("is judged of" in text for text in report.forecast.reservations)


def test_packages_that_yaw_are_held_to_none_and_the_keys_are_refused(tmp_path: Path) -> None:
    solve = 'yaw_deg = [-30.0, 0.0, 30.0]\n[solve]\nmodel = "pitch-yaw-roll"\n'
    said = complaint(tmp_path, LIMITS + YAW, solve)
    for limit in ("acceptance.pitch_limit_deg = 0.01", "acceptance.roll_limit_deg = 0.02"):
        assert f"no sensor of this run can be held to {limit} of the rig file" in said
    assert "procedure.toml:" in said
    assert "solve.model" in said
    assert "remove it from the rig file of this run" in said


def test_a_lone_axis_is_held_to_pitch_and_a_limit_of_roll_is_refused(tmp_path: Path) -> None:
    said = complaint(tmp_path, LIMITS, "", *ONE_AXIS)
    assert "acceptance.roll_limit_deg = 0.02" in said
    assert "pitch_limit_deg" not in said


def test_straight_lines_are_held_to_no_angle(tmp_path: Path) -> None:
    said = complaint(tmp_path, LIMITS, '[solve]\nmodel = "linear"\n')
    assert said.count("no sensor of this run can be held to acceptance.") == 2


def test_a_limit_that_some_packages_of_a_run_are_held_to_is_a_reservation(tmp_path: Path) -> None:
    said = check(rig_file(tmp_path, more=LIMITS + ANOTHER_PACKAGE), procedure_file(tmp_path)).forecast.reservations
    (of_roll,) = [text for text in said if "is judged of" in text]
    assert of_roll.startswith("acceptance.roll_limit_deg = 0.02 is judged of SN1, and not of SN2: ")


def test_a_long_rest_is_held_to_its_own_figure_and_the_limits_of_the_rig_file_are_a_reservation(tmp_path: Path) -> None:
    folder = EXAMPLES / "servo-mechanism"
    rig = tmp_path / "rig.toml"
    rig.write_text((folder / "rig.toml").read_text(encoding="utf-8") + LIMITS, encoding="utf-8")
    said = check(read_rig(rig), read_procedure(folder / "drift.toml")).forecast.reservations
    judged = [text for text in said if "is judged of" in text]
    assert [text.partition(" is ")[0] for text in judged] == [
        "acceptance.pitch_limit_deg = 0.01 of the rig file",
        "acceptance.roll_limit_deg = 0.02 of the rig file",
    ]
    assert all(text.endswith("this run is held to static.allowed_deg") for text in judged)
