"""The grid's residuals against least squares with dummies for every point and every replication."""

import numpy as np
import pytest

from ams.analysis.diagnostics.residuals import grid_residuals
from ams.analysis.diagnostics.time_order import _moments, autocorrelation
from ams.analysis.diagnostics.wrong_dwells import convict, largest_p_values

N, K, P = 3, 9, 3


@pytest.fixture
def basis() -> np.ndarray:
    return np.random.default_rng(1).standard_normal((K, P))


def _maker(basis: np.ndarray, dwells: np.ndarray) -> np.ndarray:
    """1 − the projector on effects of points and parameters of replications, of the dwells that are there."""
    columns = np.zeros((N * K, K + N * P))
    for dwell in range(N * K):
        replication, point = divmod(dwell, K)
        columns[dwell, point] = 1.0
        columns[dwell, K + replication * P : K + (replication + 1) * P] = basis[point]
    seen = columns[dwells]
    return np.eye(len(dwells)) - seen @ np.linalg.pinv(seen, rcond=1e-10)


@pytest.mark.parametrize(
    "missing", [(), (4,), (4, 13, 20), (5, 14), (5, 14, 23), tuple(range(22, 27)), (0, *range(21, 27))]
)
def test_residuals_and_leverages_are_those_of_dummies_whatever_is_missing(basis, missing) -> None:
    dwells = np.setdiff1d(np.arange(N * K), missing)
    outputs = np.random.default_rng(2).standard_normal((dwells.size, 2))
    found, maker = grid_residuals(basis, outputs, dwells, N, K), _maker(basis, dwells)
    assert found.residuals[dwells] == pytest.approx(maker @ outputs, abs=1e-12)
    assert found.leverages[dwells] == pytest.approx(np.diag(maker), abs=1e-12)
    assert found.dof == pytest.approx(np.trace(maker))
    assert found.column(int(dwells[3]))[dwells] == pytest.approx(maker[:, 3], abs=1e-12)


def test_taking_a_dwell_out_is_as_if_it_had_never_been_there(basis) -> None:
    outputs = np.random.default_rng(3).standard_normal((N * K, 1))
    every, without = np.arange(N * K), np.setdiff1d(np.arange(N * K), (7, 22))
    later = grid_residuals(basis, outputs, every, N, K).without(7).without(22)
    never = grid_residuals(basis, outputs[without], without, N, K)
    assert later.residuals == pytest.approx(never.residuals, abs=1e-12)
    assert later.dof == never.dof


def test_one_dwell_is_convicted_and_none_of_its_neighbours(basis) -> None:
    outputs = np.random.default_rng(4).standard_normal((N * K, 1))
    outputs[11] += 1e4
    found = convict(grid_residuals(basis, outputs, np.arange(N * K), N, K), 0.003, outputs[:, 0], outputs[:, 0])
    assert found.dwells == (11,)
    assert found.sizes[0] == pytest.approx(1e4, abs=10.0)


def test_of_two_replications_the_one_that_leaves_the_model_is_convicted() -> None:
    chance, truth = np.random.default_rng(5), np.zeros(2 * 30)
    basis = chance.standard_normal((30, 2))
    outputs = truth + chance.standard_normal(60)
    outputs[44] += 100.0
    found = convict(grid_residuals(basis, outputs[:, None], np.arange(60), 2, 30), 0.003, outputs, outputs)
    assert found.dwells == (44,)


def test_the_largest_residual_is_convicted_as_often_as_its_p_value_says(basis) -> None:
    outputs = np.random.default_rng(6).standard_normal((N * K, 4000))
    p_values, _ = largest_p_values(grid_residuals(basis, outputs, np.arange(N * K), N, K))
    assert np.mean(p_values < 0.05) == pytest.approx(0.05, abs=0.012)


def test_moments_of_the_autocorrelation_are_traces_of_the_residual_maker(basis) -> None:
    order = np.stack([np.random.default_rng(7).permutation(K) for _ in range(N)])
    replication, here, following = np.repeat(np.arange(N), K - 1), order[:, :-1].ravel(), order[:, 1:].ravel()
    neighbours = np.zeros((N * K, N * K))
    neighbours[replication * K + here, replication * K + following] = 0.5
    neighbours += neighbours.T
    found = grid_residuals(basis, np.zeros((N * K, 1)), np.arange(N * K), N, K)
    ms = _maker(basis, np.arange(N * K)) @ neighbours
    assert _moments(found.replications, found.q, replication, here, following) == pytest.approx(
        (np.trace(ms), np.trace(ms @ ms))
    )


def test_independent_dwells_are_found_correlated_once_in_twenty_and_smooth_ones_always() -> None:
    chance, points = np.random.default_rng(8), 60
    basis = chance.standard_normal((points, 4))
    pairs = np.repeat(np.arange(N), points - 1), np.tile(np.arange(points - 1), N), np.tile(np.arange(1, points), N)
    white = chance.standard_normal((N * points, 2000))
    found = autocorrelation(grid_residuals(basis, white, np.arange(N * points), N, points), pairs)
    assert np.mean(found.p_value < 0.05) == pytest.approx(0.05, abs=0.015)
    smooth = white[:, :50] + np.roll(white[:, :50], 1, axis=0)
    found = autocorrelation(grid_residuals(basis, smooth, np.arange(N * points), N, points), pairs)
    assert np.mean(found.p_value < 1e-3) > 0.9


def test_the_chance_of_a_correlation_of_successive_dwells_is_that_of_small_samples() -> None:
    """At 0.1 % of 4 × 20 dwells that know nothing of each other; by a normal tail it would be a half of that."""
    chance, campaigns = np.random.default_rng(4), 40_000
    basis, dwells = np.column_stack([np.ones(20), chance.standard_normal((20, 3))]), np.arange(80)
    grid = grid_residuals(basis, chance.standard_normal((80, campaigns)), dwells, 4, 20)
    replication, point = np.divmod(dwells, 20)
    follows = point < 19
    pairs = (replication[follows], point[follows], point[follows] + 1)
    p_value = autocorrelation(grid, pairs).p_value
    for level in (0.01, 0.001):
        assert (p_value <= level).mean() == pytest.approx(level, abs=4.0 * np.sqrt(level / campaigns))
