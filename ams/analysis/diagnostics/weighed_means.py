"""The means of the points as precision and what is known of the table weigh them, beside the model.

M = A − A B (BᵀA B + D)⁻¹BᵀA, A the weights of the means, B the model and the errors that many points share, D one for
each of the latter. Columns H explain yᵀM H (HᵀM H)⁻¹HᵀM y of means y. Where no errors are shared, all but a scale of M
is of the design alone.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import independent
from ams.arrays import BoolArray, FloatArray
from ams.remembered import remembered
from ams.solve.layout import Layout

LEFT_BY_MODEL: Final = 0.02
"""Of the square of a column: what the model leaves less of is hardly told from it."""


@dataclass(frozen=True)
class Weighing:
    """M, over a variance that it is of."""

    weights: FloatArray
    """(K,) A"""
    beside: FloatArray
    """(K, b) B"""
    shared: int
    """How many columns of B are of errors that many points share."""
    weighted: FloatArray
    """A B, (K, b)."""
    inverse: FloatArray
    """(b, b)"""
    of_point: FloatArray
    """The diagonal of M, (K,)."""
    of_index: FloatArray
    """(I,) squares of the columns of all indices; 0 where the model leaves hardly more."""

    @property
    def of_model(self) -> FloatArray:
        """(K, …) the columns of B that are of the model."""
        return self.beside[:, : self.beside.shape[1] - self.shared]

    def squares(self, columns: FloatArray, least: float = LEFT_BY_MODEL) -> FloatArray:
        """Return the squares hᵀMh of (K, c) columns, (c,); 0 where the model leaves no more of one than ``least``."""
        seen, whole = self.weighted.T @ columns, self.weights @ columns**2
        square = whole - np.vecdot(seen.T, (self.inverse @ seen).T)
        return np.where(square > least * whole, square, 0.0)


@dataclass(frozen=True)
class WeighedMeans:
    """Of one output."""

    by: Weighing
    variance: float
    """That ``by`` is of."""
    mean: FloatArray
    """(K,) y"""

    @cached_property
    def left(self) -> FloatArray:
        """M y, (K,)."""
        seen = self.by.weighted.T @ self.mean
        return np.asarray((self.by.weights * self.mean - self.by.weighted @ (self.by.inverse @ seen)) / self.variance)

    @cached_property
    def of_point(self) -> FloatArray:
        """The diagonal of M, (K,)."""
        return self.by.of_point / self.variance

    @cached_property
    def is_judged(self) -> BoolArray:
        """Whether the others say anything about a point, (K,)."""
        return np.asarray(self.by.of_point > LEFT_BY_MODEL * self.by.weights)

    @property
    def square(self) -> float:
        return float(self.mean @ self.left)

    @property
    def dof(self) -> int:
        return int(self.mean.size - self.by.of_model.shape[1])

    def explained(self, columns: FloatArray) -> tuple[FloatArray, int, float]:
        """Return (c,) the amounts of (K, c) columns together, how many numbers they are and what they explain."""
        seen = self.by.weighted.T @ columns
        whole = columns.T @ (columns * self.by.weights[:, None])
        return self._explained(whole - seen.T @ self.by.inverse @ seen, columns.T @ self.left)

    def explained_by_each(self, points: BoolArray) -> tuple[FloatArray, int, float]:
        """Return the same of one column for each of some points."""
        seen = self.by.weighted[points]
        return self._explained(np.diag(self.by.weights[points]) - seen @ self.by.inverse @ seen.T, self.left[points])

    def _explained(self, block: FloatArray, seen: FloatArray) -> tuple[FloatArray, int, float]:
        """Return it by (c, c) HᵀM H, of the variance that ``by`` is of, and (c,) HᵀM y."""
        values, vectors = np.linalg.eigh(block / self.variance)
        kept = values > LEFT_BY_MODEL * values.max(initial=0.0)
        along = vectors[:, kept].T @ seen
        return vectors[:, kept] @ (along / values[kept]), int(kept.sum()), float(along @ (along / values[kept]))

    def with_known(self, columns: FloatArray, of_indices: FloatArray) -> "WeighedMeans":
        """Return the same beside (K, c) more columns."""
        by, of_model = self.by, self.by.of_model
        given = independent(np.hstack([of_model, columns]))
        return replace(self, by=_weighing(by.weights, given, by.beside[:, of_model.shape[1] :], of_indices))


def weighed_means(evidence: Evidence, output: int, known: FloatArray, of_indices: FloatArray) -> WeighedMeans | None:
    """Return the means of an output beside (K, c) known columns; None where no precision is known.

    ``of_indices``: (K, I) columns whose squares are asked for.
    """
    if evidence.sums is None:
        return None
    given = independent(np.hstack([evidence.basis, known])) if known.shape[1] > 0 else evidence.basis
    means = evidence.means(output, given)
    variance = means.precision_variance
    if not variance > 0.0:
        return None
    if means.common.shape[1] == 0:
        return WeighedMeans(_weighing_alone(evidence.layout, given, of_indices), variance, means.mean)
    return WeighedMeans(_weighing(means.readings / variance, given, means.common, of_indices), 1.0, means.mean)


def _weighing(weights: FloatArray, of_model: FloatArray, shared: FloatArray, of_indices: FloatArray) -> Weighing:
    beside, model = np.hstack([of_model, shared]), of_model.shape[1]
    weighted = beside * weights[:, None]
    square = beside.T @ weighted
    last = np.arange(model, square.shape[0])
    square[last, last] += 1.0
    inverse = np.asarray(np.linalg.pinv(square, rcond=1e-12, hermitian=True))
    of_point = np.asarray(weights - np.vecdot(weighted @ inverse, weighted))
    found = Weighing(weights, beside, last.size, weighted, inverse, of_point, np.zeros(0))
    return replace(found, of_index=found.squares(of_indices))


@remembered(16)
def _weighing_alone(layout: Layout, of_model: FloatArray, of_indices: FloatArray) -> Weighing:
    """Return M of means of unit variance that share no errors."""
    return _weighing(layout.relative_readings, of_model, np.zeros((layout.points, 0)), of_indices)
