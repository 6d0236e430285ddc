"""Indices of an axis of the table, told from angles as they are read back.

An axis stands a little otherwise each time it comes back to an index, or its encoder reads so; steps between indices
are far larger. Sorted angles belong to one index up to a gap that is plainly a step of the design. Where no gap is (the
angles follow no grid, or one as fine as what is read back), only angles that are equal but for rounding are one index.
"""

from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray

READ_BACK_RAD: Final = 2e-3
"""What an axis reads otherwise on coming back to an index is less: six standard deviations of a servo of 0.02°."""
_ROUNDING_RAD: Final = 1e-4
"""What an axis whose angles are set, or read by a fine encoder, reads otherwise is less."""
_OF_A_STEP: Final = 0.25
"""Of the smallest step of the design: what the angles of one index lie within, and the least that is a move."""
_WIDEST_RAD: Final = 2.0 * READ_BACK_RAD
"""Of the angles of one index: wider ones are a grid that is finer than what is read back."""


def index_of(angle_rad: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return (N,) the number of the index of every angle of (N,), and the (I,) mean angles of the indices, rad."""
    order = np.argsort(angle_rad, kind="stable")
    stood = angle_rad[order]
    number = np.empty(stood.size, dtype=np.int64)
    number[order] = np.append(0, np.cumsum(np.diff(stood) > _least_step_rad(stood)))
    return number, np.bincount(number, weights=angle_rad) / np.bincount(number)


def index_around(angle_rad: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the same of an axis that turns all round: −180° and 180° are one index. The means lie from −π to π."""
    folded = np.arctan2(np.sin(angle_rad), np.cos(angle_rad))
    stood = np.sort(folded)
    after_gap = np.argmax(np.diff(stood, append=stood[0] + 2.0 * np.pi)) + 1
    begin = stood[after_gap % stood.size]
    number, mean = index_of(np.where(folded < begin, folded + 2.0 * np.pi, folded))
    return number, np.where(mean > np.pi, mean - 2.0 * np.pi, mean)


def has_moved(angle_rad: FloatArray) -> BoolArray:
    """Return (N − 1,) whether an axis moves to another index from each of (N,) angles, in order of time, to the next.

    A whole turn is a move.
    """
    return np.asarray(np.abs(np.diff(angle_rad)) > _least_step_rad(np.sort(angle_rad)))


def is_back(angle_rad: FloatArray, before_rad: FloatArray) -> BoolArray:
    """Return whether angles are those of before, but for what an axis reads otherwise on coming back."""
    return np.asarray(np.abs(np.sin(0.5 * (angle_rad - before_rad))) < 0.5 * READ_BACK_RAD)


def _least_step_rad(sorted_rad: FloatArray) -> float:
    """Return the gap between (N,) sorted angles from which on they are of two indices."""
    gaps = np.diff(sorted_rad)
    is_step = gaps > READ_BACK_RAD
    if not is_step.any():
        return _ROUNDING_RAD
    least = _OF_A_STEP * float(gaps[is_step].min())
    first, last = np.append(True, is_step), np.append(is_step, True)
    widest = float(np.max(sorted_rad[last] - sorted_rad[first]))
    return least if widest <= min(least, _WIDEST_RAD) else _ROUNDING_RAD
