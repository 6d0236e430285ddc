"""Whether a dwell remembers the attitudes before it: hysteresis, an after-effect, or too short a settling time.

The column of the attitude before is what the sensor senses at the dwell before less what it senses now, within a
replication; the first dwell of a replication has none before it. The columns of a memory are what an element that
follows the force along the nominal axis with a time constant of so many dwells lags behind it, ṁ = (f − m)/τ, through
the whole run: creep does not know of replications. At the first dwell it is at rest.

In an order that differs from replication to replication every point tells these for itself; in an order that is always
the same they repeat, and are among the columns that the means of the points are tested for. Where every second
replication goes the same way backwards, a memory turns the sensitivities one way and then the other.
"""

import numpy as np

from ams.analysis.diagnostics.beliefs import MEMORY_DWELLS
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.settling import UNKNOWN, Estimate, joined
from ams.analysis.diagnostics.point_means import Tested
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.sensed_force import Accelerometer, sensed_along
from ams.analysis.diagnostics.time_order import LEAST_DOF
from ams.arrays import FloatArray, IntArray
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.statistics.distributions import f_tail

_NOTHING = 1e-9
"""Of the square of what is left of a column, g²: nothing to divide by."""
_LITTLE = 1e-3
"""Of the square of a column: with less left beside points and replications its size is not estimated."""
_LEAST_REPLICATIONS = 4
"""Whose parameters tell what they follow from what they do by themselves."""
_DRIFTS = 0.05
"""The chance below which the parameters that a memory moves are taken to drift beyond precision."""


def turned_from(evidence: Evidence, output: int) -> FloatArray:
    """Return the (N,) change of what the output senses from this dwell back to the one before it, over its largest."""
    along = evidence.sensed[:, output]
    return np.asarray(along[dwell_before(evidence.time_order, evidence.layout)] - along)


def memories(evidence: Evidence, base: Accelerometer) -> FloatArray:
    """Return (N, 3) what an element with a memory of so many dwells shows still less what there is now, g."""
    rows = evidence.rows
    return memories_in_order(rows.time_s, evidence.time_order, sensed_along(base, rows))


def memories_between(evidence: Evidence, grid: GridResiduals, output: int, base: Accelerometer) -> list[Estimate]:
    """Estimate each memory from what differs between replications; none if the order never differs.

    Beside the effects of points and the parameters of every replication the dwells tell it. What the parameters
    themselves follow of it, in an order that goes forward and then back, counts against the rest of their own changes.
    """
    if evidence.order_repeats or evidence.sums is None or grid.dof - 1 < LEAST_DOF:
        return []
    columns = memories(evidence, base)
    is_whole = grid.taken.shape[1] == 0 and evidence.layout.is_complete
    if is_whole:
        left = _beside_parameters(grid.q, evidence.dwell, columns, grid.replications)
    else:
        left = grid.projected(evidence.on_grid(columns))
    whole = np.einsum("nc,nc->c", columns, columns).tolist()
    squares, along = np.einsum("nc,nc->c", left, left).tolist(), (grid.residuals[:, 0] @ left).tolist()
    sum_of_squares, dof = float(grid.squares[0]), grid.dof - 1
    found = [
        _estimate(size, square, sum_of_squares - size**2 / square, dof) if square > _LITTLE * everything else UNKNOWN
        for square, size, everything in zip(squares, along, whole, strict=True)
    ]
    if not (is_whole and evidence.sums.is_balanced and grid.replications >= _LEAST_REPLICATIONS):
        return found
    return [
        joined([dwells, moved]) for dwells, moved in zip(found, _moved(evidence, grid, output, columns), strict=True)
    ]


def memories_alike(evidence: Evidence, base: Accelerometer) -> FloatArray:
    """Return the (3, 3) correlation of the estimates of each memory from what differs between replications."""
    left = evidence.grid.projected(evidence.on_grid(memories(evidence, base)))
    length = np.sqrt(np.einsum("nc,nc->c", left, left))
    unit = left / np.where(length > 0.0, length, 1.0)
    return np.asarray(unit.T @ unit)


def _moved(evidence: Evidence, grid: GridResiduals, output: int, columns: FloatArray) -> list[Estimate]:
    """Estimate each memory from how the parameters of the replications follow it, against the rest of what they do.

    All parameters scatter by precision where nothing drifts, and then the rest of all of them is one scatter. Where
    those that a memory moves drift beyond that, theirs is.
    """
    shape = (grid.replications, grid.points)
    moves = evidence.on_grid(evidence.departures[:, output : output + 1]).reshape(shape) @ grid.q
    memory, direction, pattern = _of_parameters(grid.q, evidence.dwell, columns, grid.replications)
    flat = memory.reshape(-1, memory.shape[-1])
    squares, along = np.einsum("ic,ic->c", flat, flat), moves.ravel() @ flat
    whole, dof = float(np.einsum("rp,rp->", moves, moves)), (grid.replications - 1) * moves.shape[1] - 1
    same_way = moves @ direction
    left = same_way - pattern * (np.einsum("rc,rc->c", pattern, same_way) / np.einsum("rc,rc->c", pattern, pattern))
    of_direction, found = np.einsum("rc,rc->c", left, left).tolist(), []
    for square, size, rest_of_direction in zip(squares.tolist(), along.tolist(), of_direction, strict=True):
        rest, fewer = whole - size**2 / square, grid.replications - 2
        ratio = rest_of_direction / fewer / (rest / dof) if rest > 0.0 else 0.0
        drifts = ratio > 1.0 and float(f_tail(ratio, float(fewer), float(dof))) <= _DRIFTS
        found.append(_estimate(size, square, *((rest_of_direction, fewer) if drifts else (rest, dof))))
    return found


