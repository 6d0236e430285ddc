"""Whether the sensitive axis of an accelerometer turns with temperature: no model has that.

Offset and sensitivity of a model over temperature change along one direction each; the two sensitivities across the
axis times the recorded temperature are beside them, as replications differ by them. It counts as turning where that
explains more than what else the replications' axes do: a chance turn at each visit is not temperature.
"""

from dataclasses import dataclass

import numpy as np

from ams.analysis.diagnostics.beliefs import AXIS_OVER_TEMPERATURE, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time import temperature as by_temperature
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.analysis.diagnostics.time_order import LEAST_DOF
from ams.arrays import FloatArray
from ams.frames import AXES
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.statistics.distributions import f_tail


@dataclass(frozen=True)
class Turning:
    """Of one output."""

    test: BeliefTest
    unexplained: float
    """p-value of what else the replications' sensitivities and offsets do."""


def axis_over_temperature(evidence: Evidence, output: int, lag_h: float | None) -> Turning | None:
    """Return the test of one output; None where no temperature coefficients are estimated, or where nothing tells.

    ``lag_h``: time constant of a lag behind the record, whose effect on offset and sensitivity is known beside it.
    """
    base = accelerometer_base(evidence.models[output])
    if base is None or not by_temperature.is_estimated(evidence, output) or evidence.sums is None:
        return None
    rise, layout = by_temperature.departure_degc(evidence), evidence.layout
    variance, dof = float(evidence.precision_variance[output]), evidence.grid.dof
    if rise is None or dof < LEAST_DOF or not variance > 0.0 or layout.replications < by_temperature.LEAST_PLOTS:
        return None
    linear, along = evidence.basis[layout.point, :LINEAR_COLUMNS], evidence.sensed[:, [output]]
    courses = [rise[:, None], rise[:, None] ** 2]
    apart = None if lag_h is None else by_temperature.lagged_degc(evidence, lag_h)
    if apart is not None:
        courses.append(apart[:, None])
    known = layout.about_points(np.hstack([part for course in courses for part in (course, course * along)]))
    of_visit = np.equal.outer(layout.replication, np.arange(layout.replications - 1))
    every = layout.about_points(np.hstack([of_visit * linear[:, [column]] for column in range(LINEAR_COLUMNS)]))
    e = evidence.departures[:, output]
    turned, p_values = [], []
    for column in (1 + index for index, axis in enumerate(AXES) if axis != base.nominal_axis):
        turned.append(layout.about_points(rise[:, None] * linear[:, [column]]))
        visits = layout.about_points(of_visit * linear[:, [column]])
        p_values.append(_p_value(known, turned[-1], visits, e, (variance, dof)))
    across = np.hstack(turned)
    (with_turn, rank), (whole, whole_rank) = (
        by_temperature.explained(np.hstack(columns), e) for columns in ([known, across], [known, across, every])
    )
    others = whole_rank - rank
    if others == 0:
        return None
    rest = max(whole - with_turn, 0.0) / others
    size, uncertainty = _size(known, across, e, max(variance, rest))
    p_value = min(1.0, len(turned) * min(p_values))
    test = BeliefTest(
        AXIS_OVER_TEMPERATURE, "temperature-residual", p_value, size, uncertainty, "V/g per °C", is_held=False
    )
    return Turning(test, float(f_tail(rest / variance, float(others), float(dof))))


def _p_value(
    known: FloatArray, turned: FloatArray, visits: FloatArray, e: FloatArray, precision: tuple[float, int]
) -> float:
    """Return the chance of one direction, 1 where it explains no more than what visits do to that direction.

    ``precision``: variance of a dwell and its degrees of freedom.
    """
    (without, rank), (with_turn, turned_rank), (whole, whole_rank) = (
        by_temperature.explained(np.hstack(columns), e)
        for columns in ([known], [known, turned], [known, turned, visits])
    )
    others = whole_rank - turned_rank
    if turned_rank == rank or others == 0:
        return 1.0
    rest = max(whole - with_turn, 0.0) / others
    return by_temperature.more_than_visits(with_turn - without, 1, (rest, others), precision)


def _size(known: FloatArray, turned: FloatArray, e: FloatArray, variance: float) -> tuple[float, float]:
    """Return what the sensitivities across the axis change by a °C, both together, with its standard uncertainty."""
    left = turned - known @ np.linalg.lstsq(known, turned, rcond=1e-9)[0]
    inverse = np.linalg.pinv(left.T @ left)
    turn = inverse @ (left.T @ e)
    size = float(np.linalg.norm(turn))
    way = turn / size if size > 0.0 else np.array([1.0, 0.0])
    return size, float(np.sqrt(variance * (way @ inverse @ way)))
