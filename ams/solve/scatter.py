"""The variance that points have of their own, beside errors that many of them share.

Rows are y = X c + G δ + e with known columns G (unit variance) and e of unknown variance t over the row's weight. The
estimate is that of restricted maximum likelihood (Patterson and Thompson 1971): where G is large it looks along the
directions that G does not touch, which a plain difference of mean squares cannot.

With a handful of points there may be no such direction (pitch alone: every point has an index of its own). Then the
likelihood is often largest at t = 0, and intervals that believe it hold the truth in half of the campaigns. There the
whole scatter counts as the points' own: wider than need be, by as much as G is counted twice. What fails there are the
weights that such a t makes (all on the points that G does not touch); an ordinary estimate has none, and believes t.
"""

from dataclasses import dataclass

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.solve.lone_errors import column_by_row

_BISECTIONS = 60
_LONGEST_STEP = 5.0
"""Of log t: further away the likelihood is no parabola."""
_SETTLED = 1e-10
"""Of the last step; what is left after it is the square of that."""
_NEGLIGIBLE = 1e-12
_SMALLEST_DOF = 1.0
_TINY = float(np.finfo(float).tiny)
_DISTINGUISHED = 3.0
"""Degrees of freedom from which on the points' own variance can be told from that of the common errors."""
FEW_POINTS = 20
"""Degrees of freedom of the points up to which that makes a difference where replications tell the precision."""


def few_points_of(*, is_weighted: bool, is_replicated: bool) -> float:
    """Return the degrees of freedom of the points up to which the whole scatter may count as their own."""
    if not is_weighted:
        return 0.0
    return FEW_POINTS if is_replicated else np.inf


@dataclass(frozen=True)
class Scatter:
    """Variances of a row of unit weight of m outputs, with their degrees of freedom."""

    variance: FloatArray
    """(m,)"""
    dof: FloatArray
    """(m,) at least 1: where the common errors drown the points' own variance, it is no chi-square any more (it may be
    zero), and Student's factor for a part of a degree of freedom would be beyond all bounds."""


def points_scatter(
    basis: FloatArray, outputs: FloatArray, common: FloatArray, weights: FloatArray, few_points: float = np.inf
) -> Scatter:
    """Return the scatter from (K, P), (K, m), (m, K, q) and (K,); NaN where no degrees of freedom are left.

    With ``few_points`` degrees of freedom or less the whole scatter counts where the common errors drown the points'
    own.
    """
    dof, size = basis.shape[0] - basis.shape[1], outputs.shape[1]
    if dof <= 0:
        return Scatter(np.full(size, np.nan), np.full(size, np.nan))
    root = np.sqrt(weights)[:, None]
    q, _ = np.linalg.qr(root * basis)
    residuals = _across(q, root * outputs)
    square = np.einsum("km,km->m", residuals, residuals)
    whole = Scatter(square / dof, np.full(size, float(dof)))
    columns = column_by_row(common)
    if columns.shape[-1] == 0 or not square.any():
        return whole
    spread, along = _principal(_across(q, root * columns), residuals)
    directions = np.isfinite(spread).sum(axis=1)
    free = dof - directions
    rest = np.maximum(square - along.sum(axis=1), 0.0)
    variance = _balance(spread, along, rest, np.where(square > 0.0, square, 1.0), free)
    return _believed(variance, spread, whole, free, few_points, square == 0.0)


def expected_scatter(
    basis: FloatArray, variance: FloatArray, common: FloatArray, weights: FloatArray, few_points: float = np.inf
) -> Scatter:
    """Return what :func:`points_scatter` finds on the average where rows of unit weight have the (m,) variance."""
    dof, size = basis.shape[0] - basis.shape[1], variance.size
    if dof <= 0:
        return Scatter(np.full(size, np.nan), np.full(size, np.nan))
    whole, columns = Scatter(variance, np.full(size, float(dof))), column_by_row(common)
    if columns.shape[-1] == 0:
        return whole
    root = np.sqrt(weights)[:, None]
    q, _ = np.linalg.qr(root * basis)
    across = _across(q, root * columns)
    variances = np.linalg.eigvalsh(np.swapaxes(across, -1, -2) @ across)
    spread = np.asarray(np.where(variances <= _NEGLIGIBLE * variances[:, -1:], np.inf, variances), dtype=np.float64)
    there = np.isfinite(spread)
    square = dof * variance + np.where(there, spread, 0.0).sum(axis=1)
    whole = Scatter(square / dof, np.full(size, float(dof)))
    return _believed(variance, spread, whole, dof - there.sum(axis=1), few_points, square == 0.0)


