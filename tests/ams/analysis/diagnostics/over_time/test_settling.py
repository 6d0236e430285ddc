"""Estimates of one coefficient, joined."""

import numpy as np
import pytest

from ams.analysis.diagnostics.over_time.settling import UNKNOWN, Estimate, joined


def test_joined_estimates_are_the_weighted_least_squares_of_their_common_value() -> None:
    sizes, uncertainties = np.array([3.0, 1.0, 2.5]), np.array([0.5, 0.2, 1.0])
    found = joined(map(Estimate, sizes.tolist(), uncertainties.tolist(), [30.0] * 3))
    column, left = 1.0 / uncertainties[:, None], sizes / uncertainties
    assert found.size == pytest.approx(np.linalg.lstsq(column, left, rcond=None)[0][0])
    assert found.uncertainty == pytest.approx(np.linalg.inv(column.T @ column)[0, 0] ** 0.5)


def test_joined_estimates_have_the_interval_of_their_freedom() -> None:
    """Two estimates, one from eight degrees of freedom, hold the truth in 95 of 100 intervals (Welch)."""
    chance, held = np.random.default_rng(1), []
    for _ in range(2000):
        scatters = [np.sqrt(chance.chisquare(dof) / dof) for dof in (8.0, 60.0)]
        sizes = chance.normal(0.0, 1.0, 2)
        held.append(joined(map(Estimate, sizes, scatters, (8.0, 60.0))).p_value > 0.05)
    assert np.mean(held) == pytest.approx(0.95, abs=0.02)


def test_what_is_not_known_adds_nothing() -> None:
    known = Estimate(1.0, 0.1, 10.0)
    assert joined([UNKNOWN, known]) == known
    assert np.isnan(joined([UNKNOWN]).p_value)
