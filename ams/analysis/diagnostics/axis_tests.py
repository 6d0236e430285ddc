"""All tests of one sensor axis and what they decide together.

Each test has a p-value of its own; which are significant is decided over all of them by Holm's correction, at the share
of the level that the axis has: the tests of all axes of a run are one family. A term of low order that is significant
counts as known, and its neighbours are tested beside it. A drift that temperature explains is temperature's.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Final

import numpy as np

from ams.analysis.diagnostics import previous_attitude
from ams.analysis.diagnostics import temperature as by_temperature
from ams.analysis.diagnostics.beliefs import (
    AUTOCORRELATION,
    BY_POINT,
    BY_POINT_GAIN,
    BY_REPLICATION,
    COLUMNS,
    CURVATURE,
    DRIFT_OF,
    LACK_OF_FIT,
    LAG,
    LEVEL,
    MEMORIES,
    OVER_TIME,
    ROBUST,
    SETTLING,
    SQUARENESS,
    TABLE_LIMIT,
    TURNED_FROM,
    WRONG_DWELL,
    AxisTests,
    BeliefTest,
    Column,
)
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.low_order import squareness_of_points
from ams.analysis.diagnostics.overlap import Overlap, significant, with_neighbours
from ams.analysis.diagnostics.point_means import LEAST_DOF, Elimination, Tested, eliminate, gram_of, independent
from ams.analysis.diagnostics.replication_scatter import ReplicationScatter, is_unsteady
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.robust_fit import robust_fit
from ams.analysis.diagnostics.settling import Between, Estimate, slope_test
from ams.analysis.diagnostics.stated_sizes import stated_sizes
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.terms_over_temperature import of_terms_over_temperature
from ams.analysis.diagnostics.tested_terms import (
    columns_of,
    linear_base,
    terms_of_accelerometer,
    terms_of_gyro,
    tested_base,
)
from ams.analysis.diagnostics.time_order import (
    Autocorrelation,
    Slope,
    autocorrelation,
    hours,
    neighbours,
    settling_between,
    settling_of_points,
    slope_between,
)
from ams.analysis.diagnostics.uneven_noise import uneven_noise, uneven_test
from ams.analysis.diagnostics.wrong_dwells import judged_by, largest_p_values
from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.models.gyro import Gyro, GyroWithTerms
from ams.models.thermal import SECOND_ORDER_NAMES, TEMPERATURE_NAMES
from ams.remembered import remembered
from ams.solve.extension import angles_of_points
from ams.statistics.distributions import f_tail

_LINEAR: Final = 4
_NEEDED: Final = 0.05
MOST_TESTS: Final = 35
"""Of one axis."""
_PLAINER: Final = {"K1'": "K2", "K0'": "K3", SQUARENESS: "Kpo"}
_RECORDED: Final = (BY_POINT, BY_POINT_GAIN)
_BY_POINT: Final = tuple(column for column in COLUMNS if column.name in _RECORDED)


@dataclass(frozen=True)
class SharedTests:
    """What is computed for all axes of one piece of evidence at once."""

    wrong_dwell: FloatArray
    """(m,) p-values."""
    autocorrelation: Autocorrelation
    over_time: Slope | None
    by_replication: Slope | None
    settling: Slope
    """As far as the order of the points differs from replication to replication."""


def shared_tests(evidence: Evidence) -> SharedTests:
    """Return what all axes' tests begin with."""
    time, warmth = hours(evidence), by_temperature.departure_degc(evidence)
    return SharedTests(
        largest_p_values(evidence.grid)[0],
        autocorrelation(evidence.grid, neighbours(evidence)),
        None if time is None else slope_between(evidence, time),
        None if warmth is None else slope_between(evidence, warmth),
        settling_between(evidence),
    )


