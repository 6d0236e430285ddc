"""Package and table solved together from the rows of one run: what a joint fit says like every other calibration."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from simulated_campaign import ARCSEC, OFFSET_V, VECTOR_V_PER_G, Campaign
from simulated_columns import teeth_within

from ams.calibration.calibrate import calibrate
from ams.calibration.jointly import calibrate_jointly
from ams.errors import DesignError
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.models.extended import CUBIC_NAME
from ams.models.thermal import TemperatureCoefficients
from ams.sets.verdict_conditions import TERMS_NOT_DETERMINED
from ams.solve.joint import joint_fit
from ams.solve.table_errors import Mounting, TablePriors
from ams.statistics.intervals import t_quantile

PRIORS = TablePriors(table=teeth_within(1.0))
AXES = {axis: axis for axis in "xyz"}
PLAIN = CalibrationRequest(nominal_axes=AXES, extended="no")
ROWS = Campaign(index_limit_arcsec=1.0, replications=4).observe(np.random.default_rng(3))


@pytest.mark.parametrize("has_terms", [True, False])
def test_it_is_the_joint_fit_with_residuals_of_every_row_and_replication_tests(has_terms: bool) -> None:
    solved = calibrate_jointly(ROWS, replace(PLAIN, extended="yes" if has_terms else "no"), PRIORS)
    fit = joint_fit([Mounting(ROWS)], "xyz", PRIORS, has_terms=has_terms)
    for axis, solved_axis in solved.axes.items():
        np.testing.assert_array_equal(solved_axis.primary, fit.primary[axis])
        np.testing.assert_allclose(solved_axis.primary_covariance, fit.axis_covariance(axis), rtol=1e-12)
        np.testing.assert_allclose(solved_axis.fitted_v + solved_axis.residuals_v, ROWS.outputs[axis], rtol=1e-12)
        scatter = solved_axis.residuals_v.std() / np.linalg.norm(solved_axis.primary[1:]) / ARCSEC
        assert scatter < 2.0, "less than the noise of a dwell and the teeth that were not told"
        assert solved_axis.replication is not None
        assert solved_axis.replication.replications == 4
        assert {"offset", "sensitivity"} <= solved_axis.replication.drift.keys()
        assert (CUBIC_NAME in solved_axis.primary_names, bool(solved_axis.centring)) == (has_terms, has_terms)
    np.testing.assert_allclose(solved.package.covariance, fit.covariance, rtol=1e-12)
    assert "solved together" in " ".join(solved.remarks)


@pytest.mark.parametrize("extended", ["yes", "no"])
@pytest.mark.parametrize("step_deg", [90.0, 30.0])
def test_terms_that_the_points_do_not_determine_are_told_as_by_any_fit(
    extended: Literal["yes", "no"], step_deg: float
) -> None:
    """Four rolls a quarter of a turn apart show no terms of second order, with and without asking for them."""
    rows = Campaign(roll_deg=np.arange(-180.0, 180.0, step_deg), replications=3).observe(np.random.default_rng(4))
    request = replace(PLAIN, extended=extended)
    together, apart = calibrate_jointly(rows, request, PRIORS), calibrate(rows, request)
    for axis in AXES:
        is_told = [
            any(said.startswith(TERMS_NOT_DETERMINED) for said in fit.axes[axis].remarks) for fit in (together, apart)
        ]
        assert is_told == [step_deg == 90.0] * 2


def test_a_meter_that_is_wrong_is_added_as_a_whole_and_is_the_same_for_all_axes_behind_it() -> None:
    """GUM F.1.2: gain g on every output moves b and k by g of themselves, a zero moves b alone; both axes alike."""
    gain, zero = SharedError("meter gain", "gain", 1e-5), SharedError("meter zero", "reading", 2e-6)
    own = SharedError("resistor", "gain", 3e-5, is_of_one_channel=True)
    shared = {"x": (gain, zero, own), "y": (gain, own), "z": ()}
    before = calibrate_jointly(ROWS, PLAIN, PRIORS)
    after = calibrate_jointly(ROWS, replace(PLAIN, shared_errors=shared), PRIORS)
    added = after.package.covariance - before.package.covariance
    x, y = before.axes["x"].primary, before.axes["y"].primary
    first = np.array([1.0, 0.0, 0.0, 0.0])
    expected = (1e-10 + 9e-10) * np.outer(x, x) + 4e-12 * np.outer(first, first)
    np.testing.assert_allclose(added[:4, :4], expected, rtol=1e-6, atol=1e-22)
    np.testing.assert_allclose(added[:4, 4:8], 1e-10 * np.outer(x, y), rtol=1e-6, atol=1e-22)
    np.testing.assert_allclose(added[8:], 0.0, atol=1e-22)
    np.testing.assert_array_equal(after.axes["z"].primary, before.axes["z"].primary)


def test_a_level_that_was_read_is_an_error_of_the_table_and_what_is_declared_goes_before_it() -> None:
    level = SharedError("level of the base about pitch", "pitch", 4.0 * ARCSEC)
    request = replace(PLAIN, shared_errors=dict.fromkeys("xyz", (level,)))
    read, declared = (calibrate_jointly(ROWS, request, p) for p in (PRIORS, replace(PRIORS, pitch_zero_rad=9 * ARCSEC)))
    said = [" ".join(entry.remarks) for entry in (read, declared)]
    assert "pitch zero" in said[0]
    assert "prior 4″" in said[0]
    assert "prior 9″" in said[1]


def test_two_replications_that_drift_are_covered_by_the_intervals_that_are_stated() -> None:
    """±1.96 u holds 0.72 to 0.77 here; the intervals rest on one degree of freedom and say so. Scatter of 0.95: 1 %."""
    held, campaign = [], Campaign(
        index_limit_arcsec=1.0, replications=2, offset_drift_arcsec=3.0, sensitivity_drift=2e-5,
        pitch_deg=(-60.0, -30.0, 0.0, 30.0, 60.0), roll_deg=(-180.0, -120.0, -60.0, 0.0, 60.0, 120.0),
    )  # fmt: skip
    for seed in range(60):
        solved = calibrate_jointly(campaign.observe(np.random.default_rng(seed)), PLAIN, PRIORS)
        for axis, solved_axis in solved.axes.items():
            u = np.sqrt(np.diag(solved_axis.primary_covariance))
            off = np.abs(solved_axis.primary - [OFFSET_V[axis], *VECTOR_V_PER_G[axis]])
            held.append(off <= t_quantile(0.95, solved_axis.primary_dof) * u)
    assert np.mean(held) >= 0.92
    assert any("on 1 degree of freedom between" in sentence for sentence in solved.warnings)


REFUSED = [
    (replace(PLAIN, model="pitch-only"), 'model = "pitch-only"'),
    (replace(PLAIN, temperature="estimate"), 'temperature = "estimate"'),
    (
        replace(PLAIN, temperature="apply", known_temperature={"x": TemperatureCoefficients(0.0, 0.0)}),
        'temperature = "apply"',
    ),
    (replace(PLAIN, extended="test"), 'extended = "test"'),
    (replace(PLAIN, time_term=True), 'time_term = "linear"'),
]


@pytest.mark.parametrize(("request_", "what"), REFUSED, ids=[what for _, what in REFUSED])
def test_what_the_joint_fit_has_not_is_refused_in_words(request_: CalibrationRequest, what: str) -> None:
    with pytest.raises(DesignError, match=f"joint fit: got {what}.*nothing was solved; solve without joint"):
        calibrate_jointly(ROWS, request_, PRIORS)


def test_a_package_that_was_moved_is_refused_in_words() -> None:
    moved = replace(ROWS, mounting=1 + (np.arange(ROWS.rows) > ROWS.rows // 2))
    with pytest.raises(DesignError, match="got 2 mountings, allowed is one"):
        calibrate_jointly(moved, PLAIN, PRIORS)
