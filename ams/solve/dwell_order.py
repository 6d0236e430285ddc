"""In which order rows were taken, and where in its replication each of them stands."""

from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.inputs.indices import are_back
from ams.remembered import known, remembered
from ams.solve.layout import Layout

SETTLES_IN: Final = 1.0 / 12.0
"""Of a replication's dwells: the time constant of a transient. It has 0.87 and more in common with those from a third
of it to three times it."""


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