def axis_tests(
    evidence: Evidence,
    shared: SharedTests,
    output: int,
    convicted: Mapping[str, BeliefTest],
    limit: TableLimit | None = None,
    family: int = 1,
    given: FloatArray | None = None,
) -> AxisTests:
    """Return all tests of one axis, decided as one of a ``family`` of axes.

    ``convicted``: tests that were made already, of what is not in the evidence any more. ``limit``: what all axes of
    the package say of the table's declared limit; where it is plainly broken, its index errors count as known.
    ``given``: (K, c) of what is taken out already, as far as the points have it.
    """
    if not evidence.precision_variance[output] > 0.0:
        return AxisTests({})
    level = LEVEL / family
    lag, lagging = _lag(evidence, output, level)
    grid, steady = evidence.grid.of(output), evidence.steady_grid_of(output)
    wrong_p_value, wander = float(shared.wrong_dwell[output]), shared.autocorrelation.of(output)
    if lagging is not None:
        grid, steady = grid.beside(evidence.on_grid(lagging)), None
        wander = autocorrelation(grid, neighbours(evidence)).of(0)
    dwells = judged_by(grid, steady)
    if lagging is not None or dwells is steady:
        wrong_p_value = float(largest_p_values(dwells)[0][0])
    known = np.zeros((evidence.layout.points, 0)) if lagging is None else evidence.layout.mean_by_point(lagging)
    if given is not None and given.shape[1] > 0:
        known = np.hstack([known, given])
    if limit is not None and not limit.is_departing and limit.p_value <= limit.outputs * level / MOST_TESTS:
        known = np.hstack([known, _index_effects(evidence, output, limit, known)])
    before = previous_attitude.turned_from(evidence, output)
    found = [
        BeliefTest(WRONG_DWELL, "wrong-dwell", wrong_p_value),
        *([] if limit is None else [_of_the_table(limit)]),
        *_of_replications(evidence, output, known),
        BeliefTest(AUTOCORRELATION, "autocorrelation", wander[1], wander[0]),
        *_of_the_attitude_before(evidence, grid, before),
        *_robust(evidence, grid),
        *uneven_test(uneven_noise(grid), evidence.layout),
    ]
    if shared.over_time is not None:
        found.append(slope_test(OVER_TIME, "drift", shared.over_time, output, "per h"))
    found += _of_temperature(evidence, shared, output, known)
    found += [*([] if lag is None else [lag]), *of_terms_over_temperature(evidence, output, lag)]
    terms = low_order(evidence, output, known, before)
    columns = columns_of(evidence.models[output])
    between, by_replication = _between(evidence, shared, output, grid), None
    if terms is None:
        found.append(slope_test(SETTLING, "drift", shared.settling, output, ""))
    else:
        by_replication = ReplicationScatter(evidence, output, terms, level, is_unsteady(found, level / MOST_TESTS))
        found += [
            between.with_means(by_replication.referred(_term(column, tested, terms.dof), index))
            for index, (column, tested) in enumerate(zip(columns, terms.each(), strict=False))
        ]
    made = {test.name: test for test in found if isfinite(test.p_value)} | dict(convicted)
    memories = [made[name] for name in MEMORIES if name in made]
    decided = _decided(made, by_replication, between, convicted, level, columns)
    return replace(_explained_by_temperature(evidence, output, decided), grid=grid, dwells=dwells, memories=memories)


def _lag(evidence: Evidence, output: int, level: float) -> tuple[BeliefTest | None, FloatArray | None]:
    """Return the test of a lag, and where it is plain (N, 2) what the lag does: all others are tested beside that."""
    if not by_temperature.has_plateaus(evidence):
        return None, None
    lag = by_temperature.lag(evidence, output)
    test = BeliefTest(LAG, "temperature-lag", lag.p_value, lag.size, lag.detail)
    if not lag.p_value <= level / MOST_TESTS:
        return test, None
    return test, by_temperature.lag_columns(evidence, output, lag.detail)


