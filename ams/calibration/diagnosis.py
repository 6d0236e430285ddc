"""From solved sensor axes to their findings: evidence once for all, convicted dwells out, the other tests again.

A wrong dwell is convicted by what the other replications say of it; the remaining tests of its axis are made on a
solution without it, so that nothing else is blamed for it. The result itself keeps the dwell: a person takes it back.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.analysis.diagnostics.axis_tests import SharedTests, axis_tests, shared_tests
from ams.analysis.diagnostics.beliefs import DRIFT_OF, LACK_OF_FIT, WRONG_DWELL, AxisTests
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.facts import (
    Moved,
    drift_in_parameters,
    temperature_confounded,
    time_confounded,
    undetermined_axis,
)
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.time_order import even_drift
from ams.analysis.diagnostics.wording import Convicted, Scale, findings_of
from ams.analysis.diagnostics.wrong_dwells import WrongDwells, convict
from ams.analysis.replication import ReplicationColumns, quantity
from ams.arrays import BoolArray, FloatArray
from ams.calibration.columns import SolvedColumns, plots_of, solve_linearised
from ams.findings import Finding
from ams.frames import wrap_deg
from ams.inputs.request import select_rows
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations
from ams.solve.layout import layout_of
from ams.solve.linearised import linearise
from ams.units import ARCSEC_PER_DEG, label_and_unit


@dataclass(frozen=True)
class Diagnosis:
    """Of one sensor axis."""

    findings: tuple[Finding, ...]
    solved: SolvedColumns
    """Of the rows that the tests believe: the solution itself where no dwell is convicted."""
    row: int
    """Place of the axis in ``solved``."""
    tests: AxisTests


@dataclass(frozen=True)
class Circumstances:
    """What the observations were solved under."""

    rows: Observations
    outputs: FloatArray
    """(N, m) as read."""
    table: TableUncertainty | None
    shared: Sequence[SharedError]
    limits: Sequence[TableLimit | None] = ()
    """Of each output, what the package that it belongs to says of the table's declared limit; empty: not asked."""

    family: int = 1
    """How many axes a run has, whose tests are one family; 1: every output is judged by itself."""

    order: Sequence[Finding] = ()
    """What is said of the order of the points already."""

    def limit_of(self, place: int) -> TableLimit | None:
        return self.limits[place] if self.limits else None


def diagnose(solved: SolvedColumns, circumstances: Circumstances) -> list[Diagnosis]:
    """Return the findings of every axis of one group."""
    axes = range(len(solved.problem.models))
    if solved.problem.form.weights is not None:
        return [Diagnosis(tuple(_undetermined(solved, place)), solved, place, AxisTests({})) for place in axes]
    evidence = evidence_of(solved, circumstances.rows)
    shared, order = shared_tests(evidence), (*time_confounded(evidence), *temperature_confounded(evidence))
    found = []
    for place in axes:
        one = _axis(evidence, shared, place, solved, replace(circumstances, order=order))
        found.append(replace(one, findings=(*one.findings, *order, *_undetermined(solved, place))))
    return found


def _axis(
    evidence: Evidence, shared: SharedTests, place: int, solved: SolvedColumns, circumstances: Circumstances
) -> Diagnosis:
    limit = circumstances.limit_of(place)
    tests = axis_tests(evidence, shared, place, None, limit, circumstances.family)
    wrong = _convicted(evidence, place, tests)
    if wrong is None or not wrong.dwells:
        return _diagnosis(evidence, solved, place, tests, None, circumstances, limit)
    kept, convicted = _rows_of(evidence, wrong)
    rows, model = select_rows(circumstances.rows, kept), solved.problem.models[place]
    layout = layout_of(rows)
    problem = linearise([model], rows, layout, circumstances.outputs[kept, place : place + 1], None)
    believed = solve_linearised(
        problem, layout, plots_of(model, rows, layout), circumstances.table, circumstances.shared
    )
    other = evidence_of(believed, select_rows(circumstances.rows, kept))
    tests = axis_tests(other, shared_tests(other), 0, wrong.p_value, limit, circumstances.family)
    return _diagnosis(other, believed, 0, tests, convicted, circumstances, limit)


def _undetermined(solved: SolvedColumns, place: int) -> Iterator[Finding]:
    return undetermined_axis(
        solved.problem.models[place],
        solved.primary[place],
        solved.primary_covariance[place],
    )


def evidence_of(solved: SolvedColumns, rows: Observations) -> Evidence:
    """Return what the tests look at."""
    problem, layout = solved.problem, solved.layout
    form, alone, ordinary = problem.form, problem.alone, solved.mixed.ordinary
    fitted = form.basis @ ordinary
    basis = alone.block if alone.repeats > 1 else layout.mean_by_point(alone.basis)
    return Evidence(
        rows=rows,
        layout=layout,
        models=problem.models,
        basis=basis,
        left=problem.outputs - fitted,
        fitted=fitted,
        primary=solved.primary,
        own=ordinary[: alone.basis.shape[1]],
        common=[_at_points(solved, blocks) for blocks in solved.common],
        sums=solved.mixed.sums,
        replication=solved.replication,
    )


def _at_points(solved: SolvedColumns, blocks: Mapping[str, FloatArray]) -> FloatArray:
    if not blocks:
        return np.zeros((solved.layout.points, 0))
    joined = np.hstack(list(blocks.values()))
    is_by_point = solved.problem.form.repeats > 1
    return joined if is_by_point else solved.layout.mean_by_point(joined)


