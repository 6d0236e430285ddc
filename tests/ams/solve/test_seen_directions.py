"""What a model leaves of errors is seen by its share of them, in whatever unit they are counted."""

import numpy as np
import pytest

from ams.solve.seen_directions import seen_directions


def left_of(patterns: np.ndarray, taken: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the products of what columns leave of patterns, and the squares of the patterns."""
    q, _ = np.linalg.qr(taken)
    left = patterns - q @ (q.T @ patterns)
    return left.T @ left, (patterns**2).sum(axis=0)


@pytest.mark.parametrize(("apart", "seen"), [(0.0, 0), (1e-5, 0), (0.05, 0), (0.2, 1), (1.0, 1)])
def test_a_pattern_is_seen_where_more_than_a_hundredth_of_its_square_is_left(apart: float, seen: int) -> None:
    absorbed, beside = np.eye(6)[:, :2].T
    information, whole = left_of((absorbed + apart * beside)[:, None], absorbed[:, None])
    assert seen_directions(information, whole).shape == (1, seen)


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e6])
def test_the_unit_of_an_error_makes_it_neither_seen_nor_absorbed(unit: float) -> None:
    patterns = np.random.default_rng(1).standard_normal((20, 4)) * np.array([1.0, unit, 1.0, unit])
    patterns[:, 3] = unit * patterns[:, 0]  # two errors that do the same are one
    information, whole = left_of(patterns, np.ones((20, 1)))
    directions = seen_directions(information, whole)
    assert directions.shape == (4, 3)
    assert directions.T @ information @ directions == pytest.approx(np.eye(3), abs=1e-9)


def test_an_error_that_does_nothing_is_not_seen() -> None:
    assert seen_directions(np.diag([0.0, 1.0]), np.array([0.0, 1.0])).shape == (2, 1)