def _of_the_table(limit: TableLimit) -> BeliefTest:
    size = max(limit.largest_rad.values())
    return BeliefTest(TABLE_LIMIT, "lack-of-fit", limit.p_value, size, unit="rad", axes=limit.outputs)


def _index_effects(evidence: Evidence, output: int, limit: TableLimit, known: FloatArray) -> FloatArray:
    """Return (K, c) what any index errors do to the points, beside a linear sensor and what is known already."""
    base = linear_base(evidence.models[output])
    points = next(iter(limit.columns.values())).shape[0]
    if base is None or points != evidence.layout.points:
        return np.zeros((evidence.layout.points, 0))
    angles = Attitude(*angles_of_points(evidence.rows, evidence.layout))
    slopes = base.angle_jacobian(evidence.primary[output][: len(base.primary_names)], angles)
    return limit.effects(slopes, np.hstack([evidence.basis[:, :_LINEAR], known]))


def _of_replications(evidence: Evidence, output: int, known: FloatArray) -> list[BeliefTest]:
    replication, sums = evidence.replication, evidence.sums
    if replication is None or sums is None:
        return []
    drifts = [
        BeliefTest(f"{DRIFT_OF}{name}", "drift", float(test.p_value[output]))
        for name, test in replication.drift.items()
    ]
    return [_lack_of_fit(evidence, output, known), *drifts]


def _of_the_attitude_before(evidence: Evidence, grid: GridResiduals, column: FloatArray) -> list[BeliefTest]:
    found = previous_attitude.between_replications(evidence, grid, column)
    return [] if found is None else [_term(Column(TURNED_FROM, "autocorrelation", ""), found)]


def _between(evidence: Evidence, shared: SharedTests, output: int, grid: GridResiduals) -> Between:
    """Return, by what differs from replication to replication, estimates of what the means of the points show too."""
    settles, base = shared.settling, linear_base(evidence.models[output])
    coefficient, uncertainty = settles.coefficient[output], settles.standard_uncertainty[output]
    found = {SETTLING: Estimate(float(coefficient), float(uncertainty), float(evidence.grid.dof))}
    if base is not None:
        found |= zip(
            MEMORIES, previous_attitude.memories_between(evidence, grid, output, base.nominal_axis), strict=False
        )
    return Between(found)


def _robust(evidence: Evidence, grid: GridResiduals) -> list[BeliefTest]:
    found = robust_fit(evidence, grid)
    return [] if found is None else [BeliefTest(ROBUST, "wrong-dwell", found.p_value, found.size, found.expected)]


def _lack_of_fit(evidence: Evidence, output: int, known: FloatArray) -> BeliefTest:
    """Test what repeats against precision and what the table's certificate and others explain, all together."""
    assert evidence.replication is not None
    plain = evidence.replication.lack_of_fit
    given = independent(np.hstack([evidence.basis, known])) if known.shape[1] > 0 else evidence.basis
    means = evidence.means(output, given)
    repeating = means.precision_variance * max(float(plain.t[output]) - 1.0, 0.0)
    p_value, dof = float(plain.p_value[output]), evidence.layout.points - given.shape[1]
    if (means.common.shape[1] > 0 or known.shape[1] > 0) and means.precision_variance > 0.0 and dof > 0:
        joined = np.column_stack([given, means.mean])
        whole = Elimination(gram_of(means, joined, means.precision_variance), given.shape[1], 0, dof, given)
        p_value = float(f_tail(whole.chi_square / dof, dof, plain.denominator_dof))
    return BeliefTest(LACK_OF_FIT, "lack-of-fit", p_value, float(np.sqrt(repeating)))


def _of_temperature(evidence: Evidence, shared: SharedTests, output: int, known: FloatArray) -> list[BeliefTest]:
    if shared.by_replication is None:
        return []
    found = []
    if TEMPERATURE_NAMES[0] not in evidence.models[output].primary_names:
        found = [slope_test(BY_REPLICATION, "temperature-residual", shared.by_replication, output, "per °C")]
        if tested_base(evidence.models[output]) is None:
            found += _by_point(evidence, output, known)
    if by_temperature.has_plateaus(evidence) and SECOND_ORDER_NAMES[0] not in evidence.models[output].primary_names:
        bent = by_temperature.between_replications(evidence, output, None, curved=True).curvature
        found.append(BeliefTest(CURVATURE, "temperature-curvature", bent.p_value, bent.size))
    return found


