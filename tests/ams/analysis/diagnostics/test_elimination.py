"""Columns that are tested beside others which are not independent of each other: few points have no room for all."""

import numpy as np
import pytest

from ams.analysis.diagnostics.point_means import PointMeans, eliminate


@pytest.mark.parametrize("has_common_errors", [False, True])
def test_a_column_beside_which_is_in_the_span_of_the_others_takes_nothing(has_common_errors: bool) -> None:
    """A grid with four rolls a quarter of a turn apart is such a design: it ended in a singular matrix."""
    chance = np.random.default_rng(4)
    points = 20
    basis, columns = chance.standard_normal((points, 4)), chance.standard_normal((points, 2))
    doubled = basis @ [1.0, -2.0, 0.5, 0.0] + 3.0 * columns[:, 1]
    common = chance.standard_normal((points, 3)) if has_common_errors else np.zeros((points, 0))
    means = PointMeans(basis, chance.standard_normal(points), np.ones(points), common, 0.1)
    found = eliminate(means, np.column_stack([columns, doubled]), columns)
    expected = found.test(0, beside=(1,))
    assert found.test(0, beside=(1, 2)).p_value == pytest.approx(expected.p_value, rel=1e-6)
    assert found.test(0, beside=(2, 1)).coefficient == pytest.approx(expected.coefficient, rel=1e-6)
    assert found.correlation(beside=(1, 2))[1, 2] == 0.0
    assert np.isnan(found.test(2, beside=(1,)).p_value)
