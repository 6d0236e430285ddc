"""What the tests of one solution look at, made once for all its sensor axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isnan

import numpy as np

from ams.analysis.diagnostics.point_means import PointMeans
from ams.analysis.diagnostics.residuals import GridResiduals, grid_residuals
from ams.analysis.replication import ReplicationColumns
from ams.arrays import FloatArray, IntArray
from ams.models.model import Model
from ams.observations import Observations
from ams.solve.dwell_order import attitudes_repeat, order_repeats, rows_in_time
from ams.solve.layout import Layout
from ams.solve.replicated import ReplicatedSums

_ROUNDING = 32.0 * float(np.finfo(float).eps)
"""Of the largest fitted output: a scatter below it is of the arithmetic."""
_NOTHING = 1e-9
"""Of the largest singular value: a direction that is only rounding."""
_HARDLY, _PLAIN = 0.02, 3.0
"""Of columns: a combination that departures see so much less of than of another is taken out where it is plain beside
their scatter."""
_FEW = 0.75
"""Of what the offsets of the replications leave: where their other parameters leave less, a dwell hides in them."""


@dataclass(frozen=True)
class Evidence:
    """Of m sensor axes that were measured at the same rows."""

    rows: Observations
    layout: Layout
    models: Sequence[Model]
    """(m)"""
    basis: FloatArray
    """(K, P) at the points, of what a replication determines alone."""
    left: FloatArray
    """(N, m) residuals of the ordinary fit."""
    fitted: FloatArray
    """(N, m)"""
    primary: FloatArray
    """(m, all) the reported primary parameters."""
    alone: FloatArray
    """(P, m) the ordinary estimates of what a replication determines alone."""
    common: Sequence[FloatArray]
    """(m) columns (K, q) of errors that many points share, one standard uncertainty each."""
    sums: ReplicatedSums | None
    """None with one replication."""
    replication: ReplicationColumns | None

    @cached_property
    def time_order(self) -> IntArray:
        """(N,) the rows in the order of time; without times the order of the rows stands for it."""
        return rows_in_time(self.rows.time_s, self.layout.rows)

    @cached_property
    def order_repeats(self) -> bool:
        """Whether every replication visits all points at the same attitudes in the same order."""
        rows = self.rows
        angles_rad = (rows.pitch_rad, rows.roll_rad, *(() if rows.yaw_rad is None else (rows.yaw_rad,)))
        return attitudes_repeat(self.layout, *angles_rad) and order_repeats(self.time_order, self.layout)

    @property
    def dwell(self) -> IntArray:
        """(N,) number of every row in the grid of all replications and points."""
        return self.layout.dwell

    @cached_property
    def grid(self) -> GridResiduals:
        """What every dwell says beside the others."""
        return grid_residuals(self.basis, self.left, self.dwell, self.layout.replications, self.layout.points)

    @cached_property
    def _steady_grid(self) -> GridResiduals:
        layout = self.layout
        offset = np.ones((layout.points, 1))
        return grid_residuals(offset, self.left, self.dwell, layout.replications, layout.points)

    def steady_grid_of(self, output: int) -> GridResiduals | None:
        """Return the same of an output whose replications differ by an offset alone; None where that is hardly more."""
        points, parameters = self.basis.shape
        if self.sums is None or points - parameters >= _FEW * (points - 1):
            return None
        return self._steady_grid.of(output)

    @cached_property
    def precision_variance(self) -> FloatArray:
        """(m,) of one dwell, from the grid; NaN where it is not known or no more than rounding."""
        dof = self.grid.dof
        variance = self.grid.squares / dof if dof > 0 else np.full(self.left.shape[1], np.nan)
        largest = np.abs(self.fitted).max(axis=0)
        return np.where(np.sqrt(variance) > _ROUNDING * largest, variance, np.nan)

    @cached_property
    def sensed(self) -> FloatArray:
        """(N, m) what the outputs sense beside their offset, over its largest."""
        centred = self.fitted - self.fitted.sum(axis=0) / self.layout.rows
        largest = np.abs(centred).max(axis=0)
        return np.asarray(centred / np.where(largest > 0.0, largest, 1.0))

    @cached_property
    def point_effects(self) -> FloatArray:
        """(K, m) mean residual of every point, the drift of the replications taken out."""
        return self.layout.mean_by_point(self.left) if self.sums is None else self.sums.point_effects

    @cached_property
    def departures(self) -> FloatArray:
        """(N, m) what differs from replication to replication: drift and precision."""
        return self.layout.about_points(self.left)

    def part_of(self, output: int, columns: FloatArray, beside: FloatArray | None = None) -> FloatArray:
        """Return (N,) what (N, c) columns explain of an output, beside the effects of points and (N, d) others."""
        every = columns if beside is None else np.hstack([columns, beside])
        lengths = np.linalg.norm(every, axis=0)
        lengths = np.where(lengths > 0.0, lengths, 1.0)
        seen = self.layout.about_points(every) / lengths
        left, sizes, right = np.linalg.svd(seen, full_matrices=False)
        along = left.T @ self.departures[:, output]
        # What the replications hardly differ by, such as a cosine of pitch where all before it were of two pitches, is
        # what is read off them a hundredfold: noise would be taken out as an effect of all rows.
        plain = np.abs(along) > _PLAIN * float(np.sqrt(np.nan_to_num(self.precision_variance[output])))
        kept = (sizes > _NOTHING * sizes.max(initial=0.0)) & (plain | (sizes > _HARDLY * sizes.max(initial=0.0)))
        found = right[kept].T @ (along[kept] / sizes[kept]) / lengths
        return np.asarray(columns @ found[: columns.shape[1]])

    def on_grid(self, columns: FloatArray) -> FloatArray:
        """Return (N, c) columns on the grid of all replications and points, zero where a dwell is missing."""
        grid = np.zeros((self.layout.replications * self.layout.points, columns.shape[1]))
        grid[self.dwell] = columns
        return grid

    def means(self, output: int, given: FloatArray, added: FloatArray | None = None) -> PointMeans:
        """Return the point means of one output; ``added`` (K,) is put back to what the fit left."""
        mean = self.point_effects[:, output] if added is None else self.point_effects[:, output] + added
        readings, typical = self.layout.relative_readings, self.layout.typical_readings
        variance = float(self.precision_variance[output])
        of_a_dwell = 0.0 if self.sums is None or isnan(variance) else variance
        common = self.common[output] if self.common else np.zeros((self.layout.points, 0))
        if self.sums is not None and self.sums.drift_left.shape[1] > 0:
            common = np.hstack([common, np.sqrt(of_a_dwell) * self.sums.drift_left])
        return PointMeans(given, mean, readings, common, of_a_dwell / typical)
