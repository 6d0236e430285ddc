"""Budgets against the GUM's own examples (JCGM 100:2008, annex H) and supplement 1 (JCGM 101:2008)."""

import numpy as np
import pytest

from ams.errors import SolveError
from ams.models.linear import fit_line
from ams.statistics.budget import Input, combine, type_a, type_b
from ams.statistics.monte_carlo import confirm, propagate


def end_gauge_nm(x):
    """GUM H.1: l = l_S + d − l_S (δα·θ + α_S·δθ), lengths in nm."""
    standard, d_mean, d_random, d_systematic, alpha, theta, d_alpha, d_theta = x
    return standard + d_mean + d_random + d_systematic - standard * (d_alpha * theta + alpha * d_theta)


END_GAUGE = [
    Input("l_S", 50_000_623.0, 25.0, 18),
    Input("d", 215.0, 5.8, 24, origin="A"),
    Input("d_1", 0.0, 3.9, 5),
    Input("d_2", 0.0, 6.7, 8),
    type_b("alpha_S", 11.5e-6, 2e-6, "limit"),
    Input("theta", -0.1, 0.41),
    type_b("d_alpha", 0.0, 1e-6, "limit", degrees_of_freedom=50),
    type_b("d_theta", 0.0, 0.05, "limit", degrees_of_freedom=2),
]


def test_gum_h1_the_end_gauge():
    budget = combine(end_gauge_nm, END_GAUGE)
    assert budget.values[0] == pytest.approx(50_000_838.0, abs=0.5)
    assert round(budget.standard_uncertainties[0]) == 32
    assert budget.degrees_of_freedom[0] == pytest.approx(16.7, abs=0.3)  # GUM rounds u to 32 before the fourth power
    assert budget.expanded(0.99)[0] == pytest.approx(93.0, abs=1.0)
    printed = {"l_S": 25.0, "d_alpha": 2.9, "d_theta": 16.6, "alpha_S": 0.0, "theta": 0.0}
    for name, nm in printed.items():
        index = [i.name for i in budget.inputs].index(name)
        assert budget.contributions[0, index] == pytest.approx(nm, abs=0.06)


def test_gum_h1_and_a_budget_of_correlated_inputs_are_those_of_gtc():
    """GTC propagates through every arithmetic step by itself, with degrees of freedom and correlations."""
    import GTC

    inputs = [GTC.ureal(i.value, i.standard_uncertainty, i.degrees_of_freedom) for i in END_GAUGE]
    theirs, ours = end_gauge_nm(inputs), combine(end_gauge_nm, END_GAUGE)
    assert ours.values[0] == pytest.approx(theirs.x, rel=1e-14)
    assert ours.standard_uncertainties[0] == pytest.approx(theirs.u, rel=1e-9)
    assert ours.degrees_of_freedom[0] == pytest.approx(theirs.df, rel=1e-7)
    for index, given in enumerate(inputs):
        assert ours.contributions[0, index] == pytest.approx(abs(GTC.component(theirs, given)), rel=1e-7, abs=1e-9)
    v, i, phi = GTC.multiple_ureal(
        [H2_V.mean(), H2_I.mean(), H2_PHI.mean()], [column.std(ddof=1) / 5**0.5 for column in (H2_V, H2_I, H2_PHI)], 4
    )
    for given, other, columns in ((v, i, (H2_V, H2_I)), (v, phi, (H2_V, H2_PHI)), (i, phi, (H2_I, H2_PHI))):
        GTC.set_correlation(np.corrcoef(*columns)[0, 1], given, other)
    results = [v / i * GTC.cos(phi), v / i * GTC.sin(phi), v / i]
    budget = h2_budget()
    np.testing.assert_allclose(budget.values, [result.x for result in results], rtol=1e-14)
    np.testing.assert_allclose(budget.standard_uncertainties, [result.u for result in results], rtol=1e-8)
    r = budget.correlation()
    for row, column in ((0, 1), (0, 2), (1, 2)):
        assert r[row, column] == pytest.approx(GTC.get_correlation(results[row], results[column]), abs=1e-8)


