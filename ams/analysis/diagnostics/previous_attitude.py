"""Whether a dwell remembers the attitude that the sensor was turned from: hysteresis, or too short a settling time.

The column is what the sensor senses at the dwell before less what it senses now, within a replication; the first dwell
of a replication has none before it. In an order that differs from replication to replication every point tells it for
itself; in an order that is always the same it repeats, and is one of the columns that the means of the points are
tested for.
"""

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import Tested
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.time_order import LEAST_DOF, order_repeats, time_order
from ams.arrays import FloatArray, IntArray
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.statistics.distributions import f_tail

_NOTHING = 1e-9


def turned_from(evidence: Evidence, output: int) -> FloatArray:
    """Return the (N,) change of what the output senses from this dwell back to the one before it, over its largest."""
    along = evidence.sensed[:, output]
    return np.asarray(along[_dwell_before(time_order(evidence), evidence.layout)] - along)


@remembered(16)
def _dwell_before(order: IntArray, layout: Layout) -> IntArray:
    """Return (N,) the dwell before each in its replication; of the first of a replication itself."""
    found = np.arange(order.size)
    replication, here, before = layout.replication[order], order[1:], order[:-1]
    found[here] = np.where(replication[1:] == replication[:-1], before, here)
    return found


def between_replications(evidence: Evidence, grid: GridResiduals, column: FloatArray) -> Tested | None:
    """Test one output beside the effects of points and replications; None where the order never differs."""
    if order_repeats(evidence):
        return None
    left = grid.projected(evidence.on_grid(column[:, None]))[:, 0]
    square, dof = float(left @ left), grid.dof - 1
    if evidence.sums is None or dof < LEAST_DOF or not square > _NOTHING * max(float(column @ column), _NOTHING):
        return None
    coefficient = float(left @ grid.residuals[:, 0]) / square
    rest = float(grid.squares[0]) - coefficient**2 * square
    if not rest > 0.0:
        return None
    uncertainty = float(np.sqrt(rest / dof / square))
    return Tested(coefficient, uncertainty, float(f_tail((coefficient / uncertainty) ** 2, 1.0, float(dof))))
