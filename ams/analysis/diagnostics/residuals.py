"""What every dwell says beside the other replications of its point and the other points of its replication.

Every point has an effect of its own and every replication parameters of its own: what is left is precision alone, with
no lack of fit and no drift in it. The points of all replications make one grid; the residual maker of the whole grid is
(1 − J/n) ⊗ (1 − QQᵀ), Q an orthonormal basis of the model at the points. A dwell that is missing, or that is not
believed, is taken out of the grid by its own columns of that maker (Beckman and Cook 1983), so that nothing is solved
again.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.remembered import remembered
from ams.solve.linear_form import orthogonal
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, median

_GONE = 1e-9
"""Of a residual's variance: a dwell that nothing else says anything about; of a column, and of its square beside others
of length one: nothing but rounding."""


@dataclass(frozen=True)
class GridResiduals:
    """Residuals of m outputs over n replications of K points, dwells numbered replication by replication."""

    replications: int
    points: int
    q: FloatArray
    """(K, P) orthonormal."""
    residuals: FloatArray
    """(n K, m); zero where a dwell is taken out."""
    taken: FloatArray
    """(n K, d) orthonormal directions that the dwells taken out had in the residuals."""
    present: FloatArray
    """(n K,) one where there is a dwell, zero where it is taken out."""

    @property
    def dof(self) -> int:
        """Degrees of freedom that are left."""
        return max(self.replications - 1, 1) * (self.points - int(self.q.shape[1])) - int(self.taken.shape[1])

    @cached_property
    def squares(self) -> FloatArray:
        """(m,) sums of squares."""
        return np.asarray(np.einsum("im,im->m", self.residuals, self.residuals))

    @cached_property
    def _judgement(self) -> "_Judgement":
        if self.taken.shape[1] == 0 and self._are_all_present:
            return _of_whole_grid(self.replications, self.q)
        left = _leverages(self.replications, self.q)
        if self.taken.shape[1] > 0:
            left = left - np.einsum("id,id->i", self.taken, self.taken)
            left = np.where(left > _GONE, left, 0.0)
        return _judgement(left * self.present)

    @property
    def leverages(self) -> FloatArray:
        """(n K,) variance of each residual for dwells of unit variance."""
        return self._judgement.leverages

    @property
    def judged(self) -> BoolArray:
        """(n K,) whether others say anything about a dwell."""
        return self._judgement.judged

    @property
    def weights(self) -> FloatArray:
        """(n K,) one over the leverages; 0 where a dwell is not judged."""
        return self._judgement.weights

    @property
    def spread(self) -> FloatArray:
        """(n K,) standard deviation of each residual for dwells of unit variance; one where a dwell is not judged."""
        return self._judgement.spread

    @cached_property
    def away(self) -> FloatArray:
        """(n K,) how far each dwell of the first output is from what the others say, over ``spread``; 0: not judged."""
        away = np.abs(self.residuals[:, 0] / self.spread)
        return away if self._are_all_judged else away * self.judged

    @cached_property
    def typical_sd(self) -> float:
        """Standard deviation of a dwell of the first output, by the median of those that are judged."""
        return SD_PER_MEDIAN_DEVIATION * median(self.away if self._are_all_judged else self.away[self.judged])

    @property
    def _are_all_judged(self) -> bool:
        return self._judgement.are_all_judged

    @cached_property
    def _are_all_present(self) -> bool:
        return bool(self.present.all())

    def column(self, dwell: int) -> FloatArray:
        """Return the (n K,) column of the residual maker for one dwell."""
        replication, point = divmod(dwell, self.points)
        within = -self.q @ self.q[point]
        within[point] += 1.0
        between = np.array([self._between(r - replication) for r in range(self.replications)])
        whole = np.outer(between, within).ravel()
        return np.asarray(whole - self.taken @ self.taken[dwell])

    def reads_off(self, dwell: int) -> float:
        """Return how far a dwell of the first output reads off what all others say."""
        return float(self.residuals[dwell, 0] / self.column(dwell)[dwell])

    def without(self, dwell: int) -> "GridResiduals":
        """Return what the others say when a dwell is taken out."""
        column, present = self.column(dwell), self.present.copy()
        present[dwell] = 0.0
        if column[dwell] <= _GONE:
            return replace(self, present=present)
        direction = column / np.sqrt(column[dwell])
        residuals = self.residuals - np.outer(direction, self.residuals[dwell] / np.sqrt(column[dwell]))
        residuals[dwell] = 0.0
        return replace(self, residuals=residuals, taken=np.column_stack([self.taken, direction]), present=present)

    def beside(self, columns: FloatArray) -> "GridResiduals":
        """Return what is left when (n K, c) further columns are known as well.

        What rounding leaves of a column that is known already has no direction: it would turn those of the others.
        """
        left = self.projected(columns)
        lengths = np.linalg.norm(left, axis=0)
        is_new = lengths > _GONE * np.linalg.norm(columns, axis=0)
        directions, sizes, _ = np.linalg.svd(left[:, is_new] / lengths[is_new], full_matrices=False)
        q = directions[:, sizes**2 > _GONE]
        residuals = self.residuals - q @ (q.T @ self.residuals)
        return replace(self, residuals=residuals, taken=np.column_stack([self.taken, q]))

    def of(self, output: int) -> "GridResiduals":
        """Return those of one output alone."""
        if self.residuals.shape[1] == 1:
            return self
        return replace(self, residuals=self.residuals[:, output : output + 1])

    def projected(self, columns: FloatArray) -> FloatArray:
        """Return what is left of (n K, c) columns when the residual maker acts on them."""
        if columns.shape[1] == 1:
            line = columns.reshape(self.replications, self.points)
            if self.replications > 1:
                line = line - line.sum(axis=0) / self.replications
            flat = (line - (line @ self.q) @ self.q.T).reshape(-1, 1)
        else:
            grid = columns.reshape(self.replications, self.points, -1)
            if self.replications > 1:
                grid = grid - grid.mean(axis=0)
            flat = (grid - self.q @ (self.q.T @ grid)).reshape(self.residuals.shape[0], -1)
        if self.taken.shape[1] > 0:
            flat = flat - self.taken @ (self.taken.T @ flat)
        return np.asarray(flat if self._are_all_present else flat * self.present[:, None])

    def _between(self, apart: int) -> float:
        """Return an element of the replications' part of the residual maker, on its diagonal or off it."""
        return _between(self.replications, apart)


