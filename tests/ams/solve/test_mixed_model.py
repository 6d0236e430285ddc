"""The mixed-model estimate against dense matrices."""

import numpy as np
from attitudes import attitude_from_degrees

from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from ams.solve.layout import layout_of
from ams.solve.linear_form import factor
from ams.solve.mixed_model import estimate
from ams.solve.whole_plots import whole_plots

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


def solve(form, layout, output, common):
    """Of one output; common errors by name, or none."""
    known = [common] if common else []
    return estimate(form, form, layout, output[:, None], known, whole_plots(layout, None, ()))


def test_estimate_is_generalised_least_squares_with_the_dense_covariance() -> None:
    form, layout, output, common = scene(3)
    found = solve(form, layout, output, {"table": common})
    same_point = np.equal.outer(layout.point, layout.point)
    dense = found.precision_variance[0] * np.eye(layout.rows) + found.lack_of_fit_variance[0] * same_point
    inverse = np.linalg.inv(dense + common @ common.T)
    expected = np.linalg.solve(form.basis.T @ inverse @ form.basis, form.basis.T @ inverse @ output)
    np.testing.assert_allclose(found.estimate[0], expected, rtol=1e-9)
    np.testing.assert_allclose(found.estimator[0] @ form.basis, np.eye(4), atol=1e-11)


def test_balanced_data_without_common_errors_give_the_mean_of_the_replications_and_their_spread() -> None:
    form, layout, output, _ = scene(4)
    found = solve(form, layout, output, {})
    alone = np.stack(
        [
            np.linalg.lstsq(form.basis[layout.replication == r], output[layout.replication == r], rcond=None)[0]
            for r in range(4)
        ]
    )
    np.testing.assert_allclose(found.estimate[0], alone.mean(axis=0), rtol=1e-11)
    between = next(part for part in found.components if part.name == "replications")
    np.testing.assert_allclose(between.covariance[0], np.cov(alone, rowvar=False) / 4, rtol=1e-8, atol=1e-15)
    assert between.dof[0] == 3


def test_lack_of_fit_beyond_common_errors_leaves_those_out() -> None:
    """Common errors alone make a lack of fit; told about them, the solver sees none beyond or little."""
    form, layout, output, common = scene(4)
    blind = solve(form, layout, output, {})
    found = solve(form, layout, output, {"table": common})
    assert blind.lack_of_fit_variance[0] > 1.0
    assert found.lack_of_fit_variance[0] < 0.5 * blind.lack_of_fit_variance[0]


def test_components_add_up_and_one_replication_has_residuals_only() -> None:
    form, layout, output, common = scene(1)
    found = solve(form, layout, output, {"table": common})
    assert [part.name for part in found.components] == ["residuals", "table"]
    np.testing.assert_array_equal(found.covariance, sum(part.covariance for part in found.components))
    assert found.sums is None


def test_a_column_solved_among_others_is_the_column_solved_alone() -> None:
    form, layout, output, common = scene(4)
    others = np.stack([output, 3.0 * output[::-1], output + 1.0], axis=1)
    knowns = [{"table": scale * common} for scale in (1.0, 0.5, 2.0)]
    for known in ([], knowns):
        together = estimate(form, form, layout, others, known, whole_plots(layout, None, ()))
        for column in range(3):
            alone = solve(form, layout, others[:, column], known[column] if known else {})
            np.testing.assert_allclose(together.estimate[column], alone.estimate[0], rtol=1e-10)
            np.testing.assert_allclose(together.covariance[column], alone.covariance[0], rtol=1e-8, atol=1e-18)
            np.testing.assert_allclose(together.precision_variance[column], alone.precision_variance[0])
