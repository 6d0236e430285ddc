"""Whether something changed once, between two dwells, and stayed: a slip of the table, or a step of one output.

Every place in the order of time is tried. Of a change before place c an output shows p·1(at c or later), p being what
it takes of the change at each row: its slopes by the table's axes where these slip, one where its offset steps, the
force along its nominal axis where its sensitivity does. Every point has an effect of its own, so that what is left of
that column is what differs from replication to replication.

A slip of the table is the same angle for all outputs of a package, and is tried over all of them together. The p-value
of the largest of all places is bounded by what the unit vectors of the columns travel on their sphere (Hotelling 1939,
Knowles and Siegmund 1989): P(max|t| > u) ≤ P(|t| > u) + L/π·(1 − w²)^(ν/2 − 1), w² = u²/(u² + ν − 1).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.frames import specific_force, specific_force_by_pitch, specific_force_by_roll
from ams.remembered import remembered
from ams.statistics.distributions import f_tail

What = Literal["roll", "pitch", "offset", "sensitivity"]
LEAST_DOF: Final = 40
"""Of what differs from replication to replication: with fewer every place is its own explanation."""
_LEAST_ASIDE: Final = 8
_LEAST_SHARE: Final = 0.03
"""Of the dwells on either side of a change: fewer are single dwells that are wrong."""
_NOTHING: Final = 1e-9
_LARGEST: Final = 1.0 - 1e-12
_WORTH_IT: Final = 0.2
"""Of a p-value: where it is larger, the weights of the outputs make no matter of how far the columns travel."""


@dataclass(frozen=True)
class Paths:
    """What is left of products of patterns when a change comes before each place, for q pairs of patterns."""

    squares: FloatArray
    """(C, q) inner products of both patterns from the place on, of the places with dwells enough on either side."""
    overlaps: FloatArray
    """(C − 1, q) the same of a place and the one after it."""
    first: int
    """Of the places."""
    travelled: float
    """By the unit vectors of each pattern with itself, all of the same weight."""


@dataclass(frozen=True)
class Watched:
    """One output."""

    departures: FloatArray
    """(N,) what differs from replication to replication."""
    variance: float
    """Of a dwell."""
    k: FloatArray | None
    """(3,) per g; None where it senses no attitude."""
    sensed: FloatArray
    """(N,) what a change of its sensitivity scales."""


@dataclass(frozen=True)
class Change:
    """The likeliest of all places of one pattern."""

    what: What
    output: int | None
    """None: all outputs together."""
    index: int
    """In the order of time: the first dwell after it."""
    p_value: float
    """Over all places."""
    square: float
    """Of the departures in units of their variance, explained."""


@dataclass(frozen=True)
class Course:
    """The design of a package in time."""

    point: IntArray
    """(N,)"""
    time_order: IntArray
    """(N,)"""
    pitch_rad: FloatArray
    roll_rad: FloatArray
    dof: int
    """Of each output's departures."""

    @property
    def is_judged(self) -> bool:
        return self.dof >= LEAST_DOF and self.point.size > 2 * _LEAST_ASIDE

    def in_time(self, values: FloatArray) -> FloatArray:
        """Return (N,) values of the rows in the order of time."""
        return values if _is_in_order(self.time_order) else values[self.time_order]

    def since(self, index: int) -> BoolArray:
        """Return (N,) the rows at a place or later."""
        found = np.zeros(self.point.size, dtype=bool)
        found[self.time_order[index:]] = True
        return found


def changes_of_table(course: Course, outputs: Sequence[Watched]) -> list[Change]:
    """Return the likeliest slip about roll and about pitch that all outputs of a package show together."""
    seen = [output for output in outputs if output.k is not None]
    if not course.is_judged or not seen:
        return []
    k, variance = (
        np.stack([output.k for output in seen if output.k is not None]),
        np.array([output.variance for output in seen]),
    )
    field = np.stack([output.departures for output in seen], axis=1) @ (k / variance[:, None])
    weights = k.T @ (k / variance[:, None])
    squares = sum(float(output.departures @ output.departures) / output.variance for output in seen)
    found = []
    slips: tuple[What, ...] = ("roll", "pitch")
    for what in slips:
        pattern = slip_pattern(what, course.pitch_rad, course.roll_rad)
        paths = _paths(course.point, course.time_order, pattern, _SLIPS[what])
        along = np.einsum("nj,nj->n", pattern, field)
        twice = np.array([weights[a, b] * (1.0 if a == b else 2.0) for a, b in _SLIPS[what]])
        found.append(_largest(what, None, course.in_time(along), paths, twice, squares, len(seen) * course.dof))
    return found


def changes_of_output(course: Course, watched: Watched, output: int) -> list[Change]:
    """Return the likeliest step of one output's offset, and of its sensitivity."""
    if not course.is_judged:
        return []
    squares, departures = float(watched.departures @ watched.departures), course.in_time(watched.departures)
    found = []
    patterns: tuple[tuple[What, FloatArray], ...] = (
        ("offset", _ones(course.point.size)),
        ("sensitivity", watched.sensed),
    )
    for what, pattern in patterns:
        paths = _paths(course.point, course.time_order, pattern, _ALONE)
        if paths.squares.max(initial=0.0) > _NOTHING * pattern.size:
            along = departures if what == "offset" else departures * course.in_time(pattern)
            change = _largest(what, output, along, paths, None, squares, course.dof)
            found.append(replace(change, square=change.square / watched.variance))
    return found


