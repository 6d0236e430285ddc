"""Orders: in which sequence the points of a design are visited within one replication.

There-and-back goes out on every second pitch row and back on the rows between: no point is added, both directions are
inside each replication (TP recommendation 4), and time is nearly orthogonal to pitch, so that a drift cannot pass for a
sensitivity. Every order is a permutation of its design; only forward-reverse, which visits every attitude twice, first
gives the second visit a point of its own, as TP counts the points of its rows 22 and 24.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby, pairwise
from typing import Literal

import numpy as np

from procedures.plan.designs import Design, DesignPoint

Order = Literal["there-and-back", "forward-reverse", "serpentine", "raster", "as-listed", "blocks", "random", "seeded"]
Rows = list[list[DesignPoint]]

DRAWN_ANEW = ("random",)
"""Orders whose seed is drawn when the plan is made."""
SHUFFLED = ("blocks", "random", "seeded")
"""Orders that chance decides, anew for every replication."""


def visits(design: Design, order: Order) -> Design:
    """Return the design with one point a visit: twice the points for forward-reverse, else the design itself.

    The visit of label k on the way back is labelled K + k.
    """
    if order != "forward-reverse":
        return design
    count = len(design.points)
    back = tuple(replace(point, label=point.label + count) for point in design.points)
    return replace(design, points=design.points + back)


def sequence(design: Design, order: Order, chance: np.random.Generator | None = None) -> tuple[DesignPoint, ...]:
    """Return the points of one replication in their order.

    ``design`` is what :func:`visits` made for this order; the shuffled orders need ``chance``.
    """
    points = design.points
    if order == "forward-reverse":
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
        [abs(there - here) for here, there in zip(one, other, strict=True)] for one, other in pairwise(attitudes_deg)
    ]
    return tuple(float(sum(axis)) for axis in zip(*steps, strict=True))


def _rows(points: Iterable[DesignPoint]) -> Rows:
    """Points of equal pitch together, pitch, yaw and roll ascending."""
    ordered = sorted(points, key=lambda point: (point.pitch_deg, point.yaw_deg, point.roll_deg, point.label))
    return [list(row) for _, row in groupby(ordered, key=lambda point: point.pitch_deg)]


def _out_and_back(rows: Rows) -> Rows:
    return rows[0::2] + rows[1::2][::-1]


def _snake(rows: Rows) -> list[DesignPoint]:
    """Roll alternates its sense from row to row, so that no row begins with a long way back."""
    return [point for place, row in enumerate(rows) for point in (row[::-1] if place % 2 else row)]


def _shuffled(points: Sequence[DesignPoint], order: Order, chance: np.random.Generator) -> tuple[DesignPoint, ...]:
    """``blocks``: pitch rows in random order, roll in random order within each. Else: all points in random order."""
    if order == "blocks":
        rows = _rows(points)
        return tuple(
            rows[row][place] for row in chance.permutation(len(rows)) for place in chance.permutation(len(rows[row]))
        )
    return tuple(points[place] for place in chance.permutation(len(points)))
