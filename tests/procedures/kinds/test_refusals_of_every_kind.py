"""What a grid refuses, every kind refuses: an attitude that an axis cannot stop at, by file, line and nearest angle."""

from pathlib import Path

import pytest
from motion_runs import motion_run

from procedures.errors import PlanError
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.kinds.registry import KINDS
from rig.description.read import read_rig
from rig.errors import DescriptionError

TABLE = """
[rig]
name = "bench"
gravity_mps2 = 9.80665
[axes.pitch]
driver = "indexing-table"
port = "socket://127.0.0.1:1"
increment_deg = 1.0
limits_deg = [-20.0, 20.0]
speed_dps = 5.0
approach_deg = {approach}
[axes.roll]
driver = "indexing-table"
port = "socket://127.0.0.1:1"
increment_deg = 1.0
limits_deg = [{low}, 180.0]
zero_deg = {zero}
speed_dps = 10.0
axis = 2
[readouts.dmm]
driver = "hp3458a"
resource = "prologix+socket://127.0.0.1:7#22"
nplc = 10
channels = {{ x = {{ scanner = 1, range_v = 10.0 }} }}
[sensors.SN1]
model = "single-axis package"
channels = {{ x = "dmm.x" }}
nominal_sensitivity_v_per_g = 2.5
"""
REST = """[procedure]
title = "a rest"
kind = "static"
[static]
duration_s = 60.0
pitch_deg = {pitch}
[solve]
model = "linear"
"""


def _refusal(folder: Path, pitch: str, approach: float = 0.0, low: float = -180.0, table: str = TABLE) -> str:
    (folder / "rig.toml").write_text(table.format(approach=approach, low=low, zero=min(0.0, -low)), encoding="utf-8")
    (folder / "rest.toml").write_text(REST.format(pitch=pitch), encoding="utf-8")
    rig = read_rig(folder / "rig.toml")
    with pytest.raises((PlanError, DescriptionError)) as caught:
        make_plan(rig, read_procedure(folder / "rest.toml"))
    return str(caught.value).replace(str(folder), "")


def test_a_rest_between_two_teeth_is_refused_with_its_neighbours(tmp_path: Path) -> None:
    text = _refusal(tmp_path, "12.5")
    assert text.startswith("/rest.toml:6: static.pitch_deg: point 1 asks for pitch 12.5°, the table stops only at")
    assert "nearest 12° and 13°" in text


def test_an_angle_that_the_machine_cannot_be_told_is_refused_with_what_would_be_written(tmp_path: Path) -> None:
    (tmp_path / "whole.toml").write_text(
        'name = "whole"\nincrement_deg = 1.0\nterminator = "\\r"\n'
        'position = { command = "P", reply = "{position_deg:g}" }\n'
        'move = { command = "M{target_deg:.0f}", targets_deg = [-15.0, 15.0] }\nstop = { command = "S" }\n',
        encoding="utf-8",
    )
    table = TABLE.replace("increment_deg = 1.0", 'increment_deg = 0.5\ndialect = "whole.toml"', 1)
    table = table.replace("127.0.0.1:1", "127.0.0.1:3", 1)  # a controller of its own: one line has one dialect
    text = _refusal(tmp_path, "12.5", table=table)
    assert text.startswith(
        "/rest.toml:6: static.pitch_deg: point 1 asks for pitch 12.5°: the dialect whole would write"
    )
    assert "'M12' by 'M{target_deg:.0f}', which is 12° (axes.pitch.dialect; 1 of 2 points cannot be told)" in text
    assert "would write 'M16', and its machine takes -15 to 15°" in _refusal(tmp_path, "16.0", table=table)
    assert "would write 'M16'" in _refusal(tmp_path, "12.0", approach=4.0, table=table)


def test_an_approach_that_leaves_the_limits_is_refused(tmp_path: Path) -> None:
    text = _refusal(tmp_path, "18.0", approach=5.0)
    assert text.startswith("/rest.toml:6: static.pitch_deg: point 1 asks for pitch 18°, allowed -20 to 20°")
    assert "3° too far with its approach of 5°, nearest 15°" in text


def test_the_level_attitude_that_every_kind_visits_is_held_to_the_limits_too(tmp_path: Path) -> None:
    assert "asks for roll 0°, allowed 10 to 180° (axes.roll.limits_deg), 10° too far, nearest 10°" in _refusal(
        tmp_path, "0.0", low=10.0
    )


@pytest.mark.parametrize("pitch", ["nan", "inf"])
def test_what_is_no_number_of_degrees_is_refused(tmp_path: Path, pitch: str) -> None:
    assert _refusal(tmp_path, pitch).startswith("/rest.toml:6: static.pitch_deg: ")


HOMES = {"servo-mechanism": "home_deg = 5.0", "rate-table": "zero_deg = -5.0"}
"""How each says that the home is inside the narrowed limits."""


def _limits(axis: str, low_deg: float, high_deg: float, example: str) -> dict[str, str]:
    home = HOMES[example] if low_deg > 0.0 else ""
    return {
        rf"(\[axes\.{axis}\]\n(?:.*\n)*?)limits_deg = \[[^]]*\]": rf"\1{home}\nlimits_deg = [{low_deg}, {high_deg}]"
    }


@pytest.mark.parametrize(
    ("example", "procedure", "kind"),
    [
        ("servo-mechanism", "accelerometer", "tumble"),
        ("servo-mechanism", "drift", "static"),
        ("servo-mechanism", "magnetometer", "two-level"),
        ("rate-table", "rates", "rates"),
        ("rate-table", "harmonic", "profile"),
    ],
)
def test_no_kind_plans_what_narrowed_limits_forbid(tmp_path: Path, example: str, procedure: str, kind: str) -> None:
    assert kind in KINDS
    with pytest.raises(PlanError, match=r"procedure\.toml:\d+: .*limits"):
        motion_run(tmp_path, example, procedure, rig_changes=_limits(r"\w+", 5.0, 170.0, example))


@pytest.mark.parametrize(("low", "high"), [(-20.0, 20.0), (-180.0, 170.0), (5.0, 364.0)])
def test_an_axis_that_may_not_turn_a_whole_circle_is_not_asked_for_revolutions(
    tmp_path: Path, low: float, high: float
) -> None:
    changes = _limits("pitch", low, high, "rate-table")
    with pytest.raises(
        PlanError, match=r"procedure\.toml:\d+: rates\.pitch_dps: pitch turns whole revolutions, allowed are"
    ):
        motion_run(tmp_path, "rate-table", "rates", rig_changes=changes)
