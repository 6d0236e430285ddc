"""Orders: in which sequence the points of a design are visited within one replication.

There-and-back goes out on every second pitch row and back on the rows between: no point is added, both directions are
inside each replication (TP recommendation 4), and time is nearly orthogonal to pitch, so that a drift cannot pass for a
sensitivity. Neighbours is its brother by chance: the rows of a replication are dealt over blocks that each span the
whole range of pitch, and inside a block the nearest row comes next, entered from its nearer end. Every order is a
permutation of its design; only forward-reverse, which visits every attitude twice, first gives the second visit a point
of its own, as TP counts the points of its rows 22 and 24.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np

from procedures.description.procedure_file import Order
from procedures.plan.designs import Design, DesignPoint

Rows = list[list[DesignPoint]]

DRAWN_ANEW = ("random",)
"""Orders whose seed is drawn when the plan is made."""
SHUFFLED = ("neighbours", "blocks", "random", "seeded")
"""Orders that chance decides, anew for every replication."""
MOST_BLOCKS = 6
"""Of ``neighbours``; even numbers, so that as many blocks go up in pitch as come down."""
TWICE = "forward-reverse"
"""The order that visits every attitude twice."""
LONGER_THAN_SERPENTINE = 1.15
"""What the travel of ``neighbours`` may be, times the serpentine's: fewer blocks where it would be more."""


def attitudes_in_words(points: int, order: str) -> str:
    """Return how many attitudes a design of so many points has, and how often a replication visits each."""
    return f"{points // 2} attitudes, each visited twice" if order == TWICE else f"{points} attitudes"


def visits(design: Design, order: Order) -> Design:
    """Return the design with one point a visit: twice the points for forward-reverse, else the design itself.

    The visit of label k on the way back is labelled K + k.
    """
    if order != TWICE:
        return design
    count = len(design.points)
    back = tuple(replace(point, label=point.label + count) for point in design.points)
    return replace(design, points=design.points + back)


def sequence(design: Design, order: Order, chance: np.random.Generator | None = None) -> tuple[DesignPoint, ...]:
    """Return the points of one replication in their order.

    ``design`` is what :func:`visits` made for this order; the shuffled orders need ``chance``.
    """
    points = design.points
    if order == TWICE:
        half = len(points) // 2
        return (*_snake(_rows(points[:half])), *reversed(_snake(_rows(points[half:]))))
    if order in SHUFFLED:
        assert chance is not None, f"order {order} needs a generator"
        return _shuffled(points, order, chance)
    if order == "as-listed":
        return points
    rows = _rows(points)
    if order == "there-and-back":
        return tuple(_snake(_out_and_back(rows)))
    return tuple(_snake(rows)) if order == "serpentine" else tuple(point for row in rows for point in row)


def travel_deg(attitudes_deg: Iterable[Sequence[float]]) -> tuple[float, ...]:
    """Sum of the distances that each axis goes between consecutive attitudes."""
    steps = [
        [abs(there - here) for here, there in zip(attitude, other, strict=True)]
        for attitude, other in pairwise(attitudes_deg)
    ]
    return tuple(float(sum(axis)) for axis in zip(*steps, strict=True))


def _rows(points: Iterable[DesignPoint]) -> Rows:
    """Return points of equal pitch together; pitch, yaw and roll ascend."""
    ordered = sorted(points, key=lambda point: (point.pitch_deg, point.yaw_deg, point.roll_deg, point.label))
    return [list(row) for _, row in groupby(ordered, key=lambda point: point.pitch_deg)]


def _out_and_back(rows: Rows) -> Rows:
    return rows[0::2] + rows[1::2][::-1]


def _snake(rows: Rows) -> list[DesignPoint]:
    """Roll alternates its sense from row to row, so that no row begins with a long way back."""
    return [point for index, row in enumerate(rows) for point in (row[::-1] if index % 2 else row)]


def _shuffled(points: Sequence[DesignPoint], order: Order, chance: np.random.Generator) -> tuple[DesignPoint, ...]:
    """``blocks``: pitch rows in random order, roll in random order within each. ``neighbours``: by :func:`_neighbours`.

    Else: all points in random order.
    """
    if order == "neighbours":
        return _neighbours(_rows(points), chance)
    if order == "blocks":
        rows = _rows(points)
        return tuple(
            rows[row][index] for row in chance.permutation(len(rows)) for index in chance.permutation(len(rows[row]))
        )
    return tuple(points[index] for index in chance.permutation(len(points)))


def _neighbours(rows: Rows, chance: np.random.Generator) -> tuple[DesignPoint, ...]:
    """Rows dealt over as many blocks as the travel allows; a serpentine from a random end where it allows none."""
    most_deg = LONGER_THAN_SERPENTINE * _length_deg(_snake(rows))
    for blocks in range(min(MOST_BLOCKS, 2 * ((len(rows) - 1) // 2)), 0, -2):
        path = _through(_dealt(rows, blocks, chance), chance)
        if _length_deg(path) <= most_deg:
            return tuple(path)
    return tuple(_snake(rows[:: 1 if chance.integers(2) else -1]))


def _dealt(rows: Rows, blocks: int, chance: np.random.Generator) -> list[Rows]:
    """Deal each set of neighbouring rows over the blocks, one each: every block spans the whole range."""
    block_of = np.concatenate([chance.permutation(blocks) for _ in range(-(-len(rows) // blocks))])[: len(rows)]
    return [[row for row, number in zip(rows, block_of, strict=True) if number == block] for block in range(blocks)]


def _through(blocks: list[Rows], chance: np.random.Generator) -> list[DesignPoint]:
    """Each block from the end of its rows that is nearer, each row from its nearer end; the first ends by chance."""
    path: list[DesignPoint] = []
    for block in filter(None, blocks):
        at = path[-1] if path else block[-int(chance.integers(2))][0]
        is_upward = abs(block[0][0].pitch_deg - at.pitch_deg) <= abs(block[-1][0].pitch_deg - at.pitch_deg)
        for row in block if is_upward else block[::-1]:
            at = path[-1] if path else row[-int(chance.integers(2))]
            path += row if _apart_deg(row[0], at) <= _apart_deg(row[-1], at) else row[::-1]
    return path


def _apart_deg(point: DesignPoint, other: DesignPoint) -> float:
    return (
        abs(point.pitch_deg - other.pitch_deg)
        + abs(point.yaw_deg - other.yaw_deg)
        + abs(point.roll_deg - other.roll_deg)
    )


def _length_deg(points: Sequence[DesignPoint]) -> float:
    return sum(_apart_deg(point, other) for point, other in pairwise(points))