def _largest(
    what: What,
    output: int | None,
    along: FloatArray,
    paths: Paths,
    weights: FloatArray | None,
    squares: float,
    dof: int,
) -> Change:
    """Return the place at which a change explains most of ``squares``, with the chance of that over all places.

    ``along``: what each dwell adds, in the order of time.
    """
    # A change lasts to the end: each place has one dwell more than the one after it, so all places cost one sum.
    after = np.cumsum(along[: paths.first - 1 : -1])[::-1][: paths.squares.shape[0]]
    size = paths.squares[:, 0] if weights is None else paths.squares @ weights
    least = _NOTHING * float(size.max())
    explained = np.where(size > least, after * after / np.maximum(size, least), 0.0)
    index = int(np.argmax(explained))
    share = min(float(explained[index]) / squares, _LARGEST) if squares > 0.0 else 0.0
    p_value = 1.0
    if share > 0.0:
        beyond = float(f_tail(share * (dof - 1) / (1.0 - share), 1.0, float(dof - 1)))
        crossing = (1.0 - share) ** (0.5 * dof - 1.0) / np.pi
        p_value = beyond + paths.travelled * crossing
        # The way of one pattern with itself is kept with the design; that under the outputs' weights is not.
        if weights is not None and p_value < _WORTH_IT:
            p_value = beyond + _travelled(size, paths.overlaps @ weights) * crossing
    return Change(what, output, index + paths.first, min(1.0, p_value), float(explained[index]))


def _travelled(squares: FloatArray, overlaps: FloatArray) -> float:
    """Return the angle that the unit vectors of the columns travel from place to place."""
    length = np.sqrt((squares[1:] * squares[:-1]).clip(min=0.0))
    is_there = length > _NOTHING * squares.max(initial=0.0)
    return float(np.arccos(np.clip(overlaps[is_there] / length[is_there], -1.0, 1.0)).sum())


@remembered(16)
def _is_in_order(order: IntArray) -> bool:
    return bool(np.all(order[1:] > order[:-1]))


@remembered(16)
def _ones(rows: int) -> FloatArray:
    return np.ones(rows)


_ALONE: Final = ((0, 0),)
_SLIPS: Final[dict[str, tuple[tuple[int, int], ...]]] = {
    "roll": ((1, 1), (1, 2), (2, 2)),
    "pitch": ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)),
}


@remembered(16)
def slip_pattern(what: str, pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return the (N, 3) change of specific force by a slip of one axis, per radian."""
    by = specific_force_by_roll if what == "roll" else specific_force_by_pitch
    return np.asarray(by(pitch_rad, roll_rad))


@remembered(16)
def force_along(pitch_rad: FloatArray, roll_rad: FloatArray, nominal_axis: str) -> FloatArray:
    """Return the (N,) specific force along one nominal axis, g."""
    return np.array(specific_force(pitch_rad, roll_rad)[:, "xyz".index(nominal_axis)])


@remembered(32)
def _paths(point: IntArray, order: IntArray, patterns: FloatArray, pairs: tuple[tuple[int, int], ...]) -> Paths:
    """Return the inner products for every place, each column less its mean over the rows of a point.

    One place further back in time adds one row r, of point k with n rows: with A and B the sums of both patterns over
    the rows of k that were there before, the product grows by ab − (aB + Ab + ab)/n, and what the row has in common
    with those before it is −(aB + Ab)/2n.
    """
    readings = np.bincount(point)[point[order]]
    pattern_of = patterns.reshape(order.size, -1)[order]
    before = _sums_of_same_point_after(point[order], pattern_of)
    first, second = (np.array([pair[side] for pair in pairs]) for side in (0, 1))
    a, b = pattern_of[:, first], pattern_of[:, second]
    crossed = (a * before[:, second] + before[:, first] * b) / readings[:, None]
    gained = a * b * (1.0 - 1.0 / readings)[:, None] - crossed
    squares = np.cumsum(gained[::-1], axis=0)[::-1]
    overlaps = squares[1:] - 0.5 * crossed[:-1]
    aside = max(_LEAST_ASIDE, int(_LEAST_SHARE * order.size))
    judged, stepped = slice(aside, order.size - aside + 1), slice(aside, order.size - aside)
    alike = np.array([1.0 if first == other else 0.0 for first, other in pairs])
    kept, met = squares[judged].copy(), overlaps[stepped].copy()
    return Paths(kept, met, aside, _travelled(kept @ alike, met @ alike))


def _sums_of_same_point_after(point: IntArray, pattern_of: FloatArray) -> FloatArray:
    """Return for each of the rows in time the (N, p) sums over the later rows of the same point."""
    by_point = np.lexsort((-np.arange(point.size), point))  # of a point the last comes first
    sums = np.cumsum(pattern_of[by_point], axis=0) - pattern_of[by_point]
    is_first = np.diff(point[by_point], prepend=-1) != 0
    found = np.empty(sums.shape)
    found[by_point] = sums - sums[is_first][np.cumsum(is_first) - 1]
    return found
