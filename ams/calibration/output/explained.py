"""One output less what explains a part of it: a course, wrong dwells, a transient, a memory, each taken out once told.

In this order: what is plainest first, so that nothing else is blamed for it. After each all other tests are made again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.analysis.diagnostics.beliefs import (
    AT_A_LOCATION,
    AUTOCORRELATION,
    BY_REPLICATION,
    COLUMNS,
    LACK_OF_FIT,
    LAG,
    MEMORIES,
    RECORDED,
    SETTLING,
    UNEVEN,
    WRONG_DWELL,
    AxisTests,
    BeliefTest,
)
from ams.analysis.diagnostics.declared.earth_on_gyros import EarthOnRates, earth_on_rates
from ams.analysis.diagnostics.declared.gravity_on_gyros import (
    GravityTest,
    force_columns,
    gravity_on_zero,
    is_declared,
)
from ams.analysis.diagnostics.declared.laid_points import LaidOtherwise, laid_otherwise
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.locations import Location
from ams.analysis.diagnostics.low_order import OF_GYROS
from ams.analysis.diagnostics.over_time import previous_attitude
from ams.analysis.diagnostics.over_time.drift_course import likeliest_course, plain_courses
from ams.analysis.diagnostics.over_time.memories import plainest_memory
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.tested_terms import AnyGyro, tested_base
from ams.analysis.diagnostics.time_order import settling
from ams.analysis.diagnostics.uneven_noise import uneven_noise, uneven_test
from ams.analysis.diagnostics.words.wrong_dwell_words import Convicted
from ams.analysis.diagnostics.wrong_dwells import WrongDwells, convict
from ams.arrays import BoolArray, FloatArray
from ams.calibration.output.believed import Believed
from ams.solve.layout import Layout

_STRONG = 0.1
"""Of what differs between the replications: a course that leaves more while dwells still know of each other is a wander
and no drift."""
_FAR = 8.0
"""Standard deviations of the dwells of a replication, those left out that stand out of all."""
_ALIKE = frozenset(column.name for column in COLUMNS)
"""Tests of what repeats in every replication: a transient that does is one of them."""


_LIKE_THE_EARTH = (LACK_OF_FIT, *OF_GYROS)
"""Tests of a gyro that ring where its rates lack the Earth's."""


@dataclass(frozen=True)
class Ground:
    """What a gyro shows of what stands on the ground."""

    laid: LaidOtherwise | None = None
    """Points that are stated alike and read otherwise."""
    earth: EarthOnRates | None = None

    def columns(self, layout: Layout) -> FloatArray:
        """Return (K, c) what of the points is told by it."""
        parts = [part.columns for part in (self.laid, self.earth) if part is not None]
        return layout.mean_by_point(np.hstack([np.zeros((layout.rows, 0)), *parts]))


@dataclass(frozen=True)
class Explained:
    """One output less what is told of it, and the tests of what is left."""

    seen: Believed
    made: Mapping[str, BeliefTest]
    """The tests of what was taken out, as they stood before."""
    tests: AxisTests
    limit: TableLimit | None
    family: int
    as_read: GridResiduals | None = None
    """What dwells were judged by before the noise of a replication was drawn in; None where all scatter alike."""

    def then(self, made: Mapping[str, BeliefTest], seen: Believed) -> "Explained":
        """Return what is left when something more, told by its tests, is taken out: all other tests made again."""
        made = {**self.made, **made}
        return replace(self, seen=seen, made=made, tests=seen.tested(made, self.limit, self.family))


def without_course_or_noise(left: Explained) -> Explained:
    """Return the output without its plain course and with even noise.

    A louder replication moves as a drift does, and a drift that fades makes the first replication louder: where the
    noise alone leaves no drift, it is the noise.
    """
    even = _with_even_noise(left)
    if even is not left and not plain_courses(even.tests):
        return even
    return _with_even_noise(_without_course(left))


def _without_course(left: Explained) -> Explained:
    """Return the output without its plain drift or temperature, unless what is left wanders as it did before."""
    plain = plain_courses(left.tests)
    course = likeliest_course(left.seen.evidence, left.seen.index) if plain else None
    if course is None:
        return left
    tests, of_temperature = left.tests.tests, course.is_of_temperature
    made = {name: test for name, test in plain.items() if of_temperature or name != BY_REPLICATION}
    made |= {name: tests[name] for name in RECORDED if of_temperature and name in tests}
    without = left.then(made, left.seen.without_course(course))
    wanders = without.tests.is_significant.get(AUTOCORRELATION, False)
    return left if wanders and _scatter(without.seen) >= _STRONG * _scatter(left.seen) else without


