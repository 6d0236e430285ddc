"""How long `calrig plan` takes for two hundred calibrations of the example rig, an order and a D-optimal design."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import get_args

import numpy as np

from bench.figure import Effort, Figure
from procedures.check.candidate import SearchRange, SearchRequest, Target
from procedures.check.candidates import compare
from procedures.description.procedure_file import Order
from procedures.plan.designs import full_grid
from procedures.plan.exchange import exchanged
from procedures.plan.optimal import terms
from procedures.plan.order import sequence, visits
from procedures.solution.expected import Usage
from rig.description.read import read_rig

RIG = Path(__file__).parents[1] / "examples" / "rig.toml"
MANY = SearchRange(replications=(3, 4, 6, 10), orders=("there-and-back",))
"""One order: each calibration has an expectation of its own."""
FEW = SearchRange(
    grids=((7, 8),), fractions=(), optimal=(), replications=(3,), samples=(5,), orders=("there-and-back",)
)
GRID = full_grid(np.linspace(-90.0, 90.0, 60).tolist(), np.linspace(-180.0, 172.8, 50).tolist())


def figures(effort: Effort) -> Iterator[Figure]:
    """Time one comparison."""
    request = SearchRequest(
        read_rig(RIG), Target(hours=50.0), Usage((-60.0, 60.0)), space=FEW if effort.is_tiny else MANY
    )
    counts: list[int] = []
    spent_s = effort.best_s(lambda: counts.append(len(compare(request).candidates)), repeats=1)
    count = counts[0]
    yield Figure("200 calibrations compared", 200.0 * spent_s / count, "s", 10.0, at_most=True, note=f"of {count}")
    for order in get_args(Order):
        points = visits(GRID, order)
        spent_s = effort.best_s(partial(sequence, points, order, np.random.default_rng(0)), 1)
        yield Figure(f"3 000 points ordered, {order}", spent_s, "s", 2.0, at_most=True)
    angles = [(pitch, roll) for pitch in np.arange(-90.0, 91.0, 5.0) for roll in np.arange(-180.0, 181.0, 30.0)]
    rows = terms(np.deg2rad(np.array(angles)), "extended", with_roll=True)
    spent_s = effort.best_s(lambda: exchanged(rows, 72, np.random.default_rng(0), None), repeats=1)
    yield Figure(f"D-optimal design of 72 points of {len(rows)}", spent_s, "s", 5.0, at_most=True)
