"""As how many tests correlated tests count, against a bivariate normal distribution and against chance itself."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from ams.statistics.intervals import holm
from ams.statistics.tests_alike import counted, ring_together


@pytest.mark.parametrize("level", [0.05, 1e-3])
@pytest.mark.parametrize("rho", [0.0, 0.3, -0.8, 0.99])
def test_two_ring_together_as_often_as_the_bivariate_normal_has_it(rho: float, level: float) -> None:
    u = norm.isf(0.5 * level)
    same_side = 2.0 * multivariate_normal.cdf([-u, -u], cov=[[1.0, abs(rho)], [abs(rho), 1.0]], abseps=1e-12)
    assert ring_together(np.array([[rho]]), level)[0, 0] == pytest.approx(same_side, rel=1e-5)


def test_tests_that_know_nothing_of_each_other_count_each_and_the_same_one_counts_once() -> None:
    assert counted(np.eye(5), 1e-3) == pytest.approx(5.0, abs=0.01)
    assert counted(np.ones((5, 5)), 1e-3) == pytest.approx(1.0, abs=1e-9)
    pairs = np.kron(np.eye(3), np.ones((2, 2)))
    assert counted(pairs, 1e-3) == pytest.approx(3.0, abs=0.01)


def test_the_chance_of_any_stays_within_the_level_and_nearer_to_it_than_one_by_one() -> None:
    """Six variables, each of which follows the one before it with a correlation of 0.9."""
    correlation = 0.9 ** np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    drawn = np.random.default_rng(1).standard_normal((400_000, 6)) @ np.linalg.cholesky(correlation).T
    least = 2.0 * norm.sf(np.abs(drawn).max(axis=1))
    level, count = 0.05, counted(correlation, 0.05 / 6)
    assert (least <= level / 6).mean() < 0.7 * level
    assert 0.75 * level < (least <= level / count).mean() <= level


def test_holm_has_no_more_tests_than_they_count() -> None:
    p_values = np.array([0.014, 0.5, 0.6, 0.7])
    assert holm(p_values).tolist() == [False] * 4
    assert holm(p_values, count=3.5).tolist() == [True, False, False, False]
    assert holm(np.array([0.012, 0.02, 0.6, 0.7]), count=3.5).tolist() == [True, False, False, False]
