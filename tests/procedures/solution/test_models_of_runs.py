"""Runs on twins whose procedure asks for CR's packages on a gimbal, or for SR's straight lines."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from installed_examples import install_example
from small_run import RIG, Bench, bench, dwells_of

from ams.calibration.calibrate import calibrate
from ams.observations import Observations
from procedures.delivery.deliver import Delivery, deliver, sensors_document, sets_of, solve_run
from procedures.description.procedure_file import Solve
from procedures.errors import PlanError
from procedures.kinds.expected_attitudes import forecast_of_design
from procedures.kinds.read import read_procedure
from procedures.kinds.solve import solve_sensors
from procedures.solution.request import request_for, request_of
from rig.errors import DescriptionError

YAW = (
    "[readouts.dmm]",
    '[axes.yaw]\ndriver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\nlimits_deg = [-90.0, 90.0]\n'
    "speed_dps = 180.0\naxis = 3\n[readouts.dmm]",
)
GIMBAL = ("roll_deg = {", "yaw_deg = [-30.0, 0.0, 30.0]\nroll_deg = {")

CAMPAIGNS = 60
OTHER_AXES = (
    "y = { offset_v = -0.003, sensitivity_v_per_g = 2.48, coning_deg = 0.3, azimuth_deg = -110.0, noise_v = 2e-5 }",
    "z = { offset_v = 0.008, sensitivity_v_per_g = 2.52, coning_deg = 0.4, azimuth_deg = 160.0, noise_v = 2e-5 }",
)


def solve_table(text: str) -> tuple[str, str]:
    return "[check]", f"[solve]\n{text}\n[check]"


def solved_axes(made: Bench, run_dir: Path) -> dict:
    made.run(run_dir)
    plan = made.plan
    found = solve_sensors(dwells_of(run_dir), made.rig, plan, "run")["SN1"]
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


STING = (
    "[twin]\nseed",
    '[readouts.second]\ndriver = "hp3458a"\nresource = "twin"\nnplc = 1\n'
    "channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, "
    "z = { scanner = 3, range_v = 10.0 } }\n"
    '[sensors.STING]\nmodel = "three-axis package"\nnominal_sensitivity_v_per_g = 2.5\n'
    'channels = { x = "second.x", y = "second.y", z = "second.z" }\nstage = ["pitch", "yaw"]\n[twin]\nseed',
)
STING_TRUTH = (
    "[twin.truth.SN1]",
    "[twin.truth.STING]\n"
    "x = { offset_v = 0.011, sensitivity_v_per_g = 2.45, coning_deg = 0.6, azimuth_deg = 50.0, noise_v = 2e-5 }\n"
    "y = { offset_v = -0.007, sensitivity_v_per_g = 2.55, coning_deg = 0.4, azimuth_deg = -70.0, noise_v = 2e-5 }\n"
    "z = { offset_v = 0.002, sensitivity_v_per_g = 2.51, coning_deg = 0.5, azimuth_deg = 120.0, noise_v = 2e-5 }\n"
    "[twin.truth.SN1]",
)


def test_cr_s_sting_and_model_packages_are_calibrated_in_one_run(tmp_path: Path) -> None:
    """CR: pitch and yaw carry the sting package, roll the model's as well; each comes back in its own terms."""
    made = bench(tmp_path, (YAW, STING, STING_TRUTH), (GIMBAL, solve_table('model = "pitch-yaw-roll"')))
    made.run(tmp_path / "run")
    found = solve_sensors(dwells_of(tmp_path / "run"), made.rig, made.plan, "run")
    said = {name: entry.calibration.model for name, entry in found.items() if entry.calibration}
    assert said == {"SN1": "pitch-yaw-roll-model", "STING": "pitch-yaw-roll-sting"}
    truths = {
        "SN1": {"x": (0.005, 2.5, 0.5, 35.0)},
        "STING": {"x": (0.011, 2.45, 0.6, 50.0), "y": (-0.007, 2.55, 0.4, -70.0)},
    }
    for name, axes in truths.items():
        calibration = found[name].calibration
        assert calibration is not None
        for axis, truth in axes.items():
            got = values(calibration.axes[axis])
            assert got["offset_v"][0] == pytest.approx(truth[0], abs=5e-5)
            assert got["sensitivity_v_per_g"][0] == pytest.approx(-truth[1], abs=1e-4)
            assert got["coning_deg"][0] == pytest.approx(truth[2], abs=4e-3)
            assert got["azimuth_deg"][0] == pytest.approx((truth[3] + 270.0) % 360.0 - 180.0, abs=0.6)


