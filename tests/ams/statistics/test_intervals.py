import numpy as np
import pytest

from ams.calibration_result import VarianceComponent
from ams.statistics.distributions import f_quantile
from ams.statistics.intervals import (
    combined_dof,
    confidence_halfwidth,
    f_test,
    holm,
    prediction_halfwidth,
    t_quantile,
    tabled_t_quantile,
)


@pytest.mark.parametrize(
    ("dof", "table"), [(1, 12.706), (2, 4.303), (5, 2.571), (10, 2.228), (30, 2.042), (np.inf, 1.960)]
)
def test_student_quantiles_are_those_of_the_tables(dof: float, table: float) -> None:
    """GUM table G.2, 95 %."""
    assert float(t_quantile(0.95, dof)) == pytest.approx(table, abs=6e-4)


@pytest.mark.parametrize("level", [0.95, 0.999])
def test_the_table_of_student_quantiles_is_the_quantile(level: float) -> None:
    dof = np.array([0.5, 1.0, 1.7, 3.0, 4.5, 11.0, 60.3, 1e4, 1e9, np.inf])
    np.testing.assert_allclose(tabled_t_quantile(level, dof), t_quantile(level, dof), rtol=1e-6)
    assert np.isnan(tabled_t_quantile(level, np.array([np.nan]))).all()


def test_f_limit_is_that_of_tp_table_2() -> None:
    assert f_quantile(0.95, 5, 477 * 6) == pytest.approx(2.22, abs=0.005)


def test_no_degrees_of_freedom_give_no_quantile() -> None:
    assert np.isnan(t_quantile(0.95, float("nan")))


def test_welch_satterthwaite_reproduces_the_example_of_the_gum() -> None:
    """GUM G.4.1, example: components 0.25, 0.57, 0.82 % with 9, 4, 14 degrees of freedom give 19.0."""
    found = combined_dof(np.array([[0.25**2], [0.57**2], [0.82**2]]), np.array([9.0, 4.0, 14.0]))
    assert found[0] == pytest.approx(19.0, abs=0.05)


def test_few_degrees_of_freedom_are_combined_by_cochran_and_cox() -> None:
    """Equal variances with 1 and infinitely many: factor (12.706 + 1.960)/2 = 7.333, of Student's t with 1.27 …"""
    dof = combined_dof(np.array([[1.0], [1.0]]), np.array([1.0, np.inf]))
    assert float(t_quantile(0.95, dof)[0]) == pytest.approx(7.333, abs=2e-3)


@pytest.mark.parametrize("dof", [(1.0, 40.0), (2.0, 40.0), (2.0, 2.0), (2.0, np.inf)])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_intervals_hold_the_truth_where_a_part_is_known_from_two_or_three_replications(
    dof: tuple[float, float], share: float
) -> None:
    """Chance alone; Welch and Satterthwaite's would hold 0.92 to 0.95 of two degrees of freedom."""
    chance, draws = np.random.default_rng(3), 40_000
    true = np.array([share, 1.0 - share])
    known = [np.ones(draws) if np.isinf(nu) else chance.chisquare(nu, draws) / nu for nu in dof]
    variances = true[:, None] * known
    half = t_quantile(0.95, combined_dof(variances, np.array(dof))) * np.sqrt(variances.sum(axis=0))
    assert np.mean(np.abs(chance.normal(size=draws)) <= half) > 0.947


def test_a_certificate_alone_has_infinite_degrees_of_freedom_and_no_variance_has_none() -> None:
    found = combined_dof(np.array([[1.0, 0.0]]), np.array([np.inf]))
    assert np.isinf(found[0])
    assert np.isnan(found[1])


def test_holm_stops_at_the_first_test_that_is_not_significant() -> None:
    """Levels 0.05/4, 0.05/3, …: 0.010 ≤ 0.0125 passes, 0.020 > 0.0167 stops, and 0.022 falls with it."""
    assert holm(np.array([0.020, 0.010, 0.022, 0.9])).tolist() == [False, True, False, False]
    assert holm(np.array([0.020, np.nan, 0.010])).tolist() == [True, False, True]


def test_holm_loosens_the_level_with_every_test_that_passed() -> None:
    """0.005 ≤ 0.0125, 0.015 ≤ 0.0167, 0.020 ≤ 0.025, 0.040 ≤ 0.05: all, where Bonferroni's 0.0125 passes one."""
    assert holm(np.array([0.020, 0.015, 0.040, 0.005])).tolist() == [True, True, True, True]
    assert holm(np.array([[0.060, 0.015], [0.010, 0.040]])).tolist() == [[False, True], [True, True]]


def test_an_f_test_at_its_limit_has_the_probability_of_its_level() -> None:
    test = f_test(float(f_quantile(0.95, 5, 60)), 5, 60)
    assert test.p_value == pytest.approx(0.05, abs=1e-9)
    assert not test.is_significant


def test_prediction_adds_the_variance_of_the_reading() -> None:
    """TP (73) in the limit of many degrees of freedom: root of the sum of squares times 1.960."""
    component = VarianceComponent("replications", np.diag([9.0, 0.0]), 1e9)
    at = np.array([[1.0, 0.0]])
    assert confidence_halfwidth(at, [component])[0] == pytest.approx(1.95996 * 3.0, rel=1e-5)
    assert prediction_halfwidth(at, [component], 4.0, np.inf)[0] == pytest.approx(1.95996 * 5.0, rel=1e-5)


@pytest.mark.parametrize("dof", [1.0, 2.0, 3.0, 5.0])
def test_a_new_reading_is_never_told_better_than_its_mean(dof: float) -> None:
    """One degree of freedom and a reading as noisy as the calibration: 12.7 against (12.7 + 1.96)/√2 = 10.4."""
    component, at = VarianceComponent("replications", np.eye(1), dof), np.eye(1)
    confidence = confidence_halfwidth(at, [component])
    predictions = [prediction_halfwidth(at, [component], sd, np.inf) for sd in (0.01, 0.3, 1.0, 3.0, 10.0, 100.0)]
    assert np.all(np.diff([confidence, *predictions], axis=0) >= 0.0)
    assert predictions[-1] == pytest.approx(196.0, rel=0.01)


def test_predictions_of_a_small_calibration_cover() -> None:
    rng = np.random.default_rng(1)
    basis, covered = np.stack([np.ones(8), np.linspace(-1, 1, 8)], axis=1), 0
    inverse, at = np.linalg.inv(basis.T @ basis), np.array([[1.0, 0.7]])
    for _ in range(4000):
        y = rng.standard_normal(8)
        estimate = inverse @ basis.T @ y
        variance = float(np.sum((y - basis @ estimate) ** 2) / 6)
        component = VarianceComponent("residuals", variance * inverse, 6.0)
        half = prediction_halfwidth(at, [component], np.sqrt(variance), 6.0)[0]
        covered += abs(rng.standard_normal() - at[0] @ estimate) < half
    assert covered / 4000 == pytest.approx(0.95, abs=0.015)


def test_of_no_tests_none_is_significant() -> None:
    assert holm(np.zeros((3, 0))).shape == (3, 0)