def _estimate(along: float, square: float, rest: float, dof: int) -> Estimate:
    if not rest > 0.0:
        return UNKNOWN
    return Estimate(along / square, float(np.sqrt(rest / dof / square)), float(dof))


@remembered(16)
def memories_in_order(time_s: FloatArray | None, order: IntArray, along: FloatArray) -> FloatArray:
    force, kept = along[order], _kept(time_s, order)
    found = np.empty((order.size, len(MEMORY_DWELLS)))
    found[order] = _recursion(kept, kept * -np.diff(force, prepend=force[0])).T
    return found


@remembered(16)
def _kept(time_s: FloatArray | None, order: IntArray) -> FloatArray:
    """Return (3, N) what is left of each memory from one dwell to the next, in the order of time; 0 at the first."""
    waited = np.ones(order.size - 1) if time_s is None else np.diff(time_s[order])
    usual = float(np.median(waited)) if waited.size else 0.0
    waited = waited / usual if usual > 0.0 else np.ones(order.size - 1)
    fading = np.exp(-waited / np.array(MEMORY_DWELLS)[:, None])
    return np.concatenate([np.zeros((len(MEMORY_DWELLS), 1)), fading], axis=1)


def _recursion(kept: FloatArray, added: FloatArray) -> FloatArray:
    """Return (…, N) y with y_j = kept_j y_(j−1) + added_j, in passes of twice the reach each."""
    found, kept, reach = added.copy(), kept.copy(), 1
    while reach < found.shape[-1]:
        found[..., reach:] = found[..., reach:] + kept[..., reach:] * found[..., :-reach]
        kept[..., reach:] = kept[..., reach:] * kept[..., :-reach]
        kept[..., :reach] = 0.0
        reach *= 2
    return found


@remembered(16)
def _beside_parameters(q: FloatArray, dwell: IntArray, columns: FloatArray, replications: int) -> FloatArray:
    by_replication = _about_points(dwell, columns, replications)
    return np.asarray((by_replication - q @ (q.T @ by_replication)).reshape(columns.shape))


@remembered(16)
def _of_parameters(
    q: FloatArray, dwell: IntArray, columns: FloatArray, replications: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what the parameters of n replications take from c columns, about their mean.

    (n, P, c); (P, c) the direction in which they move the most; (n, c) how far each moves along it.
    """
    moved = q.T @ _about_points(dwell, columns, replications)
    direction = np.linalg.svd(np.moveaxis(moved, -1, 0))[2][:, 0].T.copy()
    return moved, direction, np.einsum("rpc,pc->rc", moved, direction)


def _about_points(dwell: IntArray, columns: FloatArray, replications: int) -> FloatArray:
    """Return (n, K, c) columns less their mean over the replications of each point."""
    grid = np.empty_like(columns)
    grid[dwell] = columns
    by_replication = grid.reshape(replications, grid.shape[0] // replications, -1)
    return np.asarray(by_replication - by_replication.mean(axis=0))


@remembered(16)
def dwell_before(order: IntArray, layout: Layout) -> IntArray:
    """Return (N,) the dwell before each in its replication; of the first of a replication itself."""
    found = np.arange(order.size)
    replication, here, before = layout.replication[order], order[1:], order[:-1]
    found[here] = np.where(replication[1:] == replication[:-1], before, here)
    return found


def between_replications(evidence: Evidence, grid: GridResiduals, column: FloatArray) -> Tested | None:
    """Test one output beside the effects of points and replications; None where the order never differs."""
    if evidence.order_repeats:
        return None
    left = grid.projected(evidence.on_grid(column[:, None]))[:, 0]
    square, dof = float(left @ left), grid.dof - 1
    if evidence.sums is None or dof < LEAST_DOF or not square > max(_LITTLE * float(column @ column), _NOTHING):
        return None
    coefficient = float(left @ grid.residuals[:, 0]) / square
    rest = float(grid.squares[0]) - coefficient**2 * square
    if not rest > 0.0:
        return None
    uncertainty = float(np.sqrt(rest / dof / square))
    return Tested(coefficient, uncertainty, float(f_tail((coefficient / uncertainty) ** 2, 1.0, float(dof))))