@pytest.mark.parametrize(
    ("rig", "solve", "sentence"),
    [
        (
            (YAW, STING, STING_TRUTH),
            'packages = { STING = "model" }',
            'is a "model" package here, but the rig file says that pitch, yaw',
        ),
        ((YAW, STING, STING_TRUTH), 'packages = { SN1 = "sting", STING = "sting" }', ""),
    ],
)
def test_a_package_that_is_not_what_its_stage_says_is_refused(
    tmp_path: Path, rig: tuple, solve: str, sentence: str
) -> None:
    changes = (GIMBAL, solve_table(f'model = "pitch-yaw-roll"\n{solve}'))
    if not sentence:
        assert bench(tmp_path, rig, changes).plan.sensors  # a stage that is not declared is the procedure's to say
        return
    with pytest.raises(PlanError, match=sentence):
        bench(tmp_path, rig, changes)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ((STING,), "needs a gimbal with the axes pitch, yaw and roll; the rig has no yaw"),
        ((YAW, (STING[0], STING[1].replace('"pitch", "yaw"', '"yaw"'))), r"got \['yaw'\], allowed are"),
    ],
)
def test_a_stage_that_is_none_is_refused(tmp_path: Path, changes: tuple, sentence: str) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        bench(tmp_path, changes, (solve_table('model = "pitch-roll"'),))


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


@pytest.mark.usefixtures("no_report")
def test_delivery_of_a_gimbal_run_leaves_a_set_with_its_yaw_range(tmp_path: Path) -> None:
    delivery = _delivered_gimbal(tmp_path)
    document = json.loads(delivery.sets["SN1"].read_text(encoding="utf-8"))
    assert document["validity"]["yaw_deg"] == [-30.0, 30.0]
    assert document["convention"]["name"] == "CR"
    rows = {row.name: row for row in delivery.view.sensors[0].axes[0].parameters}
    assert (rows["sensitivity_v_per_g"].truth, rows["azimuth_deg"].truth) == (-2.5, pytest.approx(125.0))


@pytest.mark.thorough
def test_delivery_of_a_gimbal_run_leaves_a_report(tmp_path: Path) -> None:
    assert _delivered_gimbal(tmp_path).report.exists()


def _delivered_gimbal(tmp_path: Path) -> Delivery:
    made = bench(tmp_path, (YAW,), (GIMBAL, solve_table('model = "pitch-yaw-roll"')))
    made.run(tmp_path / "run")
    return deliver(solve_run(tmp_path / "run"), None)


@pytest.mark.thorough
def test_straight_lines_of_accelerometers_leave_a_report_and_a_set(tmp_path: Path) -> None:
    made = bench(tmp_path, (), (solve_table('model = "linear"'),))
    made.run(tmp_path / "run")
    run = solve_run(tmp_path / "run")
    delivery = deliver(run, None)
    document = json.loads(delivery.sets["SN1"].read_text(encoding="utf-8"))
    assert (document["model"], document["convention"]["name"]) == ("linear-accelerometer", "SR")
    assert document["validity"]["level_z_g"] == pytest.approx([-1.0, 1.0], abs=0.01)
    assert "g/V" in delivery.report.read_text(encoding="utf-8")
    axis = sensors_document(run)["SN1"]["axes"]["z"]
    assert axis["remarks"][0].startswith("the level of the base is not declared")
    (level,) = (entry for entry in axis["findings"] if entry["kind"] == "level-undeclared")
    assert (level["significant"], level["text"]) == (False, axis["remarks"][0])


