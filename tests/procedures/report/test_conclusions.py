from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import mixed
from report_scene import Scene, run_view
from scipy.stats import t
from solved_campaigns import columns_of, rows_of

from ams.calibration.calibrate import calibrate
from ams.calibration_result import ParameterEstimate
from ams.findings import EXPLAINED_BY
from ams.inputs.request import CalibrationRequest
from procedures.report.conclusions import axis_view, by_replication, mean_residuals, parameter_row
from procedures.report.filters import MOST_PARAMETERS, in_parts, truths_missed
from procedures.solution.budget_view import BudgetRow, BudgetView


def test_the_coverage_factor_is_students_at_the_stated_degrees_of_freedom() -> None:
    row = parameter_row(ParameterEstimate("offset_v", 1.0, 2e-6, 2e-6, 7.5, (0.0, 2.0)), 2.5, None)
    assert row.coverage_factor == pytest.approx(t.ppf(0.975, 7.5))
    assert row.expanded_uncertainty == pytest.approx(t.ppf(0.975, 7.5) * 2e-6)


def test_what_is_not_determined_stays_so() -> None:
    row = parameter_row(ParameterEstimate("azimuth_deg", None, None, None, None, None), 2.5, 35.0)
    assert (row.value, row.expanded_uncertainty, row.in_other_terms) == (None, None, "")
    assert row.holds_truth is None


def test_a_twin_s_truth_that_is_missed_by_more_than_chance_is_said() -> None:
    sensor = run_view(Scene(axes=("x",))).sensors[0]
    axis = sensor.axes[0]

    def said(away: float) -> str:
        row = parameter_row(ParameterEstimate("azimuth_deg", 179.9, 0.05, 0.05, 1e4, (179.8, 180.0)), 2.5, 179.9 + away)
        return truths_missed(replace(sensor, axes=(replace(axis, parameters=(row,)),)))

    assert [said(away) for away in (0.0, 0.15, -359.95)] == ["", "", ""], "inside, outside by chance, the same angle"
    assert said(0.5).startswith("1 of 1 95 % intervals misses the truth, the azimuth by 5.1 expanded uncertainties")


def test_azimuths_on_both_sides_of_180_degrees_are_close() -> None:
    replication = run_view(Scene()).sensors[0].axes[0].calibration.replication
    assert replication is not None
    turned = replace(replication, per_replication={1: {"azimuth_deg": 179.9}, 2: {"azimuth_deg": -179.9}})
    assert list(by_replication(turned, "azimuth_deg").values()) == pytest.approx([179.9, 180.1])


def test_mean_residuals_are_by_attitude() -> None:
    sensor = run_view(Scene(replications=4)).sensors[0]
    assert sensor.observations is not None
    pitch, roll, mean = mean_residuals(sensor.axes[0].calibration, sensor.observations)
    third = sensor.observations.point == 3
    assert mean[2] == pytest.approx(sensor.axes[0].calibration.residuals_v[third].mean(), abs=1e-15)
    assert pitch[2] == pytest.approx(float(np.rad2deg(sensor.observations.pitch_rad[third][0])))
    assert roll[2] == pytest.approx(float(np.rad2deg(sensor.observations.roll_rad[third][0])))


def test_lack_of_fit_says_where_and_drift_says_which_and_how_much() -> None:
    sensor = run_view(Scene(tooth_arcsec=3.0, offset_drift_v=4e-6, noise_arcsec=1e-4, axes=("x",))).sensors[0]
    assert sensor.observations is not None
    lack, offset, *others = sensor.axes[0].tests
    pitch, roll, mean = mean_residuals(sensor.axes[0].calibration, sensor.observations)
    worst = int(np.argmax(np.abs(mean)))
    assert f"most at pitch {pitch[worst]:.0f}°".replace("-", "−") in lack.conclusion
    assert f"roll {roll[worst]:.0f}°".replace("-", "−") in lack.conclusion
    assert offset.is_significant
    assert "changed between the replications by 8.0 µV or 0.66″" in offset.conclusion
    assert all("No change" in test.conclusion for test in others)


