"""Does the package need the extended model? An F-test against the error that contains the table's teeth.

The replications' own offsets and sensitivities are taken out first (drift is no lack of fit), then the mean of every
point is looked at: ȳ = X c + Z q + G δ + e, with one δ per index of the table, shared by all points at that index, and
e of variance a/n_k. a is what the points' scatter asks for, never less than the precision that the replications show.
F compares qᵀ Cov(q)⁻¹ q / 5, by generalised least squares, with that error. Without G a table of ±1 arc second would be
taken for a soft mount in most runs.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ams.calibration_result import FTest
from ams.errors import DesignError
from ams.frames import Attitude, specific_force
from ams.inputs.table_uncertainty import TableUncertainty, index_columns, shown_rad
from ams.models.accelerometer import PitchRoll
from ams.models.extended import CONFOUNDED, quadratic_basis
from ams.observations import Observations
from ams.solve.layout import Layout, layout_of
from ams.statistics.intervals import f_test

FloatArray = NDArray[np.float64]

_TERMS: Final = 9
_BISECTIONS: Final = 40


@dataclass(frozen=True)
class Extension:
    """What the test found."""

    test: FTest
    q_v_per_g2: FloatArray
    """(5,) in the order of ``ams.models.extended.Q_NAMES``."""
    q_covariance: FloatArray
    """(5, 5), teeth of the table included."""
    is_accepted: bool
    standard_error_before_v: float
    standard_error_after_v: float
    """Of all rows about the pooled fit, without and with Q."""
    remark: str = CONFOUNDED


@dataclass(frozen=True)
class _PointMeans:
    """One row a point."""

    basis: FloatArray
    """(K, 4)"""
    quadratic: FloatArray
    """(K, 5)"""
    output_v: FloatArray
    readings: FloatArray
    """(K,) how many readings the mean is of."""
    precision_v2: float
    """Variance of one reading from the scatter between replications; 0 where there is one replication."""
    common: FloatArray
    """(K, q) columns of the table's teeth, volts."""


def judge_extension(
    observations: Observations, label: str, table: TableUncertainty | None = None, level: float = 0.95
) -> Extension:
    """Test the five terms of Q for one sensor axis of a pitch-roll calibration.

    Raises: DesignError where the points cannot tell nine parameters apart and leave an error.
    """
    means = _point_means(observations, label, table)
    joined = np.hstack([means.basis, means.quadratic])
    if joined.shape[0] <= _TERMS or np.linalg.matrix_rank(joined, tol=1e-9 * np.linalg.norm(joined)) < _TERMS:
        raise DesignError(
            f"extended model of {label}: {joined.shape[0]} points do not determine its {_TERMS} parameters and an "
            "error; nothing was decided; add pitch and roll angles (five or more of each, past ±45°)"
        )
    dof = joined.shape[0] - _TERMS
    generalised = _generalised(joined, means)
    variance = _scatter_variance(generalised, means.precision_v2, dof)
    estimate, covariance, _ = generalised.at(variance)
    q, q_covariance = estimate[4:], covariance[4:, 4:]
    test = f_test(float(q @ np.linalg.solve(q_covariance, q)) / 5.0, 5, dof, level)
    rows = _all_rows(observations, label)
    return Extension(
        test, q, q_covariance, test.is_significant, _standard_error(rows, 4), _standard_error(rows, _TERMS)
    )


def _point_means(observations: Observations, label: str, table: TableUncertainty | None) -> _PointMeans:
    layout = layout_of(observations)
    basis = PitchRoll("x").basis(observations)
    output = np.asarray(observations.outputs_v[label], dtype=float)
    readings = layout.sum_by_point(np.ones(layout.rows))
    level_output, precision = without_drift(basis, output, layout, readings)

    def mean(rows: FloatArray) -> FloatArray:
        return np.asarray((layout.sum_by_point(rows).T / readings).T)

    pitch, roll = angles_of_points(observations, layout)
    point_basis = mean(basis)
    slopes = _slopes(np.linalg.lstsq(basis, output, rcond=None)[0], pitch, roll)
    common = (
        np.zeros((layout.points, 0))
        if table is None
        else index_columns(table, shown_rad(table, {"pitch": pitch, "roll": roll}), slopes)
    )
    quadratic = mean(quadratic_basis(specific_force(observations.pitch_rad, observations.roll_rad)))
    return _PointMeans(point_basis, quadratic, mean(level_output), readings, precision, common)


def angles_of_points(observations: Observations, layout: Layout) -> tuple[FloatArray, FloatArray]:
    """(K,) pitch and roll of the points, radians."""
    first = np.unique(layout.point, return_index=True)[1]
    return observations.pitch_rad[first], observations.roll_rad[first]


