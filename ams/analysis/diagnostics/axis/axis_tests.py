"""All tests of one sensor axis, made, and decided together.

Each test has a p-value of its own; which are significant is decided over all of them by Holm's correction, at the share
of the level that the axis has: the tests of all axes of a run are one family. A term of low order that is significant
counts as known, and its neighbours are tested beside it. A drift that temperature explains is temperature's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite
from typing import Final

import numpy as np

from ams.analysis.diagnostics.axis.axis_over_temperature import axis_over_temperature
from ams.analysis.diagnostics.axis.decided_together import decided_together, explained_by_temperature
from ams.analysis.diagnostics.axis.point_columns import by_point_degc, column_test, low_order
from ams.analysis.diagnostics.axis.robust_fit import robust_fit
from ams.analysis.diagnostics.beliefs import (
    AT_A_LOCATION,
    AUTOCORRELATION,
    BY_REPLICATION,
    COLUMNS,
    CURVATURE,
    DRIFT_OF,
    LACK_OF_FIT,
    LAG,
    LEVEL,
    MEMORIES,
    RECORDED,
    ROBUST,
    SETTLING,
    TABLE_LIMIT,
    TURNED_FROM,
    UNTOLD,
    WRONG_DWELL,
    AxisTests,
    BeliefTest,
    Column,
)
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.locations import LocationsShown, locations_shown
from ams.analysis.diagnostics.over_time import previous_attitude
from ams.analysis.diagnostics.over_time import temperature as by_temperature
from ams.analysis.diagnostics.over_time.drift_with_time import drift_with_time
from ams.analysis.diagnostics.over_time.range_ends import explained_by_ends
from ams.analysis.diagnostics.over_time.settling import Between, Estimate, slope_test
from ams.analysis.diagnostics.over_time.terms_over_temperature import of_terms_over_temperature
from ams.analysis.diagnostics.point_means import Elimination, eliminate, gram_of, independent
from ams.analysis.diagnostics.replication_scatter import ReplicationScatter, is_unsteady
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.sensed_force import attitude_of_points
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.tested_terms import (
    accelerometer_base,
    columns_of,
    tested_base,
)
from ams.analysis.diagnostics.time_order import (
    Autocorrelation,
    Slope,
    autocorrelation,
    hours,
    neighbours,
    settling_between,
    slope_between,
)
from ams.analysis.diagnostics.uneven_noise import uneven_noise, uneven_test
from ams.analysis.diagnostics.wrong_dwells import judged_by, largest_p_values, least_p_value
from ams.arrays import FloatArray
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.models.thermal import SECOND_ORDER_NAMES, TEMPERATURE_NAMES
from ams.solve.resolution import repeated_by_steps
from ams.statistics.distributions import f_tail

MOST_TESTS: Final = 39
"""Of one axis."""
_BY_POINT: Final = tuple(column for column in COLUMNS if column.name in RECORDED)


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
    readings: FloatArray,
    convicted: Mapping[str, BeliefTest],
    limit: TableLimit | None = None,
    family: int = 1,
    given: FloatArray | None = None,
) -> AxisTests:
    """Return all tests of one axis, decided as one of a ``family`` of axes.

    ``readings`` (N,): its output as it was read, whatever is taken out of the evidence.
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
    wrong_p_value = least_p_value(dwells, wrong_p_value, level / MOST_TESTS, readings)
    known = _known(evidence, output, lagging, given, limit, level)
    before = previous_attitude.turned_from(evidence, output)
    found = [
        BeliefTest(WRONG_DWELL, "wrong-dwell", wrong_p_value),
        *([] if limit is None else [_of_the_table(limit)]),
        *_of_replications(evidence, output, known, readings),
        BeliefTest(AUTOCORRELATION, "autocorrelation", wander[1], wander[0]),
        *_of_the_attitude_before(evidence, grid, before),
        *_robust(evidence, grid),
        *uneven_test(uneven_noise(grid, readings), evidence.layout),
    ]
    if shared.over_time is not None:
        found.append(drift_with_time(evidence, shared.over_time, output))
    found += _of_temperature(evidence, shared, output, known)
    found += [*([] if lag is None else [lag]), *of_terms_over_temperature(evidence, output, lag)]
    turning = axis_over_temperature(evidence, output, None)
    found += [] if turning is None else [turning.test]
    terms = low_order(evidence, output, known, before)
    columns = columns_of(evidence.models[output])
    shown = _locations(evidence, output, known, None if AT_A_LOCATION in convicted else terms, level)
    found.append(_of_locations(shown))
    between, by_replication = _between(evidence, shared, output, grid), None
    if terms is None:
        found.append(slope_test(SETTLING, "drift", shared.settling, output, "", is_held=False))
    else:
        by_replication = ReplicationScatter(evidence, output, terms, level, is_unsteady(found, level / MOST_TESTS))
        found += [
            between.with_means(by_replication.referred(column_test(column, tested, terms.dof), index))
            for index, (column, tested) in enumerate(zip(columns, terms.each(), strict=False))
        ]
    made = {test.name: test for test in found if isfinite(test.p_value)} | dict(convicted)
    memories = [made[name] for name in MEMORIES if name in made]
    decided = decided_together(made, by_replication, between, convicted, level, columns)
    decided = explained_by_ends(evidence, output, explained_by_temperature(evidence, output, decided), convicted)
    return replace(decided, grid=grid, dwells=dwells, memories=memories, locations=shown.locations)


