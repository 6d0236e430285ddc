"""Laws of ``[export]``: a format that has no form of a sensor's set is refused before anything moves."""

from pathlib import Path

import pytest
from motion_runs import motion_run
from planning_files import procedure_file, rig_file
from solved_sets import tp_set

from ams.errors import SetError
from ams.exports.formats import FORMATS
from procedures.errors import PlanError
from procedures.kinds.planner import make_plan

YAW = """
[axes.yaw]
driver = "zaber"
port = "socket://127.0.0.1:3"
microstep_deg = 0.000234375
speed_dps = 5.0
limits_deg = [-90.0, 90.0]
"""
THREE = ('channels = { x = "dmm.x", y = "dmm.y", z = "dmm.z" }\nnom', "three-axis package")


def rig_of(folder: Path, axes: str, more: str = ""):
    words = {1: "single", 2: "two", 3: "three"}
    channels = ", ".join(f'{axis} = "dmm.{axis}"' for axis in axes)
    package = f'model = "{words[len(axes)]}-axis package"'
    changes = [('model = "three-axis package"', package), (THREE[0], f"channels = {{ {channels} }}\nnom")]
    return rig_file(folder, *changes, more=more)


def exporting(*formats: str) -> str:
    return f"[export]\nformats = [{', '.join(map(repr, formats))}]\n".replace("'", '"')


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_imucal_of_fewer_than_three_axes_is_refused_by_the_plan_as_by_the_export(tmp_path: Path, axes: str) -> None:
    with pytest.raises(PlanError, match=r"export\.formats: 'imucal' has no form of the set that SN1 will have") as plan:
        make_plan(rig_of(tmp_path, axes), procedure_file(tmp_path, more=exporting("json", "imucal")))
    with pytest.raises(SetError) as export:
        FORMATS["imucal"].to_bytes(tp_set(axes))
    needed = "needed are three accelerometers or three gyros x, y, z that lie in no plane"
    for refused in (plan, export):
        assert f"got the axes {', '.join(axes)}" in str(refused.value)
        assert needed in str(refused.value)
    assert "calrig export SET --to imucal" in str(plan.value)


@pytest.mark.parametrize("axes", ["x", "xy", "xyz"])
@pytest.mark.parametrize("name", sorted(set(FORMATS) - {"imucal"}))
def test_every_other_format_takes_packages_in_pitch_and_roll(tmp_path: Path, name: str, axes: str) -> None:
    assert make_plan(rig_of(tmp_path, axes), procedure_file(tmp_path, more=exporting(name))).steps


@pytest.mark.parametrize("name", ["linear", "c-fixed"])
def test_formats_of_pitch_and_roll_are_refused_of_packages_that_yaw(tmp_path: Path, name: str) -> None:
    yawing = 'yaw_deg = [-30.0, 0.0, 30.0]\n[solve]\nmodel = "pitch-yaw-roll"\n'
    with pytest.raises(PlanError, match="got convention CR, needed are accelerometers of pitch and roll") as refused:
        make_plan(rig_file(tmp_path, more=YAW), procedure_file(tmp_path, more=yawing + exporting(name)))
    assert f"'{name}' has no form of the set that SN1 will have" in str(refused.value)


def test_three_axes_have_every_format(tmp_path: Path) -> None:
    assert make_plan(rig_file(tmp_path), procedure_file(tmp_path, more=exporting(*sorted(FORMATS)))).steps


LINES = {
    "fields": ("servo-mechanism", "magnetometer"),
    "up and down": ("servo-mechanism", "accelerometer"),
    "rates": ("servo-mechanism", "gyro"),
}


@pytest.mark.parametrize("name", ["linear", "c-fixed"])
@pytest.mark.parametrize("lines", LINES)
def test_formats_of_straight_lines_are_planned_for_straight_lines(tmp_path: Path, lines: str, name: str) -> None:
    assert motion_run(tmp_path, *LINES[lines], {r'(model = "linear")': rf"\1\n\n{exporting(name)}"}).plan.steps


def test_imucal_has_no_form_of_magnetometers_and_the_plan_says_so(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"'imucal' has no form of the set that MicroMag3 will have: got the axes"):
        motion_run(tmp_path, *LINES["fields"], {r'(model = "linear")': rf"\1\n\n{exporting('imucal')}"})
