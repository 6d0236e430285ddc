"""Whether something changed between two dwells, and stayed or came back: the table, the meter, or one output.

Every place in the order of time is tried. Of a change before place c an output shows p·1(at c or later), p being what
it takes of the change at each row: its slopes by the table's axes where these slip, one where its offset steps, the
force along its nominal axis where its sensitivity does. Every point has an effect of its own, so that what is left of
that column is what differs from replication to replication.

A slip of the table, or a turn of the package on its mount, is the same angle for all outputs of a package, a change of
the meter the same part of all that is read, or the same voltage: each is tried over all of them together. The p-value
of the largest of all places is bounded by what the unit vectors of the columns travel on their sphere (Hotelling 1939,
Knowles and Siegmund 1989): P(max|t| > u) ≤ P(|t| > u) + L/π·(1 − w²)^(ν/2 − 1), w² = u²/(u² + ν − 1).

An output that drifts evenly has the course of that beside every change, d of unit length: |z|² of a column z is then
less by (d·z)², and so is what two places have in common, z·z′ by (d·z)(d·z′), so that all places cost one sum more.

What came back is looked for between the places of a coarse grid, of which every replication has as many, so that a
replication by itself is one of them; that of the largest of all pairs is at most their number times P(|t| > u).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.step_noise import times_as_loud
from ams.analysis.diagnostics.step_paths import (
    NOTHING,
    Intervals,
    Paths,
    intervals_of,
    least_aside,
    paths_of,
    travelled,
)
from ams.analysis.diagnostics.step_patterns import (
    ALONE,
    EACH_WITH_EACH,
    ON_MOUNT,
    SLIPS,
    Watched,
    What,
    force,
    ones,
    slip_pattern,
)
from ams.arrays import BoolArray, FloatArray, IntArray
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.statistics.distributions import f_tail

LEAST_DOF: Final = 40
"""Of what differs from replication to replication: with fewer every place is its own explanation."""
_SEEN: Final = 12.0
"""In variances of a dwell: of two or three hundred intervals the likeliest explains as much by chance."""
_ROUNDS: Final = 2
_LARGEST: Final = 1.0 - 1e-12
_DOUBTFUL: Final = 0.01
"""Of a p-value: where it is larger, nothing is told of a change."""
_WORTH_IT: Final = 0.2
"""Of a p-value: where it is larger, the weights of the outputs make no matter of how far the columns travel."""


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
    end: int | None = None
    """In the order of time: the first dwell after it came back; None where it stayed."""

    @property
    def is_of_table(self) -> bool:
        return self.output is None and self.what in SLIPS

    @property
    def is_of_meter(self) -> bool:
        return self.output is None and self.what not in SLIPS

    @property
    def is_on_mount(self) -> bool:
        return self.output is None and self.what in ON_MOUNT

    @property
    def numbers(self) -> int:
        """Return how many it has to choose: when, until when, and how far."""
        return 2 if self.end is None else 3


@dataclass(frozen=True)
class Course:
    """The design of a package in time."""

    layout: Layout
    time_order: IntArray
    """(N,)"""
    pitch_rad: FloatArray
    roll_rad: FloatArray
    dof: int
    """Of each output's departures."""

    @property
    def is_judged(self) -> bool:
        return self.dof >= LEAST_DOF and self.layout.rows > 2 * least_aside(self.layout.rows)

    def in_time(self, values: FloatArray) -> FloatArray:
        """Return (N,) values of the rows in the order of time."""
        return values if self._is_in_order else values[self.time_order]

    @cached_property
    def _is_in_order(self) -> bool:
        return _is_in_order(self.time_order)

    def during(self, change: Change) -> BoolArray:
        """Return (N,) the rows that a change is in."""
        return self.between(change.index, change.end)

    def between(self, index: int, end: int | None = None) -> BoolArray:
        """Return (N,) the rows from one place in time on, to before another where one is given."""
        found = np.zeros(self.layout.rows, dtype=bool)
        found[self.time_order[index:end]] = True
        return found


