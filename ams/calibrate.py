"""Calibration of one sensor package: the whole story on one page.

Observations and a request go in, a :class:`~ams.solve.result.Calibration` comes out. For every sensor axis:

1. the model, linear in its primary parameters (offset and vector of sensitivities) or made so at its solution;
2. ordinary least squares over all rows: the pooled forms of TP (43) to (50), kept as ``tp``;
3. what is common to all rows of an index or a coefficient (table, temperature) as columns of U_Y;
4. the mixed-model estimate, whose covariance holds precision, drift, lack of fit and the common errors, each once;
5. the derived parameters, their uncertainties, the tests, and in words what the data cannot say.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ams.errors import DesignError, SolveError
from ams.frames import AXES
from ams.model_choice import ModelChoice, base_model, choose_model
from ams.models.model import Model
from ams.models.thermal import contrasts_taken, estimated_terms
from ams.observations import Observations
from ams.request import CalibrationRequest, refuse_unusable, select_rows
from ams.solve.derived import DerivedParameters, derive
from ams.solve.gauss_newton import Convergence, gauss_newton
from ams.solve.layout import Layout, layout_of
from ams.solve.linear_form import LinearForm, factor
from ams.solve.mixed_model import MixedEstimate, estimate
from ams.solve.result import AxisCalibration, Calibration, Replication, VarianceComponent
from ams.solve.standing import standing_rows
from ams.uncertainty.intervals import effective_dof
from ams.uncertainty.replication import analyse, quantity
from ams.uncertainty.table import TableUncertainty, index_columns

FloatArray = NDArray[np.float64]

_LARGE_CONDITION = 1e4
_LONGEST_LIST = 8
NOT_PER_REPLICATION = ("offset_tc_v_per_degc", "sensitivity_tc_per_degc", "reference_temperature_degc")


def calibrate(observations: Observations, request: CalibrationRequest) -> Calibration:
    """Solve every sensor axis that the request names.

    Raises:
        ObservationsError: rows are missing, repeated or not finite, or a column that the request needs is not there.
        DesignError: the points or temperatures cannot determine the model.
        SolveError: the iteration of a nonlinear model did not converge.
    """
    refuse_unusable(observations, request)
    layout = layout_of(observations)
    labels = tuple(request.axes_of(observations))
    base = base_model(labels[0], observations, request)
    kept, left_out = standing_rows(observations, layout, base)
    rows = observations
    if left_out:
        rows = select_rows(observations, kept)
        layout = layout_of(rows)
    weights = None if request.weights is None else request.weights[kept] / request.weights[kept].mean()
    forms: dict[Hashable, LinearForm] = {}
    axes = {}
    for label in labels:
        choice = choose_model(label, rows, request)
        problem = _linearise(choice.model, rows, rows.outputs_v[label], weights, forms)
        solved = _solve_axis(label, problem, rows, layout, request.table, observations)
        axes[label] = _with_choice(solved, choice)
    return Calibration(axes, base.name, base.convention, (*left_out, *_layout_warnings(layout)))


@dataclass(frozen=True)
class _Linearised:
    """One axis as y = basis·(free primary parameters), exact or at the solution."""

    model: Model
    free: NDArray[np.intp]
    """Places of the free primary parameters."""
    form: LinearForm
    alone: LinearForm
    """The part that a replication determines by itself."""
    output_v: FloatArray
    convergence: Convergence | None

    def complete(self, free_values: FloatArray) -> FloatArray:
        """(…, P) primary parameters from the free ones: the fixed ones put in their places."""
        return _complete(self.model, self.free, free_values)


def _complete(model: Model, free: NDArray[np.intp], values: FloatArray) -> FloatArray:
    primary = np.empty((*values.shape[:-1], len(model.primary_names)))
    primary[..., free] = values
    for name, (value, _) in model.fixed.items():
        primary[..., model.primary_names.index(name)] = value
    return primary


def _linearise(
    model: Model,
    rows: Observations,
    output_v: FloatArray,
    weights: FloatArray | None,
    forms: dict[Hashable, LinearForm],
) -> _Linearised:
    free = np.array([i for i, name in enumerate(model.primary_names) if name not in model.fixed])
    if rows.rows == free.size:
        raise DesignError(
            f"{rows.source}: {rows.rows} observations determine {free.size} parameters and leave nothing to judge the "
            f"error by: allowed {free.size + 1} or more; nothing was solved; add points or replications"
        )
    names = [model.primary_names[i] for i in free]
    if model.basis_key is None:
        return _linearise_at_solution(model, free, names, rows, output_v, weights)
    if model.basis_key not in forms:
        forms[model.basis_key] = factor(model.basis(rows), names, rows, weights)
    form = forms[model.basis_key]
    if model.fixed:
        output_v = output_v - model.predict(_complete(model, free, np.zeros(free.size)), rows)
    return _Linearised(model, free, form, form, output_v, None)


def _linearise_at_solution(
    model: Model,
    free: NDArray[np.intp],
    names: list[str],
    rows: Observations,
    output_v: FloatArray,
    weights: FloatArray | None,
) -> _Linearised:
    """Gauss-Newton, TP (43) to (50), from the model's own start; the rest of the story is told at its answer."""
    result = gauss_newton(
        lambda values: model.predict(_complete(model, free, values), rows),
        lambda values: model.jacobian(_complete(model, free, values), rows)[:, free],
        model.start(rows, output_v)[free],
        output_v,
        names,
        None if weights is None else 1.0 / weights,
    )
    if result.convergence.reason == "iterations":
        raise SolveError(
            f"Gauss-Newton: {model.name} with {', '.join(names)}: no convergence in {result.convergence.iterations} "
            f"iterations: last step {result.convergence.last_step_in_standard_uncertainties:.2g} "
            f"standard uncertainties, "
            "allowed 1e-6; nothing is reported; look at the residuals for a wrong row"
        )
    basis = model.jacobian(_complete(model, free, result.estimate), rows)[:, free]
    size = free.size - estimated_terms(model)
    form = factor(basis, names, rows, weights)
    alone = form if size == free.size else factor(basis[:, :size], names[:size], rows, weights)
    return _Linearised(model, free, form, alone, result.residuals + basis @ result.estimate, result.convergence)


