"""What :mod:`ams.solve.mixed_model` will report, on the average, of observations that nobody has made yet.

The solver's own weights, at the variances that are believed beforehand instead of those that the observations show, and
the covariance that these variances give the estimate. Every part of the covariance has the name and the degrees of
freedom that it will have when it is solved.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ams.arrays import FloatArray
from ams.observations import Sampled
from ams.solve.components import ComponentColumns
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.mixed_model import (
    CommonErrors,
    MixedEstimates,
    common_of_points,
    from_common,
    joined_columns,
    lack_of_fit,
    row_variance,
    weighted_estimator,
)
from ams.solve.scatter import Scatter, expected_scatter, few_points_of
from ams.solve.whole_plots import WholePlots
from ams.statistics.distributions import normal_density, normal_share


@dataclass(frozen=True)
class Belief:
    """What is believed of one sensor axis before it is measured, in the unit of its outputs."""

    precision: float
    """Standard deviation of one row: the mean of one dwell."""
    lack_of_fit: float = 0.0
    """Standard deviation of what a point has of its own in all replications, the table's indices apart."""
    drift: Mapping[str, float] = field(default_factory=dict)
    """Primary parameter to its standard deviation between replications, or visits of a plateau."""
    sampled: Sampled | None = None
    """What the samples of its dwells will show; None where no step is declared."""


@dataclass(frozen=True)
class _Variances:
    """(m,) of a row, and of a point beside it."""

    precision: FloatArray
    lack_of_fit: FloatArray
    drift: FloatArray
    """(m, A, A) covariance of the parameters of a group of rows."""


def expected_estimates(
    form: LinearForm,
    alone: LinearForm,
    layout: Layout,
    outputs: FloatArray,
    names: Sequence[str],
    beliefs: Sequence[Belief],
    common: Sequence[CommonErrors],
    plots: WholePlots,
    *,
    is_weighted: bool = True,
) -> MixedEstimates:
    """Return what :func:`ams.solve.mixed_model.estimate` returns on the average for rows that scatter as believed.

    ``outputs`` are (N, m) without any error: what the model cannot follow in them is lack of fit. ``names`` are those
    of the columns of ``alone``.
    """
    ordinary = form.solve(outputs)
    bent = np.sum((outputs - form.basis @ ordinary) ** 2, axis=0) / layout.replications
    misfit = bent / max(layout.points - form.basis.shape[1], 1)
    believed = _Variances(
        np.array([belief.precision**2 for belief in beliefs]),
        np.array([belief.lack_of_fit**2 for belief in beliefs]) + misfit,
        np.stack([np.diag([belief.drift.get(name, 0.0) ** 2 for name in names]) for belief in beliefs]),
    )
    joined = joined_columns(form, layout, common)
    weights = np.ones(layout.rows) if form.weights is None else form.weights
    ss_ordinary = (layout.rows - form.basis.shape[1]) * (believed.precision + believed.lack_of_fit)
    if plots.dof < 1:
        few_points = few_points_of(is_weighted=is_weighted, is_replicated=False)
        scatter = _of_rows(form, believed, joined, weights, few_points)
        row_variances = [variance / weights for variance in scatter.variance]
        estimator = weighted_estimator(form, row_variances, joined if is_weighted else [])
        parts = [_noise("residuals", estimator, scatter.variance, weights, scatter.dof)]
        unknown = np.full(len(beliefs), np.nan)
        parts += from_common(form, estimator, common)
        return MixedEstimates(ordinary.T, tuple(parts), estimator, unknown, unknown, ordinary, ss_ordinary, None)
    few_points = few_points_of(is_weighted=is_weighted, is_replicated=True)
    found = _of_points(alone, layout, believed, joined, few_points)
    row_variances = [row_variance(form, layout, *pair) for pair in zip(believed.precision, found.variance, strict=True)]
    estimator = weighted_estimator(form, row_variances if joined else [], joined if is_weighted else [])
    parts = [_spread(estimator, alone, believed, plots, weights)]
    if found.variance.any():
        parts.append(lack_of_fit(estimator, layout, found.variance, found.dof, None))
    parts += from_common(form, estimator, common)
    return MixedEstimates(
        ordinary.T, tuple(parts), estimator, believed.precision, found.variance, ordinary, ss_ordinary, None
    )


def _of_rows(
    form: LinearForm, believed: _Variances, joined: Sequence[FloatArray], weights: FloatArray, few_points: float
) -> Scatter:
    """Return what the residuals of one replication show: precision, and the points' own beside it."""
    size = believed.precision.size
    common = np.tile(np.stack(joined), (1, form.repeats, 1)) if joined else np.zeros((size, weights.size, 0))
    return expected_scatter(form.basis, believed.precision + believed.lack_of_fit, common, weights, few_points)


def _of_points(
    alone: LinearForm, layout: Layout, believed: _Variances, joined: Sequence[FloatArray], few_points: float
) -> Scatter:
    """Return the lack of fit that the points will show: what comes out below zero counts as none."""
    size, alone_size = believed.precision.size, alone.basis.shape[1]
    if layout.points <= alone_size:
        return Scatter(np.zeros(size), np.full(size, np.nan))
    readings = layout.sum_by_point(np.ones(layout.rows) if alone.weights is None else alone.weights)
    typical = float(readings.mean())
    of_precision = believed.precision / typical
    common = common_of_points(alone, layout, joined, size)
    scatter = expected_scatter(
        layout.mean_by_point(alone.basis), of_precision + believed.lack_of_fit, common, readings / typical, few_points
    )
    dof_precision = layout.rows - layout.points - alone_size * (layout.replications - 1)
    spread = np.sqrt(2.0 * scatter.variance**2 / scatter.dof + 2.0 * of_precision**2 / max(dof_precision, 1))
    return Scatter(_positive_part(scatter.variance - of_precision, spread), scatter.dof)


def _positive_part(mean: FloatArray, standard_deviation: FloatArray) -> FloatArray:
    """Return the mean of a normal variable of which what is below zero counts as zero."""
    ratio = mean / np.maximum(standard_deviation, np.finfo(float).tiny)
    return np.asarray(mean * normal_share(ratio) + standard_deviation * normal_density(ratio))


def _noise(
    name: str, estimator: FloatArray, variance: FloatArray, weights: FloatArray, dof: FloatArray
) -> ComponentColumns:
    squares = (estimator / weights) @ np.swapaxes(estimator, -1, -2)
    return ComponentColumns(name, variance[:, None, None] * squares, dof)


def _spread(
    estimator: FloatArray, alone: LinearForm, believed: _Variances, plots: WholePlots, weights: FloatArray
) -> ComponentColumns:
    """Return what differs between replications, or between visits of a plateau: precision and drift.

    Where shared parameters are found from the groups' own, each group's parameters move the estimate as it responds to
    that group.
    """
    dof = np.full(believed.precision.size, float(plots.dof))
    noise = _noise(plots.name, estimator, believed.precision, weights, dof)
    if plots.absorbed == 0 and not believed.drift.any():
        return noise
    rows = plots.membership.T[:, :, None] * alone.basis
    response = np.expand_dims(estimator, -3) @ rows
    drift = believed.drift[:, None]
    if plots.absorbed > 0:
        each_covariance = np.linalg.inv(np.swapaxes(rows, -1, -2) @ (weights[:, None] * rows))
        drift = drift + believed.precision[:, None, None, None] * each_covariance
        covariance = np.zeros_like(noise.covariance)
    else:
        covariance = noise.covariance
    moved = np.sum(response @ drift @ np.swapaxes(response, -1, -2), axis=-3)
    return ComponentColumns(plots.name, covariance + moved, dof)
