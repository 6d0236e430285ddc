"""Whether the offset drifts evenly with time, or only differs from replication to replication.

Offsets that differ from replication to replication, each by chance, lie on a line of time by a part: beside the scatter
of dwells that is plain, and it is no drift. Where they scatter about the line by more than dwells do, the line is held
against their own scatter about it, and against what goes on within the replications.
"""

from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import OVER_TIME, UNTOLD, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.settling import slope_test
from ams.analysis.diagnostics.time_order import Slope, hours
from ams.arrays import FloatArray
from ams.statistics.distributions import f_tail

_OFF_THE_LINE: Final = 0.05
"""Chance of what the replications scatter about the line, below which they differ by more than a drift."""
_LEAST_REPLICATIONS: Final = 3
"""Two always lie on a line: what goes on within them has to agree with it."""
_NOTHING: Final = 1e-9
"""Share of the squares of time that lie within the replications, below which nothing is seen there."""


def drift_with_time(evidence: Evidence, slope: Slope, output: int) -> BeliefTest:
    """Return the test of one output. ``slope``: against the hours of the rows, beside the scatter of dwells."""
    test, hours_of_rows = slope_test(OVER_TIME, "drift", slope, output, "per h"), hours(evidence)
    if hours_of_rows is None or not test.p_value <= UNTOLD:
        return test
    p_value = _of_a_line(evidence, output, hours_of_rows)
    return test if p_value is None else test._replace(p_value=max(p_value, test.p_value))


def _of_a_line(evidence: Evidence, output: int, column: FloatArray) -> float | None:
    """Return the chance of a line beside replications that differ each by itself; None where none is seen to."""
    layout, variance = evidence.layout, float(evidence.precision_variance[output])
    y, z, dof = evidence.departures[:, output], layout.about_points(column), float(evidence.grid.dof)
    count = np.bincount(layout.replication, minlength=layout.replications).astype(np.float64)
    y_mean, z_mean = (_by_replication(values, layout.replication, count) for values in (y, z))
    z_about = z_mean - count @ z_mean / count.sum()
    square, rest_dof = float(count @ z_about**2), layout.replications - 2
    slope = float(count @ (z_about * y_mean)) / square if square > 0.0 else 0.0
    left = y_mean - count @ y_mean / count.sum() - slope * z_about
    scatter = float(count @ left**2) / max(rest_dof, 1)
    within_y, within_z = y - y_mean[layout.replication], z - z_mean[layout.replication]
    within = float(within_z @ within_z)
    is_seen_within = within > _NOTHING * square
    within_slope = float(within_z @ within_y) / within if is_seen_within else 0.0
    if layout.replications >= _LEAST_REPLICATIONS:
        off_the_line = float(f_tail(scatter / variance, float(rest_dof), dof))
        chances = [float(f_tail(slope**2 * square / scatter, 1.0, float(rest_dof)))]
    else:
        shared = 1.0 / (1.0 / square + 1.0 / within) if is_seen_within and square > 0.0 else 0.0
        off_the_line = float(f_tail((slope - within_slope) ** 2 * shared / variance, 1.0, dof))
        chances = []
    if not off_the_line <= _OFF_THE_LINE:
        return None
    if is_seen_within:
        chances.append(float(f_tail(within_slope**2 * within / variance, 1.0, dof)))
    return min(1.0, len(chances) * min(chances, default=1.0))


def _by_replication(values: FloatArray, replication: np.ndarray, count: FloatArray) -> FloatArray:
    return np.asarray(np.bincount(replication, weights=values, minlength=count.size) / count)
