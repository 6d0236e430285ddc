"""Many sensor axes measured at the same points, solved at once: packages of a batch, or simulated campaigns.

One factorised basis serves every output; estimates, covariances and tests come as arrays with one row for every axis.
:func:`ams.calibration.calibrate.calibrate` tells its story from the same arrays, so there is one way to a number, not
two.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ams.analysis.replication import ReplicationColumns, analyse, quantity
from ams.arrays import FloatArray
from ams.inputs.shared_errors import SharedError, shared_columns
from ams.inputs.table_uncertainty import TableUncertainty, columns_of_members, corrected, index_members, shown_rad
from ams.models.drifting import REFERENCE_NAME
from ams.models.extended import TRACELESS_NAME
from ams.models.model import Model, Stimulus
from ams.models.rate_terms import LOW_ORDER_NAMES
from ams.observations import Observations, Sampled
from ams.solve.components import Causes, ComponentColumns
from ams.solve.derived import DerivedParameters, derive
from ams.solve.expected import Belief, expected_estimates
from ams.solve.layout import Layout, layout_of
from ams.solve.linearised import Linearised, is_shared, linearise, shared_regressors
from ams.solve.mixed_model import CommonErrors, MixedEstimates, estimate
from ams.solve.recorded_temperature import is_unmodelled, recorded_temperature
from ams.solve.resolution import expected_resolution, resolution
from ams.solve.shifts_within import shifts_within
from ams.solve.whole_plots import WholePlots, visits_of, whole_plots

NOT_PER_REPLICATION = frozenset({"reference_temperature_degc", REFERENCE_NAME})
"""Beside what is only seen across replications."""


@dataclass(frozen=True)
class SolvedColumns:
    """m sensor axes, solved; arrays have one row for every axis."""

    problem: Linearised
    layout: Layout
    mixed: MixedEstimates
    primary: FloatArray
    """(m, P) primary estimates, fixed ones included."""
    components: tuple[ComponentColumns, ...]
    """They add up to ``primary_covariance``."""
    primary_covariance: FloatArray
    """(m, P, P) the reported (mixed-model) covariance."""
    tp_primary_covariance: FloatArray
    """(m, P, P) the pooled covariance, TP (50)."""
    primary_dof: FloatArray
    """(m, P) effective degrees of freedom."""
    standard_error_v: FloatArray
    """(m,) S_E of TP (48)."""
    degrees_of_freedom: int
    parameters: DerivedParameters
    """What the files name, in edge units, with 95 % intervals."""
    replication: ReplicationColumns | None
    """None where nothing was replicated."""
    common: Sequence[CommonErrors] = ()
    """Errors that many rows share, one entry an axis; empty where there are none."""

    def at_points(self, blocks: Mapping[str, FloatArray]) -> FloatArray:
        """Return the (K, q) columns of common errors at the points, side by side."""
        if not blocks:
            return np.zeros((self.layout.points, 0))
        joined = np.hstack(list(blocks.values()))
        return joined if self.problem.form.repeats > 1 else self.layout.mean_by_point(joined)

    def per_replication(self, row: int) -> Mapping[int, Mapping[str, float]]:
        """Return the parameters (edge units) of one axis by replication label, each replication alone."""
        mixed, model = self.mixed, self.problem.models[row]
        assert mixed.sums is not None
        alone_size = self.problem.alone.basis.shape[1]
        separate = np.repeat(mixed.estimate[row][None], self.layout.replications, axis=0)
        separate[:, :alone_size] = mixed.sums.separate[..., row]
        kept = _of_each_replication(model.parameter_names)
        names = [model.parameter_names[i] for i in kept]
        values = model.parameters(self.problem.complete(separate))[:, kept].tolist()
        rows = zip(self.layout.replication_labels, values, strict=True)
        return {label: dict(zip(names, numbers, strict=True)) for label, numbers in rows}


def solve_columns(
    points: Observations,
    outputs: FloatArray,
    models: Sequence[Model],
    weights: FloatArray | None = None,
    table: TableUncertainty | None = None,
    shared: Sequence[SharedError] = (),
    temperature_degc: FloatArray | None = None,
    sampled: Sequence[Sampled | None] = (),
) -> SolvedColumns:
    """Solve (N, m) outputs, volts, of m sensor axes that were all measured at the rows of ``points``.

    ``models`` names one model for every column; they may differ in the nominal axis only. ``points.outputs`` is not
    looked at. ``shared`` are errors that all rows of every axis share. What the recorded ``temperature_degc``,
    (N,) or (N, m), may have done is part of the uncertainty where no model has it. ``sampled``: of every output, what
    the samples show that its rows are means of; empty where they are single readings.

    Raises:
        ObservationsError: a (replication, point) pair stands twice.
        DesignError: the points cannot determine the model.
    """
    points = corrected(points, table)
    layout = layout_of(points)
    problem = linearise(models, points, layout, outputs, weights, sampled)
    plots = plots_of(problem.model, points, layout)
    return solve_linearised(problem, layout, plots, table, shared, temperature_degc)


def plots_of(model: Model, rows: Observations, layout: Layout) -> WholePlots:
    """Return what the covariance of a model counts: replications, or visits of a temperature plateau."""
    return whole_plots(layout, visits_of(rows), shared_regressors(model, rows))


def solve_linearised(
    problem: Linearised,
    layout: Layout,
    plots: WholePlots,
    table: TableUncertainty | None,
    shared: Sequence[SharedError] = (),
    temperature_degc: FloatArray | None = None,
) -> SolvedColumns:
    """Estimate, covariance, derived parameters and tests; ``shared`` are errors that all rows of every axis share.

    ``temperature_degc`` (N,) or (N, m): recorded, and what it may have done is to count where no model has it.
    """
    common = _common_errors(problem, table, shared)
    within, beside, is_line = _parted(problem, common, shared)
    mixed = estimate(problem.form, problem.alone, layout, problem.outputs, within, plots, is_weighted=not is_line)
    if temperature_degc is not None and is_unmodelled(problem.model, temperature_degc):
        part = recorded_temperature(problem.form, mixed.estimator, problem.outputs, mixed.ordinary, temperature_degc)
        mixed = replace(mixed, components=(*mixed.components, part))
    steps = resolution(mixed, problem.form, layout, problem.outputs, problem.sampled)
    if steps is not None:
        mixed = replace(mixed, components=(*mixed.components, steps))
    within_run = shifts_within(problem, layout, mixed, shared, is_measured=True)
    mixed = replace(mixed, components=(*mixed.components, *within_run)) if within_run else mixed
    return _solved_columns(problem, layout, mixed, common, beside, shared)


def expect_linearised(
    problem: Linearised,
    layout: Layout,
    plots: WholePlots,
    beliefs: Sequence[Belief],
    table: TableUncertainty | None,
    shared: Sequence[SharedError] = (),
) -> SolvedColumns:
    """Return what :func:`solve_linearised` will tell on the average, from outputs without errors and one belief each.

    Nothing is tested, since nothing was observed.
    """
    common = _common_errors(problem, table, shared)
    within, beside, is_line = _parted(problem, common, shared)
    alone_names = [problem.model.primary_names[index] for index in problem.free[: problem.alone.basis.shape[1]]]
    mixed = expected_estimates(
        problem.form,
        problem.alone,
        layout,
        problem.outputs,
        alone_names,
        beliefs,
        within,
        plots,
        is_weighted=not is_line,
    )
    steps = expected_resolution(mixed, layout, problem.alone, problem.outputs, beliefs, alone_names)
    within_run = shifts_within(problem, layout, mixed, shared, is_measured=False)
    mixed = replace(mixed, components=(*mixed.components, *(() if steps is None else (steps,)), *within_run))
    return _solved_columns(problem, layout, mixed, common, beside, shared)


def _parted(
    problem: Linearised, common: Sequence[CommonErrors], shared: Sequence[SharedError]
) -> tuple[Sequence[CommonErrors], Sequence[CommonErrors], bool]:
    """Return the common errors that the estimate weighs by, those beside it, and whether it is a straight line's.

    A straight line is drawn as it is: weights by what its levels are wrong by would move it. Those errors are added to
    its covariance; where they make rows across a field scatter, they are also taken out of the lack of fit. So are
    errors that nobody declared and the data showed: a test moves no estimate.
    """
    is_line = problem.block.reference_level is not None
    if is_line and not any(error.effect == "field" for error in shared):
        return [], common, is_line
    shown = {error.name for error in shared if not error.is_weighed}
    if not shown:
        return common, [], is_line
    weighed = [{name: block for name, block in blocks.items() if name not in shown} for blocks in common]
    beside = [{name: block for name, block in blocks.items() if name in shown} for blocks in common]
    return (weighed if any(weighed) else []), beside, is_line


def _solved_columns(
    problem: Linearised,
    layout: Layout,
    mixed: MixedEstimates,
    common: Sequence[CommonErrors],
    beside: Sequence[CommonErrors],
    shared: Sequence[SharedError],
) -> SolvedColumns:
    """Return the whole story of estimates; common errors ``beside`` them are added to their covariances."""
    if beside:
        mixed = mixed.with_errors(problem.form, beside)
    primary = problem.complete(mixed.estimate)
    components = _as_estimated(_all_primary(problem, mixed, common), shared)
    dof = layout.rows - problem.free.size
    pooled = (mixed.ss_ordinary / dof)[:, None, None] * problem.form.unscaled_covariance
    tp_covariance = problem.placed(pooled)
    parameters = derive(problem.models, primary, components, tp_covariance)
    return SolvedColumns(
        problem=problem,
        layout=layout,
        mixed=mixed,
        primary=primary,
        components=components,
        primary_covariance=parameters.primary_covariance,
        tp_primary_covariance=tp_covariance,
        primary_dof=parameters.primary_dof,
        standard_error_v=np.sqrt(mixed.ss_ordinary / dof),
        degrees_of_freedom=dof,
        parameters=parameters,
        replication=_replication(problem, layout, mixed, parameters),
        common=common,
    )


def _common_errors(
    problem: Linearised, table: TableUncertainty | None, shared: Sequence[SharedError]
) -> list[CommonErrors]:
    """Return for every axis columns of errors that many rows share, one standard uncertainty each, volts."""
    uncertain = _uncertain(problem.model)
    rows = problem.block
    members = {} if table is None else index_members(table, shown_rad(table, _angles_rad(rows)))
    if not members and not uncertain and not shared:
        return []
    ordinary = problem.complete(problem.form.solve(problem.outputs).T)
    common: list[CommonErrors] = []
    for model, primary in zip(problem.models, ordinary, strict=True):
        blocks: dict[str, FloatArray] = {}
        if members:
            blocks["table"] = columns_of_members(members, model.angle_jacobian(primary, rows))
        if uncertain:
            slopes = model.jacobian(primary, rows)
            blocks["temperature"] = np.stack([u * slopes[:, index] for index, u in uncertain], axis=1)
        blocks |= shared_columns(shared, model, primary, rows)
        common.append({name: block for name, block in blocks.items() if block.shape[1] > 0})
    return common


def _angles_rad(rows: Stimulus) -> Mapping[str, FloatArray]:
    angles = {"pitch": rows.pitch_rad, "roll": rows.roll_rad}
    return angles if rows.yaw_rad is None else angles | {"yaw": rows.yaw_rad}


def _uncertain(model: Model) -> list[tuple[int, float]]:
    """Return the places of the fixed primary parameters that have an uncertainty, with it."""
    return [(model.primary_names.index(name), u) for name, (_, u) in model.fixed.items() if u > 0.0]


def _all_primary(
    problem: Linearised, mixed: MixedEstimates, common: Sequence[CommonErrors]
) -> tuple[ComponentColumns, ...]:
    """Return the components over all primary parameters.

    Fixed ones are included with what their uncertainty does to the free ones.
    """
    if problem.free.size == len(problem.model.primary_names):
        return mixed.components
    placed = []
    for part in mixed.components:
        covariance = problem.placed(part.covariance)
        if part.name == "temperature":
            pairs = zip(mixed.estimator, common, strict=True)
            covariance = np.stack(
                [
                    _with_fixed(
                        problem,
                        problem.form.repeats * estimator[:, : problem.block.pitch_rad.size] @ blocks["temperature"],
                    )
                    for estimator, blocks in pairs
                ]
            )
            placed.append(replace(part, covariance=covariance, causes=None))
        else:
            placed.append(replace(part, covariance=covariance, causes=_causes_of_all(problem, part.causes)))
    return tuple(placed)


def _as_estimated(
    components: Sequence[ComponentColumns], shared: Sequence[SharedError]
) -> tuple[ComponentColumns, ...]:
    """Return the components with the degrees of freedom of shared errors that were estimated and not certified."""
    dof = {error.name: error.degrees_of_freedom for error in shared if np.isfinite(error.degrees_of_freedom)}
    return tuple(
        replace(part, dof=np.full_like(part.dof, dof[part.name])) if part.name in dof else part for part in components
    )


def _causes_of_all(problem: Linearised, causes: Causes | None) -> Causes | None:
    """Return the causes over all primary parameters: fixed ones have none."""
    size = len(problem.model.primary_names)
    if causes is None or problem.free.size == size:
        return causes
    effects = np.zeros((*causes.effects.shape[:-2], size, causes.effects.shape[-1]))
    effects[..., problem.free, :] = causes.effects
    return replace(causes, effects=effects)


def _with_fixed(problem: Linearised, effect: FloatArray) -> FloatArray:
    """Return the covariance that fixed coefficients add.

    A coefficient too high by u leaves the free parameters too low by the estimator's response to it.
    """
    uncertain = _uncertain(problem.model)
    errors = np.zeros((len(problem.model.primary_names), len(uncertain)))
    errors[problem.free] = -effect
    for column, (index, u) in enumerate(uncertain):
        errors[index, column] = u
    return errors @ errors.T


def _replication(
    problem: Linearised, layout: Layout, mixed: MixedEstimates, parameters: DerivedParameters
) -> ReplicationColumns | None:
    if mixed.sums is None:
        return None
    alone_size = problem.alone.basis.shape[1]
    tested, names = _held_against_drift(parameters.names)
    directions = parameters.directions[:, tested][..., problem.free][..., :alone_size]
    largest_v = np.maximum(problem.outputs.max(axis=0), -problem.outputs.min(axis=0))
    return analyse(problem.alone, layout, largest_v, mixed.sums, names, directions)


@cache
def _held_against_drift(names: tuple[str, ...]) -> tuple[list[int], list[str]]:
    """Return the places of the parameters that are tested for a drift, and what they are called."""
    # Terms of low order are the sensor's, and their own test tells of them.
    kept = [i for i in _of_each_replication(names) if names[i] not in (*LOW_ORDER_NAMES, TRACELESS_NAME)]
    return kept, [quantity(names[i]) for i in kept]


@cache
def _of_each_replication(names: tuple[str, ...]) -> list[int]:
    """Return the places of the parameters that every replication determines by itself."""
    return [i for i, name in enumerate(names) if name not in NOT_PER_REPLICATION and not is_shared(name)]
