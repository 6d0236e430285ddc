import numpy as np
import pytest

from ams.inputs.table_uncertainty import TableUncertainty, index_columns


def test_a_limit_is_rectangular_and_an_expanded_uncertainty_is_divided_by_its_factor() -> None:
    """A limit of 1″ is a standard uncertainty of 0.577″."""
    assert TableUncertainty(1.0, 2.0, "limit").standard_rad() == pytest.approx(
        {"pitch": 0.57735, "roll": 1.1547, "yaw": 0.0}, rel=1e-5
    )
    assert TableUncertainty(1.0, 1.5, "expanded", 3.0).standard_rad() == pytest.approx(
        {"pitch": 1 / 3, "roll": 0.5, "yaw": 0.0}
    )


def test_rows_of_one_index_share_one_error_and_half_turns_are_one_index() -> None:
    pitch, roll = np.deg2rad([0.0, 0.0, 10.0, 10.0]), np.deg2rad([-180.0, 90.0, 180.0, 90.0])
    slopes = {"pitch": np.array([1.0, 2.0, 3.0, 4.0]), "roll": np.array([5.0, 6.0, 7.0, 8.0])}
    columns = index_columns(TableUncertainty(0.1, 0.2), {"pitch": pitch, "roll": roll}, slopes)
    covariance = columns @ columns.T
    expected = 0.01 * np.outer(slopes["pitch"], slopes["pitch"]) * np.equal.outer([0, 0, 1, 1], [0, 0, 1, 1])
    expected = expected + 0.04 * np.outer(slopes["roll"], slopes["roll"]) * np.equal.outer([0, 1, 0, 1], [0, 1, 0, 1])
    np.testing.assert_allclose(covariance, expected, rtol=1e-12)


def test_an_axis_without_uncertainty_has_no_columns() -> None:
    angle = {"pitch": np.zeros(3), "roll": np.zeros(3)}
    assert index_columns(TableUncertainty(0.0, 0.0), angle, angle).shape == (3, 0)