def test_residuals_that_repeat_within_the_table_have_one_chance_and_one_sentence() -> None:
    sensor = run_view(Scene(tooth_arcsec=1.0, table_explains=True)).sensors[0]
    for axis in sensor.axes:
        lack = axis.tests[0]
        stated = next(entry for entry in axis.calibration.findings if entry.details.get("test") == "lack of fit")
        assert (lack.p_value, lack.is_significant) == (stated.p_value, stated.is_significant)
        assert lack.t > lack.f_95
        assert "no more than the table’s index errors and what else is known explain" in lack.conclusion
    quiet = run_view(Scene()).sensors[0].axes[0].tests[0]
    assert quiet.conclusion == "No lack of fit found."


def test_a_change_that_something_else_explains_is_not_told_as_none() -> None:
    sensor = run_view(Scene(offset_drift_v=4e-6, noise_arcsec=1e-4, axes=("x",))).sensors[0]
    solved, rows = sensor.axes[0].calibration, sensor.observations
    assert rows is not None
    assert solved.replication is not None
    explained = tuple(
        replace(finding, is_significant=False, details={**finding.details, EXPLAINED_BY: "temperature"})
        if finding.details.get("test") == "drift of offset"
        else finding
        for finding in solved.findings
    )
    drift = {name: replace(test, is_significant=False) for name, test in solved.replication.drift.items()}
    decided = replace(solved, findings=explained, replication=replace(solved.replication, drift=drift))
    _, offset, sensitivity, *_ = axis_view("x", "dmm.x", decided, rows, {}).tests
    assert offset.conclusion == (
        "Offset changed between the replications by 8.0 µV or 0.66″: explained by temperature."
    )
    assert sensitivity.conclusion == "No change of sensitivity from replication to replication found."


def test_the_extended_model_is_reported_beside_the_model() -> None:
    # A soft mount of 30 µV/g² in xx, put into the outputs by its formula: fᵀQf with tr Q = 0.
    sensor = run_view(Scene(axes=("x",), pitch_deg=tuple(range(-90, 91, 30)))).sensors[0]
    rows = sensor.observations
    assert rows is not None
    down = np.cos(rows.pitch_rad) * np.cos(rows.roll_rad)
    bent = replace(rows, outputs={"x": rows.outputs["x"] + 30e-6 * (np.sin(rows.pitch_rad) ** 2 - down**2)})
    for observations, said in ((bent, "are significant"), (rows, "are not significant")):
        request = CalibrationRequest(nominal_axes={"x": "x"}, extended="test")
        solved = calibrate(observations, request).axes["x"]
        remarks = axis_view("x", "dmm.x", solved, observations, {}).remarks
        assert any(said in remark for remark in remarks)
    rows_of_q = [row for row in axis_view("x", "dmm.x", solved, rows, {}).parameters if row.unit == "V/g²"]
    assert rows_of_q == []


@pytest.mark.parametrize("count", [1, 6, 7, 8, 10, 14, 15])
def test_a_budget_is_told_in_tables_that_a_page_has_room_for(count: int) -> None:
    headings = tuple((f"parameter {index}", "V") for index in range(count))
    rows = tuple(BudgetRow(name, "A", 5.0, tuple(f"{name}{i}" for i in range(count)), "") for name in ("a", "b"))
    parts = list(in_parts(BudgetView(headings, rows)))
    assert max(len(part.headings) for part in parts) <= MOST_PARAMETERS
    assert [heading for part in parts for heading in part.headings] == list(headings)
    for index, row in enumerate(rows):
        assert [cell for part in parts for cell in part.rows[index].cells] == list(row.cells)
        assert {part.rows[index].source for part in parts} == {row.source}


def test_what_a_memory_leaves_is_not_said_to_be_contained_where_the_finding_says_it_is_not() -> None:
    drawn = mixed({"after-effect": 20.0, "drift-replications": 5.0}, np.random.default_rng(2), 1)
    outputs = {axis: columns_of(drawn, axis)[:, 0] for axis in drawn.setup.axes}
    rows = replace(rows_of(drawn), outputs=outputs)
    for axis, calibration in calibrate(rows, CalibrationRequest()).axes.items():
        told = " ".join(finding.text for finding in calibration.findings if finding.is_significant)
        rows_told = " ".join(row.conclusion for row in axis_view(axis, "", calibration, rows, {}).tests)
        assert "only if a limit of it is declared" in told
        assert "only if a limit of it is declared" in rows_told
        assert "is contained in the stated" not in told + rows_told
