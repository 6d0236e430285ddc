"""What a sensor may have shifted by while it was calibrated: part of the covariance, under the limit that is declared.

A limit ±L on what an offset shifts by holds between any two dwells as it holds until the next calibration. Two courses
carry the limit, each whole, as a rectangle of standard deviation L/√3: a step at an unknown moment of the run, and a
transient that every replication begins with alike. A step that is as likely between any two dwells has the covariance
L²/3 · min(u, u′) at u and u′ of the run: equal independent steps at evenly spaced moments have it. With columns C of
one standard deviation each, an estimate A y is wrong by A C a, a of unit variance beforehand.

What the residuals say of a is believed as far as they say anything. Their noise v counts with the lack of fit, since a
course that repeats stands at the same points. With H = Cᵀ M C / v, M what the model leaves, the second moment of a is
P + m mᵀ, P = (1 + H)⁻¹ and m = P Cᵀ M y / v. Nothing is taken off the estimate, so m stands in it whole. A limit below
the noise stays what it is; of one far above, such as a data sheet's for a year, what the readings leave open is
counted. Before there are readings the mean of m mᵀ without any shift, P H P, stands for it.

A sensitivity that shifts has the same courses, times the output.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.inputs.shared_errors import COURSES, SharedError
from ams.remembered import remembered
from ams.solve.components import ComponentColumns
from ams.solve.dwell_order import rows_in_time, settling_of_rows
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.linearised import Linearised
from ams.solve.mixed_model import MixedEstimates

_MOMENTS: Final = 16
"""Of a run, at which a step may come: no whole number to a replication, so that some are in the middle of one."""


def shifts_within(
    problem: Linearised, layout: Layout, mixed: MixedEstimates, shared: Sequence[SharedError], *, is_measured: bool
) -> tuple[ComponentColumns, ...]:
    """Return a component for each limit in ``shared`` on what changes while rows are taken.

    Not ``is_measured``, the outputs are those of a sensor without errors, and what they will say is a mean.
    """
    errors = [error for error in shared if error.effect in COURSES and error.standard_uncertainty > 0.0]
    if not errors:
        return ()
    courses = _courses(rows_in_time(problem.time_s, layout.rows), layout)
    return tuple(_component(error, courses, problem, layout, mixed, is_measured=is_measured) for error in errors)


@remembered(8)
def _courses(order: IntArray, layout: Layout) -> FloatArray:
    """Return (N, q) courses that together have the standard deviation of the limit where it is reached."""
    fraction = np.empty(order.size)
    fraction[order] = (np.arange(order.size) + 0.5) / order.size
    moments = (np.arange(_MOMENTS) + 0.5) / _MOMENTS
    steps = (fraction[:, None] > moments) / np.sqrt(_MOMENTS)
    return np.column_stack([steps, settling_of_rows(order, layout)])


def _component(
    error: SharedError,
    courses: FloatArray,
    problem: Linearised,
    layout: Layout,
    mixed: MixedEstimates,
    *,
    is_measured: bool,
) -> ComponentColumns:
    form, size = problem.form, problem.outputs.shape[1]
    noise = _noise_variance(form, layout, mixed)
    fitted = form.fitted(mixed.ordinary)
    covariance = np.zeros((size, *[form.basis.shape[1]] * 2))
    for index in range(size):
        columns = error.standard_uncertainty * courses
        if error.effect == "gain-course":
            columns = columns * fitted[:, index, None]
        left = problem.outputs[:, index] - fitted[:, index] if is_measured else None
        known = _second_moment(form, columns, left, noise[index])
        estimator = mixed.estimator if mixed.estimator.ndim == 2 else mixed.estimator[index]
        effects = estimator @ columns
        covariance[index] = effects @ known @ effects.T
    return ComponentColumns(error.name, covariance, np.full(size, np.inf))


def _second_moment(form: LinearForm, columns: FloatArray, left: FloatArray | None, noise: float) -> FloatArray:
    """Return the (q, q) second moment of the sizes of (N, q) columns, by what the model leaves of the outputs."""
    identity = np.eye(columns.shape[1])
    if not noise > 0.0:
        return identity
    weighted = columns if form.weights is None else form.weights[:, None] * columns
    information = weighted.T @ (columns - form.basis @ (form.estimator @ columns)) / noise
    spread = np.linalg.inv(identity + 0.5 * (information + information.T))
    if left is None:
        return np.asarray(spread + spread @ information @ spread)
    mean = spread @ (weighted.T @ left) / noise
    return np.asarray(spread + np.outer(mean, mean))


def _noise_variance(form: LinearForm, layout: Layout, mixed: MixedEstimates) -> FloatArray:
    """Return (m,) the variance of a row, or of a row's share in a point where points have more of their own."""
    over_all = mixed.ss_ordinary / max(layout.rows - form.basis.shape[1], 1)
    sums = mixed.sums
    if sums is not None and sums.dof_lack_of_fit > 0:
        return np.asarray(np.maximum(sums.ss_lack_of_fit / sums.dof_lack_of_fit, over_all))
    of_points = mixed.precision_variance + layout.rows / layout.points * mixed.lack_of_fit_variance
    return np.asarray(np.where(np.isnan(of_points), over_all, np.maximum(of_points, over_all)))