def _by_point(evidence: Evidence, output: int, known: FloatArray) -> list[BeliefTest]:
    """Return the tests of a model that has no terms of low order beside it."""
    means, columns = evidence.means(output, np.hstack([evidence.basis, known])), _by_point_degc(evidence, output)
    tested = eliminate(means, columns, np.zeros((means.mean.size, 0)))
    return [_term(_BY_POINT[index], tested.test(index)) for index in range(columns.shape[1])]


def _by_point_degc(evidence: Evidence, output: int) -> FloatArray:
    """Return (K, 2) temperature of the points, and its product with what the output senses over its largest.

    (K, 0) where none is recorded, where it is modelled or where it is one.
    """
    column, layout = by_temperature.departure_of_points(evidence), evidence.layout
    if column is None or TEMPERATURE_NAMES[0] in evidence.models[0].primary_names:
        return np.zeros((layout.points, 0))
    return np.column_stack([column, column * layout.mean_by_point(evidence.sensed[:, output])])


def low_order(evidence: Evidence, output: int, known: FloatArray, turned: FloatArray) -> Elimination | None:
    """Return what the means of the points are tested for, ready to be tested beside the linear sensor.

    These are the terms of low order, the attitude before and the temperature. None where the model has no such terms.
    ``turned`` (N,) is what the sensor was turned by from the attitude before.
    """
    base = tested_base(evidence.models[output])
    if base is None:
        return None
    layout, rows = evidence.layout, evidence.rows
    is_gyro = isinstance(base, Gyro | GyroWithTerms)
    terms = terms_of_gyro(evidence, output, base) if is_gyro else terms_of_accelerometer(evidence, base)
    linear, fitted = evidence.basis[:, :_LINEAR], evidence.basis[:, _LINEAR:]
    whole = independent(np.hstack([linear, known])) if known.shape[1] > 0 else linear
    means = evidence.means(output, whole, fitted @ evidence.alone[_LINEAR:, output])
    before = layout.mean_by_point(turned)
    skew = squareness_of_points(rows, layout, "x" if is_gyro else base.nominal_axis, evidence.primary[output])
    is_determined = layout.points >= _LINEAR + len(COLUMNS) + LEAST_DOF  # of fewer points no term can be spared
    memories = (
        np.zeros((layout.points, len(MEMORIES)))
        if is_gyro
        else previous_attitude.memories_of_points(evidence, base.nominal_axis)
    )
    in_order = _in_order(memories, settling_of_points(evidence), is_determined)
    turns, degc = np.column_stack([skew, before]), _by_point_degc(evidence, output)
    columns, unshared = np.hstack([terms, turns, in_order, degc]), np.hstack([known, turns, degc])
    return eliminate(means, columns, _beside(evidence.basis, terms, in_order), unshared)


@remembered(16)
def _in_order(memories: FloatArray, settles: FloatArray, is_determined: bool) -> FloatArray:
    """Return (K, 4) what the order of the points leaves at them; nothing where it is not asked for."""
    return np.column_stack([memories, settles]) * is_determined


@remembered(16)
def _beside(basis: FloatArray, terms: FloatArray, in_order: FloatArray) -> FloatArray:
    return np.hstack([basis, terms, in_order])


def _term(column: Column, tested: Tested, dof: float = inf) -> BeliefTest:
    coefficient, uncertainty = tested.coefficient, tested.standard_uncertainty
    return BeliefTest(column.name, column.kind, tested.p_value, coefficient, uncertainty, column.unit, dof)


