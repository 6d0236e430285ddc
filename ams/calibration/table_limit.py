"""The declared limit of a table's index errors against what all solved axes of one package saw of them."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations_with_replacement

import numpy as np

from ams.analysis.diagnostics.table_curves import SeenPoints, TableLimit, beyond_limit, indices_of
from ams.analysis.diagnostics.tested_terms import linear_base
from ams.arrays import FloatArray
from ams.calibration.columns import SolvedColumns
from ams.frames import Attitude, specific_force
from ams.inputs.table_uncertainty import TableUncertainty, shown_rad
from ams.observations import Observations
from ams.solve.extension import angles_of_points

_LINEAR = 4
"""Offset and three sensitivities, the first columns of a basis."""
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
    pitch, roll = angles_of_points(rows, groups[0][0].layout)
    outputs = [seen for solved, indices in groups for seen in _seen(solved, indices, pitch, roll)]
    shown = shown_rad(table, {"pitch": pitch, "roll": roll})
    found = {axis: indices_of(table, axis, angle) for axis, angle in shown.items()}
    of_axes = {axis: limit for axis, limit in found.items() if limit is not None}
    kept = [index for index, seen in enumerate(outputs) if seen is not None]
    if not kept or not of_axes:
        return nothing
    of_package = beyond_limit([seen for seen in outputs if seen is not None], of_axes)
    return [of_package.of_output(kept.index(index) if index in kept else None) for index in range(len(outputs))]


def slopes_at_points(
    solved: SolvedColumns, index: int, pitch: FloatArray, roll: FloatArray
) -> Mapping[str, FloatArray]:
    """Return the (K,) slopes of an output by the axes of the table, volts per radian."""
    base = linear_base(solved.problem.models[index])
    assert base is not None
    primary = solved.primary[index][: len(base.primary_names)]
    return base.angle_jacobian(primary, Attitude(pitch, roll))


def _of_higher_order(pitch: FloatArray, roll: FloatArray) -> FloatArray:
    """Return the (K, 25) products of three and of four components of the specific force."""
    components = specific_force(pitch, roll).T
    return np.stack(
        [np.prod(chosen, axis=0) for order in (3, 4) for chosen in combinations_with_replacement(components, order)],
        axis=1,
    )


def _seen(
    solved: SolvedColumns, indices: Sequence[int], pitch: FloatArray, roll: FloatArray
) -> Iterator[SeenPoints | None]:
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
        variance = float(solved.mixed.precision_variance[index])
        if linear_base(problem.models[index]) is None or not variance > (_ROUNDING * largest[index]) ** 2:
            yield None
            continue
        coefficients = solved.mixed.ordinary[_LINEAR : basis.shape[1], index]
        yield SeenPoints(
            linear=np.hstack([basis[:, :_LINEAR], sums.drift_left]),
            terms=basis[:, _LINEAR:],
            higher=_of_higher_order(pitch, roll),
            mean=sums.point_effects[:, index] + basis[:, _LINEAR:] @ coefficients,
            weight=np.sqrt(readings / variance),
            slopes=slopes_at_points(solved, index, pitch, roll),
            precision_dof=float(sums.dof_precision),
        )