@pytest.mark.thorough
def test_a_time_term_of_a_run_takes_the_twins_drift_and_the_set_says_where_it_stands(tmp_path: Path) -> None:
    """The twin's offset moves by 40 µV a replication; the drift found is that over the hours of a replication."""
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
    delivery = deliver(run, None)
    assert delivery.view.verdict.trust == "sound", delivery.view.verdict.grounds
    page = delivery.report.read_text(encoding="utf-8")
    assert "time term: the run’s times count from" in page.replace("&#39;", "’")
    document = json.loads(delivery.sets["SN1"].read_text(encoding="utf-8"))
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


@pytest.mark.parametrize("model", ["pitch-yaw-roll", "linear"])
def test_what_to_expect_of_a_gimbal_is_what_its_solutions_state(tmp_path: Path, model: str) -> None:
    """The root mean square of what many solved campaigns state, each on a table of other teeth."""
    teeth = (
        "increment_deg = 1.0\nlimits_deg = [-180.0, 180.0]",
        'increment_deg = 1.0\nlimits_deg = [-180.0, 180.0]\nuncertainty_arcsec = 3.0\nindex_errors = "independent"',
    )
    made = bench(tmp_path, (YAW, teeth), (GIMBAL, solve_table(f'model = "{model}"')))
    procedure = read_procedure(tmp_path / "procedure.toml")
    (expected, *_) = forecast_of_design(made.rig, procedure, made.plan, ()).expected
    chance, points = np.random.default_rng(3), made.plan.design.points
    pitch, yaw, roll = (np.deg2rad([getattr(p, f"{name}_deg") for p in points]) for name in ("pitch", "yaw", "roll"))
    k = 2.5 * np.array(
        [np.cos(np.deg2rad(0.5)), *(np.sin(np.deg2rad(0.5)) * f(np.deg2rad(35.0)) for f in (np.cos, np.sin))]
    )
    count, squares = len(points), dict.fromkeys(expected.standard_uncertainty, 0.0)
    for _ in range(CAMPAIGNS):
        moved = [angle + errors_of_teeth(angle, chance) for angle in (pitch, roll)]
        clean = np.tile(0.005 + felt(moved[0], yaw, moved[1]) @ k, 2)
        output = clean + 2e-5 / np.sqrt(5) * chance.standard_normal(clean.size)
        rows = Observations(
            np.repeat([1, 2], count), np.tile(np.arange(count), 2), np.tile(pitch, 2), np.tile(roll, 2),
            {"x": output}, np.tile(yaw, 2),
        )  # fmt: skip
        request = request_of("SN1", made.rig, made.plan.sensors["SN1"], made.plan.solve, rows)
        solved = calibrate(rows, replace(request, nominal_axes={"x": "x"})).axes["x"]
        for name, (_, u) in values(solved).items():
            squares[name] += u**2 / CAMPAIGNS
    assert dict(expected.standard_uncertainty) == pytest.approx(
        {name: np.sqrt(square) for name, square in squares.items()}, rel=0.2
    )


