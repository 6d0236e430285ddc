"""What repeats in every replication: the points' means, with the errors that many points share.

Rows are the points, y = X c + Σ γ h + J δ + e: J the common errors of the table and of certificates with unit variance,
e of variance ``variance`` over the readings of a point. All is told by one Gram matrix of the columns [X | h | y] under
the inverse of that covariance (Woodbury), from which any few columns are tested by elimination. Without common errors
the variance is the scatter of the points about the whole model, which holds lack of fit; with them it is what is left
beside them, never less than precision.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import NamedTuple

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.remembered import remembered
from ams.solve.lone_errors import lone_apart
from ams.solve.scatter import points_scatter
from ams.statistics.distributions import f_tail

LEAST_DOF = 3
"""Degrees of freedom that a test of the means of the points needs."""
_NOTHING_LEFT = 1e-10
"""Of the square of a column: less is left beside the others by rounding."""
_ALIKE = 1e-6
"""Of the squares of columns of unit length, together: a combination with less of it left is told by none of them."""
_SMALLEST = 1e-60
"""Volts²: keeps weights finite where nothing scatters."""


@dataclass(frozen=True)
class PointMeans:
    """Of one output."""

    basis: FloatArray
    """(K, P) what is given and never tested."""
    mean: FloatArray
    """(K,) means over the replications with their drift taken out; less any fit by ``basis``."""
    readings: FloatArray
    """(K,) how many readings, over their average."""
    common: FloatArray
    """(K, q)"""
    precision_variance: float
    """Of a mean of average readings; 0 where it is not known."""


class Tested(NamedTuple):
    """One column beside what is given."""

    coefficient: float
    standard_uncertainty: float
    p_value: float


class Joint(NamedTuple):
    """Several columns together beside what is given."""

    coefficients: FloatArray
    """(c,)"""
    covariance: FloatArray
    """(c, c)"""
    p_value: float


@dataclass(frozen=True)
class Elimination:
    """Columns to test, under one covariance."""

    gram: FloatArray
    """[basis | columns | y]"""
    given: int
    columns: int
    dof: int
    design: FloatArray
    """(K, …) [basis | columns]"""

    def test(self, column: int, beside: tuple[int, ...] = ()) -> Tested:
        """Test one column with the basis and the columns ``beside`` given; NaN where they leave nothing of it."""
        gram, given = self.gram, self._known(beside)
        rest = [self.given + column, self.given + self.columns]
        from_given = gram[given]
        block = gram[rest][:, rest] - gram[rest][:, given] @ np.linalg.solve(from_given[:, given], from_given[:, rest])
        if self.dof < LEAST_DOF or not block[0, 0] > _NOTHING_LEFT * gram[rest[0], rest[0]]:
            return Tested(np.nan, np.nan, np.nan)
        coefficient = block[0, 1] / block[0, 0]
        p_value = float(f_tail(coefficient * block[0, 1], 1.0, float(self.dof)))
        return Tested(float(coefficient), float(block[0, 0] ** -0.5), p_value)

    def each(self) -> list[Tested]:
        """Test every column alone beside the basis."""
        given, tested = slice(0, self.given), slice(self.given, self.given + self.columns)
        y = self.given + self.columns
        across = self.gram[given, self.given :]
        solved = np.linalg.solve(self.gram[given, given], across)
        whole = self.gram.diagonal()[tested]
        left = whole - np.vecdot(across[:, :-1].T, solved[:, :-1].T)
        with_y = self.gram[tested, y] - across[:, :-1].T @ solved[:, -1]
        is_left = (left > _NOTHING_LEFT * whole) & (self.dof >= LEAST_DOF)
        left = np.where(is_left, left, np.nan)
        coefficient = with_y / left
        p_value = f_tail(coefficient * with_y, 1.0, float(self.dof))
        columns = (coefficient.tolist(), (left**-0.5).tolist(), np.where(is_left, p_value, np.nan).tolist())
        return [Tested(*numbers) for numbers in zip(*columns, strict=True)]

    def together(self, columns: Sequence[int], beside: tuple[int, ...] = ()) -> Joint | None:
        """Test several columns at once, those ``beside`` given; None where a combination of them leaves nothing."""
        gram, known = self.gram, self._known(beside)
        rest = [self.given + column for column in (*columns, self.columns)]
        across = gram[np.ix_(known, rest)]
        left = gram[np.ix_(rest, rest)] - across.T @ np.linalg.solve(gram[np.ix_(known, known)], across)
        lengths, size = np.sqrt(np.diagonal(gram)[rest[:-1]]), len(columns)
        alike = left[:-1, :-1] / np.outer(lengths, lengths)
        if self.dof < LEAST_DOF or not size or not np.linalg.eigvalsh(alike)[0] > _ALIKE:
            return None
        covariance = np.asarray(np.linalg.inv(left[:-1, :-1]), dtype=float)
        coefficients = covariance @ left[:-1, -1]
        p_value = float(f_tail(float(coefficients @ left[:-1, -1]) / size, float(size), float(self.dof)))
        return Joint(coefficients, covariance, p_value)

    def correlation(self, beside: tuple[int, ...] = ()) -> FloatArray:
        """Return the (c, c) correlation of the tests of the columns, those ``beside`` given.

        It is 0 where they leave nothing of a column.
        """
        known = self._known(beside)
        tested = slice(self.given, self.given + self.columns)
        across, whole = self.gram[known, tested], self.gram[tested, tested]
        left = whole - across.T @ np.linalg.solve(self.gram[np.ix_(known, known)], across)
        square = np.diagonal(left)
        scale = np.zeros(self.columns)
        is_left = square > _NOTHING_LEFT * np.diagonal(whole)
        scale[is_left] = square[is_left] ** -0.5
        return np.asarray(left * np.outer(scale, scale))

    def _known(self, beside: tuple[int, ...]) -> list[int]:
        """Return the places of the basis and of the columns beside of which those before leave anything."""
        if beside not in self._known_beside:
            self._known_beside[beside] = self._left_beside(beside)
        return self._known_beside[beside]

    @cached_property
    def _known_beside(self) -> dict[tuple[int, ...], list[int]]:
        """Every column of a stage is tested beside the same others."""
        return {}

    def _left_beside(self, beside: tuple[int, ...]) -> list[int]:
        gram, known = self.gram, list(range(self.given))
        for index in (self.given + column for column in beside):
            across = gram[known, index]
            left = gram[index, index] - across @ np.linalg.solve(gram[np.ix_(known, known)], across)
            if left > _NOTHING_LEFT * gram[index, index]:
                known.append(index)
        return known

    @property
    def chi_square(self) -> float:
        """What is left of y beside the basis, as a sum of squares over its variance."""
        known, y = slice(0, self.given), self.given + self.columns
        explained = self.gram[y, known] @ np.linalg.solve(self.gram[known, known], self.gram[known, y])
        return float(self.gram[y, y] - explained)


def eliminate(
    means: PointMeans, columns: FloatArray, further: FloatArray, unshared: FloatArray | None = None
) -> Elimination:
    """Return (K, c) columns ready to be tested; ``further`` (K, f) count as explained in the scatter as well.

    ``further`` may hold what the basis or the columns hold: it is what many outputs share, and is factored once.
    ``unshared`` (K, …): those of the basis and the columns that it does not hold; None: any of them.
    """
    joined = np.column_stack([means.basis, columns, means.mean])
    design = joined[:, :-1]
    whole = _independent_of(further, design if unshared is None else unshared)
    dof = means.mean.size - whole.shape[1]
    variance = _variance(means, whole, dof)
    return Elimination(gram_of(means, joined, variance), means.basis.shape[1], columns.shape[1], dof, design)


def gram_of(means: PointMeans, joined: FloatArray, variance: float) -> FloatArray:
    """Return the Gram matrix of the columns [basis | columns | y] under the inverse of the covariance."""
    if means.common.shape[1] == 0:
        return np.asarray((joined * (means.readings / variance)[:, None]).T @ joined)
    alone, common = lone_apart(means.common)
    weights = 1.0 / (variance / means.readings + alone)
    weighted = joined * weights[:, None]
    gram = weighted.T @ joined
    across = weighted.T @ common
    inner = common.T @ (common * weights[:, None])
    inner[np.diag_indices_from(inner)] += 1.0
    return np.asarray(gram - across @ np.linalg.solve(inner, across.T))


def _variance(means: PointMeans, whole: FloatArray, dof: int) -> float:
    """Return that of a mean of average readings."""
    tiny = max(_NOTHING_LEFT * float(means.mean @ means.mean) / means.mean.size, _SMALLEST)
    if dof < LEAST_DOF:
        return max(means.precision_variance, tiny)
    if means.common.shape[1] == 0:
        root = np.sqrt(means.readings)
        q = whole if np.all(root == 1.0) else np.linalg.qr(root[:, None] * whole)[0]
        y = root * means.mean
        left = y - q @ (q.T @ y)
        return max(float(left @ left) / dof, tiny)
    scatter = points_scatter(whole, means.mean[:, None], means.common[None], means.readings)
    return max(float(scatter.variance[0]), means.precision_variance, tiny)


def _independent_of(shared: FloatArray, added: FloatArray) -> FloatArray:
    """Return orthonormal columns of both, those that are shared factored once for all outputs."""
    q = spanned(shared)
    left = added - q @ (q.T @ added)
    length = np.vecdot(added.T, added.T)
    found: list[FloatArray] = []
    for index in np.flatnonzero(np.vecdot(left.T, left.T) > _NOTHING_LEFT * length).tolist():
        column = left[:, index].copy()
        for other in found:
            column -= other * (other @ column)
        square = float(column @ column)
        if square > _NOTHING_LEFT * length[index]:
            found.append(column / sqrt(square))
    return np.column_stack([q, *found])


@remembered(16)
def spanned(columns: FloatArray) -> FloatArray:
    """Return orthonormal columns of all that is independent in (K, c) columns that many outputs share."""
    columns = _of_something(columns)
    q, r = np.linalg.qr(columns)
    is_left = _is_left(columns, r)
    return q if is_left.all() else np.linalg.qr(columns[:, is_left])[0]


def independent(columns: FloatArray) -> FloatArray:
    """Return the columns that are independent of those before them."""
    columns = _of_something(columns)
    r = np.asarray(np.linalg.qr(columns, mode="r"))
    return columns[:, _is_left(columns, r)]


def _of_something(columns: FloatArray) -> FloatArray:
    """Return the columns that are not nothing: one of those would take a row of R from the others."""
    return columns[:, np.any(columns != 0.0, axis=0)]


def _is_left(columns: FloatArray, r: FloatArray) -> BoolArray:
    """Return (c,) of which columns those before them leave something, by their triangular factor."""
    diagonal = np.zeros(columns.shape[1])
    diagonal[: columns.shape[0]] = np.diag(r)
    return np.asarray(diagonal**2 > _NOTHING_LEFT * np.vecdot(columns.T, columns.T))
