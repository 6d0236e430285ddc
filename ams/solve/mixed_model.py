"""The reported estimate and its covariance: precision, drift, lack of fit and the table's index errors together.

Rows are y = X (c + d_r) + G δ + l_point + e: d_r the drift of a replication, δ the common errors with unit variance
(index errors of the table, uncertainty of known coefficients), l a point's own lack of fit, e the precision. Any linear
estimate A y with A X = 1 has the covariance

    (spread of the replications) / n  +  s_lof² B Bᵀ  +  (A G)(A G)ᵀ,      B = A summed over the readings of a point,

whatever A is. The weights in A (generalised least squares) only make it small: they need not be exact, the covariance
stays right. The lack-of-fit variance is what is left of its mean square once the common errors have had their share, so
the table's index errors are never counted twice. Source: MATH of the default forms beside TP 8; TP (50) for
one replication.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.replicated import ReplicatedSums, replicated_sums
from ams.solve.result import VarianceComponent

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
    sums = replicated_sums(alone, layout, np.column_stack([output_v - shared, joined]))
    precision, beyond, beyond_dof = _variances(sums)
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
        _first(sums),
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
    root = np.ones(layout.rows) if form.weights is None else np.sqrt(form.weights)
    residuals = root * (output_v - form.basis @ ordinary)
    dof = layout.rows - form.basis.shape[1]
    left = joined - form.basis @ (form.estimator @ joined)
    explained = float(np.sum((root[:, None] * left) ** 2))
    square = float(residuals @ residuals)
    variance = max(0.0, square - explained) / dof if dof > 0 else float("nan")
    weighting = max(variance, 0.05 * square / dof) if dof > 0 else 1.0
    estimator = _generalised(form, np.full(layout.rows, weighting) / root**2, joined)
    spread = variance * (estimator / root) @ (estimator / root).T
    component = VarianceComponent("residuals", spread, float(dof))
    return MixedEstimate(
        ordinary + estimator @ (output_v - form.basis @ ordinary),
        (component, *_common_components(estimator, common)),
        estimator,
        float("nan"),
        float("nan"),
        None,
    )


def _variances(sums: ReplicatedSums) -> tuple[float, float, float]:
    """Precision, lack of fit beyond the common errors (volts²), and the latter's degrees of freedom.

    Those are the degrees of freedom of its mean square: counting the subtraction as well would leave fewer than one
    where the lack of fit is small, and widen intervals that hold without it (97 % instead of 95.4 %, simulated).
    """
    if sums.dof_precision <= 0 or sums.dof_lack_of_fit <= 0:
        return float("nan"), 0.0, float("nan")
    precision = float(sums.ss_precision[0]) / sums.dof_precision
    lack_of_fit = float(sums.ss_lack_of_fit[0]) / sums.dof_lack_of_fit
    explained = float(sums.ss_lack_of_fit[1:].sum()) / sums.dof_lack_of_fit
    beyond = max(0.0, (lack_of_fit - precision - explained) / sums.multiplicity)
    return precision, beyond, float(sums.dof_lack_of_fit)


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


def _first(sums: ReplicatedSums) -> ReplicatedSums:
    """The outputs' own sums, without those of the common errors' columns."""
    return ReplicatedSums(
        sums.separate[..., :1],
        sums.contrasts[..., :1],
        sums.contrast_covariance,
        sums.departures[:, :1],
        sums.ss_precision[:1],
        sums.dof_precision,
        sums.ss_lack_of_fit[:1],
        sums.dof_lack_of_fit,
        sums.multiplicity,
    )
