"""From which side the axes of a table came to every dwell, and what their play does with it.

An axis with play comes to rest on either side of where it says, by the sense of its last move: half the play beyond or
short of it. One that did not move stays where it lay. The sense is that from one angle to the next, the straight way;
before an axis has moved for the first time nobody knows it, nor after a step of the run that is no row (a reference
visit, a check set, a dwell that was taken back), until the axis moves again. What is not known counts as neither.
"""

from typing import Final

import numpy as np

from ams.analysis.diagnostics.step_patterns import What, slip_pattern
from ams.arrays import FloatArray, IntArray
from ams.remembered import remembered

MOVED_RAD: Final = 1e-4
"""What indices read otherwise on coming back is less."""
_OF_TABLE: Final[tuple[What, ...]] = ("pitch", "roll")
_OF_GIMBAL: Final[tuple[What, ...]] = ("pitch", "roll", "yaw")
_OF_STING: Final[tuple[What, ...]] = ("pitch", "yaw")


def axes_with_play(yaw_rad: FloatArray | None, *, is_rolled: bool = True) -> tuple[What, ...]:
    """Return the axes whose play is looked for; ``is_rolled``: whether roll reaches the package."""
    if yaw_rad is None:
        return _OF_TABLE
    return _OF_GIMBAL if is_rolled else _OF_STING


@remembered(16)
def last_way(angle_rad: FloatArray, order: IntArray, step: IntArray | None) -> FloatArray:
    """Return (N,) the sense of the last move of an axis before each row: +1, −1, or 0 where it is not known.

    ``order``: (N,) the rows in the order of time. ``step``: (N,) the steps of the run; None: nothing lay between rows.
    """
    angle = angle_rad[order]
    moved = np.append(0.0, np.diff(angle))
    way = np.where(np.abs(moved) > MOVED_RAD, np.sign(moved), 0.0)
    is_moment = way != 0.0
    is_moment[0] = True
    if step is not None and step.size > 1:
        apart = np.diff(step[order])
        is_unknown = np.append(False, apart != np.median(apart))
        way, is_moment = np.where(is_unknown, 0.0, way), is_moment | is_unknown
    last = np.maximum.accumulate(np.where(is_moment, np.arange(order.size), 0))
    found = np.empty(order.size)
    found[order] = way[last]
    return found


@remembered(16)
def turned_by_play(
    axes: tuple[What, ...],
    pitch_rad: FloatArray,
    roll_rad: FloatArray,
    yaw_rad: FloatArray | None,
    order: IntArray,
    step: IntArray | None,
    single_approach: frozenset[str],
    unknown: tuple[float, ...],
) -> FloatArray:
    """Return the (N, 3 a) change of specific force by a radian of play, of each of a ``axes`` (3).

    ``single_approach``: axes that the machine lets come from one side always, whose play cannot show. ``unknown``: what
    stands for a sense that is not known, of each axis; empty: it counts as neither.
    """
    angles = (pitch_rad, roll_rad, yaw_rad)
    by_axis = {"pitch": pitch_rad, "roll": roll_rad, "yaw": yaw_rad}
    parts = []
    for axis, instead in zip(axes, unknown or (0.0,) * len(axes), strict=True):
        angle = by_axis[axis]
        assert angle is not None, "the axes are those of the table"
        way = last_way(angle, order, step)
        parts.append(_turned(axis, angles, way, instead, has_single_approach=axis in single_approach))
    return np.hstack(parts)


def _turned(
    axis: What,
    angles: tuple[FloatArray, FloatArray, FloatArray | None],
    way: FloatArray,
    instead: float,
    *,
    has_single_approach: bool,
) -> FloatArray:
    if has_single_approach or not (np.any(way > 0.0) and np.any(way < 0.0)):
        return np.zeros((way.size, 3))
    sense = np.where(way == 0.0, instead, way)
    return np.asarray(0.5 * sense[:, None] * slip_pattern(axis, *angles))
