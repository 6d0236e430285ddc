"""Which of many candidate points determine a model best: an exchange from a start by chance to where no swap helps.

Each point in turn is taken out of the design and the candidate put in that serves best (Fedorov 1972, in the order of
Cook and Nachtsheim 1980), until a whole round changes nothing. *D* makes the determinant of the moments XᵀX largest,
that is the volume of the parameters' confidence region smallest; *I* makes the mean variance of a prediction over a
region smallest, trace((XᵀX)⁻¹ M) with M the mean of xxᵀ over it. Several starts, the best is kept; the same seed gives
the same design.
"""

from collections.abc import Sequence

import numpy as np

from ams.arrays import FloatArray
from procedures.errors import PlanError

STARTS = 4
MOST_ROUNDS = 50
_GAIN = 1e-9
"""Smaller relative gains are rounding."""
_RIDGE = 1e-9
"""Of the mean moment: a start by chance may not determine everything yet."""


def exchanged(
    candidates: FloatArray, count: int, chance: np.random.Generator, region: FloatArray | None, kept: Sequence[int] = ()
) -> list[int]:
    """Return ``count`` different rows of (C, P) candidates, rising, the ``kept`` ones among them.

    ``region``: (P, P) M of I-optimality; None: D-optimal.

    Raises: PlanError where no such rows determine every column.
    """
    best: tuple[float, list[int]] | None = None
    for _ in range(STARTS):
        free = np.setdiff1d(np.arange(len(candidates)), kept)
        start = [*kept, *chance.permutation(free)[: count - len(kept)].tolist()]
        found = _improved(candidates, start, len(kept), region)
        score = criterion(candidates[found], region)
        if best is None or score < best[0]:
            best = score, found
    assert best is not None
    if not np.isfinite(best[0]) or np.linalg.matrix_rank(candidates[best[1]]) < candidates.shape[1]:
        raise PlanError(
            f"{count} points of this lattice do not determine {candidates.shape[1]} terms; no design was made; give "
            'more points or angles, or terms = "linear"'
        )
    return sorted(best[1])


def criterion(rows: FloatArray, region: FloatArray | None) -> float:
    """Return what is made small: minus the logarithm of the determinant, or the mean variance over the region."""
    moments = rows.T @ rows
    if region is None:
        sign, logarithm = np.linalg.slogdet(moments)
        return float(-logarithm) if sign > 0 else float("inf")
    return float(np.trace(np.linalg.solve(moments + _ridge(moments), region)))


def _improved(candidates: FloatArray, design: list[int], kept: int, region: FloatArray | None) -> list[int]:
    design = list(design)
    for _ in range(MOST_ROUNDS):
        changed = False
        for index in range(kept, len(design)):
            others = np.delete(np.array(design), index)
            moments = candidates[others].T @ candidates[others]
            gains = _gains(candidates, np.linalg.inv(moments + _ridge(moments)), region)
            mine = gains[design[index]]
            gains[others] = -np.inf
            other = int(np.argmax(gains))
            if gains[other] > mine + _GAIN * abs(mine):
                design[index], changed = other, True
        if not changed:
            break
    return design


def _ridge(moments: FloatArray) -> FloatArray:
    return np.asarray(_RIDGE * np.trace(moments) / len(moments) * np.eye(len(moments)))


def _gains(candidates: FloatArray, inverse: FloatArray, region: FloatArray | None) -> FloatArray:
    """Return what each candidate adds to a design with that inverse of its moments: the more, the better."""
    turned = candidates @ inverse
    variance = np.einsum("cp,cp->c", turned, candidates)
    if region is None:
        return np.asarray(variance)
    return np.asarray(np.einsum("cp,pq,cq->c", turned, region, turned) / (1.0 + variance))
