"""n replications of the same points: what each replication says alone, and what is left when points have effects too.

Three linear fits are made of every output. *Pooled*: one set of parameters, as TP 8 has it. *Separate*: each
replication has parameters of its own, y = X_r c_r + e. *Two-way*: every point has an effect of its own besides,
y = X_r c_r + m_point + e. What the last leaves is precision; what it takes away from the second is lack of fit. Where
every replication holds every point at the same attitudes all are closed forms, made for any number of outputs at once;
else they are solved by projection, which gives exact F tests for unbalanced data as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray, column_blocks
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm

_SAME_BASIS = 1e-13
DISTINGUISHED = 1e-9
"""Of the largest eigenvalue: what fewer rows than that say of a direction counts as nothing."""
_OF_NOTHING: Final = 1e-12
"""Smallest eigenvalue of a Gram matrix of columns of unit length that is not zero but for rounding."""
_NOTHING = 1e-3
"""Of a row's standard deviation."""


@dataclass(frozen=True)
class ReplicatedSums:
    """For m right-hand sides at once."""

    is_balanced: bool
    """Every replication holds every point at the same attitudes, with equal weights."""
    pooled: FloatArray
    """(P, m) ordinary least squares over all rows."""
    separate: FloatArray
    """(n, P, m) estimates of each replication alone."""
    contrasts: FloatArray
    """(n, P, m) departures of the replications' parameters from one another, point effects taken out."""
    contrast_covariance: FloatArray
    """(n, P, n, P) their covariance for rows of unit variance; of rank (n − 1) P."""
    ss_precision: FloatArray
    """(m,)"""
    dof_precision: int
    ss_lack_of_fit: FloatArray
    """(m,)"""
    dof_lack_of_fit: int
    point_effects: FloatArray
    """(K, m) every point's mean residual of the pooled fit, the drift of the replications taken out."""
    drift_left: FloatArray
    """(K, q) errors of the point effects that many points share, for rows of unit variance: what is not known of the
    drift that was taken out. (K, 0) where every replication holds every point: there it has no mean at any."""
    ss_pooled_bias: FloatArray
    """(m,) SS_bias of TP 8, from the residuals of the pooled fit."""
    ss_pooled_precision: FloatArray
    """(m,) SS_prec of TP 8; with ``ss_pooled_bias`` the whole sum of squares of the pooled fit."""

    def contrast_squares(self, directions: FloatArray) -> FloatArray:
        """Return the (m, q) sums of squares of the contrasts along (m, q, P) directions.

        They are in units of the variance of a row.
        """
        along = np.einsum("nim,mqi->mqn", self.contrasts, directions)
        if self.is_balanced:
            n = along.shape[-1]
            per_replication = self.contrast_covariance[0, :, 0, :] / (1.0 - 1.0 / n)
            return np.asarray((along**2).sum(axis=-1) / ((directions @ per_replication) * directions).sum(axis=-1))
        covariance = np.einsum("mqi,risj,mqj->mqrs", directions, self.contrast_covariance, directions, optimize=True)
        trace = np.trace(covariance, axis1=-2, axis2=-1)[..., None, None]
        covariance = covariance + trace / along.shape[-1] ** 2  # the null vector, all ones, that contrasts do not touch
        return np.asarray(np.sum(along * np.linalg.solve(covariance, along[..., None])[..., 0], axis=-1))

    def departures(self, form: LinearForm, layout: Layout, outputs: FloatArray) -> FloatArray:
        """Return the (N, m) residuals of the pooled fit with the point effects taken out: drift and precision."""
        return np.asarray(outputs - form.basis @ self.pooled - self.point_effects[layout.point])


def replicated_sums(form: LinearForm, layout: Layout, outputs: FloatArray) -> ReplicatedSums:
    """Return the sums of squares and estimates of (N, m) outputs; every replication must determine the model alone."""
    if _same_everywhere(form, layout):
        return _balanced(form, layout, outputs, layout.order)
    return _unbalanced(form, layout, outputs)


def _same_everywhere(form: LinearForm, layout: Layout) -> bool:
    """Return whether every replication holds every point at the same attitudes."""
    if form.weights is not None or not layout.is_complete:
        return False
    if form.repeats == layout.replications and layout.order is None:
        return True
    stacked = _by_replication(form.basis, layout, layout.order)
    return bool(np.all(np.abs(stacked - stacked[0]) <= _SAME_BASIS * np.abs(stacked[0]).max()))


def _by_replication(values: FloatArray, layout: Layout, order: IntArray | None) -> FloatArray:
    """Return (n, K, …) rows sorted by replication and point."""
    ordered = values if order is None else values[order]
    return ordered.reshape(layout.replications, layout.points, -1)


