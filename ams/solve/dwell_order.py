"""In which order rows were taken, and where in its replication each of them stands."""

from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.inputs.indices import are_back, has_moved
from ams.remembered import known, remembered
from ams.solve.layout import Layout

SETTLES_IN: Final = 1.0 / 12.0
"""Of a replication's dwells: the time constant of a transient. It has 0.87 and more in common with those from a third
of it to three times it."""
_AT_REST: Final = 1e-3
"""Of the fastest turn: slower is none."""
_SAME_AXIS: Final = 0.99
"""Cosine between the axes of two turns about one."""
_STANDS: Final = 0.1
"""Of a turn: an axis that takes less of it stands."""


@remembered(16)
def rows_in_time(time_s: FloatArray | None, rows: int) -> IntArray:
    """Return the rows in the order of time; without times the order of the rows stands for it.

    Packages have times of their own and mostly one order, which what depends on it alone knows as one.
    """
    return known(np.arange(rows) if time_s is None else np.argsort(time_s, kind="stable"))


def turns_in_replication(order: IntArray, replication: IntArray, replications: int) -> tuple[IntArray, IntArray]:
    """Return (N,) the place of each row in its replication, as time has it, and (n,) the rows of each replication."""
    sizes = np.bincount(replication, minlength=replications)
    together = order[np.argsort(replication[order], kind="stable")]
    turn = np.empty(order.size, dtype=np.int64)
    turn[together] = np.arange(order.size) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return turn, sizes


@remembered(16)
def order_repeats(order: IntArray, layout: Layout) -> bool:
    """Return whether every replication visits all points in the same order."""
    turn, _ = turns_in_replication(order, layout.replication, layout.replications)
    by_point = np.empty((layout.replications, layout.points), dtype=np.int64)
    by_point[layout.replication, layout.point] = turn
    return bool(np.all(by_point == by_point[0]))


@remembered(16)
def attitudes_repeat(layout: Layout, *angles_rad: FloatArray) -> bool:
    """Return whether every replication has all points at the same (N,) angles, however the rows are sorted.

    But for what an axis that comes back reads otherwise: no effect of the order is estimated from so little.
    """
    if not layout.is_complete:
        return False
    by_dwell = np.empty((len(angles_rad), layout.rows))
    by_dwell[:, layout.dwell] = angles_rad
    return all(are_back(angle.reshape(layout.replications, layout.points)) for angle in by_dwell)


@remembered(16)
def settling_of_rows(order: IntArray, layout: Layout) -> FloatArray:
    """Return the (N,) column of a transient at the start of every replication: one at its first dwell, fading."""
    turn, sizes = turns_in_replication(order, layout.replication, layout.replications)
    return np.asarray(np.exp(-turn / (SETTLES_IN * sizes[layout.replication])))


def moves_of_slower_axes(*angles_rad: FloatArray) -> BoolArray:
    """Return (N − 1,) whether an axis moves, other than the one that moves most often, after each of (N,) dwells."""
    moves = sorted((has_moved(angle) for angle in angles_rad), key=np.count_nonzero)
    return np.asarray(np.any(moves[:-1], axis=0))


@remembered(16)
def rows_by_laying(
    order: IntArray, replication: IntArray, angles_rad: FloatArray, euler_rate_rad_s: FloatArray | None
) -> IntArray:
    """Return the (N,) number of the run of rows, one after the other in time, that each row stands in; −1: in none.

    A run is of one replication, turns about one axis, or goes from angle to angle of the axis that moves most often,
    while the other axes stand. A rest belongs to it where it lies between two turns of it. ``order``: (N,) the rows as
    time has them; ``angles_rad`` and ``euler_rate_rad_s``: (N, 3) of pitch, yaw and roll.
    """
    together = order[np.argsort(replication[order], kind="stable")]
    angles_rad, replication = angles_rad[together], replication[together]
    if euler_rate_rad_s is None:
        moving, is_end = np.arange(order.size), moves_of_slower_axes(*angles_rad.T)
    else:
        rates = euler_rate_rad_s[together]
        speed = np.linalg.norm(rates, axis=1)
        moving = np.flatnonzero(speed > _AT_REST * speed.max())
        is_end = _lays_otherwise(rates[moving] / speed[moving, None], angles_rad[moving])
    is_end |= np.diff(replication[moving]) != 0
    number = np.concatenate([[-1], np.cumsum(np.append(0, is_end))[: moving.size], [-2]])
    position = np.arange(order.size)
    before = number[np.searchsorted(moving, position, side="right")]
    run = np.empty(order.size, dtype=np.int64)
    run[together] = np.where(before == number[np.searchsorted(moving, position) + 1], before, -1)
    return run


def _lays_otherwise(axis: FloatArray, angles_rad: FloatArray) -> BoolArray:
    """Return (M − 1,) whether a turn is about another axis than the one before it, or others stand at other angles.

    ``axis``: (M, 3) of length one, in pitch, yaw and roll as ``angles_rad`` (M, 3).
    """
    if len(axis) == 0:
        return np.zeros(0, dtype=bool)
    is_other = np.abs(np.einsum("ma,ma->m", axis[1:], axis[:-1])) < _SAME_AXIS
    moves = np.stack([has_moved(angle) for angle in angles_rad.T], axis=1)
    return np.asarray(is_other | np.any(moves & (np.abs(axis[1:]) < _STANDS), axis=1))
