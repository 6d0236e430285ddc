"""What one output shows of the play of the table's axes: as it differs between replications, or repeats at the points.

Where the order of the points differs from replication to replication, the same point is approached from both sides, and
nothing that an output does by the attitude has a part in the difference: the effects of points and the parameters of
every replication are taken out. In an order that is always the same the play repeats as a lack of fit does; there the
sensor's own terms of low order and a wrong zero of the table are taken out of the means of the points.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.approach import turned_by_play
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import spanned
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.step_patterns import slip_pattern
from ams.analysis.diagnostics.tested_terms import linear_base, terms_of_accelerometer
from ams.analysis.diagnostics.time_order import LEAST_DOF, row_time
from ams.arrays import FloatArray, IntArray
from ams.models.accelerometer import PitchRoll
from ams.models.extended import ExtendedPitchRoll
from ams.remembered import remembered
from ams.solve.layout import Layout

_DIFFERS: Final = 0.25
"""Of the whole effect: what differs between replications has to be as much to be looked at."""
_NOTHING: Final = 1e-9
SENSITIVITIES: Final = slice(1, 4)
"""Of the parameters: the sensitivities."""


@dataclass(frozen=True)
class ShownPlay:
    """Of one output."""

    base: PitchRoll | ExtendedPitchRoll
    evidence: Evidence
    output: int
    k: FloatArray
    """(3,) V/g."""
    taken_by_row: FloatArray
    """(N, 6) as :func:`ams.analysis.diagnostics.approach.turned_by_play` has it."""
    q: FloatArray | None
    """(K, P) what is taken out of the means; None where it is told by what differs between replications."""
    left_of_force: FloatArray
    """(S, 6) what is left of ``taken_by_row``."""
    reading: FloatArray
    """(S,) of what was read."""
    square: FloatArray
    """(2, 2)"""
    along: FloatArray
    """(2,)"""
    variance: float
    """Of a reading, beside the play of both axes."""
    dof: float

    @property
    def left(self) -> FloatArray:
        """(S, 2) what is left of a radian of play of either axis."""
        return np.stack([self.left_of_force[:, :3] @ self.k, self.left_of_force[:, 3:] @ self.k], axis=1)

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
    evidence: Evidence, output: int, single_approach: frozenset[str], unknown: tuple[float, float] = (0.0, 0.0)
) -> ShownPlay | None:
    """Return what an output shows of the play; None of one that tells nothing of it.

    ``single_approach``, ``unknown``: as :func:`ams.analysis.diagnostics.approach.turned_by_play` has them.
    """
    base, rows = linear_base(evidence.models[output]), evidence.rows
    if base is None or row_time(evidence) is None or not evidence.precision_variance[output] > 0.0:
        return None
    by_row = turned_by_play(rows.pitch_rad, rows.roll_rad, evidence.time_order, rows.step, single_approach, unknown)
    grid = evidence.grid
    left, gram, share = _between(
        by_row, evidence.dwell, grid.q, grid.taken, grid.present, grid.replications, grid.points
    )
    q, reading, dof = None, grid.residuals[:, output], grid.dof
    if share < _DIFFERS or dof < LEAST_DOF or evidence.layout.replications < 2:
        terms = terms_of_accelerometer(evidence, base)
        q, left, gram, dof = _at_points(by_row, rows.pitch_rad, rows.roll_rad, evidence.layout, evidence.basis, terms)
        means = evidence.point_effects[:, output]
        reading = means - q @ (q.T @ means)
    if dof < LEAST_DOF:
        return None
    k = evidence.primary[output][SENSITIVITIES]
    square = (gram.reshape(6, 2, 3) @ k).T.reshape(2, 2, 3) @ k
    along = (reading @ left).reshape(2, 3) @ k
    explained, numbers = _explained(square, along, _NOTHING * float(k @ k))
    rest, dof = float(reading @ reading) - explained, dof - numbers
    if numbers == 0 or not rest > 0.0:
        return None
    return ShownPlay(base, evidence, output, k, by_row, q, left, reading, square, along, rest / dof, float(dof))


def _explained(square: FloatArray, along: FloatArray, nothing: float) -> tuple[float, int]:
    """Return what the play of both axes explains of the squares, and of how many of them anything is seen."""
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
    """Return (n K, 6) what differs between replications, its (6, 6) products, and which part of the whole it is."""
    on_grid = np.zeros((replications * points, by_row.shape[1]))
    on_grid[dwell] = by_row
    left = GridResiduals(replications, points, q, np.zeros((present.size, 1)), taken, present).projected(on_grid)
    whole = float(np.einsum("nc,nc->", by_row, by_row))
    return left, left.T @ left, float(np.einsum("nc,nc->", left, left)) / whole if whole > 0.0 else 0.0


@remembered(16)
def _at_points(
    by_row: FloatArray,
    pitch_rad: FloatArray,
    roll_rad: FloatArray,
    layout: Layout,
    basis: FloatArray,
    terms: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, int]:
    """Return what is taken out of the means, (K, 6) what that leaves of the play, its products, and what is left."""
    of_zero = layout.mean_by_point(np.asarray(slip_pattern("pitch", pitch_rad, roll_rad)))
    q = spanned(np.hstack([basis, terms, of_zero]))
    means = layout.mean_by_point(by_row)
    left = means - q @ (q.T @ means)
    left[:, np.einsum("kc,kc->c", left, left) <= _NOTHING * layout.points] = 0.0
    return q, left, left.T @ left, layout.points - q.shape[1]
