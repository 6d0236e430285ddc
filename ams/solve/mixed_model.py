"""The reported estimate and its covariance: precision, drift, lack of fit and the table's index errors together.

Rows are y = X (c + d_g) + G δ + l_point + e: d_g the drift of a replication (of a visit of a temperature plateau, where
a visit holds several replications), δ the common errors with unit variance (index errors of the table, uncertainty of
known coefficients), l a point's own lack of fit, e the precision. Any linear estimate A y with A X = 1 has the
covariance

    (spread of the groups)  +  s_lof² B Bᵀ  +  (A G)(A G)ᵀ,      B = A summed over the readings of a point,

whatever A is. The weights in A (generalised least squares) only make it small: they need not be exact, the covariance
stays right. The lack-of-fit variance is what the points' scatter asks for beyond precision *and* common errors, so the
table's index errors are never counted twice. All is made for m outputs of the same rows at once. Source: TP 8 for the
idea, TP (50) for one replication.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.arrays import FloatArray
from ams.solve.components import Causes, ComponentColumns
from ams.solve.layout import Layout
from ams.solve.least_spread import no_less_than_noise
from ams.solve.linear_form import LinearForm
from ams.solve.lone_errors import lone_apart
from ams.solve.replicated import ReplicatedSums, replicated_sums
from ams.solve.scatter import few_points_of, points_scatter
from ams.solve.whole_plots import WholePlots

CommonErrors = Mapping[str, FloatArray]
"""Name to columns of one standard uncertainty each, volts: (N, q), or (N / repeats, q) where the basis repeats."""

_SMALLEST_ROW_VARIANCE = 1e-6
"""Of the mean variance from common errors: keeps the weights finite where the rows have no noise of their own."""


@dataclass(frozen=True)
class MixedEstimates:
    """Estimates of the free primary parameters of m sensor axes."""

    estimate: FloatArray
    """(m, P)"""
    components: tuple[ComponentColumns, ...]
    """Independent parts of their covariances."""
    estimator: FloatArray
    """(P, N); (m, P, N) where there are common errors."""
    precision_variance: FloatArray
    """(m,) volts²; NaN where it cannot be estimated."""
    lack_of_fit_variance: FloatArray
    """(m,) volts², beyond the common errors."""
    ordinary: FloatArray
    """(P, m) of the ordinary fit."""
    ss_ordinary: FloatArray
    """(m,) sum of squares of its residuals."""
    sums: ReplicatedSums | None
    """Of the outputs less what ``alone`` does not hold; None where nothing is replicated."""

    def with_errors(self, form: LinearForm, common: Sequence[CommonErrors]) -> "MixedEstimates":
        """Return the same estimates with common errors added to their covariances, one entry an output or none."""
        return replace(self, components=(*self.components, *from_common(form, self.estimator, common)))

    @property
    def covariance(self) -> FloatArray:
        """The (m, P, P) covariance of all components together."""
        return np.asarray(sum(component.covariance for component in self.components))


def estimate(
    form: LinearForm,
    alone: LinearForm,
    layout: Layout,
    outputs: FloatArray,
    common: Sequence[CommonErrors],
    plots: WholePlots,
    *,
    is_weighted: bool = True,
) -> MixedEstimates:
    """Estimate from (N, m) outputs.

    ``alone`` is the part of the model that every replication determines by itself: ``form``, or its leading columns
    where further parameters (temperature coefficients) are only seen across replications. ``common`` is empty, or has
    one entry for every output. Not weighted, the estimate is the ordinary one whatever is common.
    """
    joined = joined_columns(form, layout, common)
    # No group of rows to spare: nothing is left that differs between groups and could tell a spread.
    if plots.dof < 1:
        return _unreplicated(form, layout, outputs, common, joined, is_weighted=is_weighted)
    ordinary, alone_v = _split(form, alone, outputs)
    sums = replicated_sums(alone, layout, alone_v)
    ss_ordinary = sums.ss_pooled_bias + sums.ss_pooled_precision
    if ordinary is None:
        ordinary = sums.pooled
    else:
        ss_ordinary = _square(form, outputs - form.basis @ ordinary)
    few_points = few_points_of(is_weighted=is_weighted, is_replicated=True)
    precision, beyond, beyond_dof = _variances(alone, layout, sums, joined, few_points)
    typical = np.where(np.isnan(precision), ss_ordinary / max(layout.rows - form.basis.shape[1], 1), precision)
    row_variances = [row_variance(form, layout, *pair) for pair in zip(typical, beyond, strict=True)] if joined else []
    estimator, found = _weighted(form, outputs, ordinary, row_variances, joined if is_weighted else [])
    spread = _spread(estimator, form, alone, layout, alone_v, sums, plots)
    components = [no_less_than_noise(spread, estimator, form, precision, sums.dof_precision)]
    if beyond.any():
        components.append(lack_of_fit(estimator, layout, beyond, beyond_dof, sums.point_effects))
    components += from_common(form, estimator, common)
    return MixedEstimates(found.T, tuple(components), estimator, precision, beyond, ordinary, ss_ordinary, sums)


def joined_columns(form: LinearForm, layout: Layout, common: Sequence[CommonErrors]) -> list[FloatArray]:
    """Return the common errors of every output side by side."""
    block_rows = layout.rows // form.repeats
    return [np.hstack(list(blocks.values())) if blocks else np.zeros((block_rows, 0)) for blocks in common]


def _unreplicated(
    form: LinearForm,
    layout: Layout,
    outputs: FloatArray,
    common: Sequence[CommonErrors],
    joined: Sequence[FloatArray],
    *,
    is_weighted: bool,
) -> MixedEstimates:
    """Estimate from one replication (or none to spare).

    Precision and lack of fit cannot be told apart; the residuals hold both.
    """
    weights = np.ones(layout.rows) if form.weights is None else form.weights
    ordinary = form.solve(outputs)
    ss_ordinary = _square(form, outputs - form.basis @ ordinary)
    free = layout.rows - form.basis.shape[1]
    variance = ss_ordinary / free if free > 0 else np.full(ss_ordinary.size, np.nan)
    dof = np.full(variance.size, free if free > 0 else np.nan)
    if joined:
        common_rows = np.tile(np.stack(joined), (1, form.repeats, 1))
        few_points = few_points_of(is_weighted=is_weighted, is_replicated=False)
        scatter = points_scatter(form.basis, outputs, common_rows, weights, few_points)
        variance, dof = scatter.variance, scatter.dof
    row_variances = [v / weights for v in variance]
    estimator, found = _weighted(form, outputs, ordinary, row_variances, joined if is_weighted else [])
    spread = variance[:, None, None] * ((estimator / weights) @ np.swapaxes(estimator, -1, -2))
    residuals = np.sqrt(weights)[:, None] * (outputs - form.basis @ ordinary)
    causes = Causes(estimator / np.sqrt(weights), np.sqrt(variance), residuals)
    components = (ComponentColumns("residuals", spread, dof, causes), *from_common(form, estimator, common))
    unknown = np.full(variance.size, np.nan)
    return MixedEstimates(found.T, components, estimator, unknown, unknown, ordinary, ss_ordinary, None)


def _split(form: LinearForm, alone: LinearForm, outputs: FloatArray) -> tuple[FloatArray | None, FloatArray]:
    """Return the ordinary fit, and the outputs less what only several replications together determine.

    None: there is nothing of that kind.
    """
    alone_size = alone.basis.shape[1]
    if alone_size == form.basis.shape[1]:
        return None, outputs
    ordinary = form.solve(outputs)
    return ordinary, outputs - form.basis[:, alone_size:] @ ordinary[alone_size:]


def _square(form: LinearForm, residuals: FloatArray) -> FloatArray:
    weighted = residuals if form.weights is None else form.weights[:, None] * residuals
    return np.asarray(np.einsum("nm,nm->m", weighted, residuals))


def _variances(
    alone: LinearForm, layout: Layout, sums: ReplicatedSums, joined: Sequence[FloatArray], few_points: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (m,) precision, lack of fit beyond the common errors (volts²), and the latter's degrees of freedom.

    Those are the degrees of freedom of the points' scatter: counting the subtraction of precision as well would leave
    fewer than one where the lack of fit is small, and widen intervals that hold without it (97 % for 95 %, simulated).
    """
    size = sums.ss_precision.size
    if sums.dof_precision <= 0 or sums.dof_lack_of_fit <= 0:
        return np.full(size, np.nan), np.zeros(size), np.full(size, np.nan)
    precision = sums.ss_precision / sums.dof_precision
    # Every point has the same number of rows: the textbook's difference of mean squares, without iteration.
    if sums.is_balanced and not joined:
        beyond = (sums.ss_lack_of_fit / sums.dof_lack_of_fit - precision) / layout.replications
        return precision, np.maximum(0.0, beyond), np.full(size, float(sums.dof_lack_of_fit))
    readings = layout.sum_by_point(np.ones(layout.rows) if alone.weights is None else alone.weights)
    typical, basis = float(readings.mean()), layout.mean_by_point(alone.basis)
    drift = np.sqrt(precision)[:, None, None] * sums.drift_left
    common = np.concatenate([common_of_points(alone, layout, joined, size), drift], axis=2)
    scatter = points_scatter(basis, sums.point_effects, common, readings / typical, few_points)
    return precision, np.maximum(0.0, scatter.variance - precision / typical), scatter.dof