@dataclass(frozen=True)
class Scan:
    """What all places of one pattern are looked at with."""

    what: What
    output: int | None
    course: Course
    pattern: FloatArray
    """(N,) or (N, 3)"""
    pairs: tuple[tuple[int, int], ...]
    """Of the columns of the pattern, that are weighed."""
    weights: FloatArray | None
    """(q,) of the pairs; None where there is one."""
    since: FloatArray
    """(N + 1,) sums from every place on of what each dwell adds, in the order of time."""
    squares: float
    """Of the departures."""
    dof: int
    variance: float = 1.0
    """That squares are told in."""
    drift: FloatArray | None = None
    """(N,) of unit length: it stands beside every change; None where nothing drifts."""
    drifting: FloatArray | None = None
    """(q,) as the weights, of the outputs that drift; None where there is one."""

    @cached_property
    def paths(self) -> Paths:
        """Return the products for every place."""
        return paths_of(self.course.layout.point, self.course.time_order, self.pattern, self.pairs)

    @property
    def intervals(self) -> Intervals:
        """Return the products for every pair of places of a coarse grid."""
        return intervals_of(self.course.layout.point, self.course.time_order, self.pattern, self.pairs)

    @cached_property
    def sizes(self) -> FloatArray:
        """(C,) squares of the columns of all places."""
        paths = self.paths
        moments = np.arange(paths.first, paths.first + paths.squares.shape[0])
        return self.weighed(paths.squares) - self._drifted(moments, moments)

    @cached_property
    def travelled(self) -> float:
        """Return the angle that the unit vectors of the columns travel."""
        paths = self.paths
        # The way of one pattern with itself is kept with the design; that under weights, or beside a drift, is not.
        if self.weights is None and self.drift is None:
            return paths.travelled
        moments = np.arange(paths.first, paths.first + paths.overlaps.shape[0])
        return travelled(self.sizes, self.weighed(paths.overlaps) - self._drifted(moments, moments + 1))

    @property
    def interval_sizes(self) -> FloatArray:
        """(I,) squares of the columns of all pairs of places of the coarse grid."""
        intervals = self.intervals
        begin, end = intervals.begin, intervals.end
        both = self._drifted(begin, begin) + self._drifted(end, end) - 2.0 * self._drifted(begin, end)
        return self.weighed(intervals.squares) - both

    def overlap(self, index: int) -> FloatArray:
        """Return (N,) the inner product of a change before one place and one before each, of all dwells."""
        course, rows = self.course, self.course.layout.rows
        patterns = self.pattern.reshape(rows, -1)
        changed = np.where(course.between(index)[:, None], patterns, 0.0)
        left, patterns = course.in_time(course.layout.about_points(changed)), course.in_time(patterns)
        first, second = self.sides
        crossed = 0.5 * (patterns[:, first] * left[:, second] + patterns[:, second] * left[:, first])
        found = np.cumsum(self.weighed(crossed)[::-1])[::-1]
        return found - self._drifted(np.full(rows, index), np.arange(rows))

    @property
    def sides(self) -> tuple[IntArray, IntArray]:
        """Return the columns of the pattern on either side of the pairs."""
        first, second = np.array(self.pairs).T
        return first, second

    @cached_property
    def _in_drift(self) -> FloatArray:
        """(N + 1, p) what the columns of every place have in common with the drift."""
        if self.drift is None:
            return np.zeros((self.course.layout.rows + 1, 1))
        along = self.course.in_time(self.pattern.reshape(self.course.layout.rows, -1) * self.drift[:, None])
        return np.concatenate([np.cumsum(along[::-1], axis=0)[::-1], np.zeros((1, along.shape[1]))])

    def _drifted(self, moments: IntArray, against: IntArray) -> FloatArray:
        """Return (n,) what the products of n pairs of places are less by, beside the drift."""
        if self.drift is None:
            return np.zeros(moments.size)
        (first, second), u, v = self.sides, self._in_drift[moments], self._in_drift[against]
        products = 0.5 * (u[:, first] * v[:, second] + u[:, second] * v[:, first])
        return products[:, 0] if self.drifting is None else products @ self.drifting

    def weighed(self, products: FloatArray) -> FloatArray:
        """Return (…,) inner products of pairs of patterns (…, q), all together."""
        return products[:, 0] if self.weights is None else products @ self.weights

    def share(self, explained: float) -> float:
        """Return the share of the squares that is explained."""
        return min(explained / self.squares, _LARGEST) if self.squares > 0.0 else 0.0

    def beyond(self, share: float) -> float:
        """Return the chance that one place explains more."""
        return float(f_tail(share * (self.dof - 1) / (1.0 - share), 1.0, float(self.dof - 1)))

    def change(self, index: int, p_value: float, explained: float, end: int | None = None) -> Change:
        """Return what was found."""
        return Change(self.what, self.output, index, min(1.0, p_value), explained / self.variance, end)