def _balanced(form: LinearForm, layout: Layout, outputs: FloatArray, order: IntArray | None) -> ReplicatedSums:
    n, points, size = layout.replications, layout.points, form.basis.shape[1]
    first = slice(0, points) if order is None else order[:points]
    basis, estimator = form.basis[first], n * form.estimator[:, first]
    rows = _by_replication(outputs, layout, order)
    blocks = [_departures(rows[..., block], basis, estimator) for block in column_blocks(outputs.shape[1])]
    means, contrasts, ss_departures, ss_precision = map(_side_by_side, zip(*blocks, strict=True))
    pooled = estimator @ means
    pooled += estimator @ (means - basis @ pooled)
    misfit = means - basis @ pooled
    ss_lack_of_fit = n * np.einsum("km,km->m", misfit, misfit)
    return ReplicatedSums(
        is_balanced=True,
        pooled=pooled,
        separate=pooled + contrasts,
        contrasts=contrasts,
        contrast_covariance=_covariance_of_contrasts(n, form.unscaled_covariance),
        ss_precision=ss_precision,
        dof_precision=(n - 1) * (points - size),
        ss_lack_of_fit=ss_lack_of_fit,
        dof_lack_of_fit=points - size,
        point_effects=misfit,
        drift_left=np.zeros((points, 0)),
        ss_pooled_bias=ss_lack_of_fit,
        ss_pooled_precision=ss_departures,
    )


