"""Half-widths next to a bound: of the rows told 95 % hold wherever the attitude lies, by integrals of densities."""

import numpy as np
import pytest
from scipy.stats import norm

from ams.attitude.truncated_pivot import along_distance, factor_across, factor_along, factor_of_root

FULL = 1.959964
FROM_BOUND = np.arange(-2.5, 8.25, 0.25)
"""Of the true attitude, in standard deviations; a reading is told beyond 0."""


def held(true: np.ndarray, half: np.ndarray, reading: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return by trapezoids the share of (R,) readings told whose interval holds each of (T,) true values."""
    density = norm.pdf(error)
    return np.asarray((density * (np.abs(reading - true[:, None]) <= half)).sum(axis=1) / density.sum(axis=1))


def test_an_angle_that_is_the_distance_holds_95_percent_of_the_rows_told() -> None:
    beyond = np.linspace(1e-4, 16.0, 8001)
    share = held(FROM_BOUND, FULL * factor_along(beyond), beyond, beyond - FROM_BOUND[:, None])
    assert np.all(share > 0.948)
    assert np.all(share < 0.9755)
    np.testing.assert_allclose(share[FROM_BOUND <= 0.0], 0.95, atol=2e-3)
    np.testing.assert_allclose(share[FROM_BOUND >= 6.0], 0.95, atol=2e-3)
    plain = held(FROM_BOUND, FULL * np.ones(beyond.size), beyond, beyond - FROM_BOUND[:, None])
    assert plain[FROM_BOUND == -1.0] == pytest.approx(1.0 - norm.sf(FULL) / norm.sf(1.0), abs=0.002)


def test_an_angle_that_goes_with_the_root_holds_95_percent_of_the_rows_told() -> None:
    beyond, bound = np.linspace(1e-4, 16.0, 8001), 4.0
    square, true = bound + beyond, bound + FROM_BOUND
    half = FULL * factor_of_root(beyond) / np.sqrt(2.0 * square)
    share = held(np.sqrt(2.0 * true), half, np.sqrt(2.0 * square), beyond - FROM_BOUND[:, None])
    assert np.all(share > 0.942)
    assert np.all(share < 0.972)
    assert share[-1] == pytest.approx(0.95, abs=0.003)


@pytest.mark.parametrize("from_bound", [-2.0, -1.0, 0.0, 1.0, 3.0])
def test_an_angle_about_the_singular_attitude_holds_95_percent_of_the_rows_told(from_bound: float) -> None:
    bound = 11.46

    along, across = np.meshgrid(np.linspace(-from_bound - 1.0, 8.0, 1501), np.linspace(-6.0, 6.0, 801))
    x = bound + from_bound + along
    distance = np.hypot(x, across)
    weight = norm.pdf(along) * norm.pdf(across) * (distance > bound)
    half = FULL * factor_across(distance, distance - bound) / distance
    holding, all_told = (weight * (np.abs(np.arctan2(across, x)) <= half)).sum(), weight.sum()
    assert holding / all_told == pytest.approx(0.952, abs=0.004)


def test_a_row_before_the_bound_and_one_far_beyond_keep_their_own() -> None:
    far = np.array([-1.0, 30.0])
    np.testing.assert_allclose(factor_along(far), 1.0)
    np.testing.assert_allclose(factor_of_root(far), 1.0, atol=1e-6)
    np.testing.assert_allclose(factor_across(np.array([10.0, 40.0]), far), 1.0, atol=1e-6)


def test_an_error_that_has_no_part_of_the_distance_is_not_widened() -> None:
    covariance = np.array([[[4.0, 0.0, 1.2], [0.0, 1.0, 0.0], [1.2, 0.0, 9.0]]])
    sd, share = along_distance(covariance, np.array([[1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(sd, 2.0)
    np.testing.assert_allclose(share, [[1.0, 0.0, 0.2]])
    np.testing.assert_allclose(factor_along(np.array([[0.5]]), share)[0, 1], 1.0)
