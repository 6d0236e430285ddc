"""The reported estimate and its covariance: precision, drift, lack of fit and the table's index errors together.

Rows are y = X (c + d_r) + G δ + l_point + e: d_r the drift of a replication, δ the common errors with unit variance
(index errors of the table, uncertainty of known coefficients), l a point's own lack of fit, e the precision. Any linear
estimate A y with A X = 1 has the covariance

    (spread of the replications) / n  +  s_lof² B Bᵀ  +  (A G)(A G)ᵀ,      B = A summed over the readings of a point,

whatever A is. The weights in A (generalised least squares) only make it small: they need not be exact, the covariance
stays right. The lack-of-fit variance is what the points' scatter asks for beyond precision *and* common errors, so the
table's index errors are never counted twice. Source: TP 8 for the idea, TP (50) for one
replication.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.replicated import ReplicatedSums, replicated_sums
from ams.solve.result import VarianceComponent
from ams.solve.scatter import own_scatter

FloatArray = NDArray[np.float64]

_SMALLEST_OWN_VARIANCE = 1e-6
"""Of the mean variance from common errors: keeps the weights finite where the rows have no noise of their own."""


@dataclass(frozen=True)
class MixedEstimate:
    """Estimate of the free primary parameters of one sensor axis."""

    estimate: FloatArray
    """(P,)"""
    components: tuple[VarianceComponent, ...]
    """Independent parts of its covariance."""
    estimator: FloatArray
    """(P, N)"""
    precision_variance: float
    """Volts²; NaN where it cannot be estimated."""
    lack_of_fit_variance: float
    """Volts², beyond the common errors."""
    sums: ReplicatedSums | None
    """Of the outputs alone (m = 1); None for one replication."""

    @property
    def covariance(self) -> FloatArray:
        return np.asarray(sum(component.covariance for component in self.components))


def estimate(
    form: LinearForm,
    alone: LinearForm,
    layout: Layout,
    output_v: FloatArray,
    common: Mapping[str, FloatArray],
    absorbed: int = 0,
) -> MixedEstimate:
    """Estimate from (N,) outputs.

    ``alone`` is the part of the model that every replication determines by itself: ``form``, or its leading columns
    where further parameters (temperature coefficients) are only seen across replications; ``absorbed`` counts the
    contrasts between replications that those use up. ``common`` maps a name to (N, q) columns of common errors.
    """
    columns = [block for block in common.values() if block.shape[1] > 0]
    joined = np.hstack(columns) if columns else np.zeros((layout.rows, 0))
    ordinary = form.solve(output_v)
    if layout.replications - 1 - absorbed < 1:
        return _unreplicated(form, layout, output_v, ordinary, common, joined)
    own_size = alone.basis.shape[1]
    shared = form.basis[:, own_size:] @ ordinary[own_size:]
    sums = replicated_sums(alone, layout, (output_v - shared)[:, None])
    precision, beyond, beyond_dof = _variances(alone, layout, sums, joined)
    own = _own_variance(form, layout, precision, beyond, output_v - form.basis @ ordinary)
    estimator = _generalised(form, own, joined)
    components = [_replication_component(estimator, alone, layout, sums, absorbed)]
    if beyond > 0.0:
        components.append(_lack_of_fit_component(estimator, layout, beyond, beyond_dof))
    return MixedEstimate(
        ordinary + estimator @ (output_v - form.basis @ ordinary),
        (*components, *_common_components(estimator, common)),
        estimator,
        precision,
        beyond,
        sums,
    )


def _unreplicated(
    form: LinearForm,
    layout: Layout,
    output_v: FloatArray,
    ordinary: FloatArray,
    common: Mapping[str, FloatArray],
    joined: FloatArray,
) -> MixedEstimate:
    """One replication (or none to spare): precision and lack of fit cannot be told apart; the residuals hold both."""
    weights = np.ones(layout.rows) if form.weights is None else form.weights
    scatter = own_scatter(form.basis, output_v, joined, weights)
    estimator = _generalised(form, scatter.variance / weights, joined)
    spread = scatter.variance * (estimator / weights) @ estimator.T
    component = VarianceComponent("residuals", spread, scatter.dof)
    return MixedEstimate(
        ordinary + estimator @ (output_v - form.basis @ ordinary),
        (component, *_common_components(estimator, common)),
        estimator,
        float("nan"),
        float("nan"),
        None,
    )


def _variances(
    alone: LinearForm, layout: Layout, sums: ReplicatedSums, joined: FloatArray
) -> tuple[float, float, float]:
    """Precision, lack of fit beyond the common errors (volts²), and the latter's degrees of freedom.

    Those are the degrees of freedom of the points' scatter: counting the subtraction of precision as well would leave
    fewer than one where the lack of fit is small, and widen intervals that hold without it (97 % for 95 %, simulated).
    """
    if sums.dof_precision <= 0 or sums.dof_lack_of_fit <= 0:
        return float("nan"), 0.0, float("nan")
    precision = float(sums.ss_precision[0]) / sums.dof_precision
    readings = layout.sum_by_point(np.ones(layout.rows) if alone.weights is None else alone.weights)
    typical = float(readings.mean())
    basis, common = (layout.mean_by_point(columns) for columns in (alone.basis, joined))
    scatter = own_scatter(basis, sums.point_means[:, 0], common, readings / typical)
    return precision, max(0.0, scatter.variance - precision / typical), scatter.dof


def _own_variance(
    form: LinearForm, layout: Layout, precision: float, beyond: float, residuals: FloatArray
) -> FloatArray:
    """(N,) variance of each row for the weights; a point's lack of fit counts once, however often it was read."""
    if np.isnan(precision):
        precision = float(residuals @ residuals) / max(residuals.size - form.basis.shape[1], 1)
    readings = layout.sum_by_point(np.ones(layout.rows))[layout.point]
    return precision / (1.0 if form.weights is None else form.weights) + readings * beyond