def _solve_axis(
    label: str,
    problem: _Linearised,
    rows: Observations,
    layout: Layout,
    table: TableUncertainty | None,
    observations: Observations,
) -> AxisCalibration:
    model, form = problem.model, problem.form
    ordinary = problem.complete(form.solve(problem.output_v))
    common = _common_errors(problem, ordinary, rows, table)
    absorbed = contrasts_taken(model, rows.temperature_degc, layout.replication)
    mixed = estimate(form, problem.alone, layout, problem.output_v, common, absorbed)
    primary = problem.complete(mixed.estimate)
    components = _all_primary(problem, mixed, common)
    dof = layout.rows - problem.free.size
    standard_error_v = _standard_error_v(problem, dof)
    tp_covariance = _placed(problem, standard_error_v**2 * form.unscaled_covariance)
    derived = derive(model, primary, components, tp_covariance)
    fitted_v = model.predict(primary, observations)
    return AxisCalibration(
        axis=label,
        model=model.name,
        nominal_axis=model.nominal_axis,
        parameters=derived.estimates,
        covariance=derived.covariance,
        primary_names=model.primary_names,
        primary=primary,
        primary_covariance=np.asarray(sum(component.covariance for component in components)),
        tp_primary_covariance=tp_covariance,
        primary_dof=effective_dof(np.eye(primary.size), components),
        standard_error_v=standard_error_v,
        degrees_of_freedom=dof,
        sensitive_axis_v_per_g=_sensitive_axis(model, primary),
        fitted_v=fitted_v,
        residuals_v=observations.outputs_v[label] - fitted_v,
        replication=_replication(problem, layout, mixed, derived),
        warnings=_axis_warnings(label, problem, mixed, derived),
        variance_components=components,
        notes=_notes(problem, mixed),
    )


def _standard_error_v(problem: _Linearised, dof: int) -> float:
    """S_E of TP (48), of the pooled fit; of a row of mean weight where rows are weighted."""
    form = problem.form
    residuals = problem.output_v - form.basis @ form.solve(problem.output_v)
    weighted = residuals if form.weights is None else form.weights * residuals
    return float(np.sqrt(weighted @ residuals / dof))


def _with_choice(solved: AxisCalibration, choice: ModelChoice) -> AxisCalibration:
    """The F-test on the extended model belongs to the result, accepted or not."""
    if choice.extension is None and not choice.warnings:
        return solved
    return replace(
        solved,
        warnings=(*choice.warnings, *solved.warnings),
        notes={**solved.notes, "extension": choice.extension},
    )


def _common_errors(
    problem: _Linearised, primary: FloatArray, rows: Observations, table: TableUncertainty | None
) -> Mapping[str, FloatArray]:
    """(N, q) columns of errors that many rows share, one standard uncertainty each, volts."""
    common = {}
    if table is not None:
        slopes = problem.model.angle_jacobian(primary, rows)
        angles = {"pitch": rows.pitch_rad, "roll": rows.roll_rad}
        angles |= {} if rows.yaw_rad is None else {"yaw": rows.yaw_rad}
        common["table"] = index_columns(table, angles, slopes)
    uncertain = [(name, u) for name, (_, u) in problem.model.fixed.items() if u > 0.0]
    if uncertain:
        jacobian = problem.model.jacobian(primary, rows)
        common["temperature"] = np.stack(
            [u * jacobian[:, problem.model.primary_names.index(name)] for name, u in uncertain], axis=1
        )
    return common


