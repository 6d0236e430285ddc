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
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_BISECTIONS = 60
_NEGLIGIBLE = 1e-12
_SMALLEST_DOF = 1.0
_TOLD_APART = 3.0
"""Degrees of freedom from which on the points' own variance can be told from that of the common errors."""
_FEW_POINTS = 20
"""Degrees of freedom of the points up to which that makes a difference: with more the known common errors rule."""


@dataclass(frozen=True)
class Scatter:
    """Variance of a row of unit weight with its degrees of freedom."""

    variance: float
    dof: float
    """At least 1: where the common errors drown the points' own variance, it is no chi-square any more (it may be
    zero), and Student's factor for a part of a degree of freedom would be beyond all bounds."""


def own_scatter(basis: FloatArray, output: FloatArray, common: FloatArray, weights: FloatArray) -> Scatter:
    """From (K, P), (K,), (K, q) and (K,); NaN where no degrees of freedom are left."""
    dof = basis.shape[0] - basis.shape[1]
    if dof <= 0:
        return Scatter(float("nan"), float("nan"))
    root = np.sqrt(weights)
    q, _ = np.linalg.qr(root[:, None] * basis)
    residuals = _across(q, root * output)
    square = float(residuals @ residuals)
    if common.shape[1] == 0 or square == 0.0:
        return Scatter(square / dof, float(dof))
    spread, along = _principal(_across(q, root[:, None] * common), residuals)
    rest = max(square - float(along.sum()), 0.0)
    variance = _balance(spread, along, rest, square, dof)
    information = float(np.sum((variance / (variance + spread)) ** 2)) if variance > 0.0 else 0.0
    told = information + dof - spread.size
    if told < _TOLD_APART and dof <= _FEW_POINTS:
        return Scatter(square / dof, float(dof))
    return Scatter(variance, max(told, _SMALLEST_DOF))


def _across(q: FloatArray, columns: FloatArray) -> FloatArray:
    """What is left of columns when those of the orthonormal q are taken out, twice for rounding."""
    once = columns - q @ (q.T @ columns)
    return np.asarray(once - q @ (q.T @ once))


def _principal(common: FloatArray, residuals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Variances along the principal directions of the common errors, and the residuals' squares along them."""
    variances, vectors = np.linalg.eigh(common.T @ common)
    kept = variances > _NEGLIGIBLE * variances[-1]
    along = (residuals @ common @ vectors[:, kept]) ** 2 / variances[kept]
    return variances[kept], along


def _balance(spread: FloatArray, along: FloatArray, rest: float, square: float, dof: int) -> float:
    """The t at which the restricted likelihood has no slope; 0 where it falls from there on."""
    low, high = _NEGLIGIBLE * square, square + float(spread[-1])
    if _slope(low, spread, along, rest, dof) <= 0.0:
        return 0.0
    for _ in range(_BISECTIONS):
        middle = float(np.sqrt(low * high))
        if _slope(middle, spread, along, rest, dof) > 0.0:
            low = middle
        else:
            high = middle
    return float(np.sqrt(low * high))


def _slope(variance: float, spread: FloatArray, along: FloatArray, rest: float, dof: int) -> float:
    """Twice the slope of the restricted log-likelihood by the variance."""
    whole = variance + spread
    return float(np.sum(along / whole**2 - 1.0 / whole)) + (rest / variance - (dof - spread.size)) / variance
