"""Runs on twins whose procedure asks for CR's packages on a gimbal, or for SR's straight lines."""

import json
from pathlib import Path

import numpy as np
import pytest
from small_run import Bench, bench, dwells_of

from procedures.errors import PlanError
from procedures.solving import solve_sensors

YAW = (
    "[readouts.dmm]",
    '[axes.yaw]\ndriver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\nlimits_deg = [-90.0, 90.0]\n'
    "speed_dps = 20.0\naxis = 3\n[readouts.dmm]",
)
GIMBAL = ("roll_deg = {", "yaw_deg = [-30.0, 0.0, 30.0]\nroll_deg = {")


def solve_table(text: str) -> tuple[str, str]:
    return "[check]", f"[solve]\n{text}\n[check]"


def solved_axes(made: Bench, run_dir: Path) -> dict:
    made.run(run_dir)
    plan = made.plan
    found = solve_sensors(dwells_of(run_dir), made.rig, plan.sensors, plan.solve, "run")["SN1"]
    assert found.failure is None, found.failure
    assert found.calibration is not None
    return dict(found.calibration.axes)


def values(axis) -> dict:
    return {estimate.name: (estimate.value, estimate.standard_uncertainty) for estimate in axis.parameters}


def test_a_gimbal_run_recovers_the_truth_in_cr_terms(tmp_path: Path) -> None:
    """MATH 1: for the same sensor C = Ω, A_CR = A_TP + 90°, S_CR = −S_TP; the twin's truth is in TP's terms."""
    made = bench(tmp_path, (YAW,), (GIMBAL, solve_table('model = "pitch-yaw-roll"')))
    assert {dwell.targets_deg["yaw"] for dwell in made.plan.design_dwells} == {-30.0, 0.0, 30.0}
    axes = solved_axes(made, tmp_path / "run")
    for axis, truth in {"x": (0.005, 2.5, 0.5, 35.0), "y": (-0.003, 2.48, 0.3, -110.0)}.items():
        found = values(axes[axis])
        assert found["offset_v"][0] == pytest.approx(truth[0], abs=3e-5)
        assert found["sensitivity_v_per_g"][0] == pytest.approx(-truth[1], abs=6e-5)
        assert found["coning_deg"][0] == pytest.approx(truth[2], abs=2e-3)
        assert found["azimuth_deg"][0] == pytest.approx((truth[3] + 90.0 + 180.0) % 360.0 - 180.0, abs=0.3)


def test_a_model_without_yaw_is_refused_for_a_design_with_yaw(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r'solve.model.*"pitch-roll" has no yaw.*use "pitch-yaw-roll"'):
        bench(tmp_path, (YAW,), (GIMBAL, solve_table('model = "pitch-roll"')))


def test_cr_without_a_yaw_axis_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match="needs the axis yaw, which the rig does not have"):
        bench(tmp_path, (), (solve_table('model = "pitch-yaw-roll"'),))


def test_a_package_that_the_rig_does_not_have_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match="no sensor SN9"):
        bench(tmp_path, (YAW,), (solve_table('model = "pitch-yaw-roll"\npackages = { SN9 = "sting" }'),))


def test_a_straight_line_of_a_tumble_is_the_two_level_solution_of_the_twin(tmp_path: Path) -> None:
    """SR: real = A·measured + B with A = 1/S and B = −b/S; S of the line is S·cosΩ of the twin."""
    tumble = (
        ('kind = "grid"', 'kind = "tumble"'),
        ('kind = "D"', 'kind = "T"'),
        ("pitch_deg = { from = -30.0, to = 30.0, step = 30.0 }\n", ""),
        ("roll_deg = { from = -180.0, to = 90.0, step = 90.0 }\n", ""),
        solve_table('model = "linear"'),
    )
    axes = solved_axes(bench(tmp_path, (), tumble), tmp_path / "run")
    slope = 2.5 * np.cos(np.deg2rad(0.5))
    found = values(axes["x"])
    assert list(found) == ["gain_g_per_v", "offset_g"]
    assert found["gain_g_per_v"][0] == pytest.approx(1.0 / slope, rel=3e-5)
    # four of the six attitudes lie across x: what the coning angle makes of gravity there is in the offset
    assert found["offset_g"][0] == pytest.approx(-0.005 / slope, abs=5e-3)