def _decided(
    made: dict[str, BeliefTest],
    scatter: ReplicationScatter | None,
    between: Between,
    convicted: Collection[str],
    level: float,
    tested_columns: Sequence[Column],
) -> AxisTests:
    """Holm over all at the level of the axis.

    A significant column counts as known, and the other columns are tested beside it.
    The recorded temperature goes first where it is significant: what was measured before what is only imagined.
    """
    names = {column.name: index for index, column in enumerate(tested_columns)}
    known, dof = list[str](), inf if scatter is None else scatter.terms.dof
    while True:
        is_significant = significant(made, level, None if scatter is None else Overlap(scatter, between, names, known))
        still_open = [name for name in names if is_significant.get(name) and name not in known]
        if scatter is None or not still_open:
            if scatter is not None and known:
                made = stated_sizes(made, names, [name for name in known if name not in convicted], scatter, between)
                made = with_neighbours(made, names, known, scatter.terms)
            return AxisTests(made, is_significant, level=level)
        known.append(_next(still_open, made, scatter.terms, tuple(names[name] for name in known)))
        beside = tuple(names[name] for name in known)
        for name, column_index in names.items():
            if name in made and name not in known and name not in convicted:
                tested = _term(tested_columns[column_index], scatter.terms.test(column_index, beside), dof)
                tested = between.with_means(scatter.referred(tested, column_index, beside))
                made[name] = replace(tested, p_value=tested.p_value if isfinite(tested.p_value) else 1.0)


def _next(
    still_open: Sequence[str], made: Mapping[str, BeliefTest], columns: Elimination, beside: tuple[int, ...]
) -> str:
    """Return the column that counts as known from now on: the recorded temperature, else the most significant.

    A large bend is in part what any column of the points shows, the temperature's too: it goes first only where it is
    needed beside all others. Of two that are nearly collinear the bend goes before the asymmetry, unless that is needed
    beside the bend as well.
    """
    names = [column.name for column in COLUMNS]
    recorded = [name for name in still_open if name in _RECORDED]
    others = tuple(names.index(name) for name in still_open if name not in _RECORDED)
    needed = [name for name in recorded if not columns.test(names.index(name), (*beside, *others)).p_value > _NEEDED]
    if needed or not others:
        return min(needed or recorded, key=lambda name: made[name].p_value)
    # By the means alone, where all have the same degrees of freedom: an estimate between replications as well would put
    # a transient before the bend that it only looks like.
    in_means = {names[index]: columns.test(index, beside).p_value for index in others}
    most = min(in_means, key=lambda name: (in_means[name] if isfinite(in_means[name]) else 1.0, made[name].p_value))
    plainer = _PLAINER.get(most)
    if plainer is not None and plainer in still_open:
        still_needed = columns.test(names.index(most), (*beside, names.index(plainer)))
        if not still_needed.p_value <= _NEEDED:
            return plainer
    return most


def _explained_by_temperature(evidence: Evidence, output: int, decided: AxisTests) -> AxisTests:
    """Take from drift what temperature explains, and from curvature what a lag does."""
    flags, tests = dict(decided.is_significant), dict(decided.tests)
    if not any(flags.get(name) for name in (LAG, CURVATURE, BY_REPLICATION)):
        return decided
    lag_h = tests[LAG].uncertainty if flags.get(LAG) else None
    between = by_temperature.between_replications(evidence, output, lag_h, curved=bool(flags.get(CURVATURE)))
    if flags.get(LAG) and flags.get(CURVATURE) and not between.curvature.p_value <= decided.conviction_level:
        flags[CURVATURE] = False
        tests[CURVATURE] = replace(tests[CURVATURE], is_explained=True)
    if flags.get(LAG) or not between.unexplained <= decided.conviction_level:
        for name, test in tests.items():
            if test.kind == "drift" and flags[name]:
                flags[name], tests[name] = False, replace(test, is_explained=True)
    return replace(decided, tests=tests, is_significant=flags)
