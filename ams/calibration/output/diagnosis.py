"""From solved sensor axes to their findings: evidence once for all, convicted dwells out, the other tests again.

A wrong dwell is convicted by what the other replications say of it; the remaining tests of its axis are made on a
solution without it, so that nothing else is blamed for it. The result itself keeps the dwell: a person takes it back.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from ams.analysis.diagnostics.axis.axis_tests import shared_tests
from ams.analysis.diagnostics.beliefs import (
    AT_A_LOCATION,
    DRIFT_OF,
    LACK_OF_FIT,
    TABLE_LIMIT,
    WRONG_DWELL,
    AxisTests,
)
from ams.analysis.diagnostics.declared.declared_axis import direction_findings
from ams.analysis.diagnostics.declared.declared_signs import fits_other_angles
from ams.analysis.diagnostics.declared.differing_replications import differing_replications
from ams.analysis.diagnostics.declared.earth_on_gyros import earth_finding
from ams.analysis.diagnostics.declared.gravity_on_gyros import gravity_finding, gravity_on_zero
from ams.analysis.diagnostics.declared.laid_points import laid_finding
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.facts import Moved, drift_in_parameters, temperature_confounded, time_confounded
from ams.analysis.diagnostics.locations import Location
from ams.analysis.diagnostics.over_time.drift_course import changes_between
from ams.analysis.diagnostics.over_time.memories import but_for_memories, without_lesser_memories
from ams.analysis.diagnostics.size_words import AxisWords, Scale
from ams.analysis.diagnostics.stated_limits import StatedLimits
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.time_order import even_drift, row_time
from ams.analysis.diagnostics.words.held_words import drift_words, lack_words, untested_scatter
from ams.analysis.diagnostics.words.location_words import location_finding
from ams.analysis.diagnostics.words.table_limit_wording import of_table_limit
from ams.analysis.diagnostics.words.wording import findings_of
from ams.analysis.diagnostics.words.wrong_dwell_words import Convicted, wrong_dwell_finding
from ams.arrays import FloatArray
from ams.calibration.output.believed import Believed, evidence_of
from ams.calibration.output.circumstances import Circumstances
from ams.calibration.output.declared_limits import (
    counts_earth,
    declared_departure,
    declared_g_sensitivity,
    lack_alike_over,
    largest_lack,
    largest_shifts,
    shift_limits,
)
from ams.calibration.output.explained import (
    Explained,
    Ground,
    without_course_or_noise,
    without_ground,
    without_locations,
    without_memory,
    without_transient,
    without_wrong_dwells,
)
from ams.calibration.output.moved_quantities import moves_between
from ams.calibration.output.rails import without_clipped
from ams.calibration.solving.columns import SolvedColumns
from ams.calibration.steps import step_words
from ams.calibration.steps.step_columns import beside_of, step_columns
from ams.calibration.steps.steps_of_output import NO_STEPS, with_steps
from ams.calibration.together import backlash_found
from ams.calibration.together.backlash_found import backlash_findings
from ams.calibration.together.package_wide import package_wide_findings
from ams.calibration_result import FTest
from ams.findings import Finding, Said
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.shared_errors import SharedError
from ams.models.model import Model


@dataclass(frozen=True)
class Diagnosis:
    """Of one sensor axis."""

    findings: tuple[Finding, ...]
    solved: SolvedColumns
    """Of the rows that the tests believe: the solution itself where no dwell is convicted."""
    row: int
    """Location of the axis in ``solved``."""
    tests: AxisTests


def diagnose(solved: SolvedColumns, circumstances: Circumstances, evidence: Evidence | None = None) -> list[Diagnosis]:
    """Return the findings of every axis of one group; ``evidence``: where it is made already."""
    axes = range(len(solved.problem.models))
    if solved.problem.form.weights is not None:
        return [
            Diagnosis(tuple(_of_direction(solved, axis, circumstances)), solved, axis, AxisTests({})) for axis in axes
        ]
    evidence = evidence_of(solved, circumstances.rows) if evidence is None else evidence
    shared, order = shared_tests(evidence), (*time_confounded(evidence), *temperature_confounded(evidence))
    found, nothing, still = [], np.zeros((circumstances.rows.rows, 0)), np.zeros(circumstances.rows.rows)
    in_order = replace(circumstances, order=order)
    given = (circumstances.outputs, circumstances.rows, circumstances.table, circumstances.shared)
    for axis in axes:
        whole = Believed(evidence, shared, solved, axis, *given, nothing, still, circumstances.outputs[:, axis])
        diagnosis = _axis(whole, axis, in_order)
        found.append(
            replace(diagnosis, findings=(*diagnosis.findings, *order, *_of_direction(solved, axis, circumstances)))
        )
    return found


def _axis(seen: Believed, index: int, circumstances: Circumstances) -> Diagnosis:
    """Return the diagnosis of one output; ``index`` is its own among those of the group."""
    limit, steps = circumstances.limit_of(index), circumstances.steps_of(index)
    clipped, seen = without_clipped(seen)
    plays = circumstances.plays_of(index)
    wide = None if clipped else circumstances.package_wide
    if clipped:
        steps, plays = NO_STEPS, ()
    if steps.during:
        columns = step_columns(seen.evidence, seen.index, steps.during)
        beside = beside_of(seen.evidence, seen.index, steps.drifting)
        before, seen = seen, seen.without(columns, beside)
        part, model = before.part_of(columns, beside), before.solved.problem.models[before.index]
        steps = replace(steps, findings=_within_declared(steps.findings, part, circumstances.shared, model))
    if plays:
        seen = seen.less(backlash_found.taken_by(plays, seen.evidence, seen.index))
    if wide is not None:
        seen = seen.beside(*wide.taken_by(seen.evidence, seen.index))
    together = circumstances.together_of(index)
    of_plays = [backlash_found.test_of(play, circumstances.table) for play in plays]
    of_package = [] if wide is None else [wide.test]
    limit = limit if all(test.is_held for test in of_plays) else None  # it is told to be broken, and by what
    made = {test.name: test for test in (*steps.tests, *but_for_memories(together), *of_plays, *of_package)}
    left = Explained(seen, made, seen.tested(made, limit, circumstances.family), limit, circumstances.family)
    left, convicted = without_wrong_dwells(without_course_or_noise(left))
    left, locations = without_locations(left)
    left, ground = without_ground(
        without_memory(without_transient(left), together),
        declared_g_sensitivity(circumstances.shared),
        lacks_earth=not counts_earth(seen.evidence.rows, circumstances.shared),
    )
    steps = steps.beside(left.tests)
    tests = without_lesser_memories(with_steps(left.tests, steps))
    diagnosis = _diagnosis(left.seen.with_course(), tests, convicted, circumstances, limit, ground, locations)
    changes = map(step_words.as_stated, steps.findings)
    turned = (*backlash_findings(plays, tests, circumstances.table), *package_wide_findings(wide, tests))
    return replace(diagnosis, findings=(*clipped, *turned, *changes, *steps.with_undecided(diagnosis.findings)))


def _within_declared(
    findings: tuple[Finding, ...], change_v: FloatArray, shared: Sequence[SharedError], model: Model
) -> tuple[Finding, ...]:
    """Return what is said of changes in mid-run, one within the limits that are declared of the sensor as held.

    A step of offset or sensitivity alone is held against its own limit by its estimate; of another change, and of one
    without a limit of its own, all that it does counts against that of the offset.
    """
    limits = shift_limits(shared)
    is_small = float(np.abs(change_v).max()) <= limits[step_words.OFFSET_LIMIT]
    is_alone = sum(said.kind == "sensor-change" for said in findings) == 1

    def sized(said: Finding) -> Finding:
        if said.kind != "sensor-change":
            return said
        step = step_words.step_of(said, model.nominal_axis, limits) if is_alone else None
        if step is not None and (step.limit > 0.0 or not is_small):
            return step_words.with_size(said, step, model.measured_unit)
        within = f"it is within the declared {step_words.OFFSET_LIMIT}"
        return step_words.as_held(said, within) if is_small else said

    return tuple(sized(said) for said in findings)


def _of_direction(solved: SolvedColumns, index: int, circumstances: Circumstances) -> Iterator[Finding]:
    model, declared = solved.problem.models[index], circumstances.declared
    yield from circumstances.signs_of(index)
    yield from direction_findings(
        model,
        solved.primary[index],
        solved.primary_covariance[index],
        solved.primary_dof[index],
        declared[index] if declared else DeclaredDirection(model.nominal_axis),
    )


def _diagnosis(
    seen: Believed,
    tests: AxisTests,
    convicted: Convicted | None,
    circumstances: Circumstances,
    limit: TableLimit | None,
    ground: Ground,
    locations: Sequence[Location],
) -> Diagnosis:
    evidence, solved, index = seen.evidence, seen.solved, seen.index
    scale = scale_of(solved, index)
    drifted = tuple(_drift_in_parameters(evidence, solved, index, tests.conviction_level))
    shifts = largest_shifts(scale, circumstances.shared)
    differing = tuple(differing_replications(evidence, index, shifts, tests.conviction_level))
    departure = declared_departure(circumstances.shared)
    alike = lack_alike_over(seen, tests, departure)
    limits = StatedLimits(
        largest_lack(seen, circumstances.shared),
        2.0 * float(np.sqrt(solved.primary_covariance[index, 0, 0])),
        any(map(fits_other_angles, circumstances.signs_of(index))),
        bool(differing),
        bool(alike),
        departure,
    )
    tests = limits.judged(tests)
    gravity = _of_gravity(seen, tests, ground, circumstances.shared)
    has_table = circumstances.table is not None
    words = AxisWords(
        scale,
        tests.conviction_level,
        has_table=has_table,
        is_of_levels=circumstances.rows.is_of_levels,
        order_repeats=evidence.order_repeats and evidence.layout.replications > 1,
        lack_is=_lack_is(tests, limits, alike, circumstances, follows_gravity=gravity is not None),
        drift_is=drift_words(
            (*circumstances.order, *drifted), is_remembering=tests.is_remembering, is_differing=bool(differing)
        ),
        drifts=moves_between(solved, index, scale) if _some_drift(tests) else {},
    )
    findings = findings_of(tests, words, _worded(tests, scale, circumstances, convicted, limit, locations))
    return Diagnosis(
        (
            *([] if gravity is None else [gravity]),
            *_of_ground(ground, tests),
            *findings,
            *drifted,
            *differing,
            *_untested_scatter(solved, index, tests, limits, circumstances),
        ),
        solved,
        index,
        tests,
    )


def _worded(
    tests: AxisTests,
    scale: Scale,
    circumstances: Circumstances,
    convicted: Convicted | None,
    limit: TableLimit | None,
    locations: Sequence[Location],
) -> dict[str, Finding]:
    """Return the findings that have words of their own, by the name of their test."""
    found = {}
    if convicted is not None and WRONG_DWELL in tests.tests:
        wrong, rows = tests.tests[WRONG_DWELL], circumstances.rows
        found[WRONG_DWELL] = wrong_dwell_finding(wrong, scale, rows, convicted, circumstances.alike)
    if limit is not None and TABLE_LIMIT in tests.tests:
        off, is_significant = tests.tests[TABLE_LIMIT], tests.is_significant[TABLE_LIMIT]
        found[TABLE_LIMIT] = of_table_limit(off, limit, is_significant=is_significant)
    if tests.is_significant.get(AT_A_LOCATION):
        found[AT_A_LOCATION] = location_finding(
            tests.tests[AT_A_LOCATION], locations or tests.locations, scale, circumstances.rows
        )
    return found


def _untested_scatter(
    solved: SolvedColumns, index: int, tests: AxisTests, limits: StatedLimits, circumstances: Circumstances
) -> Iterator[Finding]:
    if LACK_OF_FIT in tests.tests:
        return
    scatter, words = float(solved.standard_error_v[index]), scale_of(solved, index).words
    is_of_levels = circumstances.rows.is_of_levels
    yield from untested_scatter(scatter, words(scatter), limits.lack_of_fit, is_of_levels=is_of_levels)


def _lack_is(
    tests: AxisTests,
    limits: StatedLimits,
    alike: Sequence[str],
    circumstances: Circumstances,
    *,
    follows_gravity: bool,
) -> Said:
    """Return whether a lack of fit is in the stated uncertainties; ``alike``: axes over whose indices it goes alike."""
    return lack_words(
        other_angles=limits.is_of_other_angles,
        is_large=LACK_OF_FIT in tests.tests and tests.tests[LACK_OF_FIT].size > limits.lack_of_fit,
        follows_gravity=follows_gravity,
        is_remembering=tests.is_remembering,
        is_of_order=tests.is_of_order,
        alike_over=alike,
        has_table=circumstances.table is not None,
        is_of_levels=circumstances.rows.is_of_levels,
    )


def _of_gravity(seen: Believed, tests: AxisTests, ground: Ground, shared: Sequence[SharedError]) -> Finding | None:
    found = gravity_on_zero(seen.evidence, seen.index, ground.columns(seen.evidence.layout))
    has_earth = counts_earth(seen.evidence.rows, shared)
    return gravity_finding(found, tests.conviction_level, declared_g_sensitivity(shared), counts_earth=has_earth)


def _of_ground(ground: Ground, tests: AxisTests) -> Iterator[Finding]:
    if ground.laid is not None:
        yield laid_finding(ground.laid)
    if ground.earth is not None:
        yield earth_finding(ground.earth, tests.conviction_level)


def _drift_in_parameters(evidence: Evidence, solved: SolvedColumns, index: int, level: float) -> Iterator[Finding]:
    time = row_time(evidence)
    if time is None:
        return
    problem, mixed, free = solved.problem, solved.mixed, solved.problem.free
    left, fitted = evidence.left[:, index], evidence.fitted[:, index]
    drift = even_drift(problem.form.basis, left, fitted, time)
    if drift is None or not drift.p_value <= level or changes_between(evidence, index):
        return
    estimator = mixed.estimator if mixed.estimator.ndim == 2 else mixed.estimator[index]
    parameters, answer = solved.parameters, drift.slope * (estimator @ drift.seconds)
    by = parameters.directions[index][:, free] @ answer
    moved = Moved(parameters.names, by, parameters.standard_uncertainties[index])
    unit, has_times = problem.models[index].measured_unit, evidence.rows.time_s is not None
    yield from drift_in_parameters(drift, moved, unit, has_times=has_times)


def _some_drift(tests: AxisTests) -> bool:
    return any(stands and name.startswith(DRIFT_OF) for name, stands in tests.is_significant.items())


def replication_tests(found: Diagnosis) -> tuple[FTest, dict[str, FTest]] | None:
    """Return lack of fit and drifts of what is believed, as significant as all tests of the axis together have them.

    That of lack of fit has the chance that the findings state, under the covariance of the table and of what is known.
    """
    columns, flags, row = found.solved.replication, found.tests.is_significant, found.row
    if columns is None:
        return None
    drift, stated = columns.drift, found.tests.tests.get(LACK_OF_FIT)
    if not flags:
        return columns.lack_of_fit.of(row), {name: test.of(row) for name, test in drift.items()}
    p_value, is_lacking = None if stated is None else stated.p_value, flags.get(LACK_OF_FIT, False)
    return columns.lack_of_fit.of(row, is_significant=is_lacking, p_value=p_value), {
        name: test.of(row, is_significant=flags.get(f"{DRIFT_OF}{name}", False)) for name, test in drift.items()
    }


def sensitivity_of(found: Diagnosis) -> float | None:
    """Return the sensitivity of an axis, V/g; None where it has none."""
    return scale_of(found.solved, found.row).volts_per_radian


def scale_of(solved: SolvedColumns, index: int) -> Scale:
    """Return what turns an output into words."""
    model = solved.problem.models[index]
    along = [
        value
        for name, value in zip(model.primary_names, solved.primary[index].tolist(), strict=True)
        if name.startswith("k_") and name.endswith("_v_per_g")
    ]
    per_radian = hypot(*along)
    return Scale(model.measured_unit, per_radian if per_radian > 0.0 else None)
