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

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.step_patterns import ALONE, ON_MOUNT, SLIPS, What, force, ones, slip_pattern, slips_of
from ams.analysis.diagnostics.steps.step_paths import Pairs, PatternInTime, in_time, least_aside, travelled
from ams.arrays import BoolArray, FloatArray, IntArray
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.statistics.distributions import f_tail

LEAST_DOF: Final = 40
"""Of what differs from replication to replication: with fewer every place is its own explanation."""
_LARGEST: Final = 1.0 - 1e-12
"""Of the squares that a change can explain: F stays finite."""
Moments = slice | IntArray
"""In the order of time."""


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
    yaw_rad: FloatArray | None = None
    """Of a gimbal."""
    is_rolled: bool = True
    """Whether roll reaches the package; else it is at zero."""

    @property
    def angles_rad(self) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        """(N,) pitch, roll and yaw."""
        return self.pitch_rad, self.roll_rad, self.yaw_rad

    @cached_property
    def turns(self) -> tuple[What, ...]:
        """What table and package may turn about."""
        return slips_of(self.yaw_rad, is_rolled=self.is_rolled)

    def taken_of(self, what: What, k: FloatArray) -> FloatArray:
        """Return (N,) what an output of (3,) sensitivities takes of a change of table or meter, in its own unit."""
        if what == "offset":
            return ones(self.layout.rows)
        pattern = force(*self.angles_rad) if what == "sensitivity" else slip_pattern(what, *self.angles_rad)
        return np.asarray(pattern @ k)

    @property
    def is_judged(self) -> bool:
        return self.dof >= LEAST_DOF and self.layout.rows > 2 * least_aside(self.layout.rows)

    def in_time(self, values: FloatArray) -> FloatArray:
        """Return (…, N) values of the rows in the order of time."""
        return values if self._is_in_order else values[..., self.time_order]

    def left_in_time(self, values: FloatArray) -> FloatArray:
        """Return (…, N) values in the order of time less the mean of their point."""
        rows = np.empty(values.shape)
        rows[..., self.time_order] = values
        return self.in_time(self.layout.about_points(rows.T).T)

    def pattern(self, values: FloatArray, pairs: Pairs = ALONE) -> PatternInTime:
        """Return (N,) or (N, p) patterns of the rows as the run brings them."""
        return in_time(self.layout.point, self.time_order, values, pairs)

    @cached_property
    def offset(self) -> PatternInTime:
        """Return the pattern of a step of an offset."""
        return self.pattern(ones(self.layout.rows))

    @property
    def slips(self) -> "Slips":
        """Return the patterns of all turns of the table and of the package."""
        return _slips(self.layout.point, self.time_order, *self.angles_rad, self.turns)

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
class Slips:
    """All turns of the table, and of the package on its mount, along a course."""

    patterns: tuple[PatternInTime, ...]
    """In the order of :data:`SLIPS`."""
    columns: FloatArray
    """(4, 3, N) of all of them, of the specific force; five of what a gimbal rolls."""


