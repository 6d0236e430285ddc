"""Few points beside common errors in every direction: what an ordinary estimate's intervals hold, from both sides."""

import numpy as np
import pytest
from attitudes import attitude_from_degrees

from ams.arrays import FloatArray
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from ams.solve.layout import layout_of
from ams.solve.linear_form import factor
from ams.solve.mixed_model import estimate
from ams.solve.scatter import few_points_of
from ams.solve.whole_plots import whole_plots
from ams.statistics.intervals import combined_dof, t_quantile

TRUE = np.array([0.1, 0.2, -2.5, 0.3])
NOISE, REPLICATIONS = 1.0, 4
MODEL = PitchRoll("y")


def held(lack_of_fit: float, campaigns: int, seed: int) -> FloatArray:
    """Return by parameter the share of 95 % intervals that hold, over twelve points with common errors as declared.

    They differ tenfold between the directions and are two to twenty times the noise of a mean.
    """
    chance = np.random.default_rng(seed)
    pitch, roll = (each.ravel() for each in np.meshgrid([-60.0, 0.0, 60.0], np.arange(-180.0, 180.0, 90.0)))
    attitude = attitude_from_degrees(np.tile(pitch, REPLICATIONS), np.tile(roll, REPLICATIONS))
    replication, point = np.divmod(np.arange(12 * REPLICATIONS), 12)
    layout = layout_of(Observations(replication, point, attitude.pitch_rad, attitude.roll_rad, {}))
    form = factor(MODEL.basis(attitude), MODEL.primary_names, attitude)
    columns = np.linalg.qr(chance.standard_normal((12, 12)))[0] * np.geomspace(1.0, 10.0, 12)
    of_points = columns @ chance.standard_normal((12, campaigns))
    of_points += lack_of_fit * chance.standard_normal((12, campaigns))
    outputs = (form.basis @ TRUE)[:, None] + of_points[point]
    outputs += NOISE * chance.standard_normal(outputs.shape)
    common = [{"table": np.tile(columns, (REPLICATIONS, 1))}] * campaigns
    plots = whole_plots(layout, None, ())
    found = estimate(form, form, layout, outputs, common, plots, is_weighted=False)
    variances = np.stack([np.diagonal(part.covariance, axis1=-2, axis2=-1) for part in found.components])
    dof = combined_dof(variances, np.stack([part.dof for part in found.components])[:, :, None])
    half = t_quantile(0.95, dof) * np.sqrt(variances.sum(axis=0))
    return np.asarray(np.mean(np.abs(found.estimate - TRUE) <= half, axis=0))


@pytest.mark.parametrize(
    ("lack_of_fit", "most"), [*((size, 0.985) for size in (0.0, 1.0, 3.0)), (10.0, 0.97), (100.0, 0.97)]
)
def test_what_is_the_common_errors_is_counted_once(lack_of_fit: float, most: float) -> None:
    """Below the common errors the points' own scatter is hardly told; the whole scatter in its place holds 0.996."""
    shares = held(lack_of_fit, campaigns=3000, seed=17)
    assert shares.min() >= 0.935, shares
    assert shares.mean() <= most, shares


def test_only_weights_that_a_scatter_of_zero_would_make_call_for_the_whole_of_it() -> None:
    assert few_points_of(is_weighted=False, is_replicated=True) == few_points_of(is_weighted=False, is_replicated=False)
    assert few_points_of(is_weighted=False, is_replicated=True) == 0.0
    assert few_points_of(is_weighted=True, is_replicated=True) > 0.0
