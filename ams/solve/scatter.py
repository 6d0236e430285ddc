"""The variance that points have of their own, beside errors that many of them share.

Rows are y = X c + G δ + e with known columns G (unit variance) and e of unknown variance t over the row's weight. The
estimate is that of restricted maximum likelihood (Patterson and Thompson 1971): where G is large it looks along the
directions that G does not touch, which a plain difference of mean squares cannot.

With a handful of points there may be no such direction (pitch alone: every point has an index of its own). Then the
likelihood is often largest at t = 0, and intervals that believe it hold the truth in half of the campaigns. There the
whole scatter counts as the points' own: wider than need be, by as much as G is counted twice.
"""

from dataclasses import dataclass

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray

_BISECTIONS = 10
"""After which a slope of twelve decades is known to 3 %: no likelihood has two tops so near one another."""
_STEPS = 60
"""Of Newton inside that: three or four do; a step that leaves the bracket is a bisection."""
_ROUNDING = 4.0 * float(np.finfo(float).eps)
_NEGLIGIBLE = 1e-12
_SMALLEST_DOF = 1.0
_TINY = float(np.finfo(float).tiny)
_TOLD_APART = 3.0
"""Degrees of freedom from which on the points' own variance can be told from that of the common errors."""
FEW_POINTS = 20
"""Degrees of freedom of the points up to which that makes a difference where replications tell the precision."""


@dataclass(frozen=True)
class Scatter:
    """Variances of a row of unit weight of m outputs, with their degrees of freedom."""

    variance: FloatArray
    """(m,)"""
    dof: FloatArray
    """(m,) at least 1: where the common errors drown the points' own variance, it is no chi-square any more (it may be
    zero), and Student's factor for a part of a degree of freedom would be beyond all bounds."""


def own_scatter(
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
    if common.shape[-1] == 0 or not square.any():
        return whole
    spread, along = _principal(_across(q, root * common), residuals)
    directions = np.isfinite(spread).sum(axis=1)
    free = dof - directions
    rest = np.maximum(square - along.sum(axis=1), 0.0)
    variance = _balance(spread, along, rest, np.where(square > 0.0, square, 1.0), free)
    return _believed(variance, spread, whole, free, few_points, square == 0.0)


def expected_scatter(
    basis: FloatArray, variance: FloatArray, common: FloatArray, weights: FloatArray, few_points: float = np.inf
) -> Scatter:
    """Return what :func:`own_scatter` finds on the average where rows of unit weight have the (m,) variance."""
    dof, size = basis.shape[0] - basis.shape[1], variance.size
    if dof <= 0:
        return Scatter(np.full(size, np.nan), np.full(size, np.nan))
    whole = Scatter(variance, np.full(size, float(dof)))
    if common.shape[-1] == 0:
        return whole
    root = np.sqrt(weights)[:, None]
    q, _ = np.linalg.qr(root * basis)
    across = _across(q, root * common)
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
    told = np.sum((variance[:, None] / np.maximum(variance[:, None] + spread, _TINY)) ** 2, axis=1) + free
    drowned = (told < _TOLD_APART) & (whole.dof <= few_points) | nothing
    return Scatter(
        np.where(drowned, whole.variance, variance), np.where(drowned, whole.dof, np.maximum(told, _SMALLEST_DOF))
    )


def _across(q: FloatArray, columns: FloatArray) -> FloatArray:
    """Return what is left of (…, K, n) columns when those of the orthonormal q are taken out, twice for rounding."""
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
    """Return (m,) the t at which the restricted likelihood has no slope; 0 where it falls from there on."""
    low = _NEGLIGIBLE * square
    falls = _slope(low, spread, along, rest, free)[0] <= 0.0
    high = square + np.max(np.where(np.isfinite(spread), spread, 0.0), axis=1)
    middle = np.sqrt(low * high)
    for step in range(_BISECTIONS + _STEPS):
        slope, bend = _slope(middle, spread, along, rest, free)
        rises = slope > 0.0
        low, high = np.where(rises, middle, low), np.where(rises, high, middle)
        before, middle = middle, np.sqrt(low * high)
        if step < _BISECTIONS:
            continue
        newton = before - slope / np.where(bend < 0.0, bend, -1.0)
        inside = (bend < 0.0) & (newton >= low) & (newton <= high)
        middle = np.where(inside, newton, middle)
        if np.all((abs(middle - before) <= _ROUNDING * before) & inside | (high - low <= _ROUNDING * high) | falls):
            break
    return np.where(falls, 0.0, middle)


def _slope(
    variance: FloatArray, spread: FloatArray, along: FloatArray, rest: FloatArray, free: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return (m,) twice the slope of the restricted log-likelihood by the variance, and how that bends."""
    one = 1.0 / (variance[:, None] + spread)
    scattered, left = along * one * one, rest / variance
    slope = np.add.reduce(scattered - one, axis=1) + (left - free) / variance
    bend = np.add.reduce((one - 2.0 * scattered) * one, axis=1) + (free - 2.0 * left) / variance**2
    return slope, bend
