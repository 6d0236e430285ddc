"""Inner products of what a change adds to a run, at every place of it and between the places of a coarse grid.

They depend on the design alone, and are computed once for all outputs and packages that share it.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.remembered import remembered

_LEAST_ASIDE: Final = 8
_LEAST_SHARE: Final = 0.03
"""Of the dwells on either side of a change: fewer are single dwells that are wrong."""
_PARTS: Final = 24
"""Of the run, or about as many, as many in every replication: what came back is looked for between them."""
NOTHING: Final = 1e-9
"""Of the largest: less is rounding."""


@dataclass(frozen=True)
class Paths:
    """What is left of products of patterns when a change comes before each place, for q pairs of patterns."""

    squares: FloatArray
    """(C, q) inner products of both patterns from the place on, of the places with dwells enough on either side."""
    overlaps: FloatArray
    """(C − 1, q) the same of a place and the one after it."""
    first: int
    """Of the places."""
    travelled: float
    """By the unit vectors of each pattern with itself, all of the same weight."""


@dataclass(frozen=True)
class Intervals:
    """The same of q pairs of patterns when a change comes before one place and goes before another."""

    squares: FloatArray
    """(I, q)"""
    begin: IntArray
    """(I,) in the order of time."""
    end: IntArray
    """(I,) the first dwell after it."""


@remembered(32)
def paths_of(point: IntArray, order: IntArray, patterns: FloatArray, pairs: tuple[tuple[int, int], ...]) -> Paths:
    """Return the inner products for every place, each column less its mean over the rows of a point.

    One place further back in time adds one row r, of point k with n rows: with A and B the sums of both patterns over
    the rows of k that were there before, the product grows by ab − (aB + Ab + ab)/n, and what the row has in common
    with those before it is −(aB + Ab)/2n.
    """
    readings = np.bincount(point)[point[order]]
    pattern_of = patterns.reshape(order.size, -1)[order]
    before = _sums_of_same_point_after(point[order], pattern_of)
    first, second = (np.array([pair[side] for pair in pairs]) for side in (0, 1))
    a, b = pattern_of[:, first], pattern_of[:, second]
    crossed = (a * before[:, second] + before[:, first] * b) / readings[:, None]
    gained = a * b * (1.0 - 1.0 / readings)[:, None] - crossed
    squares = np.cumsum(gained[::-1], axis=0)[::-1]
    overlaps = squares[1:] - 0.5 * crossed[:-1]
    aside = least_aside(order.size)
    judged, stepped = slice(aside, order.size - aside + 1), slice(aside, order.size - aside)
    alike = np.array([1.0 if first == other else 0.0 for first, other in pairs])
    kept, met = squares[judged].copy(), overlaps[stepped].copy()
    return Paths(kept, met, aside, travelled(kept @ alike, met @ alike))


def least_aside(rows: int) -> int:
    """Return the fewest dwells on either side of a change, or inside one that came back."""
    return max(_LEAST_ASIDE, int(_LEAST_SHARE * rows))


@remembered(32)
def intervals_of(
    point: IntArray, order: IntArray, patterns: FloatArray, pairs: tuple[tuple[int, int], ...]
) -> Intervals:
    """Return the inner products for all pairs of places of a coarse grid, each column less its mean over a point.

    With T(i, k) the sums of a pattern over the rows of point k in part i of the run, the product of parts i and j is
    Σ ab where they are one, less Σₖ Tᵃ(i, k) Tᵇ(j, k)/nₖ; that of an interval is the sum over the parts in it.
    """
    readings = np.bincount(point)
    replications = int(readings.max())
    parts = replications * max(1, round(_PARTS / replications)) if replications <= 2 * _PARTS else _PARTS
    bounds = np.round(np.linspace(0.0, order.size, parts + 1)).astype(np.int64)
    pattern_of, point_of = patterns.reshape(order.size, -1)[order], point[order]
    part_of = np.repeat(np.arange(parts), np.diff(bounds))
    cell = part_of * readings.size + point_of
    sums = [np.bincount(cell, column, parts * readings.size).reshape(parts, -1) for column in pattern_of.T]
    begin, end = np.triu_indices(parts - 1, 1)
    aside = least_aside(order.size)
    first, last = bounds[begin + 1], bounds[end + 1]
    is_judged = (last - first >= aside) & (first >= aside) & (last <= order.size - aside)
    squares = []
    for a, b in pairs:
        products = np.diag(np.bincount(part_of, pattern_of[:, a] * pattern_of[:, b], parts))
        upto = np.zeros((parts + 1, parts + 1))
        upto[1:, 1:] = (products - (sums[a] / np.maximum(readings, 1)) @ sums[b].T).cumsum(axis=0).cumsum(axis=1)
        i, j = begin[is_judged] + 1, end[is_judged] + 1
        squares.append(upto[j, j] - upto[i, j] - upto[j, i] + upto[i, i])
    return Intervals(np.column_stack(squares), first[is_judged], last[is_judged])


def _sums_of_same_point_after(point: IntArray, pattern_of: FloatArray) -> FloatArray:
    """Return for each of the rows in time the (N, p) sums over the later rows of the same point."""
    by_point = np.lexsort((-np.arange(point.size), point))  # of a point the last comes first
    sums = np.cumsum(pattern_of[by_point], axis=0) - pattern_of[by_point]
    is_first = np.diff(point[by_point], prepend=-1) != 0
    found = np.empty(sums.shape)
    found[by_point] = sums - sums[is_first][np.cumsum(is_first) - 1]
    return found


def travelled(squares: FloatArray, overlaps: FloatArray) -> float:
    """Return the angle that the unit vectors of the columns travel from place to place."""
    length = np.sqrt((squares[1:] * squares[:-1]).clip(min=0.0))
    is_there = length > NOTHING * squares.max(initial=0.0)
    return float(np.arccos(np.clip(overlaps[is_there] / length[is_there], -1.0, 1.0)).sum())
