"""What one output shows of the play of the table's axes: as it differs between replications, or repeats at the points.

Where the order of the points differs from replication to replication, the same point is approached from both sides, and
nothing that an output does by the attitude has a part in the difference: the effects of points and the parameters of
every replication are taken out. In an order that is always the same the play repeats as a lack of fit does; there the
sensor's own terms of low order and a wrong zero of the table are taken out of the means of the points.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import spanned
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.sensed_force import Accelerometer, along_force, is_rolled, turned_by
from ams.analysis.diagnostics.step_patterns import What, slip_pattern
from ams.analysis.diagnostics.steps.approach import axes_with_play, turned_by_play
from ams.analysis.diagnostics.tested_terms import accelerometer_base, terms_of_accelerometer
from ams.analysis.diagnostics.time_order import LEAST_DOF, row_time
from ams.arrays import FloatArray, IntArray
from ams.remembered import remembered
from ams.solve.layout import Layout

_DIFFERS: Final = 0.25
"""Of the whole effect: what differs between replications has to be as much to be looked at."""
_DIFFERS_ON_STING: Final = 0.02
"""The same where roll does not reach the package: most of a turn by pitch or yaw is one of the package there, which the
parameters of each replication take, and what is left says more than the means of points come to from both sides."""
_NOTHING: Final = 1e-9


@dataclass(frozen=True)
class ShownPlay:
    """Of one output."""

    base: Accelerometer
    axes: tuple[What, ...]
    """That turn it, a of them."""
    evidence: Evidence
    output: int
    k: FloatArray
    """(3,) V/g, by the specific force."""
    taken_by_row: FloatArray
    """(N, 3 a) as :func:`ams.analysis.diagnostics.steps.approach.turned_by_play` has it."""
    q: FloatArray | None
    """(K, P) what is taken out of the means; None where it is told by what differs between replications."""
    left_of_force: FloatArray
    """(S, 3 a) what is left of ``taken_by_row``."""
    reading: FloatArray
    """(S,) of what was read."""
    square: FloatArray
    """(a, a)"""
    along: FloatArray
    """(a,)"""
    variance: float
    """Of a reading, beside the play of all axes."""
    dof: float

    @property
    def left(self) -> FloatArray:
        """(S, a) what is left of a radian of play of each axis."""
        return np.stack([part @ self.k for part in np.split(self.left_of_force, len(self.axes), axis=1)], axis=1)

    def by_replication(self, axis: int) -> tuple[FloatArray, FloatArray]:
        """Return (n,) products and squares of the play of an axis by each replication alone, over the variance of it.

        Of replications that lack points: nothing.
        """
        evidence, of_axis = self.evidence, slice(3 * axis, 3 * axis + 3)
        shape = (evidence.layout.replications, evidence.layout.points)
        if self.q is None:
            left = (self.left_of_force[:, of_axis] @ self.k).reshape(shape)
            reading = self.reading.reshape(shape)
        else:
            by_row = np.stack([self.taken_by_row[:, of_axis] @ self.k, evidence.left[:, self.output]], axis=1)
            on_grid = evidence.on_grid(by_row).reshape(*shape, 2)
            left, reading = np.moveaxis(on_grid - self.q @ (self.q.T @ on_grid), 2, 0)
        is_whole = evidence.layout.sum_by_replication(np.ones(evidence.layout.rows)) == shape[1]
        variance = float(evidence.precision_variance[self.output])
        along, square = np.einsum("rk,rk->r", left, reading), np.einsum("rk,rk->r", left, left)
        return along[is_whole] / variance, square[is_whole] / variance

    def projected(self, by_row: FloatArray) -> FloatArray:
        """Return (S, c) what is left of (N, c) columns in the same way."""
        if self.q is None:
            return self.evidence.grid.projected(self.evidence.on_grid(by_row))
        means = self.evidence.layout.mean_by_point(by_row)
        return np.asarray(means - self.q @ (self.q.T @ means))


def shown_play(
    evidence: Evidence, output: int, single_approach: frozenset[str], unknown: tuple[float, ...] = ()
) -> ShownPlay | None:
    """Return what an output shows of the play; None of one that tells nothing of it.

    ``single_approach``, ``unknown``: as :func:`ams.analysis.diagnostics.steps.approach.turned_by_play` has them.
    """
    base, rows = accelerometer_base(evidence.models[output]), evidence.rows
    if base is None or row_time(evidence) is None or not evidence.precision_variance[output] > 0.0:
        return None
    angles = turned_by(base, rows)
    axes = axes_with_play(angles[2], is_rolled=is_rolled(base))
    by_row = turned_by_play(axes, *angles, evidence.time_order, rows.step, single_approach, unknown)
    grid = evidence.grid
    left, gram, share = _between(
        by_row, evidence.dwell, grid.q, grid.taken, grid.present, grid.replications, grid.points
    )
    q, reading, dof = None, grid.residuals[:, output], grid.dof
    if (
        share < (_DIFFERS if is_rolled(base) else _DIFFERS_ON_STING)
        or dof < LEAST_DOF
        or evidence.layout.replications < 2
    ):
        terms = terms_of_accelerometer(evidence, base)
        q, left, gram, dof = _at_points(by_row, axes, *angles, evidence.layout, evidence.basis, terms)
        means = evidence.point_effects[:, output]
        reading = means - q @ (q.T @ means)
    if dof < LEAST_DOF:
        return None
    k, count = along_force(base, evidence.primary[output]), len(axes)
    square = (gram.reshape(3 * count, count, 3) @ k).T.reshape(count, count, 3) @ k
    along = (reading @ left).reshape(count, 3) @ k
    explained, numbers = _explained(square, along, _NOTHING * float(k @ k))
    rest, dof = float(reading @ reading) - explained, dof - numbers
    if numbers == 0 or not rest > 0.0:
        return None
    return ShownPlay(base, axes, evidence, output, k, by_row, q, left, reading, square, along, rest / dof, float(dof))


def _explained(square: FloatArray, along: FloatArray, nothing: float) -> tuple[float, int]:
    """Return what the play of all axes explains of the squares, and of how many of them anything is seen."""
    if along.size > 2:
        values, vectors = np.linalg.eigh(square)
        is_seen = values > max(nothing, _NOTHING * float(values[-1]))
        return float(((vectors.T @ along)[is_seen] ** 2 / values[is_seen]).sum()), int(is_seen.sum())
    (a, b), (_, d) = square.tolist()
    x, y = along.tolist()
    if a > nothing and d > nothing and (apart := a * d - b * b) > _NOTHING * a * d:
        return (d * x * x - 2.0 * b * x * y + a * y * y) / apart, 2
    if max(a, d) > nothing:
        return (x * x / a if a >= d else y * y / d), 1
    return 0.0, 0


@remembered(16)
def _between(
    by_row: FloatArray,
    dwell: IntArray,
    q: FloatArray,
    taken: FloatArray,
    present: FloatArray,
    replications: int,
    points: int,
) -> tuple[FloatArray, FloatArray, float]:
    """Return (n K, 3 a) what differs between replications, its products, and which part of the whole it is."""
    on_grid = np.zeros((replications * points, by_row.shape[1]))
    on_grid[dwell] = by_row
    left = GridResiduals(replications, points, q, np.zeros((present.size, 1)), taken, present).projected(on_grid)
    whole = float(np.einsum("nc,nc->", by_row, by_row))
    return left, left.T @ left, float(np.einsum("nc,nc->", left, left)) / whole if whole > 0.0 else 0.0


@remembered(16)
def _at_points(
    by_row: FloatArray,
    axes: tuple[What, ...],
    pitch_rad: FloatArray,
    roll_rad: FloatArray,
    yaw_rad: FloatArray | None,
    layout: Layout,
    basis: FloatArray,
    terms: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, int]:
    """Return what is taken out of the means, (K, 3 a) what that leaves of the play, its products, and what is left."""
    of_zeros = [
        layout.mean_by_point(np.asarray(slip_pattern(axis, pitch_rad, roll_rad, yaw_rad)))
        for axis in axes
        if axis != "roll"
    ]
    q = spanned(np.hstack([basis, terms, *of_zeros]))
    means = layout.mean_by_point(by_row)
    left = means - q @ (q.T @ means)
    left[:, np.einsum("kc,kc->c", left, left) <= _NOTHING * layout.points] = 0.0
    return q, left, left.T @ left, layout.points - q.shape[1]
