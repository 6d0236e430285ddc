"""A dwell is held against what scatters as it does: explicit removal and simulated noise are the outside answers."""

import numpy as np
import pytest

from ams.analysis.diagnostics.residuals import GridResiduals, grid_residuals
from ams.calibration.together.dwell_scatter import chances_of_even_scatter, scatter_of_all, scatter_of_replications
from ams.statistics.distributions import f_tail

POINTS, PARAMETERS = 40, 4
LOUD = np.array([1.0, 1.0, 4.0, 1.0])
"""Times the noise of each replication."""


def drawn(chance: np.random.Generator, times: np.ndarray, outputs: int = 1) -> GridResiduals:
    basis = np.column_stack([np.ones(POINTS), chance.standard_normal((POINTS, PARAMETERS - 1))])
    noise = times[:, None, None] * chance.standard_normal((times.size, POINTS, outputs))
    dwells = np.arange(times.size * POINTS)
    return grid_residuals(basis, noise.reshape(-1, outputs), dwells, times.size, POINTS)


@pytest.mark.parametrize("scatter_of", [scatter_of_all, scatter_of_replications])
def test_the_scatter_without_a_dwell_is_that_of_the_grid_it_is_taken_out_of(scatter_of) -> None:
    grid = drawn(np.random.default_rng(2), LOUD, outputs=3)
    for dwell in (0, 55, 2 * POINTS + 11, 4 * POINTS - 1):
        left = scatter_of(grid.without(dwell))
        neighbour = dwell + 1 if (dwell + 1) // POINTS == dwell // POINTS else dwell - 1
        assert scatter_of(grid).without[dwell] == pytest.approx(left.variance[neighbour], rel=1e-9)
        assert left.dof == pytest.approx(scatter_of(grid).dof - 1.0)


def test_a_dwell_of_a_loud_replication_is_no_further_off_than_chance_has_it() -> None:
    """Of all dwells beyond the 1 % bound of Fisher's F in the loud replication, 1 %; by the scatter of all, most."""
    chance, of_own, of_all = np.random.default_rng(4), [], []
    for _ in range(200):
        grid = drawn(chance, LOUD)
        loud = slice(2 * POINTS, 3 * POINTS)
        square = (grid.residuals[:, 0] ** 2 * grid.weights)[loud]
        for found, scatter in ((of_own, scatter_of_replications(grid)), (of_all, scatter_of_all(grid))):
            found.append(f_tail(square / scatter.without[loud, 0], 1.0, scatter.dof - 1.0) <= 0.01)
    assert np.mean(of_own) == pytest.approx(0.01, abs=0.004)
    assert np.mean(of_all) > 0.08


def test_even_replications_are_told_as_uneven_no_more_often_than_stated_and_loud_ones_always() -> None:
    chance = np.random.default_rng(5)
    even = np.concatenate([chances_of_even_scatter(drawn(chance, np.ones(4), outputs=300)) for _ in range(10)])
    assert 0.02 < np.mean(even <= 0.05) <= 0.06
    loud = np.concatenate([chances_of_even_scatter(drawn(chance, LOUD, outputs=30)) for _ in range(10)])
    assert loud.max() < 1e-3


def test_two_replications_say_nothing_of_which_is_loud() -> None:
    assert chances_of_even_scatter(drawn(np.random.default_rng(6), np.array([1.0, 9.0]))) == pytest.approx([1.0])
