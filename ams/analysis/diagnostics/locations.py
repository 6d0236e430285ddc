"""Whether what repeats at the points is of one location: an index of an axis of the table, or one attitude.

The means of the points, beside the model, are weighed by precision and by what is known of the table
(:mod:`ams.analysis.diagnostics.weighed_means`). A location is one amount of all its attitudes, or one of each of them;
columns h of it explain (hᵀMy)² / hᵀMh. It is told where it explains more than any other column that is asked for (the
terms of low order, what the order leaves), less the logarithm of the points a number, and where it leaves little else
of all that repeats.

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
from ams.analysis.diagnostics.point_means import LEAST_DOF
from ams.analysis.diagnostics.weighed_means import WeighedMeans, weighed_means
from ams.arrays import BoolArray, FloatArray, IntArray
from ams.inputs.indices import index_around, index_of
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.statistics.distributions import f_tail

_FEWEST_INDICES: Final = 5
"""Of an axis: one of fewer is half of a design."""
_MOST_LOCATIONS: Final = 3
_INDICES_A_LOCATION: Final = 5
"""Of an axis, at the least: of fewer a curve over all of them is as many locations."""
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
        return self.points.astype(float)[:, None] if self.is_even else _each_of(self.points)


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
class _Indices:
    """Of both axes, those of more than one attitude."""

    each: tuple[_Index, ...]
    columns: FloatArray
    """(K, I) 1 where a point is of an index."""
    counts: FloatArray
    """(I,) points."""


@dataclass(frozen=True)
class _Candidate:
    """One location, and what it explains."""

    location: Location
    explains: float
    numbers: int

    def score(self, points: int) -> float:
        """Return what it explains, less what so many numbers do by chance, the best of many chosen."""
        return self.explains - self.numbers * log(points)


def locations_shown(
    evidence: Evidence, output: int, known: FloatArray, rivals: FloatArray, level: float
) -> LocationsShown:
    """Return the locations at which what repeats of an output is off; a chance of NaN where that cannot be asked.

    ``known``: (K, c) of what is explained already. ``rivals``: (K, r) columns, one of which may explain as much.
    ``level``: chance above which none is looked at further.
    """
    indices, dof = _indices(evidence), float(evidence.grid.dof)
    weighed = weighed_means(evidence, output, known, indices.columns)
    if weighed is None or weighed.dof < LEAST_DOF:
        return LocationsShown((), float("nan"))
    points = weighed.mean.size
    found, explained, p_value = list[Location](), 0.0, 1.0
    while len(found) < _MOST_LOCATIONS and weighed.dof >= LEAST_DOF:
        explained_by = _Explained(weighed, indices)
        chance = explained_by.chance(dof)
        if chance > (_FURTHER if found else level):
            p_value = p_value if found else chance
            break
        made = explained_by.candidates()
        best = max(made, key=lambda candidate: candidate.score(points))
        rival = _best_of(weighed, rivals) - log(points)
        if not _has_room(best.location, found, indices) or best.score(points) <= max(rival + _PLAINER, 0.0):
            break
        p_value = p_value if found else chance
        found.append(_with_others(best, made, points))
        explained += best.explains
        weighed = weighed.with_known(best.location.columns, indices.columns)
    if not found:
        return LocationsShown((), p_value)
    remains = weighed.square - weighed.dof
    if remains > max(_OUT_OF_NOISE * sqrt(2.0 * weighed.dof), _REMAINS * explained):
        return LocationsShown((), 1.0)
    labels = np.array(evidence.layout.point_labels)
    return LocationsShown(tuple(replace(location, labels=labels[location.points]) for location in found), p_value)


def alike_over(evidence: Evidence, output: int, known: FloatArray) -> tuple[str, ...]:
    """Return the axes of the table over whose indices what repeats goes alike, against its scatter within them."""
    indices, found = _indices(evidence), list[str]()
    weighed = weighed_means(evidence, output, known, indices.columns)
    if weighed is None:
        return ()
    for axis in ("pitch", "roll"):
        of_axis = [index.axis == axis for index in indices.each]
        if not any(of_axis):
            continue
        _, numbers, explains = weighed.explained(indices.columns[:, of_axis])
        rest, dof = weighed.square - explains, weighed.dof - numbers
        if dof < LEAST_DOF or numbers == 0:
            continue
        ratio = (explains / numbers) / max(rest / dof, 1.0)
        if float(f_tail(ratio, float(numbers), float(dof))) <= _ALIKE:
            found.append(axis)
    return tuple(found)


@dataclass(frozen=True)
class _Explained:
    """What every location explains: each index as one amount, plain ones as one of each attitude, every attitude."""

    weighed: WeighedMeans
    indices: _Indices

    @cached_property
    def even(self) -> tuple[FloatArray, FloatArray]:
        """(I,) what each index has of y as one amount, and its own square."""
        return self.weighed.left @ self.indices.columns, self.weighed.by.of_index / self.weighed.variance

    @cached_property
    def of_point(self) -> FloatArray:
        """(K,) of each attitude by itself."""
        return _explained_by_each(self.weighed.left, np.where(self.weighed.is_judged, self.weighed.of_point, 0.0))

    @cached_property
    def uneven(self) -> dict[int, tuple[FloatArray, int, float]]:
        """Of indices whose attitudes are off beyond noise: amounts, how many numbers they are, what they explain."""
        counts = self.indices.counts
        beyond = self.of_point @ self.indices.columns > counts + _OUT_OF_NOISE * np.sqrt(2.0 * counts)
        plain = np.flatnonzero(beyond).tolist()
        return {at: self.weighed.explained_by_each(self.indices.each[at].points) for at in plain}

    def chance(self, dof: float) -> float:
        """Return the chance of as much at any location, be it one amount of it or one of each of its attitudes."""
        count, (along, squares) = len(self.indices.each), self.even
        of_index = _explained_by_each(along, squares)
        single = max(float(of_index.max(initial=0.0)), float(self.of_point.max(initial=0.0)))
        uneven = [(explains, numbers) for _, numbers, explains in self.uneven.values() if numbers > 1]
        single = max([single, *(explains for _, numbers, explains in self.uneven.values() if numbers == 1)])
        ratios = np.array([single, *(explains / numbers for explains, numbers in uneven)])
        numbers = np.array([1.0, *(float(numbers) for _, numbers in uneven)])
        chosen = np.array([count + self.of_point.size, *(count for _ in uneven)])
        return min(1.0, float(np.min(2.0 * chosen * f_tail(ratios, numbers, dof))))

    def candidates(self) -> list[_Candidate]:
        """Return every index as one amount, plain ones as one of each attitude as well, and the plainest attitude."""
        found = []
        for index, along, square in zip(self.indices.each, *(part.tolist() for part in self.even), strict=True):
            if square > 0.0:
                location = Location(index.axis, index.index_deg, index.points, True, along / square, square**-0.5)
                found.append(_Candidate(location, along**2 / square, 1))
        for at, (amounts, numbers, explains) in self.uneven.items():
            index, size = self.indices.each[at], float(np.sqrt(np.mean(amounts**2)))
            location = Location(index.axis, index.index_deg, index.points, False, size, float("nan"))
            found.append(_Candidate(location, explains, numbers))
        if self.weighed.is_judged.any():
            at = int(np.argmax(self.of_point))
            points, square = np.arange(self.of_point.size) == at, float(self.weighed.of_point[at])
            amount = float(self.weighed.left[at]) / square
            location = Location("", float("nan"), points, True, amount, square**-0.5)
            found.append(_Candidate(location, float(self.of_point[at]), 1))
        return found


def _has_room(location: Location, found: Sequence[Location], indices: _Indices) -> bool:
    """Return whether the axis of a location has indices enough for one more, beside those that are found."""
    count = sum(index.axis == location.axis for index in indices.each)
    return not location.axis or (1 + sum(other.axis == location.axis for other in found)) * _INDICES_A_LOCATION <= count


def _best_of(weighed: WeighedMeans, rivals: FloatArray) -> float:
    """Return what that of (K, r) columns explains which explains most."""
    squares = weighed.by.squares(rivals, _ROUNDING) / weighed.variance
    return float(np.max(_explained_by_each(weighed.left @ rivals, squares), initial=0.0))


def _explained_by_each(seen: FloatArray, squares: FloatArray) -> FloatArray:
    """Return (c,) what each column explains, by what it has of y and its own square; 0 where that is 0."""
    return np.divide(seen**2, squares, out=np.zeros_like(seen), where=squares > 0.0)


def _each_of(points: BoolArray) -> FloatArray:
    """Return (K, c) a column for each of the points by itself."""
    return np.asarray(np.eye(points.size)[:, points])


def _with_others(best: _Candidate, made: Sequence[_Candidate], points: int) -> Location:
    """Return a location with the other indices of its axis that fit as well."""
    location, least = best.location, best.score(points) - _AS_WELL
    others = [each for each in made if each.location.axis == location.axis != "" and each.score(points) > least]
    as_well = {each.location.index_deg for each in others}
    return replace(location, or_at_deg=tuple(sorted(as_well - {location.index_deg})))


def _indices(evidence: Evidence) -> _Indices:
    return _indices_of(evidence.layout, evidence.rows.pitch_rad, evidence.rows.roll_rad)


@remembered(16)
def _indices_of(layout: Layout, pitch_rad: FloatArray, roll_rad: FloatArray) -> _Indices:
    """Return the indices of (N,) angles, which may be as an axis or a reference reads them."""
    # Of the roll no mean of its angles: of −180° and 180° that is zero.
    roll = np.arctan2(layout.mean_by_point(np.sin(roll_rad)), layout.mean_by_point(np.cos(roll_rad)))
    found = []
    for axis, (index, mean) in (
        ("pitch", index_of(layout.mean_by_point(pitch_rad))),
        ("roll", index_around(roll)),
    ):
        mean_deg = np.round(np.rad2deg(mean), 4) + 0.0
        mean_deg = np.where(mean_deg == 180.0, -180.0, mean_deg) if axis == "roll" else mean_deg
        if mean.size >= _FEWEST_INDICES:
            of_axis = [_Index(axis, float(mean_deg[at]), index == at) for at in np.argsort(mean_deg)]
            found += [stood for stood in of_axis if stood.points.sum() > 1]
    columns = np.array([stood.points for stood in found], dtype=float).reshape(len(found), roll.size).T
    return _Indices(tuple(found), columns, columns.sum(axis=0))
