"""The points' own variance beside large common errors, by simulation and by dense likelihood."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from ams.solve import scatter
from ams.solve.scatter import FEW_POINTS, points_scatter

RNG = np.random.default_rng(21)
BASIS = np.column_stack([np.ones(40), np.linspace(-1, 1, 40)])
COMMON = RNG.standard_normal((40, 7))
WEIGHTS = RNG.uniform(0.5, 2.0, 40)


def draw(rng: np.random.Generator, own: float, common: float) -> np.ndarray:
    own_errors = own * rng.standard_normal(40) / np.sqrt(WEIGHTS)
    return BASIS @ np.array([1.0, -3.0]) + common * COMMON @ rng.standard_normal(7) + own_errors


def restricted_log_likelihood(variance: float, output: np.ndarray) -> float:
    """By dense matrices: −½ (log |V| + log |XᵀV⁻¹X| + rᵀV⁻¹r)."""
    dense = np.diag(variance / WEIGHTS) + COMMON @ COMMON.T
    inverse = np.linalg.inv(dense)
    moments = BASIS.T @ inverse @ BASIS
    residuals = output - BASIS @ np.linalg.solve(moments, BASIS.T @ inverse @ output)
    return -0.5 * float(np.linalg.slogdet(dense)[1] + np.linalg.slogdet(moments)[1] + residuals @ inverse @ residuals)


def test_the_answer_is_where_the_restricted_likelihood_is_largest() -> None:
    output = draw(np.random.default_rng(1), 0.3, 1.0)
    found = points_scatter(BASIS, output[:, None], COMMON[None], WEIGHTS).variance[0]
    best = minimize_scalar(lambda t: -restricted_log_likelihood(t, output), (0.01, 0.1), tol=1e-12).x
    assert found == pytest.approx(best, rel=1e-5)


def slope_of_likelihood(variance: float, output: np.ndarray, common: np.ndarray) -> float:
    """By dense matrices: yᵀ P W⁻¹ P y − tr P W⁻¹ with P = V⁻¹ − V⁻¹ X (Xᵀ V⁻¹ X)⁻¹ Xᵀ V⁻¹."""
    inverse = np.linalg.inv(np.diag(variance / WEIGHTS) + common @ common.T)
    projector = inverse - inverse @ BASIS @ np.linalg.solve(BASIS.T @ inverse @ BASIS, BASIS.T @ inverse)
    left = projector @ output
    return float(left @ (left / WEIGHTS) - np.trace(projector / WEIGHTS))


def test_many_at_once_are_each_where_the_likelihood_has_no_slope() -> None:
    own, sizes = (0.01, 0.3, 0.3, 2.0, 5.0), (1.0, 0.001, 3.0, 1.0, 100.0)
    outputs = [draw(np.random.default_rng(seed), *both) for seed, both in enumerate(zip(own, sizes, strict=True))]
    common = np.stack([size * COMMON for size in sizes])
    found = points_scatter(BASIS, np.stack(outputs, axis=1), common, WEIGHTS).variance
    for output, columns, variance in zip(outputs, common, found, strict=True):
        flat = brentq(slope_of_likelihood, 0.5 * variance, 2.0 * variance, (output, columns), xtol=1e-14 * variance)
        assert variance == pytest.approx(flat, rel=1e-9)


def test_a_root_that_is_reached_is_not_searched_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton's steps double the digits, so that few are needed; halving an interval takes thirty to as many digits."""
    looks: list[float] = []
    slope = scatter._slope

    def looked(variance: np.ndarray, *others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        looks.append(float(variance[0]))
        return slope(variance, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(scatter, "_slope", looked)
    most = 0
    for seed in range(100):
        looks.clear()
        points_scatter(BASIS, draw(np.random.default_rng(seed), 0.3, 1.0)[:, None], COMMON[None], WEIGHTS)
        most = max(most, len(looks))
    assert most <= 12


@pytest.mark.parametrize("common", [0.3, 1.0, 30.0])
def test_variance_and_its_degrees_of_freedom_are_right_however_large_the_common_errors(common: float) -> None:
    outputs = np.stack([draw(np.random.default_rng(seed), 0.3, common) for seed in range(1500)], axis=1)
    found = points_scatter(BASIS, outputs, np.broadcast_to(common * COMMON, (1500, 40, 7)), WEIGHTS)
    variances, dof = found.variance, float(found.dof.mean())
    assert variances.mean() == pytest.approx(0.09, rel=0.03)
    assert 2.0 * variances.mean() ** 2 / variances.var() == pytest.approx(dof, rel=0.15)


def test_directions_that_common_errors_share_count_in_part() -> None:
    """25 of 38 directions with t + 1 instead of t = 1: Fisher's information makes it 25/4 + 13, not 25/2 + 13."""
    rng, campaigns = np.random.default_rng(5), 4000
    common = np.linalg.qr(np.column_stack([BASIS, rng.standard_normal((40, 25))]))[0][:, 2:]
    outputs = rng.standard_normal((40, campaigns)) + common @ rng.standard_normal((25, campaigns))
    found = points_scatter(BASIS, outputs, np.broadcast_to(common, (campaigns, 40, 25)), np.ones(40))
    assert found.variance.mean() == pytest.approx(1.0, abs=0.03)
    assert 2.0 * found.variance.mean() ** 2 / found.variance.var() == pytest.approx(25.0 / 4.0 + 13.0, rel=0.1)
    assert float(np.median(found.dof)) == pytest.approx(25.0 / 4.0 + 13.0, rel=0.05)


def test_without_common_errors_it_is_the_mean_square_of_the_residuals() -> None:
    output = draw(np.random.default_rng(1), 0.3, 0.0)
    root = np.sqrt(WEIGHTS)
    square = np.linalg.lstsq(root[:, None] * BASIS, root * output, rcond=None)[1][0]
    found = points_scatter(BASIS, output[:, None], np.zeros((1, 40, 0)), WEIGHTS)
    assert found.variance[0] == pytest.approx(square / 38)
    assert found.dof[0] == 38


def test_nothing_left_over_says_so() -> None:
    assert np.isnan(points_scatter(BASIS[:2], np.ones((2, 1)), COMMON[None, :2], WEIGHTS[:2]).variance[0])
    nothing = np.stack([np.zeros(40), draw(np.random.default_rng(1), 0.3, 1.0)], axis=1)
    found = points_scatter(BASIS, nothing, np.stack([COMMON, COMMON]), WEIGHTS)
    assert (found.variance[0], found.dof[0]) == (0.0, 38.0)
    assert found.variance[1] > 0.0


def test_few_points_that_common_errors_drown_count_the_whole_scatter() -> None:
    """Five points, each with a common error of its own: nothing tells the two apart."""
    basis, output = BASIS[:5], np.array([1.0, -2.0, 0.5, 0.2, -1.0])
    found = points_scatter(basis, output[:, None], 3.0 * np.eye(5)[None], np.ones(5))
    square = np.linalg.lstsq(basis, output, rcond=None)[1][0]
    assert (found.variance[0], found.dof[0]) == (pytest.approx(square / 3.0), 3.0)


def test_degrees_of_freedom_never_fall_below_one() -> None:
    rng = np.random.default_rng(4)
    found = points_scatter(
        BASIS, rng.standard_normal((40, 50)), np.tile(30.0 * np.eye(40), (50, 1, 1)), WEIGHTS, FEW_POINTS
    )
    assert found.dof.min() == 1.0
    assert found.variance.min() == 0.0
