"""What the dwells before and the last move of an axis leave at a point, alike where the order is always the same.

A multiplexer, a relay or a dielectric that keeps a part of what it read last adds some of the force *across* the
nominal axis at the dwell before: in a raster that is a turned copy of the force there is now, and passes for a
sensitivity but where rows begin. Heat of a motor, a cable that twists or air that is stirred fade from the first dwell
after a move of the axis that moves seldom: once a row, in every replication alike.
"""

from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import MEMORIES, OF_THE_ORDER
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time import previous_attitude
from ams.analysis.diagnostics.sensed_force import Accelerometer, sensed_force
from ams.analysis.diagnostics.time_order import means_of_points
from ams.arrays import FloatArray, IntArray
from ams.frames import AXES
from ams.inputs.indices import has_moved
from ams.remembered import remembered
from ams.solve.dwell_order import settling_of_rows
from ams.solve.layout import Layout

_FADES_IN: Final = 2.0
"""Dwells. It has 0.85 and more in common with those from a third of it to three times it, in rows of a dozen."""
_SHORTEST_ROW: Final = 3.0
"""Dwells to a move, on average."""


def left_by_order(evidence: Evidence, base: Accelerometer | None, spared: int) -> FloatArray:
    """Return (K, 8) what the order of the points leaves at them, in the order of the columns that are tested.

    ``base``: None of what follows no force. ``spared``: points more than all columns need; nothing is asked of
    fewer, of the memories and the settling where those that came last are not to be spared either.
    """
    return _left_by_order(
        evidence.rows.time_s,
        evidence.rows.pitch_rad,
        evidence.rows.roll_rad,
        evidence.time_order,
        evidence.layout,
        None if base is None else sensed_force(base, evidence.rows),
        "" if base is None else base.nominal_axis,
        spared + len(OF_THE_ORDER) >= 0,
        spared >= 0,
    )


@remembered(16)
def _left_by_order(
    time_s: FloatArray | None,
    pitch_rad: FloatArray,
    roll_rad: FloatArray,
    order: IntArray,
    layout: Layout,
    force: FloatArray | None,
    nominal_axis: str,
    has_first: bool,
    has_last: bool,
) -> FloatArray:
    memories, across = np.zeros((layout.points, len(MEMORIES))), np.zeros((layout.points, len(AXES)))
    if force is not None:
        shown = previous_attitude.memories_in_order(time_s, order, force[:, AXES.index(nominal_axis)].copy())
        memories = means_of_points(layout, shown)
        across = _held_across(force, order, layout, nominal_axis)
    settles = means_of_points(layout, settling_of_rows(order, layout))
    moved = means_of_points(layout, _after_moves(pitch_rad, roll_rad, order, layout))
    first, last = np.column_stack([memories, settles]), np.column_stack([across, moved])
    return np.hstack([first * has_first, last * has_last])


@remembered(16)
def _held_across(force: FloatArray, order: IntArray, layout: Layout, nominal_axis: str) -> FloatArray:
    """Return the (K, 3) means at every point of the force at the dwell before less that of now, g, one column an axis.

    Nothing along the nominal axis itself: that is the previous attitude's. A channel knows nothing of replications:
    before the first dwell of one there was the last of the one before.
    """
    columns = np.zeros_like(force)
    columns[order[1:]] = force[order[:-1]] - force[order[1:]]
    columns[:, AXES.index(nominal_axis)] = 0.0
    return layout.mean_by_point(columns)


@remembered(16)
def _after_moves(pitch_rad: FloatArray, roll_rad: FloatArray, order: IntArray, layout: Layout) -> FloatArray:
    """Return (N,) what fades from the first dwell after every move of the slower axis; nothing where none is slow."""
    begins = np.append(True, np.diff(layout.replication[order]) != 0)
    moves = [np.append(False, has_moved(angle[order])) & ~begins for angle in (pitch_rad, roll_rad)]
    seldom = min(moves, key=np.count_nonzero)
    if not 0 < _SHORTEST_ROW * (int(np.count_nonzero(seldom)) + layout.replications) <= order.size:
        return np.zeros(order.size)
    turn = np.arange(order.size)
    last = np.maximum.accumulate(np.where(seldom | begins, turn, 0))
    found = np.empty(order.size)
    found[order] = np.exp(-(turn - last) / _FADES_IN)
    return found