def _between(replications: int, apart: int) -> float:
    if replications == 1:
        return 1.0
    return (1.0 if apart == 0 else 0.0) - 1.0 / replications


class _Judgement(NamedTuple):
    """What the dwells of a grid are judged by, whatever the outputs are."""

    leverages: FloatArray
    judged: BoolArray
    weights: FloatArray
    spread: FloatArray
    are_all_judged: bool


def _judgement(leverages: FloatArray) -> _Judgement:
    judged = leverages > 0.0
    weights = np.divide(1.0, leverages, out=np.zeros_like(leverages), where=judged)
    return _Judgement(leverages, judged, weights, np.sqrt(np.where(judged, leverages, 1.0)), bool(judged.all()))


@remembered(16)
def _of_whole_grid(replications: int, q: FloatArray) -> _Judgement:
    return _judgement(_leverages(replications, q))


@remembered(16)
def _leverages(replications: int, q: FloatArray) -> FloatArray:
    """Return the (n K,) variances of the residuals where no dwell is taken out."""
    left = np.tile(_between(replications, 0) * (1.0 - np.einsum("kp,kp->k", q, q)), replications)
    return np.where(left > _GONE, left, 0.0)


def grid_residuals(
    basis: FloatArray, outputs: FloatArray, dwell: IntArray, replications: int, points: int
) -> GridResiduals:
    """Return the residuals of (N, m) outputs, less any one fit, whose rows are the (N,) dwells of the grid.

    ``basis`` (K, P) is the model at the points.
    """
    grid = np.zeros((replications * points, outputs.shape[1]))
    grid[dwell] = outputs
    q = orthogonal(basis)[0]
    taken, present = _left_out(replications, points, q, dwell)
    empty = GridResiduals(replications, points, q, grid, taken, present)
    return replace(empty, residuals=empty.projected(grid))


@remembered(6)
def _left_out(replications: int, points: int, q: FloatArray, dwell: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return what the dwells that are missing among all had in the residuals, (n K, d) orthonormal, and what is there.

    Second: (n K,) one where there is a dwell. With C the columns of the residual maker M for the missing ones, CᵀC is
    the block of M at them, as M is a projection.
    """
    present = np.zeros(replications * points)
    present[dwell] = 1.0
    missing = np.flatnonzero(present == 0.0)
    nothing = np.zeros((present.size, 0))
    if missing.size == 0:
        return nothing, present
    dwells = np.zeros((present.size, missing.size))
    dwells[missing, np.arange(missing.size)] = 1.0
    columns = GridResiduals(replications, points, q, dwells, nothing, np.ones(present.size)).projected(dwells)
    values, vectors = np.linalg.eigh(columns[missing])
    is_left = values > _GONE
    return columns @ (vectors[:, is_left] / np.sqrt(values[is_left])), present