def _believed(
    variance: FloatArray, spread: FloatArray, whole: Scatter, free: IntArray, few_points: float, nothing: BoolArray
) -> Scatter:
    """Return the points' own variance where it is told from that of the common errors, else the whole scatter."""
    dof = np.sum((variance[:, None] / np.maximum(variance[:, None] + spread, _TINY)) ** 2, axis=1) + free
    drowned = (dof < _DISTINGUISHED) & (whole.dof <= few_points) | nothing
    return Scatter(
        np.where(drowned, whole.variance, variance), np.where(drowned, whole.dof, np.maximum(dof, _SMALLEST_DOF))
    )


def _across(q: FloatArray, columns: FloatArray) -> FloatArray:
    """Return what is left of (K, n) or (m, K, n) columns without those of the orthonormal q, taken out twice."""
    if columns.ndim == 3:  # one product of matrices instead of m small ones
        count, rows, size = columns.shape
        flat = _across(q, columns.transpose(1, 0, 2).reshape(rows, count * size))
        return flat.reshape(rows, count, size).transpose(1, 0, 2)
    once = columns - q @ (q.T @ columns)
    return np.asarray(once - q @ (q.T @ once))


def _principal(common: FloatArray, residuals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (m, q) variances along the principal directions of the common errors, and the residuals' squares.

    They are infinite and zero for directions that are none.
    """
    turned = np.swapaxes(common, -1, -2)
    variances, vectors = np.linalg.eigh(turned @ common)
    none = variances <= _NEGLIGIBLE * variances[:, -1:]
    projected = np.swapaxes(vectors, -1, -2) @ (turned @ residuals.T[..., None])
    variances = np.where(none, np.inf, variances)
    return variances, projected[..., 0] ** 2 / variances


def _balance(spread: FloatArray, along: FloatArray, rest: FloatArray, square: FloatArray, free: IntArray) -> FloatArray:
    """Return (m,) the t at which the restricted likelihood has no slope; 0 where it falls from there on.

    By Newton's steps of log t, and by bisection where one would leave what holds the root.
    """
    low = _NEGLIGIBLE * square
    falls = _slope(low, spread, along, rest, free)[0] <= 0.0
    high = square + np.max(np.where(np.isfinite(spread), spread, 0.0), axis=1)
    alone = rest / np.maximum(free, 1)  # by the directions that the common errors do not touch
    middle = np.where((alone > low) & (alone < high), alone, np.sqrt(low * high))
    for _ in range(0 if falls.all() else _BISECTIONS):
        slope, curvature = _slope(middle, spread, along, rest, free)
        rises = slope > 0.0
        low, high = np.where(rises, middle, low), np.where(rises, high, middle)
        bent = slope + middle * curvature  # of t times the slope, by log t
        step = np.where(bent < 0.0, -slope / np.where(bent < 0.0, bent, 1.0), 0.0)
        tried = middle * np.exp(np.clip(step, -_LONGEST_STEP, _LONGEST_STEP))
        # A step below the last digit stays where it is, which is low or high by now: there is the root.
        is_inside = (bent < 0.0) & ((tried > low) & (tried < high) | (tried == middle))
        before, middle = middle, np.where(is_inside, tried, np.sqrt(low * high))
        if np.all(falls | (np.abs(middle - before) <= _SETTLED * middle)):
            break
    return np.where(falls, 0.0, middle)


def _slope(
    variance: FloatArray, spread: FloatArray, along: FloatArray, rest: FloatArray, free: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return (m,) twice the slope of the restricted log-likelihood by the variance, and the slope of that."""
    inverse = 1.0 / (variance[:, None] + spread)
    share = along * inverse
    slope = np.sum((share - 1.0) * inverse, axis=1) + (rest / variance - free) / variance
    curvature = np.sum((1.0 - 2.0 * share) * inverse**2, axis=1) + (free - 2.0 * rest / variance) / variance**2
    return np.asarray(slope), np.asarray(curvature)
