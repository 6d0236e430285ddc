"""Whether what repeats at the points is of one location: an index of an axis of the table, or one attitude.

The means of the points, beside the model, are weighed by precision and by what is known of the table:
M = A − A B (BᵀA B + D)⁻¹BᵀA, A the weights of the means, B the model and the errors that many points share, D one for
each of the latter. A location is one amount of all its attitudes, or one of each of them; columns h of it explain
(hᵀMy)² / hᵀMh. It is told where it explains more than any other column that is asked for (the terms of low order, what
the order leaves), less the logarithm of the points a number, and where it leaves little else of all that repeats.

What goes alike over the attitudes of an index is no error that differs from attitude to attitude, which is what the
stated uncertainties take a lack of fit for: of an offset at one of n indices an n-th is in that of the sensor.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import log, sqrt
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import LEAST_DOF, PointMeans, independent
from ams.arrays import BoolArray, FloatArray, IntArray
from ams.remembered import remembered
from ams.statistics.distributions import f_tail

_FEWEST_INDICES: Final = 5
"""Of an axis: one of fewer is half of a design."""
_MOST_LOCATIONS: Final = 3
_INDICES_A_LOCATION: Final = 5
"""Of an axis, at the least: of fewer a curve over all of them is as many locations."""
_LEFT_BY_MODEL: Final = 0.02
"""Of the square of a column: what the model leaves less of is hardly told from it."""
_FURTHER: Final = 0.001
"""Chance of one more location."""
_ROUNDING: Final = 1e-6
"""Of the square of a column of another cause: it is told apart where rounding leaves it."""
_OUT_OF_NOISE: Final = 3.0
"""Standard deviations of a χ²."""
_REMAINS: Final = 0.1
"""Of what locations explain: as much may be left beside them, and they are told still."""
_PLAINER: Final = 8.0
"""By how much more a location explains than a term or what the order leaves: it is the less likely of both."""
_AS_WELL: Final = 6.63
"""χ² of one degree of freedom at 1 %: by less another index is not told apart."""
_ALIKE: Final = 0.005
"""Chance of one axis below which what is left goes alike over its indices."""


@dataclass(frozen=True)
class Location:
    """One index of an axis, or one attitude."""

    axis: str
    """"pitch" or "roll"; empty: one attitude."""
    index_deg: float
    """Of the axis; NaN of an attitude."""
    points: BoolArray
    """(K,) which are of it."""
    is_even: bool
    """Whether one amount is off at all its attitudes."""
    size: float
    """That amount, or the root of the mean square, in the output's unit."""
    standard_uncertainty: float
    """Of an amount that is even; NaN elsewhere."""
    labels: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Of its points."""
    or_at_deg: tuple[float, ...] = ()
    """Other indices of the axis that fit as well."""

    @property
    def columns(self) -> FloatArray:
        """(K, c) of what is off."""
        if self.is_even:
            return self.points.astype(float)[:, None]
        return np.eye(self.points.size)[:, self.points]


@dataclass(frozen=True)
class LocationsShown:
    """Of one output."""

    locations: tuple[Location, ...]
    """The plainest first; empty where what repeats is of no location."""
    p_value: float
    """Of the plainest, the number of locations counted; 1 where there is none."""


@dataclass(frozen=True)
class _Index:
    axis: str
    index_deg: float
    points: BoolArray


@dataclass(frozen=True)
class _Candidate:
    """One location, and what it explains."""

    location: Location
    explains: float
    numbers: int

    def score(self, points: int) -> float:
        """Return what it explains, less what so many numbers do by chance, the best of many chosen."""
        return self.explains - self.numbers * log(points)


@dataclass(frozen=True)
class _Weighed:
    """The means of the points as precision weighs them."""

    weights: FloatArray
    """(K,) A"""
    mean: FloatArray
    """(K,) y"""
    beside: FloatArray
    """(K, b) B"""
    shared: int
    """How many columns of B are of errors that many points share."""

    @cached_property
    def inverse(self) -> FloatArray:
        square = self.beside.T @ (self.beside * self.weights[:, None])
        last = np.arange(square.shape[0] - self.shared, square.shape[0])
        square[last, last] += 1.0
        return np.asarray(np.linalg.pinv(square, rcond=1e-12, hermitian=True))

    @cached_property
    def weighted(self) -> FloatArray:
        """A B, (K, b)."""
        return self.beside * self.weights[:, None]

    @cached_property
    def left(self) -> FloatArray:
        """M y, (K,)."""
        seen = self.weighted.T @ self.mean
        return np.asarray(self.weights * self.mean - self.weighted @ (self.inverse @ seen))

    @cached_property
    def of_point(self) -> FloatArray:
        """The diagonal of M, (K,)."""
        return np.asarray(self.weights - np.vecdot(self.weighted @ self.inverse, self.weighted))

    @cached_property
    def is_judged(self) -> BoolArray:
        """Whether the others say anything about a point, (K,)."""
        return np.asarray(self.of_point > _LEFT_BY_MODEL * self.weights)

    @property
    def square(self) -> float:
        return float(self.mean @ self.left)

    @property
    def dof(self) -> int:
        return int(self.mean.size - (self.beside.shape[1] - self.shared))

    def block(self, columns: FloatArray) -> FloatArray:
        """Return (c, c) Hᵀ M H of (K, c) columns."""
        seen = self.weighted.T @ columns
        return np.asarray(columns.T @ (columns * self.weights[:, None]) - seen.T @ self.inverse @ seen)

    def each(self, columns: FloatArray, least: float = _LEFT_BY_MODEL) -> tuple[FloatArray, FloatArray]:
        """Return (c,) what each of (K, c) columns has of y, and its own square; 0 where the model leaves no more of it
        than ``least``.
        """
        seen, whole = self.weighted.T @ columns, self.weights @ columns**2
        square = whole - np.vecdot(seen.T, (self.inverse @ seen).T)
        return self.left @ columns, np.where(square > least * whole, square, 0.0)

    def explained(self, columns: FloatArray) -> tuple[FloatArray, int, float]:
        """Return (c,) the amounts of (K, c) columns together, how many numbers they are and what they explain."""
        values, vectors = np.linalg.eigh(self.block(columns))
        kept = values > _LEFT_BY_MODEL * values.max(initial=0.0)
        along = vectors[:, kept].T @ (columns.T @ self.left)
        return vectors[:, kept] @ (along / values[kept]), int(kept.sum()), float(along @ (along / values[kept]))

    def with_known(self, columns: FloatArray) -> "_Weighed":
        of_model = self.beside.shape[1] - self.shared
        given = independent(np.hstack([self.beside[:, :of_model], columns]))
        return _Weighed(self.weights, self.mean, np.hstack([given, self.beside[:, of_model:]]), self.shared)


def locations_shown(
    evidence: Evidence, output: int, known: FloatArray, rivals: FloatArray, level: float
) -> LocationsShown:
    """Return the locations at which what repeats of an output is off; a chance of NaN where that cannot be asked.

    ``known``: (K, c) of what is explained already. ``rivals``: (K, r) columns, one of which may explain as much.
    ``level``: chance above which none is looked at further.
    """
    weighed, dof = _weighed(evidence, output, known), float(evidence.grid.dof)
    if weighed is None or weighed.dof < LEAST_DOF:
        return LocationsShown((), float("nan"))
    indices, points = _indices(evidence), weighed.mean.size
    found, explained, p_value = list[Location](), 0.0, 1.0
    while len(found) < _MOST_LOCATIONS and weighed.dof >= LEAST_DOF:
        made = _candidates(weighed, indices)
        chance = _chance(made, indices, dof)
        if chance > (_FURTHER if found else level):
            p_value = p_value if found else chance
            break
        best = max(made, key=lambda candidate: candidate.score(points))
        rival = _best_of(weighed, rivals) - log(points)
        if not _has_room(best.location, found, indices) or best.score(points) <= max(rival + _PLAINER, 0.0):
            break
        p_value = p_value if found else chance
        found.append(_with_others(best, made, points))
        explained += best.explains
        weighed = weighed.with_known(best.location.columns)
    if not found:
        return LocationsShown((), p_value)
    remains = weighed.square - weighed.dof
    if remains > max(_OUT_OF_NOISE * sqrt(2.0 * weighed.dof), _REMAINS * explained):
        return LocationsShown((), 1.0)
    labels = np.array(evidence.layout.point_labels)
    return LocationsShown(tuple(replace(location, labels=labels[location.points]) for location in found), p_value)


def alike_over(evidence: Evidence, output: int, known: FloatArray) -> tuple[str, ...]:
    """Return the axes of the table over whose indices what repeats goes alike, against its scatter within them."""
    weighed = _weighed(evidence, output, known)
    if weighed is None:
        return ()
    found = []
    for axis in ("pitch", "roll"):
        columns = [index.points for index in _indices(evidence) if index.axis == axis]
        if not columns:
            continue
        _, numbers, explains = weighed.explained(np.stack(columns, axis=1).astype(float))
        rest, dof = weighed.square - explains, weighed.dof - numbers
        if dof < LEAST_DOF or numbers == 0:
            continue
        ratio = (explains / numbers) / max(rest / dof, 1.0)
        if float(f_tail(ratio, float(numbers), float(dof))) <= _ALIKE:
            found.append(axis)
    return tuple(found)


def _weighed(evidence: Evidence, output: int, known: FloatArray) -> _Weighed | None:
    if evidence.sums is None:
        return None
    given = independent(np.hstack([evidence.basis, known])) if known.shape[1] > 0 else evidence.basis
    means: PointMeans = evidence.means(output, given)
    if not means.precision_variance > 0.0:
        return None
    beside = np.hstack([given, means.common])
    return _Weighed(means.readings / means.precision_variance, means.mean, beside, means.common.shape[1])


def _candidates(weighed: _Weighed, indices: Sequence[_Index]) -> list[_Candidate]:
    """Return every index as one amount, plain ones as one of each attitude as well, and the plainest attitude."""
    found = []
    of_point = weighed.left**2 * np.divide(
        1.0, weighed.of_point, out=np.zeros_like(weighed.left), where=weighed.is_judged
    )
    if indices:
        seen, squares = weighed.each(np.stack([index.points for index in indices], axis=1).astype(float))
        for index, along, square in zip(indices, seen.tolist(), squares.tolist(), strict=True):
            if square > 0.0:
                location = Location(index.axis, index.index_deg, index.points, True, along / square, square**-0.5)
                found.append(_Candidate(location, along**2 / square, 1))
    for index in indices:
        count = int(index.points.sum())
        if of_point[index.points].sum() > count + _OUT_OF_NOISE * sqrt(2.0 * count):
            amounts, numbers, explains = weighed.explained(np.eye(index.points.size)[:, index.points])
            size = float(np.sqrt(np.mean(amounts**2)))
            location = Location(index.axis, index.index_deg, index.points, False, size, float("nan"))
            found.append(_Candidate(location, explains, numbers))
    if weighed.is_judged.any():
        at = int(np.argmax(of_point))
        square = float(weighed.of_point[at])
        location = Location(
            "", float("nan"), np.arange(of_point.size) == at, True, float(weighed.left[at]) / square, square**-0.5
        )
        found.append(_Candidate(location, float(of_point[at]), 1))
    return found


def _chance(made: Sequence[_Candidate], indices: Sequence[_Index], dof: float) -> float:
    """Return the chance of as much at any location, be it one amount of it or one of each of its attitudes."""
    if not made:
        return 1.0
    points = made[0].location.points.size
    counts = [len(indices) + points if each.numbers == 1 else len(indices) for each in made]
    numbers = np.array([each.numbers for each in made], dtype=float)
    ratio = np.array([each.explains for each in made]) / numbers
    return min(1.0, float(np.min(2.0 * np.array(counts) * f_tail(ratio, numbers, dof))))


def _has_room(location: Location, found: Sequence[Location], indices: Sequence[_Index]) -> bool:
    """Return whether the axis of a location has indices enough for one more, beside those that are found."""
    count = sum(index.axis == location.axis for index in indices)
    return not location.axis or (1 + sum(other.axis == location.axis for other in found)) * _INDICES_A_LOCATION <= count


def _best_of(weighed: _Weighed, rivals: FloatArray) -> float:
    """Return what that of (K, r) columns explains which explains most."""
    seen, squares = weighed.each(rivals, _ROUNDING)
    return float(np.max(np.divide(seen**2, squares, out=np.zeros_like(seen), where=squares > 0.0), initial=0.0))


def _with_others(best: _Candidate, made: Sequence[_Candidate], points: int) -> Location:
    """Return a location with the other indices of its axis that fit as well."""
    location, least = best.location, best.score(points) - _AS_WELL
    others = [each for each in made if each.location.axis == location.axis != "" and each.score(points) > least]
    as_well = {each.location.index_deg for each in others}
    return replace(location, or_at_deg=tuple(sorted(as_well - {location.index_deg})))


def _indices(evidence: Evidence) -> tuple[_Index, ...]:
    layout, rows = evidence.layout, evidence.rows
    return _indices_of(layout.mean_by_point(rows.pitch_rad), _by_first(evidence))


def _by_first(evidence: Evidence) -> FloatArray:
    """Return (K,) the roll of the first row of every point: a mean would lie between −180° and 180°."""
    layout = evidence.layout
    first = np.zeros(layout.points)
    first[layout.point[::-1]] = evidence.rows.roll_rad[::-1]
    return first


@remembered(16)
def _indices_of(pitch_rad: FloatArray, roll_rad: FloatArray) -> tuple[_Index, ...]:
    found = []
    pitch = np.round(np.rad2deg(pitch_rad), 4) + 0.0
    roll = np.round(np.rad2deg(np.arctan2(np.sin(roll_rad), np.cos(roll_rad))), 4) + 0.0
    roll = np.where(roll == 180.0, -180.0, roll)
    for axis, stood in (("pitch", pitch), ("roll", roll)):
        values = np.unique(stood)
        if values.size >= _FEWEST_INDICES:
            of_axis = [_Index(axis, float(value), stood == value) for value in values]
            found += [index for index in of_axis if index.points.sum() > 1]
    return tuple(found)