def _all_primary(
    problem: _Linearised, mixed: MixedEstimate, common: Mapping[str, FloatArray]
) -> tuple[VarianceComponent, ...]:
    """Components over all primary parameters, fixed ones included with what their uncertainty does to the free ones."""
    placed = []
    for component in mixed.components:
        covariance = _placed(problem, component.covariance)
        if component.name == "temperature":
            covariance = _with_fixed(problem, mixed.estimator @ common["temperature"])
        placed.append(replace(component, covariance=covariance))
    return tuple(placed)


def _placed(problem: _Linearised, free_covariance: FloatArray) -> FloatArray:
    size = len(problem.model.primary_names)
    if problem.free.size == size:
        return free_covariance
    covariance = np.zeros((size, size))
    covariance[np.ix_(problem.free, problem.free)] = free_covariance
    return covariance


def _with_fixed(problem: _Linearised, effect: FloatArray) -> FloatArray:
    """A coefficient too high by u leaves the free parameters too low by the estimator's response to it."""
    names = problem.model.primary_names
    uncertain = [(names.index(name), u) for name, (_, u) in problem.model.fixed.items() if u > 0.0]
    errors = np.zeros((len(names), len(uncertain)))
    errors[problem.free] = -effect
    for column, (place, u) in enumerate(uncertain):
        errors[place, column] = u
    return errors @ errors.T


def _sensitive_axis(model: Model, primary: FloatArray) -> tuple[float, float, float]:
    """k, V/g per package axis; NaN for a component the model does not have."""
    known = dict(zip(model.primary_names, map(float, primary), strict=True))
    x, y, z = (known.get(f"k_{axis}_v_per_g", float("nan")) for axis in AXES)
    return x, y, z


def _replication(
    problem: _Linearised, layout: Layout, mixed: MixedEstimate, derived: DerivedParameters
) -> Replication | None:
    if mixed.sums is None:
        return None
    model, own = problem.model, problem.alone.basis.shape[1]
    directions = {
        quantity(name): direction[problem.free][:own]
        for name, direction in zip(model.parameter_names, derived.directions, strict=True)
        if name not in NOT_PER_REPLICATION
    }
    separate = np.broadcast_to(mixed.estimate, (layout.replications, problem.free.size)).copy()
    separate[:, :own] = mixed.sums.separate[..., 0]
    values = model.parameters(problem.complete(separate))
    per_replication = {
        number: {
            name: float(value)
            for name, value in zip(model.parameter_names, row, strict=True)
            if name not in NOT_PER_REPLICATION
        }
        for number, row in zip(layout.replication_labels, values, strict=True)
    }
    shared = problem.form.basis[:, own:] @ mixed.estimate[own:]
    return analyse(problem.alone, layout, problem.output_v - shared, mixed, directions, per_replication)


def _notes(problem: _Linearised, mixed: MixedEstimate) -> Mapping[str, object]:
    notes: dict[str, object] = {
        "condition_number": problem.form.condition_number,
        "precision_variance_v2": mixed.precision_variance,
        "lack_of_fit_variance_v2": mixed.lack_of_fit_variance,
    }
    if problem.convergence is not None:
        notes["convergence"] = problem.convergence
    return notes


def _axis_warnings(
    label: str, problem: _Linearised, mixed: MixedEstimate, derived: DerivedParameters
) -> tuple[str, ...]:
    reasons: dict[str, list[str]] = {}
    for name, reason in derived.undetermined.items():
        reasons.setdefault(reason, []).append(name)
    warnings = [f"axis {label}: {' and '.join(names)} null: {reason}" for reason, names in reasons.items()]
    condition = problem.form.condition_number
    if condition > _LARGE_CONDITION:
        warnings.append(
            f"axis {label}: the points tell the parameters apart poorly (condition number {condition:.3g}): "
            "uncertainties are correct but large; use a wider range of angles"
        )
    if mixed.sums is not None and mixed.sums.dof_precision <= 0:
        warnings.append(
            f"axis {label}: no degrees of freedom are left for precision: lack of fit and drift are not "
            f"tested; add points"
        )
    return tuple(warnings)


def _layout_warnings(layout: Layout) -> tuple[str, ...]:
    warnings = []
    if layout.replications == 1:
        warnings.append(
            "one replication only: precision, lack of fit and drift cannot be told apart; measure two or more"
        )
    if layout.replications in (2, 3):
        warnings.append(
            f"{layout.replications} replications only: intervals rest on {layout.replications - 1} degrees of freedom "
            "and are wide; four or more make them much narrower"
        )
    for label, points in layout.missing().items():
        some = ", ".join(map(str, points[:_LONGEST_LIST])) + (" …" if len(points) > _LONGEST_LIST else "")
        warnings.append(f"replication {label} lacks {len(points)} of {layout.points} points ({some}): used as it is")
    return tuple(warnings)