def _with_even_noise(left: Explained) -> Explained:
    """Return the output with replications that scatter plainly more drawn in to what the others scatter.

    What differs from the others in a loud replication, its noise and its parameters alike, counts for as much less as
    it is louder; the result itself is told with all of it.
    """
    tests, seen = left.tests, left.seen
    if tests.grid is None or not tests.is_significant.get(UNEVEN):
        return left
    wrong = _convicted(seen, tests)
    grid = tests.grid if wrong is None else _without_far(tests.grid, wrong, seen.readings)
    found = uneven_noise(grid, seen.readings)
    if found is None or not (found.p_value <= tests.conviction_level and np.any(found.excess > 1.0)):
        return left
    layout = seen.evidence.layout
    over = (1.0 - 1.0 / found.excess)[layout.replication]
    taken = over * _beside_quiet(seen.evidence.departures[:, seen.index], layout, over == 0.0)
    drawn_in = replace(seen, course=seen.course + taken).less(taken)
    # What repeats is held against the scatter of all, which is that of the means whether it is even or not.
    repeats = [test for name, test in tests.tests.items() if name == LACK_OF_FIT]
    made = {test.name: test for test in (*uneven_test(found, layout), *repeats)}
    return replace(left.then(made, drawn_in), as_read=tests.dwells)


def _beside_quiet(departures: FloatArray, layout: Layout, is_quiet: BoolArray) -> FloatArray:
    """Return (N,) how far every dwell is from the mean of the quiet dwells of its point."""
    point, quiet = layout.point[is_quiet], departures[is_quiet]
    count = np.maximum(np.bincount(point, minlength=layout.points), 1)
    return departures - (np.bincount(point, quiet, layout.points) / count)[layout.point]


