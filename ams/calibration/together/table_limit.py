"""The declared limit of a table's index errors against what all solved axes of one package saw of them."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations_with_replacement

import numpy as np

from ams.analysis.diagnostics.sensed_force import Accelerometer, attitude_of_points, sensed_force
from ams.analysis.diagnostics.table_curves import Indices, SeenPoints, TableLimit, beyond_limit, indices_of
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray
from ams.calibration.solving.columns import SolvedColumns
from ams.inputs.shared_errors import OF_THE_AXES
from ams.inputs.table_uncertainty import TableUncertainty, shown_rad
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.models.extended import centred_basis, centring_over
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.observations import Observations

_ROUNDING = 32.0 * float(np.finfo(float).eps)
"""Of the largest output: a scatter below it is of the arithmetic."""


def judge_table(
    groups: Sequence[tuple[SolvedColumns, Sequence[int]]], rows: Observations, table: TableUncertainty | None
) -> Sequence[TableLimit | None]:
    """Return what the named outputs of each group, all seen at the same ``rows``, say against the declared limit.

    To each of them, group by group. None where no limit is declared, or no output can say anything: nothing replicated,
    or a model without attitude.
    """
    nothing = [None for _, indices in groups for _ in indices]
    if table is None or not groups:
        return nothing
    outputs = [seen for solved, indices in groups for seen in _seen(solved, indices, rows)]
    kept = [index for index, seen in enumerate(outputs) if seen is not None]
    of_axes = _indices(table, groups[0][0], rows, [seen for seen in outputs if seen is not None])
    if not of_axes:
        return nothing
    of_package = beyond_limit([seen for seen in outputs if seen is not None], of_axes)
    return [of_package.of_output(kept.index(index) if index in kept else None) for index in range(len(outputs))]


def _indices(
    table: TableUncertainty, solved: SolvedColumns, rows: Observations, outputs: Sequence[SeenPoints]
) -> Mapping[str, Indices]:
    """Return the indices of each axis of the table that any of the outputs sees: not the roll of what it leaves."""
    base = accelerometer_base(solved.problem.model)
    if base is None or not outputs:
        return {}
    stood = attitude_of_points(base, rows, solved.layout)
    angles = {"pitch": stood.pitch_rad, "roll": stood.roll_rad}
    angles |= {} if stood.yaw_rad is None else {"yaw": stood.yaw_rad}
    reached = {name: angle for name, angle in angles.items() if any(seen.slopes[name].any() for seen in outputs)}
    found = {name: indices_of(table, name, angle) for name, angle in shown_rad(table, reached).items()}
    return {name: indices for name, indices in found.items() if indices is not None}


def of_higher_order(force: FloatArray) -> FloatArray:
    """Return the (K, 25) products of three and of four components of the (K, 3) specific force."""
    return np.stack(
        [np.prod(chosen, axis=0) for order in (3, 4) for chosen in combinations_with_replacement(force.T, order)],
        axis=1,
    )


def _terms(base: Accelerometer, force: FloatArray, basis: FloatArray) -> FloatArray:
    """Return the (K, t) terms of low order: those of the model; of CR's, which has none, those that are determined."""
    if not isinstance(base, PitchYawRoll):
        return basis[:, LINEAR_COLUMNS:]
    centring = centring_over(force, force.shape[0], base.nominal_axis)
    return basis[:, LINEAR_COLUMNS:] if centring is None else centred_basis(force, base.nominal_axis, centring)


def _seen(solved: SolvedColumns, indices: Sequence[int], rows: Observations) -> Iterator[SeenPoints | None]:
    """Yield the points of each output; None where it can say nothing."""
    sums, problem, layout = solved.mixed.sums, solved.problem, solved.layout
    if sums is None or problem.form.weights is not None:
        yield from [None] * len(indices)
        return
    alone = problem.alone
    basis = alone.block if alone.repeats > 1 else layout.mean_by_point(alone.basis)
    readings = layout.sum_by_point(np.ones(layout.rows))
    largest = np.abs(problem.outputs).max(axis=0)
    for index in indices:
        variance, base = float(solved.mixed.precision_variance[index]), accelerometer_base(problem.models[index])
        if base is None or not variance > (_ROUNDING * largest[index]) ** 2:
            yield None
            continue
        stood = attitude_of_points(base, rows, layout)
        force = sensed_force(base, stood)
        coefficients = solved.mixed.ordinary[LINEAR_COLUMNS : basis.shape[1], index]
        slopes = base.angle_jacobian(solved.primary[index][: len(base.primary_names)], stood)
        shared = solved.common[index] if solved.common else {}
        of_axes = {str(name): shared[name] for name in OF_THE_AXES if name in shared}
        yield SeenPoints(
            linear=np.hstack([basis[:, :LINEAR_COLUMNS], sums.drift_left]),
            terms=_terms(base, force, basis),
            higher=of_higher_order(force),
            mean=sums.point_effects[:, index] + basis[:, LINEAR_COLUMNS:] @ coefficients,
            weight=np.sqrt(readings / variance),
            slopes=slopes,
            of_axes=solved.at_points(of_axes),
            precision_dof=float(sums.dof_precision),
        )