def _departures(
    rows: FloatArray, basis: FloatArray, estimator: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return of (n, K, m) outputs the (K, m) means, the (n, P, m) contrasts, and the sums of squares about them.

    (m,) about the means, and (m,) beside the contrasts as well.
    """
    n = rows.shape[0]
    means = rows.sum(axis=0) / n
    left = rows - means
    ss_departures = np.einsum("rkm,rkm->m", left, left)
    contrasts = estimator @ left
    contrasts -= contrasts.sum(axis=0) / n
    left -= basis @ contrasts
    return means, contrasts, ss_departures, np.einsum("rkm,rkm->m", left, left)


def _side_by_side(blocks: Sequence[FloatArray]) -> FloatArray:
    return blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=-1)


@remembered(16)
def _covariance_of_contrasts(n: int, unscaled: FloatArray) -> FloatArray:
    """Return (n, P, n, P) for n replications that each hold every point, by the (P, P) covariance of them all."""
    centring = np.eye(n) - 1.0 / n
    return np.asarray(centring[:, None, :, None] * (n * unscaled)[:, None, :])


def _unbalanced(form: LinearForm, layout: Layout, outputs: FloatArray) -> ReplicatedSums:
    n, size, rows = layout.replications, form.basis.shape[1], layout.rows
    weights = np.ones(rows) if form.weights is None else form.weights
    root = np.sqrt(weights)[:, None]
    separate, ss_separate = _separate_fits(form.basis * root, layout, outputs * root)
    pooled = form.solve(outputs)
    residuals = outputs - form.basis @ pooled
    bias = _point_means(layout, residuals, weights)
    apart = _apart(form.basis, layout, form.weights)
    contrasts = apart.turn @ (apart.inverse @ (apart.centred.T @ (weights[:, None] * residuals)))
    moved = residuals - apart.by_replication @ contrasts
    ss_precision = np.sum((root * (moved - _point_means(layout, moved, weights))) ** 2, axis=0)
    effects = _point_means(layout, residuals - apart.about_mean @ contrasts, weights)
    dof_precision = rows - layout.points - apart.rank
    return ReplicatedSums(
        is_balanced=False,
        pooled=pooled,
        separate=separate,
        contrasts=contrasts.reshape(n, size, -1),
        contrast_covariance=apart.covariance.reshape(n, size, n, size),
        ss_precision=ss_precision,
        dof_precision=dof_precision,
        ss_lack_of_fit=np.maximum(ss_separate - ss_precision, 0.0),
        dof_lack_of_fit=rows - n * size - dof_precision,
        point_effects=layout.mean_by_point(effects),
        drift_left=apart.drift_left,
        ss_pooled_bias=np.sum((root * bias) ** 2, axis=0),
        ss_pooled_precision=np.sum((root * (residuals - bias)) ** 2, axis=0),
    )


def _separate_fits(basis: FloatArray, layout: Layout, outputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (n, P, m) estimates and (m,) sum of squares of the residuals, of weighted rows."""
    estimates, squares = [], np.zeros(outputs.shape[1])
    for replication in range(layout.replications):
        here = layout.replication == replication
        estimate = np.linalg.lstsq(basis[here], outputs[here], rcond=None)[0]
        squares += np.sum((outputs[here] - basis[here] @ estimate) ** 2, axis=0)
        estimates.append(estimate)
    return np.stack(estimates), squares


@dataclass(frozen=True)
class _Apart:
    """What tells n replications that do not hold the same rows from one another, whatever the outputs are."""

    by_replication: FloatArray
    """(N, n P) the basis once for every replication."""
    about_mean: FloatArray
    """(N, n P) less what all replications have in common."""
    centred: FloatArray
    """(N, (n − 1) P) free of point effects, in contrasts between the replications."""
    inverse: FloatArray
    """((n − 1) P, (n − 1) P) of their Gram matrix."""
    turn: FloatArray
    """(n P, (n − 1) P) from those contrasts to departures of the replications' parameters."""
    covariance: FloatArray
    """(n P, n P) of those departures, for rows of unit variance."""
    rank: int
    drift_left: FloatArray
    """(K, q) as in :class:`ReplicatedSums`."""


@remembered(6)
def _apart(basis: FloatArray, layout: Layout, row_weights: FloatArray | None) -> _Apart:
    """Prepare the least squares of the rows, free of point effects, on the replications' own bases.

    The contrasts add up to nothing: what all replications have in common belongs to the points. The columns are brought
    to unit length first: no unit of a parameter decides what is told apart. What is not told apart is loose in
    ``drift_left`` instead of zero.
    """
    n, weights = layout.replications, np.ones(layout.rows) if row_weights is None else row_weights
    blocks = columns_per_replication(basis, layout)
    length = np.sqrt(np.einsum("rni,rni->i", blocks, blocks))
    length = np.where(length > 0.0, length, 1.0)
    apart = np.linalg.qr(np.eye(n) - 1.0 / n)[0][:, :-1]
    free = np.einsum("rni,nk->rki", blocks / length, apart).reshape(layout.rows, -1)
    centred = free - _point_means(layout, free, weights)
    values, vectors = np.linalg.eigh(centred.T @ (weights[:, None] * centred))
    kept = values > DISTINGUISHED * values[-1]
    turn = np.kron(apart, np.diag(1.0 / length))
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    about_mean = about_their_mean(basis, layout, weights)
    errors = layout.mean_by_point(_point_means(layout, about_mean, weights)) @ (turn @ loose_root(values, vectors))
    return _Apart(
        by_replication=blocks.reshape(layout.rows, -1),
        about_mean=about_mean,
        centred=centred,
        inverse=inverse,
        turn=turn,
        covariance=turn @ inverse @ turn.T,
        rank=int(kept.sum()),
        drift_left=left_in_means(errors),
    )


def columns_per_replication(basis: FloatArray, layout: Layout) -> FloatArray:
    """Return (N, n, P) the (N, P) columns once for every replication, zero in the rows of the others."""
    columns = np.zeros((layout.rows, layout.replications, basis.shape[1]))
    columns[np.arange(layout.rows), layout.replication] = basis
    return columns


def about_their_mean(basis: FloatArray, layout: Layout, weights: FloatArray) -> FloatArray:
    """Return (N, n P): each replication's own (N, P) columns, less their share in what all replications have in common.

    The mean of the replications' parameters is weighted by what each tells of the direction that it tells least of,
    so that one that stopped part way bends it little. One weight for all its parameters: an offset stays an offset.
    Of a direction that none of them tells, as at one roll angle, all tell the least: they count alike.
    """
    n, size = layout.replications, basis.shape[1]
    columns = columns_per_replication(basis, layout)
    weighted = weights[:, None] * basis
    gram = (weighted.T @ columns.reshape(layout.rows, -1)).reshape(size, n, size).swapaxes(0, 1)
    share = np.full(n, 1.0 / n)
    if _is_determined(gram.sum(axis=0)):
        smallest = np.linalg.eigvals(np.linalg.solve(gram.sum(axis=0), gram)).real.min(axis=1)
        information = np.maximum(smallest, DISTINGUISHED)
        share = information / information.sum()
    return np.asarray((columns - share[:, None] * basis[:, None, :]).reshape(layout.rows, -1))


def _is_determined(gram: FloatArray) -> bool:
    """Return whether a (P, P) Gram matrix has no direction of nothing, whatever the units of its columns."""
    length = np.sqrt(np.diag(gram))
    if not length.all():
        return False
    return bool(np.linalg.eigvalsh(gram / np.outer(length, length))[0] > _OF_NOTHING)


def loose_root(values: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return a root of the covariance that a Gram matrix of these eigenvalues leaves, for rows of unit variance.

    A direction that no two replications tell apart is not known to be zero: it is as loose as the least known.
    """
    return np.asarray(vectors / np.sqrt(np.maximum(values, DISTINGUISHED * values[-1])))


def left_in_means(errors: FloatArray) -> FloatArray:
    """Return (K, q) columns of the same covariance as the (K, p) errors, without those that are nothing."""
    left, size, _ = np.linalg.svd(errors, full_matrices=False)
    return np.asarray((left * size)[:, size > _NOTHING])


def _point_means(layout: Layout, values: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the (N, …) weighted mean over the readings of the same point, given back to every row."""
    sums = layout.sum_by_point(weights[:, None] * values)
    return np.asarray((sums / layout.sum_by_point(weights)[:, None])[layout.point])
