"""Errors of one row alone are variance of that row: estimates, scatter and tests are those of the whole covariance."""

from collections.abc import Mapping

import numpy as np
import pytest

from ams.analysis.diagnostics.point_means import PointMeans, gram_of
from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty, index_columns
from ams.models.accelerometer import PitchRoll
from ams.solve.linear_form import factor
from ams.solve.lone_errors import column_by_row, lone_apart
from ams.solve.mixed_model import weighted_estimator
from ams.solve.scatter import expected_scatter, points_scatter
from ams.units import RAD_PER_ARCSEC

_RNG = np.random.default_rng(4)
_GRID = np.repeat(np.linspace(-1.2, 1.2, 7), 6), np.tile(np.linspace(-2.9, 2.9, 6), 7)
_OTHERS = _RNG.uniform(-1.2, 1.2, 30), _RNG.uniform(-3.0, 3.0, 30)
_DESIGNS: Mapping[str, tuple[FloatArray, FloatArray]] = {
    "a grid": _GRID,
    "angles of their own": _OTHERS,
    "a grid and others": (np.append(_GRID[0], _OTHERS[0]), np.append(_GRID[1], _OTHERS[1])),
    "a pitch of its own at each of some rolls": (_RNG.permutation(np.linspace(-1.2, 1.2, 42)), _GRID[1]),
}
_ZEROED = {"pitch": IndexErrors(zero_rad=0.01, zero_standard_uncertainty_rad=RAD_PER_ARCSEC)}
_TABLES = {
    "of unknown shape": TableUncertainty(RAD_PER_ARCSEC, 2.0 * RAD_PER_ARCSEC, "limit"),
    "zeroed": TableUncertainty(RAD_PER_ARCSEC, RAD_PER_ARCSEC, "limit", errors=_ZEROED),
    "independent": TableUncertainty(
        RAD_PER_ARCSEC, RAD_PER_ARCSEC, "limit", errors=dict.fromkeys(("pitch", "roll"), IndexErrors("independent"))
    ),
}


@pytest.mark.parametrize("certificate", _TABLES)
@pytest.mark.parametrize("design", _DESIGNS)
def test_what_is_found_is_that_of_the_whole_covariance(design: str, certificate: str) -> None:
    pitch, roll = _DESIGNS[design]
    stood = Attitude(pitch, roll)
    basis, points = PitchRoll("x").basis(stood), pitch.size
    truth = np.array([[0.01, 2.5, 0.02, -0.01], [0.0, -0.03, 2.4, 0.02]])
    common = np.stack([_columns(stood, _TABLES[certificate], each) for each in truth])
    outputs = basis @ truth.T + 2e-5 * _RNG.standard_normal((points, 2))
    weights = _RNG.integers(1, 4, points).astype(float)
    known = common @ common.swapaxes(1, 2)
    variances, others = lone_apart(common)
    for index in range(2):
        whole = np.diag(variances[index]) + others[index] @ others[index].T
        np.testing.assert_allclose(whole, known[index], atol=1e-12 * np.abs(known).max())
    assert column_by_row(common).shape[2] <= points + others.shape[2]

    scatter = points_scatter(basis, outputs, common, weights, 0.0)
    own = 4e-10 / weights
    form = factor(basis, PitchRoll("x").primary_names, stood)
    estimator = weighted_estimator(form, [own, own], list(common))
    for index, variance in enumerate(scatter.variance):
        assert variance > 0.0
        inverse = np.linalg.inv(np.diag(variance / weights) + known[index])
        beside = inverse - inverse @ basis @ np.linalg.solve(basis.T @ inverse @ basis, basis.T @ inverse)
        left = beside @ outputs[:, index]
        # Where the restricted likelihood is largest, its slope by the variance is zero.
        assert left @ (left / weights) == pytest.approx(np.trace(beside / weights), rel=1e-7)
        inverse = np.linalg.inv(np.diag(own) + known[index])
        expected = np.linalg.solve(basis.T @ inverse @ basis, basis.T @ inverse)
        np.testing.assert_allclose(estimator[index], expected, atol=1e-9 * np.abs(expected).max())
        joined = np.column_stack([basis, outputs[:, index]])
        gram = gram_of(PointMeans(basis, outputs[:, index], weights, common[index], 0.0), joined, 4e-10)
        np.testing.assert_allclose(gram, joined.T @ inverse @ joined, rtol=1e-9, atol=1e-9 * np.abs(gram).max())


def _columns(stood: Attitude, table: TableUncertainty, primary: FloatArray) -> FloatArray:
    """(K, q) volts, with a tilt that all rows share, which is no error of an index."""
    slopes = dict(PitchRoll("x").angle_jacobian(primary, stood))
    of_indices = index_columns(table, {"pitch": stood.pitch_rad, "roll": stood.roll_rad}, slopes)
    return np.column_stack([of_indices, 1e-6 * np.cos(stood.roll_rad)])


@pytest.mark.parametrize("shape", [(5, 0), (3, 5, 0), (5, 2), (3, 5, 2), (2, 3, 5, 4)])
def test_columns_of_any_number_of_outputs_and_none_at_all_keep_their_covariance(shape: tuple[int, ...]) -> None:
    """A package without a declared table has no column: its solution ended in a ValueError."""
    common = _RNG.standard_normal(shape)
    common[..., 1:, : shape[-1] // 2] = 0.0
    variances, others = lone_apart(common)
    whole, known = column_by_row(common), common @ np.swapaxes(common, -1, -2)
    np.testing.assert_allclose(whole @ np.swapaxes(whole, -1, -2), known, atol=1e-12)
    in_rows = variances[..., None] * np.eye(shape[-2])
    np.testing.assert_allclose(in_rows + others @ np.swapaxes(others, -1, -2), known, atol=1e-12)


def test_errors_that_reach_nothing_are_none() -> None:
    """Such as steps of a reading that are drowned in its noise: every column of them is zero."""
    pitch, roll = _GRID
    basis = PitchRoll("x").basis(Attitude(pitch, roll))
    outputs, weights = _RNG.standard_normal((pitch.size, 2)), np.ones(pitch.size)
    nothing = np.zeros((2, pitch.size, 3))
    for found, wanted in (
        (points_scatter(basis, outputs, each, weights), points_scatter(basis, outputs, nothing[..., :0], weights))
        for each in (nothing, nothing[..., :1])
    ):
        np.testing.assert_array_equal(found.variance, wanted.variance)
        np.testing.assert_array_equal(found.dof, wanted.dof)
    planned = expected_scatter(basis, np.ones(2), nothing, weights)
    np.testing.assert_array_equal(planned.variance, np.ones(2))
