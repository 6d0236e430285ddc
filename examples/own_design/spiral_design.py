"""A design of your own: attitudes along a spiral from pole to pole, evenly over the sphere (docs/designs.md).

Point k of n has sin(pitch) = (2k + 1)/n − 1 and a roll that advances by the golden angle. Nothing repeats, so that no
period of the table falls together with one of the design.
"""

from math import asin, degrees, sqrt
from typing import Annotated

from pydantic import Field

from procedures.description.procedure_file import Design as DesignTable
from procedures.plan.design_kind import DesignKind, Wanted
from procedures.plan.designs import Design, scattered

GOLDEN_ANGLE_DEG = 180.0 * (3.0 - sqrt(5.0))


class SpiralTable(DesignTable):
    """``[design]`` with the keys that only this kind has."""

    points: Annotated[int, Field(ge=4, le=10_000)] = 36
    whole_deg: Annotated[float, Field(gt=0.0, le=10.0)] = 1.0
    """Attitudes are rounded to multiples of this, for tables that go in steps."""


def _spiral(wanted: Wanted) -> Design:
    table = wanted.table
    assert isinstance(table, SpiralTable)
    count, step_deg = table.points, table.whole_deg
    attitudes_deg = [
        (degrees(asin((2 * index + 1) / count - 1.0)), (index * GOLDEN_ANGLE_DEG + 180.0) % 360.0 - 180.0)
        for index in range(count)
    ]
    return scattered(
        "spiral", [tuple(round(angle / step_deg) * step_deg for angle in attitude) for attitude in attitudes_deg]
    )


SPIRAL = DesignKind(name="spiral", takes=frozenset(), needs={}, table=SpiralTable, make=_spiral)