def test_delivery_of_a_gimbal_run_leaves_a_set_with_its_yaw_range(tmp_path: Path) -> None:
    from procedures.delivery import deliver, solve_run

    made = bench(tmp_path, (YAW,), (GIMBAL, solve_table('model = "pitch-yaw-roll"')))
    made.run(tmp_path / "run")
    delivery = deliver(solve_run(tmp_path / "run"), None)
    document = json.loads(delivery.sets["SN1"].read_text(encoding="utf-8"))
    assert document["validity"]["yaw_deg"] == [-30.0, 30.0]
    assert document["convention"]["name"] == "CR"
    assert delivery.report.exists()


def test_straight_lines_leave_a_report_and_say_that_they_make_no_set(tmp_path: Path) -> None:
    from procedures.delivery import deliver, sensors_document, solve_run

    made = bench(tmp_path, (), (solve_table('model = "linear"'),))
    made.run(tmp_path / "run")
    run = solve_run(tmp_path / "run")
    delivery = deliver(run, None)
    assert not delivery.sets
    assert "g/V" in delivery.report.read_text(encoding="utf-8")
    axis = sensors_document(run)["SN1"]["axes"]["z"]
    assert any("no coefficient set" in warning for warning in axis["warnings"])


def test_a_time_term_of_a_run_takes_the_twins_drift_and_the_set_says_where_it_stands(tmp_path: Path) -> None:
    """The twin's offset moves by 40 µV a replication; the drift found is that over the hours of a replication."""
    from procedures.delivery import deliver, solve_run

    drifting = ("azimuth_deg = 35.0,", "azimuth_deg = 35.0, offset_drift_v_per_replication = 4e-5,")
    four = ("replications = 2", "replications = 4")
    made = bench(tmp_path, (drifting,), (four, solve_table('time_term = "linear"')))
    made.run(tmp_path / "run")
    run = solve_run(tmp_path / "run")
    solved = run.sensors["SN1"]
    assert solved.calibration is not None
    times_s = solved.observations.time_s
    assert times_s is not None
    hours = float(np.polyfit(solved.observations.replication, times_s / 3600.0, 1)[0])
    found = values(solved.calibration.axes["x"])
    assert found["offset_drift_v_per_h"][0] == pytest.approx(4e-5 / hours, rel=0.05)
    document = json.loads(deliver(run, None).sets["SN1"].read_text(encoding="utf-8"))
    assert "offset_drift_v_per_h" not in document["axes"]["x"]["primary"]["order"]
    assert any("never applied" in warning for warning in document["axes"]["x"]["warnings"])
    assert any("the run's times count from" in warning for warning in document["warnings"])


def test_a_sensor_that_is_named_a_sting_package_is_solved_as_one(tmp_path: Path) -> None:
    """With roll at rest both packages of CR feel the same gravity, so the twin's truth comes back from either."""
    resting = (
        (GIMBAL[0], "yaw_deg = [-30.0, 0.0, 30.0]\nroll_deg = {"),
        ("from = -180.0, to = 90.0, step = 90.0", "from = 0.0, to = 0.0, count = 1"),
    )
    made = bench(tmp_path, (YAW,), (*resting, solve_table('model = "pitch-yaw-roll"\npackages = { SN1 = "sting" }')))
    axes = solved_axes(made, tmp_path / "run")
    assert axes["x"].model == "pitch-yaw-roll-sting"
    assert values(axes["x"])["sensitivity_v_per_g"][0] == pytest.approx(-2.5, abs=2e-4)
