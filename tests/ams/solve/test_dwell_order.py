"""The order of time of rows: one for all that were measured in it, whenever that was."""

import numpy as np

from ams.solve.dwell_order import rows_in_time


def test_packages_with_times_of_their_own_and_one_order_have_the_same_order() -> None:
    """By identity: what depends on the order alone is worked out for the first of them."""
    chance, turns = np.random.default_rng(1), np.random.default_rng(2).permutation(500)
    first, second = (np.sort(chance.uniform(0.0, 9e3, 500))[turns] for _ in range(2))
    assert rows_in_time(first, 500) is rows_in_time(second, 500)
    np.testing.assert_array_equal(rows_in_time(first, 500), np.argsort(first))
    other = first.copy()
    other[[3, 4]] = other[[4, 3]]
    assert rows_in_time(other, 500) is not rows_in_time(first, 500)
    np.testing.assert_array_equal(rows_in_time(other, 500), np.argsort(other))