def scans_of_table(course: Course, outputs: Sequence[Watched]) -> Iterator[Scan]:
    """Yield the scans for a turn of the table, or of the package on its mount, that all outputs show together."""
    seen = [output for output in outputs if output.k is not None]
    if not course.is_judged or not seen:
        return
    k = np.array([output.k for output in seen])
    for what, pairs in SLIPS.items():
        yield _of_all(what, course, seen, k, slip_pattern(what, course.pitch_rad, course.roll_rad), pairs)


def scans_of_meter(course: Course, outputs: Sequence[Watched]) -> Iterator[Scan]:
    """Yield the scans for a step of the meter's gain and of its offset, that all outputs of a package show together.

    Of one output alone they are those of the output.
    """
    seen = [output for output in outputs if output.k is not None]
    if not course.is_judged or len(seen) < 2:
        return
    k = np.array([output.k for output in seen])
    yield _of_all("sensitivity", course, seen, k, force(course.pitch_rad, course.roll_rad), EACH_WITH_EACH)
    yield _of_all("offset", course, seen, np.ones((len(seen), 1)), ones(course.layout.rows), ALONE)


def _of_all(
    what: What,
    course: Course,
    seen: Sequence[Watched],
    taken: FloatArray,
    pattern: FloatArray,
    pairs: tuple[tuple[int, int], ...],
) -> Scan:
    """Return the scan of a pattern (N, p) of which each of the outputs takes so much, (A, p), all together."""
    variance, departures = (np.array([getattr(output, name) for output in seen]) for name in ("variance", "departures"))
    weighed, drifts = taken / variance[:, None], [output.drift is not None for output in seen]
    along = course.in_time(((weighed @ pattern.reshape(course.layout.rows, -1).T) * departures).sum(axis=0))
    twice, of_drifts = (
        np.array([weight[a, b] * (1.0 if a == b else 2.0) for a, b in pairs])
        for weight in (taken.T @ weighed, taken[drifts].T @ weighed[drifts])
    )
    squares = float(((departures * departures).sum(axis=1) / variance).sum())
    drift = next((output.drift for output in seen if output.drift is not None), None)
    dof = len(seen) * course.dof - sum(drifts)
    return Scan(what, None, course, pattern, pairs, twice, _since(along), squares, dof, 1.0, drift, of_drifts)


def scans_of_output(course: Course, watched: Watched, output: int) -> Iterator[Scan]:
    """Yield the scans for a step of one output's offset, and of its sensitivity."""
    if not course.is_judged:
        return
    squares, departures = float(watched.departures @ watched.departures), course.in_time(watched.departures)
    patterns: tuple[tuple[What, FloatArray], ...] = (
        ("offset", ones(course.layout.rows)),
        ("sensitivity", watched.sensed),
    )
    for what, pattern in patterns:
        along = departures if what == "offset" else departures * course.in_time(pattern)
        since, dof = _since(along), course.dof - (watched.drift is not None)
        scan = Scan(what, output, course, pattern, ALONE, None, since, squares, dof, watched.variance, watched.drift)
        if scan.paths.squares.max(initial=0.0) > NOTHING * pattern.size:
            yield scan


def _since(along: FloatArray) -> FloatArray:
    """Return (N + 1,) the sums of (N,) numbers from every place on."""
    # A change lasts to the end: each place has one dwell more than the one after it, so all places cost one sum.
    found = np.zeros(along.size + 1)
    np.cumsum(along[::-1], out=found[-2::-1])
    return found


