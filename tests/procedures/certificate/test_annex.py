"""The annex of a certificate: budget and correlations, by arithmetic done here on the covariance that a set states."""

import numpy as np
import pytest
from line_sets import line_set
from simulated_campaign import Campaign
from solved import provenance
from solved_sets import gyro_set

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.sets.coefficients import CoefficientSet, build_set
from procedures.certificate.annex import annex_of

METER = SharedError("multimeter gain", "gain", 4e-6, "limit")
MICRO = 1e6


@pytest.fixture(scope="module", params=["no", "yes"])
def solved(request: pytest.FixtureRequest) -> Calibration:
    rows = Campaign(replications=4).observe(np.random.default_rng(3))
    errors = dict.fromkeys("xyz", (METER,))
    return calibrate(rows, CalibrationRequest(shared_errors=errors, extended=request.param))


def _cells(coefficients: CoefficientSet, axis: str) -> dict[str, list[str]]:
    (annex,) = (part for part in annex_of(coefficients) if part.axis == axis)
    return {row.source: list(row.cells) for row in annex.budget.rows}


def test_the_lines_of_the_budget_are_the_parts_of_the_covariance(solved: Calibration) -> None:
    """u(b) of a part is the root of its variance; u(S) by S = |k|, whose gradient is k/S."""
    coefficients = build_set(solved, provenance())
    for axis, found in solved.axes.items():
        cells, k = _cells(coefficients, axis), found.primary[1:4]
        part = next(part.covariance for part in found.variance_components if part.name == METER.name)
        u_b, u_s = np.sqrt(part[0, 0]), np.sqrt(k @ part[1:4, 1:4] @ k) / np.linalg.norm(k)
        assert float(cells[METER.name][1]) == pytest.approx(MICRO * u_s, rel=0.06)
        if cells[METER.name][0] != "·":
            assert float(cells[METER.name][0]) == pytest.approx(MICRO * u_b, rel=0.06)
        whole = found.primary_covariance
        u_s = np.sqrt(k @ whole[1:4, 1:4] @ k) / np.linalg.norm(k)
        assert float(cells["combined"][1]) == pytest.approx(MICRO * u_s, rel=0.06)
        stated = next(item for item in found.parameters if item.name == "sensitivity_v_per_g")
        assert stated.interval_95 is not None
        half = 0.5 * (stated.interval_95[1] - stated.interval_95[0])
        assert float(cells["expanded (95 %)"][1]) == pytest.approx(MICRO * half, rel=0.06)


def test_correlations_are_those_of_the_stated_covariance(solved: Calibration) -> None:
    coefficients = build_set(solved, provenance())
    for annex in annex_of(coefficients):
        axis = solved.axes[annex.axis]
        u = np.sqrt(np.diag(axis.covariance))
        expected = axis.covariance / np.outer(u, u)
        told = dict(annex.correlations.rows)
        assert float(told["S"][0].replace("−", "-")) == pytest.approx(expected[1, 0], abs=0.006)
        assert float(told["A"][2].replace("−", "-")) == pytest.approx(expected[3, 2], abs=0.006)
        assert [len(cells) for _, cells in annex.correlations.rows] == list(range(1, len(axis.parameters)))


@pytest.mark.parametrize("coefficients", [gyro_set(), line_set({"x": (0.032, -0.4)})], ids=["gyro", "line"])
def test_sets_of_other_sensors_have_an_annex_too(coefficients: CoefficientSet) -> None:
    for annex in annex_of(coefficients):
        assert annex.budget.headings
        assert any(row.source == "combined" for row in annex.budget.rows)
