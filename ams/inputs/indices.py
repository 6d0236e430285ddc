"""Indices of an axis of the table, told from angles as they are read back.

An axis stands a little otherwise each time it comes back to an index, or its encoder reads so; steps between indices
are far larger. Sorted angles are cut at every gap above a limit; of all limits that one is taken which leaves the gaps
widest beside the scatter of what stands together, which is no smaller than the steps that angles are read in have it:
a dwell that was off stays with the index it is nearest to, or is one by itself, and changes nothing for the others.
Where no gap is plain (the angles follow no grid, or one as fine as what is read back), only angles that are equal but
for rounding are one index.
"""

from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.inputs.common_step import common_step
from ams.remembered import remembered
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION

_ROUNDING_RAD: Final = 1e-4
"""What an axis whose angles are set, or read by a fine encoder, reads otherwise is less."""
_EXACT_RAD: Final = 1e-9
"""Less is no scatter but the last digits of a number."""
_FINEST_COUNT_RAD: Final = 1e-5
_COARSEST_COUNT_RAD: Final = float(np.deg2rad(0.051))
"""Angles that are whole steps of this size apart may be read in them: then a reading may be the next one by chance."""
_MOST_COUNTS: Final = 1.3
"""Standard deviation of such readings, in steps, of one index; what spreads over more is a fine grid that was meant."""
_WIDEST_SCATTER_RAD: Final = 2e-3
"""Standard deviation of what an index is read at: 0.05° of a servo, and dwells that were off by 0.3°."""
_STEP_RAD: Final = float(np.deg2rad(1.0))
"""A gap as wide as the finest grid is plain; by more it is no plainer."""
_PLAIN: Final = 6.0
"""Scatters to the smallest gap. Of angles that follow no grid it is √6: what is paired below a gap is uniform to it."""
_NEXT: Final = 1.5
"""Of a gap: the next wider one, where between them may be the limit."""
_MOST: Final = 0.5
"""Of what stands together at the widest limit: as much does at any. Two that are alike by chance tell no scatter."""
_BACK_RAD: Final = 2e-3
"""Whatever the scatter: an axis that is read by less otherwise is back."""
_FARTHEST_BACK_RAD: Final = float(np.deg2rad(0.5))
"""Of a dwell that was off; more is another attitude, as where observations are read."""
_BACK: Final = 6.0
"""Standard deviations of a difference of two angles that are read back: one in 10⁸ of them."""
_STRAYS: Final = 0.05
"""Of all angles, or one of them: as many may be off."""