def _known(
    evidence: Evidence,
    output: int,
    lagging: FloatArray | None,
    given: FloatArray | None,
    limit: TableLimit | None,
    level: float,
) -> FloatArray:
    """Return (K, c) of what is known at the points: a lag, what is taken out, index errors beyond a limit."""
    known = np.zeros((evidence.layout.points, 0)) if lagging is None else evidence.layout.mean_by_point(lagging)
    if given is not None and given.shape[1] > 0:
        known = np.hstack([known, given])
    if limit is not None and not limit.is_departing and limit.p_value <= limit.outputs * level / MOST_TESTS:
        known = np.hstack([known, _index_effects(evidence, output, limit, known)])
    return known


def _locations(
    evidence: Evidence, output: int, known: FloatArray, terms: Elimination | None, level: float
) -> LocationsShown:
    """Return the locations of the table at which what repeats is off; ``terms``: what else it is tested for."""
    if terms is None or accelerometer_base(evidence.models[output]) is None:
        return LocationsShown((), float("nan"))
    return locations_shown(evidence, output, known, terms.design[:, terms.given :], level)


def _of_locations(shown: LocationsShown) -> BeliefTest:
    size = max((abs(location.size) for location in shown.locations), default=float("nan"))
    return BeliefTest(AT_A_LOCATION, "lack-of-fit", shown.p_value, size, is_held=False)


def _lag(evidence: Evidence, output: int, level: float) -> tuple[BeliefTest | None, FloatArray | None]:
    """Return the test of a lag, and where it is plain (N, 2) what the lag does: all others are tested beside that."""
    if not by_temperature.has_plateaus(evidence):
        return None, None
    lag = by_temperature.lag(evidence, output)
    test = BeliefTest(LAG, "temperature-lag", lag.p_value, lag.size, lag.detail, is_held=False)
    if not lag.p_value <= level / MOST_TESTS:
        return test, None
    return test, by_temperature.lag_columns(evidence, output, lag.detail)


def _of_the_table(limit: TableLimit) -> BeliefTest:
    size = max(limit.largest_rad.values())
    return BeliefTest(TABLE_LIMIT, "lack-of-fit", limit.p_value, size, unit="rad", axes=limit.outputs, is_held=False)