@dataclass(frozen=True)
class Scan:
    """What all places of one pattern are looked at with."""

    what: What
    output: int | None
    course: Course
    pattern: PatternInTime
    weights: FloatArray | None
    """(q,) of the pairs of its columns; None where there is one."""
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
    def sizes(self) -> FloatArray:
        """(C,) squares of the columns of all places."""
        paths = self.pattern.paths
        moments = slice(paths.first, paths.first + paths.squares.shape[1])
        return self._beside_drift(self.weighed(paths.squares), moments, moments)

    @cached_property
    def travelled(self) -> float:
        """Return the angle that the unit vectors of the columns travel."""
        paths = self.pattern.paths
        # The way of one pattern with itself is kept with the design; that under weights, or beside a drift, is not.
        if self.weights is None and self.drift is None:
            return paths.travelled
        last = paths.first + paths.overlaps.shape[1]
        moments, against = slice(paths.first, last), slice(paths.first + 1, last + 1)
        return travelled(self.sizes, self._beside_drift(self.weighed(paths.overlaps), moments, against))

    @property
    def interval_sizes(self) -> FloatArray:
        """(I,) squares of the columns of all pairs of places of the coarse grid."""
        intervals, found = self.pattern.intervals, self.weighed(self.pattern.intervals.squares)
        if self.drift is None:
            return found
        begin, end = intervals.bounds[intervals.begin], intervals.bounds[intervals.end]
        return found - (self._drifted(begin, begin) + self._drifted(end, end) - 2.0 * self._drifted(begin, end))

    def overlap(self, index: int) -> FloatArray:
        """Return (N,) the inner product of a change before one place and one before each, of all dwells."""
        changed = self.pattern.columns.copy()
        changed[:, :index] = 0.0
        crossed = self._crossed(self.pattern.columns, self.course.left_in_time(changed))
        found, rows = np.cumsum(self.weighed(crossed)[::-1])[::-1], changed.shape[1]
        return self._beside_drift(found, slice(index, index + 1), slice(rows))

    def _crossed(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return (q, n) products of (p, n) columns of the pattern with others."""
        first, second = self.pattern.first, self.pattern.second
        return np.asarray(0.5 * (u[first] * v[second] + u[second] * v[first]))

    def _beside_drift(self, products: FloatArray, moments: Moments, against: Moments) -> FloatArray:
        """Return (n,) products of n pairs of places as they are beside the drift where there is one."""
        return products if self.drift is None else products - self._drifted(moments, against)

    @cached_property
    def _in_drift(self) -> FloatArray:
        """(p, N + 1) what the columns of every place have in common with the drift."""
        assert self.drift is not None
        return since(self.pattern.columns * self.course.in_time(self.drift))

    def _drifted(self, moments: Moments, against: Moments) -> FloatArray:
        """Return (n,) what the products of n pairs of places are less by, beside the drift."""
        products = self._crossed(self._in_drift[:, moments], self._in_drift[:, against])
        return np.asarray(products[0] if self.drifting is None else self.drifting @ products)

    @property
    def loudness(self) -> FloatArray:
        """(N,) the variance of what each dwell adds, in the order of time, for noise of one."""
        return self.weighed(self._crossed(self.pattern.columns, self.pattern.columns))

    def weighed(self, products: FloatArray) -> FloatArray:
        """Return (n,) inner products of pairs of patterns (q, n), all together."""
        return np.asarray(products[0] if self.weights is None else self.weights @ products)

    def share(self, explained: float) -> float:
        """Return the share of the squares that is explained."""
        return min(explained / self.squares, _LARGEST) if self.squares > 0.0 else 0.0

    def beyond(self, share: float) -> float:
        """Return the chance that one place explains more."""
        return float(f_tail(share * (self.dof - 1) / (1.0 - share), 1.0, float(self.dof - 1)))

    def change(self, index: int, p_value: float, explained: float, end: int | None = None) -> Change:
        """Return what was found."""
        return Change(self.what, self.output, index, min(1.0, p_value), explained / self.variance, end)


def since(along: FloatArray) -> FloatArray:
    """Return (…, N + 1) the sums of (…, N) numbers from every place on."""
    # A change lasts to the end: each place has one dwell more than the one after it, so all places cost one sum.
    found = np.zeros((*along.shape[:-1], along.shape[-1] + 1))
    np.cumsum(along[..., ::-1], axis=-1, out=found[..., -2::-1])
    return found


@remembered(8)
def _slips(
    point: IntArray,
    order: IntArray,
    pitch_rad: FloatArray,
    roll_rad: FloatArray,
    yaw_rad: FloatArray | None,
    every: tuple[What, ...],
) -> Slips:
    turns = {what: slip_pattern(what, pitch_rad, roll_rad, yaw_rad) for what in every}
    patterns = [in_time(point, order, turn, SLIPS[what]) for what, turn in turns.items()]
    return Slips(tuple(patterns), np.array([pattern.columns for pattern in patterns]))


@remembered(16)
def _is_in_order(order: IntArray) -> bool:
    return bool(np.all(order[1:] > order[:-1]))
