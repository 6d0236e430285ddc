"""The lines of a budget as pages print them: sources, what they make together, and with which factor."""

import numpy as np
import pytest
from scipy.stats import t as student

from ams.analysis.calibration_budget import axis_budget
from ams.calibration.calibrate import calibrate
from ams.calibration.findings_document import budget_document
from ams.frames import euler_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.observations import Observations
from procedures.kinds.section import TextTable, _budgets
from procedures.solution.budget_view import budget_view

SUMS = ("combined", "effective degrees of freedom", "coverage factor k", "expanded (95 %)")


def gyro():  # type: ignore[no-untyped-def]
    chance = np.random.default_rng(4)
    velocity = np.tile(np.vstack([np.kron(np.eye(3), [[-40.0], [-10.0], [10.0], [40.0]]), np.zeros((1, 3))]), (4, 1))
    still = np.zeros(len(velocity))
    rows = Observations(
        np.repeat(np.arange(4), 13), np.tile(np.arange(13), 4), still, still,
        {"x": 0.05 + 1.25 * velocity[:, 0] + 1e-3 * chance.standard_normal(still.size)}, yaw_rad=still,
        euler_rate_rad_s=euler_rates_rad_s(np.zeros((still.size, 3)), np.deg2rad(velocity)),
    )  # fmt: skip
    errors = (SharedError("multimeter zero", "reading", 2e-4, "limit"),)
    request = CalibrationRequest(model="gyro", nominal_axes={"x": "x"}, shared_errors={"x": errors})
    solved = calibrate(rows, request).axes["x"]
    return solved, axis_budget(solved, errors)


def test_a_budget_adds_up_by_welch_and_satterthwaite_and_student() -> None:
    """GUM 5.1.2, G.4.1 and G.3.2, by the lines that stand in the document."""
    solved, budget = gyro()
    document = budget_document(budget)
    for name in ("offset_v", "sensitivity_v_per_dps"):
        parts = [(line["standard_uncertainty"][name], line["degrees_of_freedom"]) for line in document["lines"]]
        u = np.sqrt(sum(part**2 for part, _ in parts))
        dof = u**4 / sum(part**4 / freedom for part, freedom in parts if freedom is not None)
        assert document["combined_standard_uncertainty"][name] == pytest.approx(u, rel=1e-9)
        stated = document["effective_degrees_of_freedom"][name]
        assert 0.5 * dof <= stated <= 1.01 * dof  # never more generous than Welch and Satterthwaite
        factor = float(student.ppf(0.975, stated))
        assert document["coverage_factor_95"][name] == pytest.approx(factor, rel=1e-6)
        assert document["expanded_uncertainty_95"][name] == pytest.approx(factor * u, rel=1e-6)
        interval = next(item.interval_95 for item in solved.parameters if item.name == name)
        assert interval is not None
        assert document["expanded_uncertainty_95"][name] == pytest.approx(0.5 * (interval[1] - interval[0]), rel=1e-6)


def test_the_page_of_a_gyro_has_the_lines_that_the_page_of_an_accelerometer_has() -> None:
    _, budget = gyro()
    view = budget_view(budget)
    assert tuple(row.source for row in view.rows[-4:]) == SUMS
    (table,) = _budgets({"x": budget})
    assert table.headings[:4] == ("axis", "source", "type", "ν")
    assert [row[1] for row in table.rows] == [row.source for row in view.rows]
    assert [row[4:-1] for row in table.rows] == [row.cells for row in view.rows]
    assert [row[3] for row in table.rows[-4:]] == ["", "", "", ""]
    combined, expanded = ([float(cell) for cell in row.cells] for row in view.rows if row.source in (SUMS[0], SUMS[3]))
    (factors,) = ([float(cell) for cell in row.cells] for row in view.rows if row.source == SUMS[2])
    for u, k, whole in zip(combined, factors, expanded, strict=True):
        assert whole == pytest.approx(k * u, rel=0.06)  # two digits are printed


def test_columns_of_numbers_are_known_from_columns_of_words() -> None:
    table = TextTable("t", ("a", "b", "c", "d"), (("x", "-1.5", "∞", ""), ("logger.gx", "—", "2.1e-09", "")))
    assert table.are_numbers == (False, True, True, False)
    assert TextTable("t", ("a", "b"), ()).are_numbers == (False, False)