def common_of_points(alone: LinearForm, layout: Layout, joined: Sequence[FloatArray], outputs: int) -> FloatArray:
    """Return (m, K, q) the common errors of the points, by output."""
    known = [columns if alone.repeats > 1 else layout.mean_by_point(columns) for columns in joined]
    return np.stack(known) if known else np.zeros((outputs, layout.points, 0))


def row_variance(form: LinearForm, layout: Layout, precision: float, beyond: float) -> FloatArray:
    """Return the (N,) variance of each row for the weights, over the repeats.

    A point's lack of fit counts once, however often it was read.
    """
    readings = layout.sum_by_point(np.ones(layout.rows))[layout.point]
    return (precision / (1.0 if form.weights is None else form.weights) + readings * beyond) / form.repeats


def _weighted(
    form: LinearForm,
    outputs: FloatArray,
    ordinary: FloatArray,
    row_variances: Sequence[FloatArray],
    joined: Sequence[FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Return the estimator, and (P, m) estimates: the ordinary ones where no errors are common."""
    if not joined:
        return form.estimator, ordinary
    estimator = weighted_estimator(form, row_variances, joined)
    residuals = outputs - form.basis @ ordinary
    return estimator, ordinary + (estimator @ residuals.T[:, :, None])[..., 0].T


def weighted_estimator(
    form: LinearForm, row_variances: Sequence[FloatArray], joined: Sequence[FloatArray]
) -> FloatArray:
    """Return the estimator, (m, P, N) where errors are common: weights for (N,) own variances and those errors."""
    if not joined:
        return form.estimator
    # Common errors are alike in every repeat: the weights are those of one block, each row with the variance of a mean.
    basis = form.basis[: joined[0].shape[0]]
    of_block = _generalised(basis, np.stack(row_variances)[:, : basis.shape[0]], np.stack(joined))
    return np.tile(of_block / form.repeats, form.repeats)


def _generalised(basis: FloatArray, row_variance: FloatArray, joined: FloatArray) -> FloatArray:
    """Return the (m, P, N) generalised least squares estimator, by Woodbury's identity.

    The row covariances are diag(own) + joined·joinedᵀ, (m, N) and (m, N, q).
    """
    row_variance = np.maximum(
        row_variance, _SMALLEST_ROW_VARIANCE * np.mean(np.sum(joined**2, axis=-1), axis=-1)[:, None]
    )
    alone, joined = lone_apart(joined)
    row_variance = (row_variance + alone)[..., None]
    weighted_basis, weighted, turned = basis / row_variance, joined / row_variance, np.swapaxes(joined, -1, -2)
    inner = np.eye(joined.shape[-1]) + turned @ weighted
    weighted_basis = weighted_basis - weighted @ np.linalg.solve(inner, turned @ weighted_basis)
    return np.asarray(np.linalg.solve(basis.T @ weighted_basis, np.swapaxes(weighted_basis, -1, -2)))


def _spread(
    estimator: FloatArray,
    form: LinearForm,
    alone: LinearForm,
    layout: Layout,
    alone_v: FloatArray,
    sums: ReplicatedSums,
    plots: WholePlots,
) -> ComponentColumns:
    """Return precision and drift, from what differs between replications, or between visits of a plateau."""
    dof = np.full(alone_v.shape[1], float(plots.dof))
    if plots.absorbed > 0:
        effects = _response(estimator, alone, _departures(form, alone, layout, sums, plots), plots)
        return _of_effects(plots.name, effects, 1.0, dof)
    if sums.is_balanced and estimator is form.estimator and plots.is_replications and alone is form:
        contributions = sums.contrasts.transpose(2, 0, 1) / layout.replications
    else:
        contributions = _contributions(estimator, alone, sums.departures(alone, layout, alone_v), plots)
    scale = float(np.sqrt(plots.count / plots.dof))
    return _of_effects(plots.name, np.swapaxes(contributions, -1, -2), scale, dof)


def _of_effects(name: str, effects: FloatArray, scale: float, dof: FloatArray) -> ComponentColumns:
    covariance = scale**2 * effects @ np.swapaxes(effects, -1, -2)
    return ComponentColumns(name, covariance, dof, Causes(effects, np.full(dof.size, scale)))


def _contributions(estimator: FloatArray, alone: LinearForm, left: FloatArray, plots: WholePlots) -> FloatArray:
    """Return the (m, groups, P) part of each group in the estimate, point effects taken out.

    Balanced: its departure / n.
    """
    alone_size = alone.basis.shape[1]
    shared = np.einsum("...pn,nm->pm" if estimator.ndim == 2 else "mpn,nm->pm", estimator[..., :alone_size, :], left)
    left = left - alone.basis @ shared
    return np.swapaxes((estimator * left.T[:, None, :]) @ plots.membership, -1, -2)


def _departures(
    form: LinearForm, alone: LinearForm, layout: Layout, sums: ReplicatedSums, plots: WholePlots
) -> FloatArray:
    """Return the (m, groups, P) departures of the groups' own parameters, for those shared and found from the groups.

    Their squares add up to the covariance of one group.

    A shared parameter takes a contrast from the directions that it moves (a sensitivity's temperature coefficient: from
    those along the sensor's axis) and from no other: each direction is divided by what is left to it.
    """
    of_replication = plots.of_replication(layout)
    departures = np.einsum("rpm,rg->mgp", sums.contrasts, of_replication / of_replication.sum(axis=0))
    root = np.asarray(np.linalg.cholesky(alone.unscaled_covariance), dtype=np.float64)
    scale = root @ _inverse_root(_contrasts_left(form, alone, plots, root)) @ np.linalg.inv(root)
    return np.asarray(departures @ scale.T)


def _contrasts_left(form: LinearForm, alone: LinearForm, plots: WholePlots, root: FloatArray) -> FloatArray:
    """Return how many contrasts between the groups the shared parameters leave each direction.

    (P, P), in units of ``root``.

    Departures d of the groups move the shared parameters by E X d, and the groups' own estimates by what the basis of
    the shared ones looks like to them.
    """
    alone_size = alone.basis.shape[1]
    basis, shared = plots.membership.T[:, :, None] * alone.basis, form.basis[:, alone_size:]
    weighted = np.swapaxes(basis if form.weights is None else form.weights[:, None] * basis, -1, -2)
    looks = np.linalg.solve(weighted @ alone.basis, weighted @ shared)
    moved = looks[:, None] @ (form.estimator[alone_size:] @ basis)
    left = np.eye(plots.count)[:, :, None, None] * np.eye(alone_size) - moved
    left = np.linalg.inv(root) @ (left - left.mean(axis=0)) @ root
    return np.asarray(np.einsum("ghij,ghkj->ik", left, left))


def _inverse_root(matrix: FloatArray) -> FloatArray:
    """Return the inverse square root of a symmetric positive definite matrix."""
    values, vectors = np.linalg.eigh(matrix)
    return np.asarray((vectors / np.sqrt(values)) @ vectors.T)


def _response(estimator: FloatArray, alone: LinearForm, departures: FloatArray, plots: WholePlots) -> FloatArray:
    """Return the (m, P, groups²) effects where shared parameters are found from the groups' own.

    Each group may have any of the departures that the groups show, and moves the estimate as the estimator responds to
    that group.
    """
    rows = np.einsum("ng,ni->gni", plots.membership, alone.basis)
    response = np.expand_dims(estimator, -3) @ rows
    effects = response @ np.swapaxes(departures, -1, -2)[:, None]
    return np.asarray(np.moveaxis(effects, 1, 2).reshape(effects.shape[0], effects.shape[2], -1))


def lack_of_fit(
    estimator: FloatArray, layout: Layout, variance: FloatArray, dof: FloatArray, point_effects: FloatArray | None
) -> ComponentColumns:
    """Return the component of what points have of their own; its causes where the effects of points are measured."""
    flat = estimator.reshape(-1, layout.rows)
    by_point = layout.sum_by_point(flat.T).T.reshape(*estimator.shape[:-1], layout.points)
    squares = by_point @ np.swapaxes(by_point, -1, -2)
    causes = None if point_effects is None else Causes(by_point, np.sqrt(variance), point_effects)
    return ComponentColumns("lack-of-fit", variance[:, None, None] * squares, dof, causes)


def from_common(form: LinearForm, estimator: FloatArray, common: Sequence[CommonErrors]) -> list[ComponentColumns]:
    parts = []
    for name in common[0] if common else ():
        rows = common[0][name].shape[0]
        each = np.broadcast_to(estimator, (len(common), *estimator.shape[-2:]))
        pairs = zip(each[..., :rows], common, strict=True)
        effects = np.stack([form.repeats * estimator @ blocks[name] for estimator, blocks in pairs])
        parts.append(_of_effects(name, effects, 1.0, np.full(len(effects), np.inf)))
    return parts