# GUM table H.2: V in V, I in mA, φ in rad, five simultaneous readings.
H2_V = np.array([5.007, 4.994, 5.005, 4.990, 4.999])
H2_I = np.array([19.663, 19.639, 19.640, 19.685, 19.678]) * 1e-3
H2_PHI = np.array([1.0456, 1.0438, 1.0468, 1.0428, 1.0433])


def impedance(x):
    v, i, phi = x
    return np.stack([v / i * np.cos(phi), v / i * np.sin(phi), v / i])


def h2_budget():
    inputs = [type_a("V", H2_V), type_a("I", H2_I), type_a("phi", H2_PHI)]
    r = np.corrcoef([H2_V, H2_I, H2_PHI])
    return combine(impedance, inputs, {("V", "I"): r[0, 1], ("V", "phi"): r[0, 2], ("I", "phi"): r[1, 2]})


def test_gum_h2_three_results_with_their_correlations():
    budget = h2_budget()
    np.testing.assert_allclose(budget.values, [127.732, 219.847, 254.260], atol=5.1e-4)
    # the GUM prints 0.295 for X where its own data give 0.29558
    np.testing.assert_allclose(budget.standard_uncertainties, [0.071, 0.295, 0.236], atol=6e-4)
    r = budget.correlation()
    assert r[0, 1] == pytest.approx(-0.588, abs=6e-4)
    assert r[0, 2] == pytest.approx(-0.485, abs=6e-4)
    assert r[1, 2] == pytest.approx(0.993, abs=6e-4)


# GUM table H.6: thermometer readings and corrections, °C.
H3_T = np.array([21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511])
H3_B = -np.array([0.171, 0.169, 0.166, 0.159, 0.164, 0.165, 0.156, 0.157, 0.159, 0.161, 0.160])


def test_gum_h3_the_calibration_line_of_a_thermometer():
    fit = fit_line(H3_T - 20.0, H3_B)
    u = np.sqrt(np.diag(fit.covariance))
    assert fit.line.offset == pytest.approx(-0.1712, abs=5e-5)
    assert fit.line.gain == pytest.approx(0.00218, abs=5e-6)
    assert u[1] == pytest.approx(0.0029, abs=5e-5)
    assert u[0] == pytest.approx(0.00067, abs=5e-6)
    assert fit.covariance[0, 1] / (u[0] * u[1]) == pytest.approx(-0.930, abs=5e-4)
    assert fit.standard_error == pytest.approx(0.0035, abs=5e-5)
    assert fit.line(np.array([10.0]))[0] == pytest.approx(-0.1494, abs=5e-5)
    assert fit.standard_uncertainty(np.array([10.0]))[0] == pytest.approx(0.0041, abs=5e-5)
    assert fit.degrees_of_freedom == 9


def test_gum_h3_the_correction_by_a_budget_of_correlated_inputs():
    fit = fit_line(H3_T - 20.0, H3_B)
    u = np.sqrt(np.diag(fit.covariance))
    inputs = [Input("y_1", fit.line.offset, u[1]), Input("y_2", fit.line.gain, u[0])]
    correlation = {("y_1", "y_2"): float(fit.covariance[0, 1] / (u[0] * u[1]))}
    budget = combine(lambda x: x[0] + 10.0 * x[1], inputs, correlation)
    assert budget.standard_uncertainties[0] == pytest.approx(0.0041, abs=5e-5)


@pytest.mark.parametrize(("kind", "half_width"), [("standard", 3.92), ("limit", 3.88)])
def test_supplement_1_the_sum_of_four(kind, half_width):
    # JCGM 101 9.2.2 and 9.2.3, tables 3 and 4: ±3.92 for normal inputs, ±3.88 for rectangular ones.
    inputs = [Input(f"X{n}", 0.0, 1.0, kind=kind) for n in range(4)]
    found = propagate(lambda x: x.sum(axis=0), inputs, np.random.default_rng(1), trials=1_000_000)
    np.testing.assert_allclose(found.symmetric_interval[0], [-half_width, half_width], atol=0.012)
    assert found.standard_uncertainty[0] == pytest.approx(2.0, abs=0.005)
    agreement = confirm(combine(lambda x: x.sum(axis=0), inputs), found)
    assert agreement.is_confirmed