def _index_effects(evidence: Evidence, output: int, limit: TableLimit, known: FloatArray) -> FloatArray:
    """Return (K, c) what any index errors do to the points, beside a linear sensor and what is known already."""
    base = accelerometer_base(evidence.models[output])
    points = next(iter(limit.columns.values())).shape[0]
    if base is None or points != evidence.layout.points:
        return np.zeros((evidence.layout.points, 0))
    stood = attitude_of_points(base, evidence.rows, evidence.layout)
    slopes = base.angle_jacobian(evidence.primary[output][: len(base.primary_names)], stood)
    return limit.effects(slopes, np.hstack([evidence.basis[:, :LINEAR_COLUMNS], known]))


def _of_replications(evidence: Evidence, output: int, known: FloatArray, readings: FloatArray) -> list[BeliefTest]:
    replication, sums = evidence.replication, evidence.sums
    if replication is None or sums is None:
        return []
    drifts = [
        BeliefTest(f"{DRIFT_OF}{name}", "drift", float(test.p_value[output]))
        for name, test in replication.drift.items()
    ]
    lack_of_fit = _lack_of_fit(evidence, output, known, 0.0)
    if lack_of_fit.p_value <= UNTOLD and (of_steps := repeated_by_steps(readings, evidence.layout)) > 0.0:
        lack_of_fit = _lack_of_fit(evidence, output, known, of_steps)
    return [lack_of_fit, *drifts]


def _of_the_attitude_before(evidence: Evidence, grid: GridResiduals, column: FloatArray) -> list[BeliefTest]:
    found = previous_attitude.between_replications(evidence, grid, column)
    return [] if found is None else [column_test(Column(TURNED_FROM, "autocorrelation", ""), found)]


def _between(evidence: Evidence, shared: SharedTests, output: int, grid: GridResiduals) -> Between:
    """Return, by what differs from replication to replication, estimates of what the means of the points show too."""
    settles, base = shared.settling, accelerometer_base(evidence.models[output])
    coefficient, uncertainty = settles.coefficient[output], settles.standard_uncertainty[output]
    found = {SETTLING: Estimate(float(coefficient), float(uncertainty), float(evidence.grid.dof))}
    if base is not None:
        found |= zip(MEMORIES, previous_attitude.memories_between(evidence, grid, output, base), strict=False)
    return Between(found)


def _robust(evidence: Evidence, grid: GridResiduals) -> list[BeliefTest]:
    found = robust_fit(evidence, grid)
    if found is None:
        return []
    return [BeliefTest(ROBUST, "wrong-dwell", found.p_value, found.size, found.expected, is_held=False)]


def _lack_of_fit(evidence: Evidence, output: int, known: FloatArray, of_steps: float) -> BeliefTest:
    """Test what repeats against precision and what the table's certificate and others explain, all together.

    ``of_steps``: variance of what the steps of the readings repeat at every point by itself.
    """
    assert evidence.replication is not None
    plain = evidence.replication.lack_of_fit
    given = independent(np.hstack([evidence.basis, known])) if known.shape[1] > 0 else evidence.basis
    means = evidence.means(output, given)
    precision = means.precision_variance
    repeating = precision * max(float(plain.t[output]) - 1.0, 0.0)
    p_value, dof = float(plain.p_value[output]), evidence.layout.points - given.shape[1]
    is_explained = means.common.shape[1] > 0 or known.shape[1] > 0 or of_steps > 0.0
    if is_explained and precision > 0.0 and dof > 0:
        joined, variance = np.column_stack([given, means.mean]), precision + of_steps
        whole = Elimination(gram_of(means, joined, variance), given.shape[1], 0, dof, given)
        against = plain.denominator_dof * (variance / precision) ** 2
        p_value = float(f_tail(whole.chi_square / dof, dof, against))
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
    means, columns = evidence.means(output, np.hstack([evidence.basis, known])), by_point_degc(evidence, output)
    tested = eliminate(means, columns, np.zeros((means.mean.size, 0)))
    return [column_test(_BY_POINT[index], tested.test(index)) for index in range(columns.shape[1])]
