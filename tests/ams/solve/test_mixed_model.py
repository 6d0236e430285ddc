"""The mixed-model estimate against dense matrices."""

import numpy as np

from ams.frames import attitude_from_degrees
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from ams.solve.layout import layout_of
from ams.solve.linear_form import factor
from ams.solve.mixed_model import estimate

MODEL = PitchRoll("y")


def scene(replications: int):
    rng = np.random.default_rng(4)
    pitch, roll = (a.ravel() for a in np.meshgrid(np.arange(-60.0, 61.0, 30.0), np.arange(-180.0, 180.0, 90.0)))
    points = pitch.size
    attitude = attitude_from_degrees(np.tile(pitch, replications), np.tile(roll, replications))
    replication, point = np.repeat(np.arange(replications), points), np.tile(np.arange(points), replications)
    layout = layout_of(Observations(replication, point, attitude.pitch_rad, attitude.roll_rad, {}))
    form = factor(MODEL.basis(attitude), MODEL.primary_names, attitude)
    common = np.tile(rng.standard_normal((points, 6)), (replications, 1))
    output = form.basis @ np.array([0.1, 0.2, -2.5, 0.3]) + common @ rng.standard_normal(6)
    return form, layout, output + 0.3 * rng.standard_normal(layout.rows), common


def test_estimate_is_generalised_least_squares_with_the_dense_covariance() -> None:
    form, layout, output, common = scene(3)
    found = estimate(form, form, layout, output, {"table": common})
    same_point = np.equal.outer(layout.point, layout.point)
    dense = found.precision_variance * np.eye(layout.rows) + found.lack_of_fit_variance * same_point
    inverse = np.linalg.inv(dense + common @ common.T)
    expected = np.linalg.solve(form.basis.T @ inverse @ form.basis, form.basis.T @ inverse @ output)
    np.testing.assert_allclose(found.estimate, expected, rtol=1e-9)
    np.testing.assert_allclose(found.estimator @ form.basis, np.eye(4), atol=1e-11)


def test_balanced_data_without_common_errors_give_the_mean_of_the_replications_and_their_spread() -> None:
    form, layout, output, _ = scene(4)
    found = estimate(form, form, layout, output, {})
    alone = np.stack(
        [
            np.linalg.lstsq(form.basis[layout.replication == r], output[layout.replication == r], rcond=None)[0]
            for r in range(4)
        ]
    )
    np.testing.assert_allclose(found.estimate, alone.mean(axis=0), rtol=1e-11)
    between = next(part for part in found.components if part.name == "replications")
    np.testing.assert_allclose(between.covariance, np.cov(alone, rowvar=False) / 4, rtol=1e-8, atol=1e-15)
    assert between.dof == 3


def test_lack_of_fit_beyond_common_errors_leaves_those_out() -> None:
    """Common errors alone make a lack of fit; told about them, the solver sees none beyond or little."""
    form, layout, output, common = scene(4)
    blind = estimate(form, form, layout, output, {})
    told = estimate(form, form, layout, output, {"table": common})
    assert blind.lack_of_fit_variance > 1.0
    assert told.lack_of_fit_variance < 0.5 * blind.lack_of_fit_variance


def test_components_add_up_and_one_replication_has_residuals_only() -> None:
    form, layout, output, common = scene(1)
    found = estimate(form, form, layout, output, {"table": common})
    assert [part.name for part in found.components] == ["residuals", "table"]
    np.testing.assert_array_equal(found.covariance, sum(part.covariance for part in found.components))
    assert found.sums is None