def test_supplement_1_says_where_first_order_fails():
    # JCGM 101 9.4: δY = X1² + X2² about zero has no first-order uncertainty; near zero the budget is not confirmed.
    inputs = [Input("X1", 0.01, 0.005), Input("X2", 0.0, 0.005)]
    budget = combine(lambda x: x[0] ** 2 + x[1] ** 2, inputs)
    found = propagate(lambda x: x[0] ** 2 + x[1] ** 2, inputs, np.random.default_rng(2))
    assert found.mean[0] == pytest.approx(150e-6, rel=0.01)  # 0.01² + 2·0.005², table 8
    assert found.standard_uncertainty[0] == pytest.approx(112e-6, rel=0.02)
    assert not confirm(budget, found).is_confirmed


def test_shortest_interval_of_a_skewed_result_is_shorter_than_equal_tails():
    inputs = [Input("X", 0.0, 1.0)]
    found = propagate(lambda x: np.exp(x), inputs, np.random.default_rng(3))
    shortest, symmetric = np.diff(found.interval[0])[0], np.diff(found.symmetric_interval[0])[0]
    assert shortest < 0.85 * symmetric


def test_correlated_draws_have_the_correlation_that_was_asked_for():
    inputs = [Input("a", 1.0, 2.0), Input("b", -1.0, 0.5)]
    found = propagate(lambda x: x, inputs, np.random.default_rng(4), correlations={("a", "b"): -0.8})
    assert found.covariance[0, 1] / np.prod(found.standard_uncertainty) == pytest.approx(-0.8, abs=0.005)
    np.testing.assert_allclose(found.standard_uncertainty, [2.0, 0.5], rtol=0.01)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("limit", 1 / 3**0.5), ("triangular", 1 / 6**0.5), ("arcsine", 1 / 2**0.5), ("expanded", 0.5), ("standard", 1.0)],
)
def test_a_certificates_statement_becomes_a_standard_uncertainty(kind, expected):
    made = type_b("x", 0.0, 1.0, kind)
    assert made.standard_uncertainty == pytest.approx(expected)
    found = propagate(lambda x: x[0], [made], np.random.default_rng(5))
    assert found.standard_uncertainty[0] == pytest.approx(expected, rel=0.01)


def test_one_arc_second_as_a_limit_is_0_58():
    assert type_b("tooth", 0.0, 1.0, "limit").standard_uncertainty == pytest.approx(0.577, abs=5e-4)


@pytest.mark.parametrize(
    ("correlations", "words"),
    [
        ({("a", "b"): 1.5}, "allowed −1 to 1"),
        ({("a", "z"): 0.5}, "different inputs of a, b, c"),
        ({("a", "b"): 0.9, ("b", "c"): 0.9, ("a", "c"): -0.9}, "contradict each other"),
    ],
)
def test_impossible_correlations_are_refused(correlations, words):
    with pytest.raises(SolveError, match=words):
        combine(lambda x: x.sum(), [Input(n, 0.0, 1.0) for n in "abc"], correlations)


def test_a_trial_without_a_value_is_refused():
    with pytest.raises(SolveError, match="gave no finite result"), np.errstate(invalid="ignore"):
        propagate(lambda x: np.arcsin(x[0]), [Input("x", 1.0, 0.1)], np.random.default_rng(6))


def test_correlated_rectangular_inputs_are_refused_in_the_trials():
    inputs = [type_b("a", 0.0, 1.0, "limit"), Input("b", 0.0, 1.0)]
    with pytest.raises(SolveError, match="a: correlated inputs must be normal"):
        propagate(lambda x: x.sum(axis=0), inputs, np.random.default_rng(7), correlations={("a", "b"): 0.3})


def test_one_reading_has_no_scatter():
    with pytest.raises(SolveError, match="take two or more"):
        type_a("x", [1.0])
