"""Replicated sums against dense least squares with dummy variables, balanced and not."""

import numpy as np
import pytest
from attitudes import attitude_from_degrees

from ams.frames import Attitude
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from ams.solve.layout import Layout, layout_of
from ams.solve.linear_form import LinearForm, factor
from ams.solve.replicated import _unbalanced, replicated_sums

MODEL = PitchRoll("x")


def scene(replications: int, dropped: tuple[int, ...] = (), weighted: bool = False):
    rng = np.random.default_rng(8)
    pitch, roll = (a.ravel() for a in np.meshgrid(np.arange(-60.0, 61.0, 30.0), np.arange(-180.0, 180.0, 90.0)))
    points = pitch.size
    kept = np.setdiff1d(np.arange(replications * points), dropped)
    attitude = attitude_from_degrees(np.tile(pitch, replications)[kept], np.tile(roll, replications)[kept])
    labels = np.repeat(np.arange(1, replications + 1), points)[kept], np.tile(np.arange(points), replications)[kept]
    layout = layout_of(Observations(*labels, attitude.pitch_rad, attitude.roll_rad, {}))
    weights = rng.uniform(0.5, 2.0, kept.size) if weighted else None
    form = factor(MODEL.basis(attitude), MODEL.primary_names, attitude, weights)
    return form, layout, rng.standard_normal((kept.size, 2))


def dense_squares(form: LinearForm, layout: Layout, outputs: np.ndarray, with_points: bool) -> tuple[np.ndarray, int]:
    """Residual sum of squares and its degrees of freedom with a dummy variable for everything."""
    replication = np.eye(layout.replications)[layout.replication]
    columns = [(replication[:, :, None] * form.basis[:, None, :]).reshape(layout.rows, -1)]
    if with_points:
        columns.append(np.eye(layout.points)[layout.point])
    root = np.sqrt(np.ones(layout.rows) if form.weights is None else form.weights)[:, None]
    design = root * np.hstack(columns)
    estimate, _, rank, _ = np.linalg.lstsq(design, root * outputs, rcond=1e-10)
    return np.sum((root * outputs - design @ estimate) ** 2, axis=0), layout.rows - int(rank)


@pytest.mark.parametrize(
    ("dropped", "weighted"), [((), False), ((3, 17, 21, 44), False), ((), True), (tuple(range(72, 80)), True)]
)
def test_sums_of_squares_and_degrees_of_freedom_are_those_of_dummy_variables(dropped, weighted) -> None:
    form, layout, outputs = scene(4, dropped, weighted)
    sums = replicated_sums(form, layout, outputs)
    separate, dof_separate = dense_squares(form, layout, outputs, with_points=False)
    two_way, dof_two_way = dense_squares(form, layout, outputs, with_points=True)
    np.testing.assert_allclose(sums.ss_precision, two_way, rtol=1e-9)
    np.testing.assert_allclose(sums.ss_lack_of_fit, separate - two_way, rtol=1e-9)
    assert sums.dof_precision == dof_two_way
    assert sums.dof_lack_of_fit == dof_separate - dof_two_way


def test_closed_forms_and_projection_agree_on_complete_data() -> None:
    form, layout, outputs = scene(5)
    closed, projected = replicated_sums(form, layout, outputs), _unbalanced(form, layout, outputs)
    for name in (
        "separate",
        "contrasts",
        "contrast_covariance",
        "ss_precision",
        "ss_lack_of_fit",
        "point_effects",
        "pooled",
        "ss_pooled_bias",
        "ss_pooled_precision",
    ):
        np.testing.assert_allclose(getattr(closed, name), getattr(projected, name), rtol=1e-9, atol=1e-12, err_msg=name)


def test_each_replication_alone_is_its_own_least_squares() -> None:
    form, layout, outputs = scene(3, dropped=(1, 2))
    sums = replicated_sums(form, layout, outputs)
    for replication in range(3):
        here = layout.replication == replication
        alone = np.linalg.lstsq(form.basis[here], outputs[here], rcond=None)[0]
        np.testing.assert_allclose(sums.separate[replication], alone, rtol=1e-9, atol=1e-13)


def test_order_of_the_rows_does_not_matter() -> None:
    form, layout, outputs = scene(4)
    shuffle = np.random.default_rng(1).permutation(layout.rows)
    moved = Layout(layout.replication[shuffle], layout.point[shuffle], layout.replication_labels, layout.point_labels)
    attitude = Attitude(np.zeros(1), np.zeros(1))
    again = replicated_sums(factor(form.basis[shuffle], MODEL.primary_names, attitude), moved, outputs[shuffle])
    first = replicated_sums(form, layout, outputs)
    np.testing.assert_allclose(again.ss_precision, first.ss_precision, rtol=1e-12)
    np.testing.assert_allclose(again.separate, first.separate, atol=1e-13)


@pytest.mark.parametrize("kept", [6, 8, 14])
def test_a_replication_that_stopped_part_way_bends_the_effects_of_the_points_little(kept: int) -> None:
    """Of noise alone: what its own poor parameters put into them stays below half of the pooled fit's own scatter."""
    form, layout, _ = scene(4, tuple(range(60 + kept, 80)))
    sums = replicated_sums(form, layout, np.random.default_rng(1).standard_normal((layout.rows, 300)))
    bent = np.linalg.lstsq(layout.mean_by_point(form.basis), sums.point_effects, rcond=None)[0]
    assert (bent.std(axis=1) < 0.5 * sums.pooled.std(axis=1)).all()