def _without_far(grid: GridResiduals, wrong: WrongDwells, readings: FloatArray) -> GridResiduals:
    """Return what dwells say without those that stand far out of their own replication.

    A wrong dwell moves the parameters of its replication, and with them what all others of it leave.
    """
    found = uneven_noise(wrong.left, readings)
    if found is None:
        return wrong.left
    for dwell, size in zip(wrong.dwells, wrong.sizes, strict=True):
        if abs(size) > _FAR * found.scatter[dwell // grid.points]:
            grid = grid.without(dwell)
    return grid


def without_wrong_dwells(left: Explained) -> tuple[Explained, Convicted | None]:
    """Return the output without the dwells that the other replications contradict, and which they are."""
    seen = left.seen
    wrong = _convicted(seen, left.tests)
    if wrong is None or not wrong.dwells:
        return left, None
    if left.as_read is not None:
        wrong = replace(wrong, sizes=_sizes(wrong.dwells, left.as_read))
    kept, convicted = _rows_of(seen.evidence, wrong)
    test = BeliefTest(WRONG_DWELL, "wrong-dwell", wrong.p_value)
    return left.then({WRONG_DWELL: test}, seen.of(kept, 0.0)), convicted


def without_locations(left: Explained) -> tuple[Explained, tuple[Location, ...]]:
    """Return the output with the locations at which alone it is off as known, and which they are."""
    tests, seen = left.tests, left.seen
    if not tests.is_significant.get(AT_A_LOCATION):
        return left, ()
    locations = tuple(tests.locations)
    at_rows = np.hstack([location.columns for location in locations])[seen.evidence.layout.point]
    return left.then({AT_A_LOCATION: tests.tests[AT_A_LOCATION]}, _known(seen, at_rows)), locations


def without_transient(left: Explained) -> Explained:
    """Return the output without its plain transient at the start of every replication."""
    if not _settles(left.tests):
        return left
    test = left.tests.tests[SETTLING]
    return left.then({SETTLING: test}, left.seen.less(test.size * settling(left.seen.evidence)))


def without_memory(left: Explained, shown: BeliefTest | None) -> Explained:
    """Return the output without its plainest memory of attitudes before; ``shown``: what its whole package has."""
    memory = plainest_memory(left.tests, shown)
    if memory is None:
        return left
    seen, base = left.seen, left.seen.accelerometer
    assert base is not None, "only accelerometers are tested for memories"
    column = previous_attitude.memories(seen.evidence, base)[:, MEMORIES.index(memory.name)]
    without = left.then({memory.name: memory}, seen.less(memory.size * column))
    return replace(without, tests=replace(without.tests, memories=left.tests.memories))


def without_ground(left: Explained, limit_dps_per_g: float | None, *, lacks_earth: bool) -> tuple[Explained, Ground]:
    """Return a gyro with what stands on the ground known to its points, and what it shows of that.

    Points that are stated alike and read otherwise go first: no equation explains them, and the others are judged
    without them. The Earth, where the rates lack it, is told where it explains all that it passes for, and where it is
    needed beside the terms of the scale factor. Gravity on the zero within ``limit_dps_per_g``, which is declared, goes
    before it where the Earth is not needed beside that: nothing is told then. ``lacks_earth``: whether the rates may
    lack the Earth's with no error of the rows for it.
    """
    evidence, index = left.seen.evidence, left.seen.index
    if not isinstance(tested_base(evidence.models[index]), AnyGyro):
        return left, Ground()
    laid = laid_otherwise(evidence, index, evidence.layout.mean_by_point(left.seen.taken))
    if laid is None or laid.p_value > left.tests.conviction_level:
        nothing = np.zeros((evidence.layout.points, 0))
        left, earth = _without_earth(left, limit_dps_per_g, nothing, lacks_earth=lacks_earth)
        return left, Ground(None, earth)
    beside = evidence.layout.mean_by_point(laid.columns)
    without = left.then({}, _known(left.seen, laid.columns))
    left, earth = _without_earth(without, limit_dps_per_g, beside, lacks_earth=lacks_earth)
    return left, Ground(laid, earth)


def _without_earth(
    left: Explained, limit_dps_per_g: float | None, beside: FloatArray, *, lacks_earth: bool
) -> tuple[Explained, EarthOnRates | None]:
    """Return the same of the Earth and of gravity; ``beside``: (K, c) of the points that are known already."""
    evidence, index, tests = left.seen.evidence, left.seen.index, left.tests
    passes = any(tests.is_significant.get(name) for name in _LIKE_THE_EARTH)
    if not (passes or _is_plain(gravity_on_zero(evidence, index, beside), tests)):
        return left, None
    earth = earth_on_rates(evidence, index, beside) if lacks_earth else None
    known = beside if earth is None else np.hstack([beside, evidence.layout.mean_by_point(earth.columns)])
    is_beside = earth is not None and _is_plain(gravity_on_zero(evidence, index, known), tests)
    is_needed = earth is not None and earth.beside_gravity <= tests.conviction_level
    alone = gravity_on_zero(evidence, index, beside, beside_terms=False)
    force = force_columns(evidence)[evidence.layout.point]
    if not is_needed and (is_beside or is_declared(alone, tests.conviction_level, limit_dps_per_g)):
        return left.then({}, _known(left.seen, force)), None
    if earth is None:
        return left, None
    without = left.then({}, _known(left.seen, earth.columns, *([force] if is_beside else [])))
    explains = not any(without.tests.is_significant.get(name) for name in _LIKE_THE_EARTH)
    return (without, earth) if explains or earth.beside_terms <= tests.conviction_level else (left, None)


def _known(seen: Believed, *columns: FloatArray) -> Believed:
    """Return the output with (N, …) columns as known where its points are judged."""
    return replace(seen, taken=np.hstack([seen.taken, *columns]))


def _is_plain(gravity: GravityTest | None, tests: AxisTests) -> bool:
    return gravity is not None and gravity.p_value <= tests.conviction_level


def _settles(tests: AxisTests) -> bool:
    """Return whether a transient at the start of every replication is plain; what a lag or the ends explain is none."""
    test = tests.tests.get(SETTLING) if tests.is_significant.get(SETTLING) else None
    plainest = min((test.p_value for test in tests.tests.values() if test.name in _ALIKE), default=1.0)
    return (
        test is not None and test.p_value <= min(tests.conviction_level, plainest) and not tests.is_significant.get(LAG)
    )


def _scatter(seen: Believed) -> float:
    """Return the sum of squares of what differs from replication to replication."""
    departures = seen.evidence.departures[:, seen.index]
    return float(departures @ departures)


def _convicted(seen: Believed, tests: AxisTests) -> WrongDwells | None:
    level = tests.conviction_level
    if tests.dwells is None or WRONG_DWELL not in tests.tests or not tests.tests[WRONG_DWELL].p_value <= level:
        return None
    evidence = seen.evidence
    other_view = np.zeros(evidence.grid.present.size)
    other_view[evidence.dwell] = evidence.left[:, seen.index]
    return convict(tests.dwells, level, other_view, seen.readings)


def _sizes(dwells: Sequence[int], left: GridResiduals) -> tuple[float, ...]:
    """Return how far dwells read off what the others say, one after the other taken out."""
    found = []
    for dwell in dwells:
        found.append(left.reads_off(dwell))
        left = left.without(dwell)
    return tuple(found)


def _rows_of(evidence: Evidence, wrong: WrongDwells) -> tuple[BoolArray, Convicted]:
    row_of = dict(zip(evidence.dwell.tolist(), range(evidence.layout.rows), strict=True))
    rows = tuple(row_of[dwell] for dwell in wrong.dwells)
    kept = np.ones(evidence.layout.rows, dtype=bool)
    kept[list(rows)] = False
    return kept, Convicted(wrong, rows)
