"""n replications of the same points: what each replication says alone, and what is left when points have effects too.

Two linear fits are made of every output. *Separate*: each replication has parameters of its own, y = X_r c_r + e.
*Two-way*: every point has an effect of its own besides, y = X_r c_r + m_point + e. What the second leaves is precision;
what it takes away from the first is lack of fit. Where every replication holds every point at the same attitudes both
are closed forms; else they are solved by projection, which gives exact F tests for unbalanced data as well.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm

FloatArray = NDArray[np.float64]

_SAME_BASIS = 1e-13
_EIGENVALUE_TOLERANCE = 1e-9


@dataclass(frozen=True)
class ReplicatedSums:
    """For m right-hand sides at once."""

    separate: FloatArray
    """(n, P, m) estimates of each replication alone."""
    contrasts: FloatArray
    """(n, P, m) departures of the replications' parameters from one another, point effects taken out."""
    contrast_covariance: FloatArray
    """(n, P, n, P) their covariance for rows of unit variance; of rank (n − 1) P."""
    departures: FloatArray
    """(N, m) rows with the point effects taken out: drift and precision."""
    ss_precision: FloatArray
    """(m,)"""
    dof_precision: int
    ss_lack_of_fit: FloatArray
    """(m,)"""
    dof_lack_of_fit: int
    point_means: FloatArray
    """(K, m) every point's mean over the replications, their drift taken out."""


def replicated_sums(form: LinearForm, layout: Layout, outputs: FloatArray) -> ReplicatedSums:
    """Sums of squares and estimates of (N, m) outputs; every replication must determine the model alone."""
    if form.weights is None and layout.is_complete:
        order = layout.order
        stacked = form.basis[order].reshape(layout.replications, layout.points, -1)
        if np.all(np.abs(stacked - stacked[0]) <= _SAME_BASIS * np.abs(stacked[0]).max()):
            return _balanced(form, layout, outputs, order)
    return _unbalanced(form, layout, outputs)


def _balanced(form: LinearForm, layout: Layout, outputs: FloatArray, order: NDArray[np.int64]) -> ReplicatedSums:
    n, points, size = layout.replications, layout.points, form.basis.shape[1]
    basis = form.basis[order[:points]]
    estimator = n * form.estimator[:, order[:points]]
    rows = outputs[order].reshape(n, points, -1)
    separate = estimator @ rows
    residuals = rows - basis @ separate
    refinement = estimator @ residuals
    separate, residuals = separate + refinement, residuals - basis @ refinement
    common = residuals.mean(axis=0)
    departures = np.empty_like(outputs)
    departures[order] = (rows - rows.mean(axis=0)).reshape(outputs.shape)
    centring = np.eye(n) - 1.0 / n
    return ReplicatedSums(
        separate=separate,
        contrasts=separate - separate.mean(axis=0),
        contrast_covariance=np.einsum("rs,ij->risj", centring, n * form.unscaled_covariance),
        departures=departures,
        ss_precision=np.sum((residuals - common) ** 2, axis=(0, 1)),
        dof_precision=(n - 1) * (points - size),
        ss_lack_of_fit=n * np.sum(common**2, axis=0),
        dof_lack_of_fit=points - size,
        point_means=rows.mean(axis=0),
    )


def _unbalanced(form: LinearForm, layout: Layout, outputs: FloatArray) -> ReplicatedSums:
    n, size, rows = layout.replications, form.basis.shape[1], layout.rows
    weights = np.ones(rows) if form.weights is None else form.weights
    root = np.sqrt(weights)[:, None]
    separate, ss_separate = _separate_fits(form.basis * root, layout, outputs * root)
    by_replication = np.zeros((rows, n, size))
    by_replication[np.arange(rows), layout.replication] = form.basis
    blocks = by_replication.reshape(rows, n * size)
    contrasts, covariance, rank = _contrasts(blocks, layout, outputs, weights)
    moved = outputs - blocks @ contrasts
    effects = _point_means(layout, moved, weights)
    ss_precision = np.sum((root * (moved - effects)) ** 2, axis=0)
    dof_precision = rows - layout.points - rank
    dof_separate = rows - n * size
    dof_lack_of_fit = dof_separate - dof_precision
    return ReplicatedSums(
        separate=separate,
        contrasts=contrasts.reshape(n, size, -1),
        contrast_covariance=covariance.reshape(n, size, n, size),
        departures=outputs - effects,
        ss_precision=ss_precision,
        dof_precision=dof_precision,
        ss_lack_of_fit=np.maximum(ss_separate - ss_precision, 0.0),
        dof_lack_of_fit=dof_lack_of_fit,
        point_means=layout.mean_by_point(effects),
    )


def _separate_fits(basis: FloatArray, layout: Layout, outputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, P, m) estimates and (m,) sum of squares of the residuals, of weighted rows."""
    estimates, squares = [], np.zeros(outputs.shape[1])
    for replication in range(layout.replications):
        here = layout.replication == replication
        estimate = np.linalg.lstsq(basis[here], outputs[here], rcond=None)[0]
        squares += np.sum((outputs[here] - basis[here] @ estimate) ** 2, axis=0)
        estimates.append(estimate)
    return np.stack(estimates), squares


def _contrasts(
    blocks: FloatArray, layout: Layout, outputs: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, int]:
    """Least squares of the rows, free of point effects, on the replications' own bases: shortest solution,
    Gram inverse, rank."""
    centred = blocks - _point_means(layout, blocks, weights)
    gram = centred.T @ (weights[:, None] * centred)
    values, vectors = np.linalg.eigh(gram)
    kept = values > _EIGENVALUE_TOLERANCE * values[-1]
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    contrasts = inverse @ (centred.T @ (weights[:, None] * outputs))
    return contrasts, inverse, int(kept.sum())


def _point_means(layout: Layout, values: FloatArray, weights: FloatArray) -> FloatArray:
    """(N, …) weighted mean over the readings of the same point, given back to every row."""
    sums = layout.sum_by_point(weights[:, None] * values)
    return np.asarray((sums / layout.sum_by_point(weights)[:, None])[layout.point])