def index_of(angle_rad: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return (N,) the number of the index of every angle of (N,), and the (I,) mean angles of the indices, rad."""
    order = np.argsort(angle_rad, kind="stable")
    gaps = np.diff(angle_rad[order])
    number = np.empty(order.size, dtype=np.int64)
    number[order] = np.append(0, np.cumsum(gaps > _widest_within_rad(angle_rad[order], gaps)))
    return number, np.bincount(number, weights=angle_rad) / np.bincount(number)


@remembered(32)
def index_around(angle_rad: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the same of an axis that turns all round: −180° and 180° are one index. The means lie from −π to π."""
    folded = np.arctan2(np.sin(angle_rad), np.cos(angle_rad))
    stood = np.sort(folded)
    after_gap = np.argmax(np.diff(stood, append=stood[0] + 2.0 * np.pi)) + 1
    begin = stood[after_gap % stood.size]
    number, mean = index_of(np.where(folded < begin, folded + 2.0 * np.pi, folded))
    return number, np.where(mean > np.pi, mean - 2.0 * np.pi, mean)


def standing_at(angle_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (N, i) 1 where an angle stands at an index and 0 elsewhere, and (i,) the means of the indices, radians.

    ``angle_rad``: (N,) of an axis that turns all round.
    """
    index, mean_rad = index_around(angle_rad)
    return np.eye(mean_rad.size)[index], mean_rad


def has_moved(angle_rad: FloatArray) -> BoolArray:
    """Return (N − 1,) whether an axis moves to another index from each of (N,) angles, in order of time, to the next.

    A whole turn is a move. An axis that is read within one turn has made none: where it is read at either end, it
    stands where its encoder begins anew.
    """
    is_within_a_turn = bool(np.ptp(angle_rad) < 2.0 * np.pi - _EXACT_RAD)
    number, _ = index_around(angle_rad) if is_within_a_turn else index_of(angle_rad)
    return np.asarray(np.diff(number) != 0)


def are_back(angle_rad: FloatArray) -> bool:
    """Return whether an axis was at the same (n, K) angles in each of n replications, but for what it reads otherwise.

    That is known by the scatter of their differences; what a whole replication differs by is none. Few may be off.
    """
    if len(angle_rad) == 1:
        return True
    turn = angle_rad - angle_rad[0]
    turn = np.arctan2(np.sin(turn), np.cos(turn))
    about = np.abs(turn[1:] - np.median(turn[1:], axis=1, keepdims=True))
    limit = max(_BACK_RAD, _BACK * SD_PER_MEDIAN_DEVIATION * float(np.median(about)))
    away = np.abs(turn - np.sort(turn, axis=0)[(len(turn) - 1) // 2])
    off = np.count_nonzero(away >= min(limit, _FARTHEST_BACK_RAD))
    return bool(away.max() < _FARTHEST_BACK_RAD and off <= max(1.0, _STRAYS * turn[1:].size))


def _widest_within_rad(sorted_rad: FloatArray, gaps: FloatArray) -> float:
    """Return the gap between (N,) sorted angles above which they are of two indices; ``gaps``: (N − 1,)."""
    limits = np.append(_ROUNDING_RAD, np.sort(gaps[gaps > _ROUNDING_RAD]))
    next_wider = np.append(limits[1:], np.inf)
    may_be = next_wider >= _NEXT * limits
    may_be[0] = True
    count_rad = _count_rad(sorted_rad, gaps)
    least = max(count_rad / float(np.sqrt(12.0)), _EXACT_RAD)
    most = min(_MOST_COUNTS * count_rad, _WIDEST_SCATTER_RAD) if count_rad > 0.0 else _WIDEST_SCATTER_RAD
    found = list[tuple[float, int, float]]()
    for limit, gap in zip(limits[may_be].tolist(), next_wider[may_be].tolist(), strict=True):
        scatter, dof = _scatter_rad(sorted_rad, gaps > limit)
        if dof and scatter < most:
            found.append((min(gap, _STEP_RAD) / max(scatter, least), dof, limit))
    enough = _MOST * max((dof for _, dof, _ in found), default=0)
    plain, _, limit = max((each for each in found if each[1] >= enough), default=(0.0, 0, _ROUNDING_RAD))
    return limit if plain >= _PLAIN else _ROUNDING_RAD


def _count_rad(sorted_rad: FloatArray, gaps: FloatArray) -> float:
    """Return the steps that angles may be read in; 0 where they are no whole steps apart, or too large ones."""
    smallest = gaps[gaps > _EXACT_RAD].min(initial=np.inf)
    if not _FINEST_COUNT_RAD < smallest <= _COARSEST_COUNT_RAD:
        return 0.0
    count = common_step(sorted_rad, _EXACT_RAD)
    return count if count > _FINEST_COUNT_RAD else 0.0


def _scatter_rad(sorted_rad: FloatArray, is_step: BoolArray) -> tuple[float, int]:
    """Return the standard deviation within what (N − 1,) steps part, and its degrees of freedom."""
    number = np.append(0, np.cumsum(is_step))
    count = np.bincount(number)
    left = sorted_rad - (np.bincount(number, weights=sorted_rad) / count)[number]
    dof = number.size - count.size
    return float(np.sqrt(left @ left / max(dof, 1))), dof