def changes_of(scans: Iterable[Scan]) -> list[Change]:
    """Return the likeliest changes of each pattern: one that stayed, and one that came back if there is one to see."""
    return [change for scan in scans for change in (likeliest(scan), _came_back(scan)) if change is not None]


def likeliest(scan: Scan, earliest: int = 0, latest: int | None = None) -> Change | None:
    """Return the place of some at which a change explains most, by the chance over all; None where none is tried."""
    size, first = scan.sizes, scan.paths.first
    begin, end = max(earliest - first, 0), size.size if latest is None else max(latest - first + 1, 0)
    explained = _explained(scan.since[first : first + size.size], size)[begin:end]
    if explained.size == 0:
        return None
    index = int(np.argmax(explained))
    return _steadied(scan, first + begin + index, float(explained[index]), lambda share: _anywhere(scan, share))


def _anywhere(scan: Scan, share: float) -> float:
    """Return the chance that a change at any place explains more."""
    if not share > 0.0:
        return 1.0
    beyond = scan.beyond(share)
    crossing = (1.0 - share) ** (0.5 * scan.dof - 1.0) / np.pi
    p_value = beyond + scan.paths.travelled * crossing
    return float(beyond + scan.travelled * crossing if p_value < _WORTH_IT else p_value)


def _came_back(scan: Scan) -> Change | None:
    """Return the pair of places between which a change explains most; None where that is what chance does."""
    intervals = scan.intervals
    if intervals.begin.size == 0:
        return None
    sums = scan.since.take(intervals.begin) - scan.since.take(intervals.end)
    explained = _explained(sums, scan.interval_sizes)
    index = int(np.argmax(explained))
    share = scan.share(float(explained[index]))
    if share * scan.dof < _SEEN:
        return None
    begin, end, count = int(intervals.begin[index]), int(intervals.end[index]), intervals.begin.size
    return _steadied(scan, begin, float(explained[index]), lambda share: count * scan.beyond(share), end)


def _steadied(
    scan: Scan, index: int, explained: float, chance: Callable[[float], float], end: int | None = None
) -> Change:
    """Return a change, of less where the dwells that tell it scatter plainly more than the others."""
    found, course = scan.change(index, chance(scan.share(explained)), explained, end), scan.course
    if found.p_value > _DOUBTFUL:
        return found
    changed = course.during(found).astype(float)
    column = course.in_time(course.layout.about_points(changed))
    patterns = course.in_time(scan.pattern.reshape(course.layout.rows, -1))
    first, second = scan.sides
    weight, along = scan.weighed(patterns[:, first] * patterns[:, second]), scan.since[:-1] - scan.since[1:]
    less = explained / times_as_loud(along, weight, column, course.layout.replication[course.time_order], scan.dof)
    return scan.change(index, chance(scan.share(less)), less, end)


def located(scan: Scan, change: Change) -> Change:
    """Return a change that came back between the likeliest of all dwells: the coarse grid is where it is looked for."""
    begin, end = change.index, change.end
    if end is None:
        return change
    first, rows = scan.paths.first, scan.course.layout.rows
    size, aside, explained = scan.sizes, least_aside(rows), change.square * scan.variance
    for _ in range(_ROUNDS):
        for is_begin in (True, False):
            fixed = end if is_begin else begin
            dwells = np.arange(first, fixed - aside + 1 if is_begin else first + size.size)
            dwells = dwells if is_begin else dwells[dwells >= fixed + aside]
            lengths = size[dwells - first] + size[fixed - first] - 2.0 * scan.overlap(fixed)[dwells]
            found = _explained(scan.since[dwells] - scan.since[fixed], lengths)
            best = int(np.argmax(found))
            begin, end = (int(dwells[best]), fixed) if is_begin else (fixed, int(dwells[best]))
            explained = float(found[best])
    return scan.change(begin, change.p_value, explained, end)


def _explained(sums: FloatArray, size: FloatArray) -> FloatArray:
    least = NOTHING * float(size.max())
    if float(size.min()) > least:
        return np.asarray(sums * sums / size)
    return np.where(size > least, sums * sums / np.maximum(size, least), 0.0)


@remembered(16)
def _is_in_order(order: IntArray) -> bool:
    return bool(np.all(order[1:] > order[:-1]))