def _generalised(form: LinearForm, own: FloatArray, joined: FloatArray) -> FloatArray:
    """(P, N) generalised least squares for the row covariance diag(own) + joined·joinedᵀ, by Woodbury's identity."""
    if joined.shape[1] == 0:
        return form.estimator
    own = np.maximum(own, _SMALLEST_OWN_VARIANCE * float(np.mean(np.sum(joined**2, axis=1))))
    weighted_basis, weighted = form.basis / own[:, None], joined / own[:, None]
    inner = np.eye(joined.shape[1]) + joined.T @ weighted
    weighted_basis = weighted_basis - weighted @ np.linalg.solve(inner, joined.T @ weighted_basis)
    return np.asarray(np.linalg.solve(form.basis.T @ weighted_basis, weighted_basis.T))


def _replication_component(
    estimator: FloatArray, alone: LinearForm, layout: Layout, sums: ReplicatedSums, absorbed: int
) -> VarianceComponent:
    """Spread of what each replication contributes, point effects taken out; balanced: V_between / n."""
    n, departures = layout.replications, sums.departures[:, 0]
    departures = departures - alone.basis @ (estimator[: alone.basis.shape[1]] @ departures)
    contributions = layout.sum_by_replication((estimator * departures).T)
    dof = n - 1 - absorbed
    return VarianceComponent("replications", n / dof * contributions.T @ contributions, float(dof))


def _lack_of_fit_component(estimator: FloatArray, layout: Layout, variance: float, dof: float) -> VarianceComponent:
    by_point = layout.sum_by_point(estimator.T)
    return VarianceComponent("lack-of-fit", variance * by_point.T @ by_point, dof)


def _common_components(estimator: FloatArray, common: Mapping[str, FloatArray]) -> tuple[VarianceComponent, ...]:
    parts = ((name, estimator @ block) for name, block in common.items() if block.shape[1] > 0)
    return tuple(VarianceComponent(name, effect @ effect.T, float("inf")) for name, effect in parts)