def test_a_model_of_another_distribution_is_expected_as_it_is_solved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is not linear: what `check` says comes from its own Jacobian at its own solution."""
    install_example("own_model", tmp_path / "site", monkeypatch)
    single = (
        ('"three-axis package"', '"single-axis package"'),
        ('channels = { x = "dmm.x", y = "dmm.y", z = "dmm.z" }', 'channels = { x = "dmm.x" }'),
        (OTHER_AXES[0], ""),
        (OTHER_AXES[1], ""),
    )
    level = (
        ("roll_deg = { from = -180.0, to = 90.0, step = 90.0 }\n", ""),
        ("step = 30.0", "step = 5.0"),
        solve_table('model = "stiffening-clinometer"'),
    )
    made = bench(tmp_path, single, level)
    procedure = read_procedure(tmp_path / "procedure.toml")
    (expected,) = forecast_of_design(made.rig, procedure, made.plan, ()).expected
    chance, points = np.random.default_rng(4), made.plan.design.points
    pitch, count = np.deg2rad([point.pitch_deg for point in points]), len(points)
    coning, azimuth = np.deg2rad([0.5, 35.0])
    k = 2.5 * np.array([np.cos(coning), np.sin(coning) * np.cos(azimuth), np.sin(coning) * np.sin(azimuth)])
    clean = np.tile(felt(pitch, 0.0 * pitch, 0.0 * pitch) @ k, 2)
    squares = dict.fromkeys(expected.standard_uncertainty, 0.0)
    for _ in range(CAMPAIGNS):
        output = clean + 2e-5 / np.sqrt(5) * chance.standard_normal(clean.size)
        labels = np.repeat([1, 2], count), np.tile(np.arange(count), 2)
        rows = Observations(*labels, np.tile(pitch, 2), np.zeros(2 * count), {"x": output})
        request = request_of("SN1", made.rig, made.plan.sensors["SN1"], made.plan.solve, rows)
        for name, (_, u) in values(calibrate(rows, request).axes["x"]).items():
            squares[name] += u**2 / CAMPAIGNS
    stated = {name: np.sqrt(square) for name, square in squares.items()}
    assert dict(expected.standard_uncertainty) == pytest.approx(stated, rel=0.35)  # one degree of freedom each


def felt(pitch: np.ndarray, yaw: np.ndarray, roll: np.ndarray) -> np.ndarray:
    """(K, 3) by the passive rotations of the gimbal, written out."""
    x = np.sin(pitch) * np.cos(yaw)
    y, z = -np.sin(pitch) * np.sin(yaw), -np.cos(pitch)
    return np.stack([x, y * np.cos(roll) + z * np.sin(roll), -y * np.sin(roll) + z * np.cos(roll)], axis=-1)


def errors_of_teeth(angle: np.ndarray, chance: np.random.Generator) -> np.ndarray:
    """One error an index, rectangular within three arc seconds; a whole turn is the same index."""
    _, index = np.unique(np.round(np.mod(angle, 2.0 * np.pi), 6), return_inverse=True)
    return chance.uniform(-3.0, 3.0, index.max() + 1)[index] * np.pi / 180.0 / 3600.0


WHOLE_TABLE = ("speed_dps = 180.0", "speed_dps = 180.0\nuncertainty_arcsec = 1.0")
JOINT = solve_table("joint = true\njoint_priors_arcsec = { roll_zero = 20.0 }")


def test_package_and_table_are_solved_together_where_the_procedure_says_so(tmp_path: Path) -> None:
    """A set like any other comes of it: coefficients within their intervals, the roll zero in their uncertainty."""
    made = bench(tmp_path, (WHOLE_TABLE,), (JOINT,))
    forecast = forecast_of_design(made.rig, read_procedure(tmp_path / "procedure.toml"), made.plan, [])
    assert any("hold nothing of roll zero u 20″" in sentence for sentence in forecast.reservations)
    axes = solved_axes(made, tmp_path / "run")
    for axis, truth in {"x": (0.005, 2.5), "y": (-0.003, 2.48), "z": (0.008, 2.52)}.items():
        for name, value in zip(("offset_v", "sensitivity_v_per_g"), truth, strict=True):
            estimate = next(parameter for parameter in axes[axis].parameters if parameter.name == name)
            assert estimate.interval_95[0] < value < estimate.interval_95[1]
    across = axes["z"].primary_covariance[2, 2] ** 0.5
    assert across == pytest.approx(2.52 * 20.0 * np.pi / 648_000, rel=0.05), "no row tells roll zero from a turned z"
    run = solve_run(tmp_path / "run")
    made_set = sets_of(run)["SN1"]
    assert made_set.document["package"]["components"].keys() >= {"table", "replications"}
    assert "roll zero: not observable" in " ".join(run.sensors["SN1"].calibration.warnings)
    budget = run.sensors["SN1"].budgets["z"]
    assert any("roll zero u 20″" in line.stated for line in budget.lines)


NOT_JOINT = [
    ('joint = true\nmodel = "pitch-only"', "joint = true goes with model"),
    ('joint = true\ntemperature = "estimate"', "joint = true goes with model"),
    ('joint = true\nextended = "test"', "joint = true goes with model"),
    ("joint_priors_arcsec = { droop = 1.0 }", "belongs to joint = true"),
    ("joint = true\njoint_priors_arcsec = { wobble = 1.0 }", "pitch_zero"),
    ("temperature_order = 2", 'temperature_order = 2 belongs to temperature = "estimate"'),
    (
        "reference_temperature_degc = 25.0",
        'reference_temperature_degc belongs to temperature = "estimate", not to "none"',
    ),
    (
        'temperature = "apply"\n'
        '[solve.known_temperature."SN1.x"]\n'
        "offset_tc_v_per_degc = 1e-5\nsensitivity_tc_per_degc = 1e-5\nreference_temperature_degc = 20.0\n"
        '[solve.known_temperature."SN1.y"]\n'
        "offset_tc_v_per_degc = 1e-5\nsensitivity_tc_per_degc = 1e-5\nreference_temperature_degc = 25.0",
        "the axes of SN1 have reference_temperature_degc 20 and 25; the coefficients of one sensor hold at one",
    ),
]


@pytest.mark.parametrize(("text", "sentence"), NOT_JOINT)
def test_what_does_not_go_together_in_solve_is_refused_by_name(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(DescriptionError, match=r"procedure\.toml:") as refused:
        bench(tmp_path, procedure=(solve_table(text),))
    assert sentence in str(refused.value)


@pytest.mark.parametrize("reference_degc", [15.0, 25.0])
def test_what_is_estimated_holds_where_the_procedure_says(reference_degc: float) -> None:
    """Straight lines over temperature: the offset that is solved for is that of the truth at the reference."""
    chance = np.random.default_rng(5)
    roll_deg = np.tile(np.repeat(np.arange(-180.0, 180.0, 30.0), 5), 6)
    pitch_deg = np.tile([-30.0, -15.0, 0.0, 15.0, 30.0], 72)
    warm_degc = np.repeat([10.0, 20.0, 30.0, 30.0, 20.0, 10.0], 60)
    field_g = -np.sin(np.radians(pitch_deg))
    output_v = 0.004 + 3e-4 * (warm_degc - 20.0) + 2.5 * field_g + chance.normal(0.0, 2e-5, roll_deg.size)
    rows = Observations(
        np.repeat(np.arange(6), 60), np.tile(np.arange(60), 6), np.radians(pitch_deg), np.radians(roll_deg),
        {"x": output_v}, temperature_degc=warm_degc, time_s=np.arange(360.0) * 60.0,
    )  # fmt: skip
    solve = Solve(temperature="estimate", reference_temperature_degc=reference_degc, extended="no")
    axis = calibrate(rows, request_for("SN1", ["x"], solve, None)).axes["x"]
    (offset,) = [item for item in axis.parameters if item.name == "offset_v"]
    assert offset.value == pytest.approx(0.004 + 3e-4 * (reference_degc - 20.0), abs=4e-6)


def test_a_joint_fit_needs_pitch_and_roll(tmp_path: Path) -> None:
    one_axis = (RIG[RIG.index("[axes.roll]") : RIG.index("[readouts.dmm]")], "")
    no_roll = ("roll_deg = { from = -180.0, to = 90.0, step = 90.0 }", "roll_deg = [0.0]")
    with pytest.raises(PlanError, match="a joint fit needs the axes pitch and roll; the rig file has pitch"):
        bench(tmp_path, (one_axis,), (JOINT, no_roll))
