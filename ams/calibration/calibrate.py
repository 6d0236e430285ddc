"""Calibration of one sensor package: the whole story on one page.

Observations and a request go in, a :class:`~ams.calibration_result.Calibration` comes out. For every sensor axis:

1. the model, linear in its primary parameters (offset and vector of sensitivities) or made so at its solution;
2. ordinary least squares over all rows: the pooled forms of TP (43) to (50), kept as ``tp``;
3. what is common to all rows of an index or a coefficient (table, temperature) as columns of U_Y;
4. the mixed-model estimate, whose covariance holds precision, drift, lack of fit and the common errors, each once;
5. the derived parameters, their uncertainties, the tests, and in words what the data cannot say.

Axes that share a basis are solved together (:mod:`ams.calibration.solving.columns`); the words are made here.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from ams.analysis.diagnostics.declared.declared_axis import handedness, undetermined_by_errors
from ams.analysis.diagnostics.declared.unlike_axes import with_unlike_axes
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.facts import untold_order
from ams.arrays import FloatArray
from ams.calibration.askew_seats import AskewSeats, judge_seats, with_seats
from ams.calibration.between_rates import errors_between_rates
from ams.calibration.layout_warnings import layout_warnings
from ams.calibration.limit_of_package import SolvedGroup, limits_of_package
from ams.calibration.output.believed import evidence_of
from ams.calibration.output.circumstances import Circumstances
from ams.calibration.output.contradicted_signs import contradicted_signs, with_readings_put_right
from ams.calibration.output.diagnosis import (
    Diagnosis,
    replication_tests,
)
from ams.calibration.output.untold import undetected_dwell, untold_noise, untold_of_few, untold_transient
from ams.calibration.output.untold_curvature import bend_remarks, curvature_warnings
from ams.calibration.outputs_together import diagnose_together, tilt_of_base, with_tilt
from ams.calibration.rates_of_table import with_rates_of_table
from ams.calibration.solving.columns import SolvedColumns, plots_of, solve_linearised
from ams.calibration.solving.model_choice import ModelChoice, base_model, choose_model, refuse_foreign_units
from ams.calibration.steps.judged_steps import judge_steps
from ams.calibration.steps.steps_of_output import NO_STEPS, StepsOfOutput
from ams.calibration.together.in_step_hidden import hidden_in_step
from ams.calibration.together.tilting_base import BaseTilt
from ams.calibration_result import AxisCalibration, Calibration, Replication
from ams.finding_kinds import FindingKind
from ams.findings import Finding, significant_texts
from ams.frames import AXES
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.known_of_run import ProvedChange, is_among
from ams.inputs.request import CalibrationRequest, refuse_unusable, select_rows
from ams.inputs.shared_errors import SharedError, notes_of
from ams.inputs.table_uncertainty import corrected
from ams.models.drifting import WithTime
from ams.models.model import Model
from ams.observations import Observations
from ams.parameter_words import not_determined
from ams.remembered import known
from ams.solve.components import components_of
from ams.solve.layout import Layout, layout_of
from ams.solve.linearised import linearise
from ams.solve.package import SolvedAxis, package_covariance
from ams.solve.residual_curvature import residual_curvature
from ams.solve.usable_replications import standing_rows

_LARGE_CONDITION = 1e4
"""Of the basis, its columns scaled: uncertainties are then so much larger than the noise that it is said."""
_LIKE_SEATS: Final[frozenset[FindingKind]] = frozenset({"axis-contradicted", "rate-undeclared", "wrong-dwell"})
"""What leaves residuals that follow the rates as well, and is told already."""
_OF_DESIGN = ("replication", "point", "pitch_rad", "roll_rad", "yaw_rad", "time_s", "temperature_degc")


def calibrate(observations: Observations, request: CalibrationRequest) -> Calibration:
    """Solve every sensor axis that the request names.

    Raises:
        ObservationsError: rows are missing, repeated or not finite, a column that the request needs is not there, or
            outputs are not in the unit that the model states.
        DesignError: the points or temperatures cannot determine the model.
        SolveError: the iteration of a nonlinear model did not converge.
    """
    refuse_unusable(observations, request)
    observations = _known(corrected(observations, request.table))
    layout = layout_of(observations)
    labels = tuple(request.axes_of(observations))
    base = base_model(labels[0], observations, request)
    refuse_foreign_units(labels, observations, request)
    kept, left_out = standing_rows(observations, layout, base)
    rows = observations
    if left_out:
        rows = select_rows(observations, kept)
        layout = layout_of(rows)
    weights = None if request.weights is None else request.weights[kept] / request.weights[kept].mean()
    choices = {label: choose_model(label, rows, layout, request) for label in labels}
    axes: dict[str, AxisCalibration] = {}
    parts: dict[str, SolvedAxis] = {}
    shared = {label: request.shared_errors.get(label, ()) for label in labels}
    groups = list(_solved(rows, layout, choices, request, weights))
    diagnoses, tilt = _diagnosed(rows, groups, choices, request)
    seats = _seats(rows, groups, diagnoses, request)
    diagnoses = diagnoses if seats is None else with_seats(diagnoses, seats, request.tested_axes or len(choices))
    diagnoses = with_rates_of_table(diagnoses, rows, shared[labels[0]])
    diagnosed = {
        label: of
        for (group, *_), found in zip(groups, diagnoses, strict=True)
        for label, of in zip(group, found, strict=True)
    }
    shown = () if tilt is None or not request.counts_tilts else tilt.counted
    shown += () if seats is None else seats.counted
    primary = {label: solved.primary[row] for group, solved, _ in groups for row, label in enumerate(group)}
    choices, between = errors_between_rates(rows, choices, primary)
    if shown or between:
        shared = {label: (*errors, *shown, *between.get(label, ())) for label, errors in shared.items()}
        groups = list(_solved(rows, layout, choices, replace(request, shared_errors=shared), weights))
    for group, solved, _ in groups:
        for row, label in enumerate(group):
            curved, found = request.residual_curvature, _with_errors_counted(diagnosed[label], solved, row)
            limits = notes_of(shared[label])
            axes[label] = _axis(label, solved, row, observations, choices[label], found, limits, curved=curved)
            names = choices[label].model.primary_names
            parts[label] = SolvedAxis(label, names, solved.components, row, shared[label])
    fitted = choices[labels[0]].model  # temperature is modelled alike of every axis
    warnings = (*left_out, *layout_warnings(layout, rows), *curvature_warnings(rows, fitted))
    package = package_covariance([parts[label] for label in labels]) if len(labels) > 1 else None
    solved_axes = with_unlike_axes({label: axes[label] for label in labels}, request.declared)
    handed = handedness(solved_axes, request.declared) if base.convention == "TP" else ()
    linear = groups[0][1].problem.form.basis[:, : len(base.primary_names)]
    hidden = hidden_in_step(rows, layout, linear) if base.convention == "TP" else ()
    remarks = (*handed, *bend_remarks(rows, fitted), *hidden)
    return Calibration(solved_axes, base.name, base.convention, warnings, remarks, package)


def _solved(
    rows: Observations,
    layout: Layout,
    choices: Mapping[str, ModelChoice],
    request: CalibrationRequest,
    weights: FloatArray | None,
) -> Iterator[SolvedGroup]:
    """Yield the groups of axes that are solved together."""
    shared = {label: request.shared_errors.get(label, ()) for label in choices}
    for group in _alike(choices, shared):
        models = [choices[label].model for label in group]
        outputs = np.stack([rows.outputs[label] for label in group], axis=1)
        sampled = [rows.sampled.get(label) for label in group]
        problem = linearise(models, rows, layout, outputs, weights, sampled)
        plots = plots_of(models[0], rows, layout)
        temperature = rows.temperature_degc if request.counts_temperature else None
        solved = solve_linearised(problem, layout, plots, request.table, shared[group[0]], temperature)
        yield group, solved, outputs


def _seats(
    rows: Observations,
    groups: Sequence[SolvedGroup],
    found: Sequence[Sequence[Diagnosis]],
    request: CalibrationRequest,
) -> AskewSeats | None:
    """Return how far the seats of a package of gyros are off; None where its signs are contradicted already."""
    every = (said for axes in found for axis in axes for said in axis.findings)
    if request.weights is not None or any(said.kind in _LIKE_SEATS and said.is_significant for said in every):
        return None
    labels = [label for group, *_ in groups for label in group]
    outputs = [(solved, row) for group, solved, _ in groups for row in range(len(group))]
    return judge_seats(outputs, rows, request.shared_errors.get(labels[0], ()))


def _diagnosed(
    rows: Observations,
    groups: Sequence[SolvedGroup],
    choices: Mapping[str, ModelChoice],
    request: CalibrationRequest,
) -> tuple[list[list[Diagnosis]], BaseTilt | None]:
    """Return the findings of every axis of every group, of the dwells at which nobody says that the table was off.

    Second: how the base tilted between the replications, where they show that it did and nothing else is told of it.
    """
    is_weighted = groups[0][1].problem.form.weights is not None
    off = is_among(rows, request.known_of_run.off)
    if off.any() and not is_weighted:
        rows = select_rows(rows, ~off)
        groups = list(_solved(rows, layout_of(rows), choices, request, None))
    mistaken: Mapping[str, Sequence[Finding]] = {}
    if not is_weighted:
        rows, mistaken = with_readings_put_right(rows, [solved for _, solved, _ in groups], tuple(choices), request)
    if mistaken:
        groups = list(_solved(rows, layout_of(rows), choices, request, None))
    family = request.tested_axes or len(choices)
    judged = [None if is_weighted else evidence_of(solved, rows) for _, solved, _ in groups]
    steps = _steps(judged, groups, family, request.known_of_run.changes)
    by_output = iter(
        limits_of_package(
            rows, groups, judged, steps, request.table, family,
            lambda less: list(_solved(less, layout_of(less), choices, request, None)),
        )
    )  # fmt: skip
    signs = contradicted_signs(rows, [solved for _, solved, _ in groups], tuple(choices), request)
    every = []
    for (group, solved, outputs), evidence in zip(groups, judged, strict=True):
        limits, changed = [next(by_output) for _ in group], [steps.get(label, NO_STEPS) for label in group]
        errors, said = request.shared_errors.get(group[0], ()), [_declared(label, choices, request) for label in group]
        alike = request.known_of_run.alike
        contradicted = [(*mistaken.get(label, ()), *signs.get(label, ())) for label in group]
        under = Circumstances(
            rows, outputs, request.table, errors, limits, family, (), changed, said,
            alike=alike, single_approach=request.single_approach, signs=contradicted,
        )  # fmt: skip
        every.append((solved, under, evidence))
    found = diagnose_together(every)
    tilt = tilt_of_base(every, found)
    return (found if tilt is None else with_tilt(found, tilt, family, is_counted=request.counts_tilts)), tilt


def _with_errors_counted(found: Diagnosis, solved: SolvedColumns, row: int) -> Diagnosis:
    """Return the findings of an axis with what the errors that were counted since leave of its sensitivity."""
    model, stated = solved.problem.models[row], (solved.primary[row], solved.primary_covariance[row])
    more = undetermined_by_errors(found.findings, model, *stated, solved.primary_dof[row])
    return replace(found, findings=(*found.findings, *more)) if more else found


def _declared(label: str, choices: Mapping[str, ModelChoice], request: CalibrationRequest) -> DeclaredDirection:
    return request.declared_of(label, choices[label].model.nominal_axis)


def _known(rows: Observations) -> Observations:
    """Return the rows with columns that what depends on the design alone knows without looking at them again."""
    columns = {name: getattr(rows, name) for name in _OF_DESIGN}
    seen: dict[str, Any] = {name: known(column) for name, column in columns.items() if column is not None}
    return replace(rows, **seen)


def _steps(
    judged: Sequence[Evidence | None], groups: Sequence[SolvedGroup], family: int, changes: Sequence[ProvedChange]
) -> Mapping[str, StepsOfOutput]:
    """Return what changed in mid-run by axis, of all axes together."""
    seen = [
        (label, judged_group, row)
        for judged_group, (group, *_) in zip(judged, groups, strict=True)
        if judged_group is not None
        for row, label in enumerate(group)
    ]
    found = judge_steps([(evidence, row) for _, evidence, row in seen], family, changes)
    return {label: steps for (label, *_), steps in zip(seen, found, strict=True)}


def _alike(choices: Mapping[str, ModelChoice], shared: Mapping[str, Sequence[SharedError]]) -> Iterator[Sequence[str]]:
    """Yield the labels of axes that are solved together; every other axis alone.

    They have the same basis, the same shared errors and nothing fixed.
    """
    groups: dict[Hashable, list[str]] = {}
    for label, choice in choices.items():
        model = choice.model
        together = model.basis_key is not None and not model.fixed
        key = (model.basis_key, model.parameter_names, tuple(shared[label])) if together else (label,)
        groups.setdefault(key, []).append(label)
    yield from groups.values()


def _axis(
    label: str,
    solved: SolvedColumns,
    row: int,
    observations: Observations,
    choice: ModelChoice,
    found: Diagnosis,
    limits: Mapping[str, object],
    *,
    curved: bool,
) -> AxisCalibration:
    """Return the calibration of one axis.

    ``limits``: what its users must know, among the notes. ``curved``: for H_E.
    """
    model, primary = choice.model, solved.primary[row]
    output_v = observations.outputs[label]
    is_exact = solved.problem.convergence is None and not model.fixed and observations.rows == solved.layout.rows
    fitted_v = solved.problem.form.fitted(primary) if is_exact else model.predict(primary, observations)
    return AxisCalibration(
        axis=label,
        model=model.name,
        nominal_axis=model.nominal_axis,
        parameters=solved.parameters.estimates(row),
        covariance=solved.parameters.covariance[row],
        primary_names=model.primary_names,
        primary=primary,
        primary_covariance=solved.primary_covariance[row],
        tp_primary_covariance=solved.tp_primary_covariance[row],
        primary_dof=solved.primary_dof[row],
        standard_error_v=float(solved.standard_error_v[row]),
        degrees_of_freedom=solved.degrees_of_freedom,
        sensitive_axis_v_per_g=_sensitive_axis(model.primary_names, primary),
        fitted_v=fitted_v,
        residuals_v=output_v - fitted_v,
        replication=_replication(solved, row, found),
        warnings=(*choice.warnings, *_axis_warnings(label, solved, row), *significant_texts(found.findings)),
        remarks=(
            *choice.remarks,
            *_axis_remarks(label, model),
            *undetected_dwell(label, found),
            *untold_transient(label, found),
            *untold_of_few(label, found),
            *untold_order(found.findings),
        ),
        variance_components=components_of(solved.components, row),
        centring=choice.centring,
        findings=found.findings,
        notes={
            **_notes(solved, row, choice),
            **_curvature(model, primary, observations, output_v - fitted_v, curved=curved),
            **limits,
        },
    )


def _curvature(
    model: Model, primary: FloatArray, observations: Observations, residuals_v: FloatArray, *, curved: bool
) -> Mapping[str, object]:
    if not curved:
        return {}

    return {"residual_curvature": residual_curvature(model, primary, observations, residuals_v)}


def _sensitive_axis(names: Sequence[str], primary: FloatArray) -> tuple[float, float, float]:
    """Return k, V/g per package axis; NaN for a component the model does not have."""
    known = dict(zip(names, primary.tolist(), strict=True))
    x, y, z = (known.get(f"k_{axis}_v_per_g", float("nan")) for axis in AXES)
    return x, y, z


def _replication(solved: SolvedColumns, row: int, found: Diagnosis) -> Replication | None:
    """Return the tests of the dwells that are believed; those of TP 8 are of all dwells."""
    tests, believed, i = replication_tests(found), found.solved, found.row
    if solved.replication is None or tests is None:
        return None
    lack_of_fit, drift = tests
    return Replication(
        replications=solved.layout.replications,
        points=solved.layout.points,
        lack_of_fit=lack_of_fit,
        drift=drift,
        tp=solved.replication.tp.of(row),
        precision_v=float(np.sqrt(believed.mixed.precision_variance[i])),
        lack_of_fit_v=float(np.sqrt(believed.mixed.lack_of_fit_variance[i])),
        per_replication=believed.per_replication(i),
    )


def _notes(solved: SolvedColumns, row: int, choice: ModelChoice) -> dict[str, object]:
    notes: dict[str, object] = {
        "condition_number": solved.problem.form.condition_number,
        "precision_variance_v2": float(solved.mixed.precision_variance[row]),
        "lack_of_fit_variance_v2": float(solved.mixed.lack_of_fit_variance[row]),
    }
    if solved.problem.convergence is not None:
        notes["convergence"] = solved.problem.convergence
    if choice.extension is not None:
        notes["extension"] = choice.extension
    return notes


def _axis_warnings(label: str, solved: SolvedColumns, row: int) -> Iterator[str]:
    reasons: dict[str, list[str]] = {}
    for name, reason in solved.parameters.undetermined[row].items():
        reasons.setdefault(reason, []).append(name)
    yield from (f"axis {label}: {not_determined(names)}: {reason}" for reason, names in reasons.items())
    yield from untold_noise(label, solved, row)
    condition = solved.problem.form.condition_number
    if condition > _LARGE_CONDITION:
        yield (
            f"axis {label}: the points tell the parameters apart poorly (condition number {condition:.3g}): "
            "uncertainties are correct but large; use a wider range of angles"
        )
    sums = solved.mixed.sums
    if sums is not None and sums.dof_precision <= 0:
        yield (
            f"axis {label}: no degrees of freedom are left for precision: lack of fit and drift are not "
            "tested; add points"
        )


def _axis_remarks(label: str, model: Model) -> tuple[str, ...]:
    if not isinstance(model, WithTime):
        return ()
    return (
        f"axis {label}: the offset holds at the reference time, time_s = {model.reference_s:.0f} s "
        "(the middle of the run); its drift is stated and never applied",
    )
