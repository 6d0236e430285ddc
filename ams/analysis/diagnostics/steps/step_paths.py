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
Pairs = tuple[tuple[int, int], ...]
"""Of the columns of a pattern: which products of two are weighed."""


@dataclass(frozen=True)
class Paths:
    """What is left of products of patterns when a change comes before each place, for q pairs of patterns."""

    squares: FloatArray
    """(q, C) inner products of both patterns from the place on, of the places with dwells enough on either side."""
    overlaps: FloatArray
    """(q, C − 1) the same of a place and the one after it."""
    first: int
    """Of the places."""
    travelled: float
    """By the unit vectors of each pattern with itself, all of the same weight."""


@dataclass(frozen=True)
class Intervals:
    """The same of q pairs of patterns when a change comes before one place and goes before another."""

    squares: FloatArray
    """(q, I)"""
    bounds: IntArray
    """(B,) in the order of time: the first dwell after each place of the coarse grid."""
    begin: IntArray
    """(I,) which of the bounds."""
    end: IntArray
    """(I,)"""


@dataclass(frozen=True)
class PatternInTime:
    """What p columns of a pattern put into a run, dwell by dwell, and the products of what is left of them."""

    columns: FloatArray
    """(p, N) in the order of time."""
    first: IntArray
    """(q,) of the columns, on one side of each pair."""
    second: IntArray
    """(q,) on the other."""
    counts: FloatArray
    """(q,) how often a pair stands in the sum over all."""
    paths: Paths
    intervals: Intervals
    is_seen: bool
    """Whether replications differ by it at any place."""

    def weights_of(self, form: FloatArray) -> FloatArray:
        """Return the (q,) weights of the pairs in a quadratic form (p, p) of the columns."""
        return np.asarray(form[self.first, self.second] * self.counts)


@remembered(32)
def in_time(point: IntArray, order: IntArray, pattern: FloatArray, pairs: Pairs) -> PatternInTime:
    """Return (N,) or (N, p) patterns of the rows in the order of time, with the products of the pairs that are weighed.

    ``point`` (N,): of the rows; ``order`` (N,): the rows in time.
    """
    columns = np.ascontiguousarray(pattern.reshape(order.size, -1)[order].T)
    first, second = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
    paths, intervals = _paths_of(point[order], columns, first, second), _intervals_of(point[order], columns, pairs)
    is_seen = bool(paths.squares.max(initial=0.0) > NOTHING * pattern.size)
    return PatternInTime(columns, first, second, np.where(first == second, 1.0, 2.0), paths, intervals, is_seen)


def _paths_of(point: IntArray, columns: FloatArray, first: IntArray, second: IntArray) -> Paths:
    """Return the inner products for every place, each column less its mean over the rows of a point.

    One place further back in time adds one row r, of point k with n rows: with A and B the sums of both patterns over
    the rows of k that were there before, the product grows by ab − (aB + Ab + ab)/n, and what the row has in common
    with those before it is −(aB + Ab)/2n.
    """
    rows, readings = point.size, np.bincount(point)[point]
    before = _sums_of_same_point_after(point, columns)
    a, b = columns[first], columns[second]
    crossed = (a * before[second] + before[first] * b) / readings
    gained = a * b * (1.0 - 1.0 / readings) - crossed
    squares = np.cumsum(gained[:, ::-1], axis=1)[:, ::-1]
    overlaps = squares[:, 1:] - 0.5 * crossed[:, :-1]
    aside = least_aside(rows)
    kept, met = squares[:, aside : rows - aside + 1].copy(), overlaps[:, aside : rows - aside].copy()
    alike = (first == second).astype(float)
    return Paths(kept, met, aside, travelled(alike @ kept, alike @ met))


def least_aside(rows: int) -> int:
    """Return the fewest dwells on either side of a change, or inside one that came back."""
    return max(_LEAST_ASIDE, int(_LEAST_SHARE * rows))


def _intervals_of(point: IntArray, columns: FloatArray, pairs: Pairs) -> Intervals:
    """Return the inner products for all pairs of places of a coarse grid, each column less its mean over a point.

    With T(i, k) the sums of a pattern over the rows of point k in part i of the run, the product of parts i and j is
    Σ ab where they are one, less Σₖ Tᵃ(i, k) Tᵇ(j, k)/nₖ; that of an interval is the sum over the parts in it.
    """
    rows, readings = point.size, np.bincount(point)
    replications = int(readings.max())
    parts = replications * max(1, round(_PARTS / replications)) if replications <= 2 * _PARTS else _PARTS
    bounds = np.round(np.linspace(0.0, rows, parts + 1)).astype(np.int64)
    part_of = np.repeat(np.arange(parts), np.diff(bounds))
    cell = part_of * readings.size + point
    sums = [np.bincount(cell, column, parts * readings.size).reshape(parts, -1) for column in columns]
    begin, end = np.triu_indices(parts - 1, 1)
    aside = least_aside(rows)
    first, last = bounds[begin + 1], bounds[end + 1]
    is_judged = (last - first >= aside) & (first >= aside) & (last <= rows - aside)
    i, j = begin[is_judged] + 1, end[is_judged] + 1
    squares = []
    for a, b in pairs:
        products = np.diag(np.bincount(part_of, columns[a] * columns[b], parts))
        upto = np.zeros((parts + 1, parts + 1))
        upto[1:, 1:] = (products - (sums[a] / np.maximum(readings, 1)) @ sums[b].T).cumsum(axis=0).cumsum(axis=1)
        squares.append(upto[j, j] - upto[i, j] - upto[j, i] + upto[i, i])
    return Intervals(np.stack(squares), bounds, i, j)


def _sums_of_same_point_after(point: IntArray, columns: FloatArray) -> FloatArray:
    """Return for each of the rows in time the (p, N) sums over the later rows of the same point."""
    by_point = np.lexsort((-np.arange(point.size), point))  # of a point the last comes first
    sums = np.cumsum(columns[:, by_point], axis=1) - columns[:, by_point]
    is_first = np.diff(point[by_point], prepend=-1) != 0
    found = np.empty(sums.shape)
    found[:, by_point] = sums - sums[:, is_first][:, np.cumsum(is_first) - 1]
    return found


def travelled(squares: FloatArray, overlaps: FloatArray) -> float:
    """Return the angle that the unit vectors of the columns travel from place to place."""
    length = np.sqrt((squares[1:] * squares[:-1]).clip(min=0.0))
    is_there = length > NOTHING * squares.max(initial=0.0)
    cosines = np.divide(overlaps, length, out=np.ones(length.size), where=is_there)
    return float(np.arccos(cosines.clip(-1.0, 1.0, out=cosines), out=cosines).sum())