def _convicted(evidence: Evidence, output: int, tests: AxisTests) -> WrongDwells | None:
    level = tests.conviction_level
    if tests.grid is None or WRONG_DWELL not in tests.tests or not tests.tests[WRONG_DWELL].p_value <= level:
        return None
    other_view = np.zeros(evidence.grid.present.size)
    other_view[evidence.dwell] = evidence.left[:, output]
    return convict(tests.grid, level, other_view)


def _rows_of(evidence: Evidence, wrong: WrongDwells) -> tuple[BoolArray, Convicted]:
    row_of = dict(zip(evidence.dwell.tolist(), range(evidence.layout.rows), strict=True))
    rows = tuple(row_of[dwell] for dwell in wrong.dwells)
    kept = np.ones(evidence.layout.rows, dtype=bool)
    kept[list(rows)] = False
    return kept, Convicted(wrong, rows)


def _diagnosis(
    evidence: Evidence,
    solved: SolvedColumns,
    place: int,
    tests: AxisTests,
    convicted: Convicted | None,
    circumstances: Circumstances,
    limit: TableLimit | None,
) -> Diagnosis:
    scale = _scale(solved, place)
    drifted = tuple(_drift_in_parameters(evidence, solved, place, tests.conviction_level))
    passes = [one for one in (*circumstances.order, *drifted) if one.kind == "time-confounded" and one.is_significant]
    findings = findings_of(
        tests,
        scale,
        circumstances.rows,
        convicted,
        _moves(solved, place, scale) if _some_drift(tests) else {},
        has_table=circumstances.table is not None,
        limit=limit,
        is_contained=not passes,
    )
    return Diagnosis((*findings, *drifted), solved, place, tests)


def _drift_in_parameters(evidence: Evidence, solved: SolvedColumns, place: int, level: float) -> Iterator[Finding]:
    if evidence.rows.time_s is None:
        return
    problem, mixed, free = solved.problem, solved.mixed, solved.problem.free
    left, fitted = evidence.left[:, place], evidence.fitted[:, place]
    drift = even_drift(problem.form.basis, left, fitted, evidence.rows.time_s)
    if drift is None:
        return
    estimator = mixed.estimator if mixed.estimator.ndim == 2 else mixed.estimator[place]
    parameters, answer = solved.parameters, drift.slope * (estimator @ drift.seconds)
    by = parameters.directions[place][:, free] @ answer
    moved = Moved(parameters.names, by, parameters.standard_uncertainties[place])
    yield from drift_in_parameters(drift, moved, problem.models[place].measured_unit, level)


def _some_drift(tests: AxisTests) -> bool:
    return any(stands and name.startswith(DRIFT_OF) for name, stands in tests.is_significant.items())


def corrected_replication(found: Diagnosis) -> ReplicationColumns | None:
    """Return the replication tests of what is believed, as significant as all tests of the axis together have it."""
    columns, flags = found.solved.replication, found.tests.is_significant
    if columns is None or not flags:
        return columns
    size = len(found.solved.problem.models)
    drift = {
        name: replace(test, is_significant=np.full(size, flags.get(f"{DRIFT_OF}{name}", False)))
        for name, test in columns.drift.items()
    }
    repeats = columns.lack_of_fit.p_value <= found.tests.conviction_level
    lack_of_fit = np.where(flags.get(LACK_OF_FIT, False), True, repeats)
    return replace(columns, lack_of_fit=replace(columns.lack_of_fit, is_significant=lack_of_fit), drift=drift)


def _scale(solved: SolvedColumns, place: int) -> Scale:
    model = solved.problem.models[place]
    along = [
        value
        for name, value in zip(model.primary_names, solved.primary[place], strict=True)
        if name.startswith("k_") and name.endswith("_v_per_g")
    ]
    per_radian = float(np.linalg.norm(along)) if along else 0.0
    return Scale(model.measured_unit, per_radian if per_radian > 0.0 else None)


def _moves(solved: SolvedColumns, place: int, scale: Scale) -> dict[str, str]:
    """Return how far each quantity moved from replication to replication, in words."""
    if solved.replication is None:
        return {}
    found: dict[str, list[float]] = {}
    units: dict[str, str] = {}
    for estimates in solved.per_replication(place).values():
        for name, value in estimates.items():
            found.setdefault(quantity(name), []).append(value)
            units[quantity(name)] = name
    return {
        name: _move(units[name], _span(name, np.array(values)), float(np.mean(values)), scale)
        for name, values in found.items()
        if name in solved.replication.drift
    }


def _span(name: str, values: FloatArray) -> float:
    if name.startswith("azimuth"):
        values = values[0] + wrap_deg(values - values[0])
    return float(np.ptp(values)) if np.isfinite(values).all() else float("nan")


def _move(name: str, span: float, mean: float, scale: Scale) -> str:
    if name == "offset_v":
        return scale.words(span)
    if name.startswith("sensitivity_v") and mean != 0.0:
        return f"{1e6 * span / abs(mean):.2g} ppm"
    return f"{span * ARCSEC_PER_DEG:.3g}″" if name.endswith("_deg") else f"{span:.2g} {label_and_unit(name)[1]}"