def _slopes(primary: FloatArray, pitch: FloatArray, roll: FloatArray) -> dict[str, FloatArray]:
    return dict(PitchRoll("x").angle_jacobian(primary, Attitude(pitch, roll)))


def without_drift(
    basis: FloatArray, output: FloatArray, layout: Layout, readings: FloatArray
) -> tuple[FloatArray, float]:
    """Outputs brought to the mean parameters of all replications, and the variance of a reading.

    The departures of the replications' parameters are found with every point's own effect taken out, so that a
    replication that lacks points is not bent by their lack of fit.
    """
    n, size = layout.replications, basis.shape[1]
    if n == 1:
        return output, 0.0
    blocks = np.zeros((layout.rows, n, size))
    blocks[np.arange(layout.rows), layout.replication] = basis
    flat = blocks.reshape(layout.rows, n * size)

    def centred(rows: FloatArray) -> FloatArray:
        return np.asarray(rows - ((layout.sum_by_point(rows).T / readings).T)[layout.point])

    values, vectors = np.linalg.eigh(centred(flat).T @ centred(flat))
    kept = values > 1e-9 * values[-1]
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    departures = inverse @ (centred(flat).T @ centred(output))
    left = centred(output) - centred(flat) @ departures
    dof = layout.rows - layout.points - int(kept.sum())
    by_replication = departures.reshape(n, size)
    shift = (by_replication - by_replication.mean(axis=0))[layout.replication]
    precision = float(left @ left) / dof if dof > 0 else 0.0
    return output - np.sum(basis * shift, axis=1), precision


@dataclass(frozen=True)
class _Generalised:
    """Least squares for the covariance U = diag(variance/n_k) + G Gᵀ at any variance, by Woodbury's identity.

    Everything is done on the ordinary fit's residuals, which are small, so that nothing cancels.
    """

    ordinary: FloatArray
    """(9,)"""
    gram: FloatArray
    """Weighted products of the columns [parameters | residual | teeth]."""

    def at(self, variance: float) -> tuple[FloatArray, FloatArray, float]:
        """Estimate (9,), covariance (9, 9) and χ² of the residuals."""
        m = _TERMS + 1
        gram = self.gram / variance
        inner = np.eye(gram.shape[0] - m) + gram[m:, m:]
        reduced = gram[:m, :m] - gram[:m, m:] @ np.linalg.solve(inner, gram[m:, :m])
        covariance = np.asarray(np.linalg.inv(reduced[:_TERMS, :_TERMS]), dtype=float)
        change = covariance @ reduced[:_TERMS, _TERMS]
        chi_square = float(reduced[_TERMS, _TERMS] - reduced[_TERMS, :_TERMS] @ change)
        return self.ordinary + change, covariance, chi_square


def _generalised(joined: FloatArray, means: _PointMeans) -> _Generalised:
    ordinary = np.asarray(np.linalg.lstsq(joined, means.output_v, rcond=None)[0], dtype=float)
    columns = np.hstack([joined, (means.output_v - joined @ ordinary)[:, None], means.common])
    return _Generalised(ordinary, columns.T @ (means.readings[:, None] * columns))


def _scatter_variance(generalised: _Generalised, precision_v2: float, dof: int) -> float:
    """The variance of a reading at which χ² is its degrees of freedom, not below the precision of the replications."""
    upper = float(generalised.gram[_TERMS, _TERMS]) / dof
    lower = max(precision_v2, 1e-12 * upper, float(np.finfo(float).tiny))
    if upper <= lower or generalised.at(lower)[2] <= dof:
        return lower
    for _ in range(_BISECTIONS):
        middle = float(np.sqrt(lower * upper))
        lower, upper = (middle, upper) if generalised.at(middle)[2] > dof else (lower, middle)
    return float(np.sqrt(lower * upper))


def _all_rows(observations: Observations, label: str) -> tuple[FloatArray, FloatArray]:
    force = specific_force(observations.pitch_rad, observations.roll_rad)
    joined = np.concatenate([np.ones((force.shape[0], 1)), force, quadratic_basis(force)], axis=1)
    return joined, np.asarray(observations.outputs_v[label], dtype=float)


def _standard_error(rows: tuple[FloatArray, FloatArray], size: int) -> float:
    """S_E of TP (48) with the first ``size`` columns."""
    joined, output = rows
    left = output - joined[:, :size] @ np.linalg.lstsq(joined[:, :size], output, rcond=None)[0]
    return float(np.sqrt(left @ left / (output.size - size)))
