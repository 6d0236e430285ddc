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

from ams.arrays import FloatArray
from ams.calibration_result import FTest
from ams.errors import DesignError
from ams.frames import Attitude, specific_force
from ams.inputs.table_uncertainty import TableUncertainty, index_columns, shown_rad
from ams.models.accelerometer import PitchRoll
from ams.models.extended import CONFOUNDED, quadratic_basis
from ams.models.gyro import GyroWithTerms
from ams.observations import Observations
from ams.remembered import remembered
from ams.solve.layout import Layout, layout_of
from ams.solve.linear_form import orthogonal
from ams.solve.lone_errors import column_by_row
from ams.solve.replicated import DISTINGUISHED, about_their_mean, columns_per_replication, left_in_means, loose_root
from ams.statistics.intervals import f_test

_TERMS: Final = 9
_BISECTIONS: Final = 40
_TINY: Final = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Extension:
    """What the test found."""

    test: FTest
    q_v_per_g2: FloatArray
    """(5,) in the order of ``ams.models.extended.Q_NAMES``; of a gyro its terms, per (°/s)² and (°/s)³."""
    q_covariance: FloatArray
    """(5, 5), teeth of the table included; of a gyro that of its terms."""
    is_accepted: bool
    standard_error_before_v: float
    standard_error_after_v: float
    """Of all rows about the pooled fit, without and with Q."""
    remark: str = CONFOUNDED
    terms: str = "terms of second order"
    """In words, what was tested."""


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
    within_v2: float | None = None
    """Sum of squares of the readings about their means, where every point was read as often; None elsewhere."""


def judge_extension(
    observations: Observations,
    label: str,
    table: TableUncertainty | None = None,
    level: float = 0.95,
    *,
    layout: Layout | None = None,
) -> Extension:
    """Test the five terms of Q for one sensor axis of a pitch-roll calibration.

    Raises: DesignError where the points cannot tell nine parameters apart and leave an error.
    """
    means = _point_means(observations, label, table, layout or layout_of(observations))
    joined, is_determined = _joined(means.basis, means.quadratic)
    if not is_determined:
        raise DesignError(
            f"extended model of {label}: {joined.shape[0]} points do not determine its {_TERMS} parameters and an "
            "error; nothing was decided; add pitch and roll angles (five or more of each, past ±45°)"
        )
    if means.within_v2 is not None and means.common.shape[1] == 0:
        return _of_alike(joined, means, means.within_v2, level)
    test, q, q_covariance = _tested(joined, means, level)
    before, after = _standard_errors(observations, label, means)
    return Extension(test, q, q_covariance, test.is_significant, before, after)


def _of_alike(joined: FloatArray, means: _PointMeans, within_v2: float, level: float) -> Extension:
    """Return the same where every point was read as often and has no error in common with others: one projection."""
    q, inverse, unscaled = _terms_last(joined)
    n, points = float(means.readings[0]), joined.shape[0]
    along = q.T @ means.output_v
    left = means.output_v - q @ along
    terms, square, dof = along[4:], n * float(left @ left), points - _TERMS
    variance = max(square / dof, means.precision_v2, _TINY)
    explained, after = n * float(terms @ terms), within_v2 + square
    test = f_test(explained / variance / terms.size, terms.size, dof, level)
    before_v, after_v = (
        float(np.sqrt(squares / (n * points - parameters)))
        for squares, parameters in ((after + explained, 4), (after, _TERMS))
    )
    return Extension(test, inverse @ terms, variance / n * unscaled, test.is_significant, before_v, after_v)


@remembered(16)
def _terms_last(joined: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the orthonormal columns, what turns the last of them into terms, and the terms' covariance."""
    q, r = orthogonal(joined)
    inverse = np.asarray(np.linalg.inv(r[4:, 4:]), dtype=np.float64)
    return q, inverse, np.asarray(inverse @ inverse.T)


def judge_rate_terms(
    observations: Observations, label: str, bent: GyroWithTerms, level: float = 0.95, *, layout: Layout | None = None
) -> Extension:
    """Test the terms of a gyro's scale factor that its rates determine, on the means of the points.

    Rates that are measured differ from replication to replication, and so do the rows of a point. Raises: DesignError
    where the points leave no error.
    """
    layout = layout or layout_of(observations)
    rows, output = bent.basis(observations), np.asarray(observations.outputs[label], dtype=float)
    linear, terms = rows[:, :4], rows[:, 4:]
    scale = np.sqrt(np.mean(terms**2, axis=0))  # a cube of °/s beside volts would cost all digits
    readings = layout.sum_by_point(np.ones(layout.rows))
    level_output, precision, drift_left = without_drift(linear, output, layout, readings)

    def mean(of_rows: FloatArray) -> FloatArray:
        return np.asarray((layout.sum_by_point(of_rows).T / readings).T)

    common = np.sqrt(precision) * drift_left
    means = _PointMeans(mean(linear), mean(terms / scale), mean(level_output), readings, precision, common)
    joined = np.hstack([means.basis, means.quadratic])
    if joined.shape[0] <= joined.shape[1]:
        raise DesignError(
            f"nonlinearity of {label}: {joined.shape[0]} points do not determine {joined.shape[1]} parameters and an "
            "error; nothing was decided; add rates"
        )
    test, q, q_covariance = _tested(joined, means, level)
    before, after = _left_without_and_with(rows, output)
    return Extension(
        test,
        q / scale,
        q_covariance / np.outer(scale, scale),
        test.is_significant,
        before,
        after,
        "over few rates the square and an asymmetry of the scale factor are nearly one",
        "terms of the scale factor",
    )


def _tested(joined: FloatArray, means: _PointMeans, level: float) -> tuple[FTest, FloatArray, FloatArray]:
    """Return the test of the terms behind the four linear columns, with the terms and their covariance."""
    count, dof = joined.shape[1] - 4, joined.shape[0] - joined.shape[1]
    generalised = _generalised(joined, means)
    variance = _scatter_variance(generalised, means.precision_v2, dof)
    estimate, covariance, _ = generalised.at(variance)
    q, q_covariance = estimate[4:], covariance[4:, 4:]
    test = f_test(float(q @ np.linalg.solve(q_covariance, q)) / count, count, dof, level)
    return test, q, q_covariance


@remembered(16)
def _joined(basis: FloatArray, quadratic: FloatArray) -> tuple[FloatArray, bool]:
    """Return the columns of both, and whether they are determined and leave an error."""
    joined = np.hstack([basis, quadratic])
    rank = np.linalg.matrix_rank(joined, tol=1e-9 * np.linalg.norm(joined))
    return joined, joined.shape[0] > _TERMS and bool(rank == _TERMS)


@remembered(16)
def _bases_of_alike(pitch: FloatArray, roll: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the linear basis, its orthonormal columns, and the terms of second order."""
    basis = PitchRoll("x").basis(Attitude(pitch, roll))
    return basis, orthogonal(basis)[0], quadratic_basis(specific_force(pitch, roll))


def _point_means(observations: Observations, label: str, table: TableUncertainty | None, layout: Layout) -> _PointMeans:
    output = np.asarray(observations.outputs[label], dtype=float)
    blocks = blocks_of_angles(observations, layout)
    if blocks is not None:
        return _means_of_alike(blocks, output, table, layout)
    basis = PitchRoll("x").basis(observations)
    readings = layout.sum_by_point(np.ones(layout.rows))
    level_output, precision, drift_left = without_drift(basis, output, layout, readings)

    def mean(rows: FloatArray) -> FloatArray:
        return np.asarray((layout.sum_by_point(rows).T / readings).T)

    pitch, roll = angles_of_points(observations, layout)
    quadratic = mean(quadratic_basis(specific_force(observations.pitch_rad, observations.roll_rad)))
    common = np.hstack([_common(table, basis, output, pitch, roll), np.sqrt(precision) * drift_left])
    return _PointMeans(mean(basis), quadratic, mean(level_output), readings, precision, common)


def blocks_of_angles(observations: Observations, layout: Layout) -> tuple[FloatArray, FloatArray] | None:
    """Return the (K,) pitch and roll of the points; None unless replication stands below replication, all alike."""
    return _blocks_of_angles(layout, observations.pitch_rad, observations.roll_rad)


@remembered(16)
def _blocks_of_angles(
    layout: Layout, pitch_rad: FloatArray, roll_rad: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    pitch, roll = layout.block(pitch_rad), layout.block(roll_rad)
    return None if pitch is None or roll is None else (pitch, roll)


def _means_of_alike(
    blocks: tuple[FloatArray, FloatArray], output: FloatArray, table: TableUncertainty | None, layout: Layout
) -> _PointMeans:
    """Return the same as for any rows, in closed form: the replications' departures have no mean."""
    n, points = layout.replications, layout.points
    pitch, roll = blocks
    basis, q, quadratic = _bases_of_alike(pitch, roll)
    by_replication = output.reshape(n, points)
    mean = by_replication.sum(axis=0) / n
    about_mean = by_replication - mean
    left = about_mean - (about_mean @ q) @ q.T
    dof = (n - 1) * (points - q.shape[1])
    precision = float(np.vdot(left, left)) / dof if dof > 0 else 0.0
    readings = np.full(points, float(n))
    common = _common(table, basis, mean, pitch, roll)
    return _PointMeans(basis, quadratic, mean, readings, precision, common, float(np.vdot(about_mean, about_mean)))


def _common(
    table: TableUncertainty | None, basis: FloatArray, output: FloatArray, pitch: FloatArray, roll: FloatArray
) -> FloatArray:
    """(K, q) columns of the table's index errors, volts."""
    if table is None:
        return np.zeros((pitch.size, 0))
    primary = np.asarray(np.linalg.lstsq(basis, output, rcond=None)[0], dtype=np.float64)
    return index_columns(
        table,
        shown_rad(table, {"pitch": pitch, "roll": roll}),
        dict(PitchRoll("x").angle_jacobian(primary, Attitude(pitch, roll))),
    )


def angles_of_points(observations: Observations, layout: Layout) -> tuple[FloatArray, FloatArray]:
    """Return the (K,) pitch and roll of the points, radians."""
    first = np.unique(layout.point, return_index=True)[1]
    return observations.pitch_rad[first], observations.roll_rad[first]


def without_drift(
    basis: FloatArray, output: FloatArray, layout: Layout, readings: FloatArray
) -> tuple[FloatArray, float, FloatArray]:
    """Return the outputs brought to the mean parameters of all replications, and the variance of a reading.

    The departures of the replications' parameters are found with every point's own effect taken out, so that a
    replication that lacks points is not bent by their lack of fit. Third: (K, q) what is not known of them, in the
    means of the points, for readings of unit variance.
    """
    if layout.replications == 1:
        return output, 0.0, np.zeros((layout.points, 0))
    flat, scaled, directions, about_mean, drift_left = _replications_apart(basis, layout, readings)
    about = _about_points(output, layout, readings)
    departures = scaled @ (directions.T @ (flat.T @ about))
    left = about - flat @ departures
    dof = layout.rows - layout.points - directions.shape[1]
    precision = float(left @ left) / dof if dof > 0 else 0.0
    return output - about_mean @ departures, precision, drift_left


def _about_points(rows: FloatArray, layout: Layout, readings: FloatArray) -> FloatArray:
    """Return (N, …) rows about the means of their points."""
    return np.asarray(rows - ((layout.sum_by_point(rows).T / readings).T)[layout.point])


@remembered(6)
def _replications_apart(
    basis: FloatArray, layout: Layout, readings: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return what tells the replications from one another, whatever the outputs are.

    Columns (N, n P) of the replications about the means of the points; (n P, r) directions that they tell, over the
    eigenvalues and as they are; (N, n P) the columns about what all replications have in common; what is not known of
    the departures in the means of the points.
    """
    flat = _about_points(columns_per_replication(basis, layout).reshape(layout.rows, -1), layout, readings)
    values, vectors = np.linalg.eigh(flat.T @ flat)
    kept = values > DISTINGUISHED * values[-1]
    about_mean = about_their_mean(basis, layout, np.ones(layout.rows))
    drift_left = left_in_means(layout.mean_by_point(about_mean) @ loose_root(values, vectors))
    return flat, vectors[:, kept] / values[kept], vectors[:, kept], about_mean, drift_left


@dataclass(frozen=True)
class _Generalised:
    """Least squares for the covariance U = diag(variance/n_k) + G Gᵀ at any variance, by Woodbury's identity.

    Everything is done on the ordinary fit's residuals, which are small, so that nothing cancels. The products of the
    teeth are diagonal along their own directions, so that another variance is one more division.
    """

    ordinary: FloatArray
    """(p,)"""
    gram: FloatArray
    """(p + 1, p + 1) weighted products of the columns [parameters | residual]."""
    teeth: FloatArray
    """(t,) squares of the teeth along their directions."""
    along_teeth: FloatArray
    """(p + 1, t) products of the columns with these directions."""

    def at(self, variance: float) -> tuple[FloatArray, FloatArray, float]:
        """Estimate (p,), covariance (p, p) and χ² of the residuals."""
        p = self.ordinary.size
        taken = self.along_teeth / (variance + self.teeth)
        reduced = (self.gram - taken @ self.along_teeth.T) / variance
        covariance = np.asarray(np.linalg.inv(reduced[:p, :p]), dtype=float)
        change = covariance @ reduced[:p, p]
        chi_square = float(reduced[p, p] - reduced[p, :p] @ change)
        return self.ordinary + change, covariance, chi_square


def _generalised(joined: FloatArray, means: _PointMeans) -> _Generalised:
    q, r = orthogonal(joined)
    ordinary = np.asarray(np.linalg.solve(r, q.T @ means.output_v), dtype=float)
    columns = np.hstack([joined, (means.output_v - joined @ ordinary)[:, None], column_by_row(means.common)])
    gram, m = columns.T @ (means.readings[:, None] * columns), ordinary.size + 1
    squares, directions = np.linalg.eigh(gram[m:, m:])
    return _Generalised(ordinary, gram[:m, :m], np.maximum(squares, 0.0), gram[:m, m:] @ directions)


def _scatter_variance(generalised: _Generalised, precision_v2: float, dof: int) -> float:
    """Return the variance of a reading at which χ² is its degrees of freedom.

    It is not below the precision of the replications.
    """
    p = generalised.ordinary.size
    upper = float(generalised.gram[p, p]) / dof
    lower = max(precision_v2, 1e-12 * upper, _TINY)
    if generalised.teeth.size == 0:  # without teeth χ² is in inverse proportion to the variance
        return max(lower, upper)
    if upper <= lower or generalised.at(lower)[2] <= dof:
        return lower
    for _ in range(_BISECTIONS):
        middle = float(np.sqrt(lower * upper))
        lower, upper = (middle, upper) if generalised.at(middle)[2] > dof else (lower, middle)
    return float(np.sqrt(lower * upper))


def _standard_errors(observations: Observations, label: str, means: _PointMeans) -> tuple[float, float]:
    """S_E of TP (48) over all rows, without and with the terms of Q."""
    rows = observations.rows
    if means.within_v2 is not None:
        root = np.sqrt(means.readings[0])  # every point was read as often
        q, _ = orthogonal(_joined(means.basis, means.quadratic)[0])
        output = root * means.output_v
        along = q.T @ output
        left = output - q @ along
        after = means.within_v2 + float(left @ left)
        before = after + float(along[4:] @ along[4:])
        return float(np.sqrt(before / (rows - 4))), float(np.sqrt(after / (rows - _TERMS)))
    force = specific_force(observations.pitch_rad, observations.roll_rad)
    joined = np.concatenate([np.ones((force.shape[0], 1)), force, quadratic_basis(force)], axis=1)
    return _left_without_and_with(joined, np.asarray(observations.outputs[label], dtype=float))


def _left_without_and_with(joined: FloatArray, output: FloatArray) -> tuple[float, float]:
    """Return S_E of all rows about four linear columns, and about these and the terms behind them."""
    q, _ = np.linalg.qr(joined / np.linalg.norm(joined, axis=0))
    along = q.T @ output
    left = output - q @ along
    after = float(left @ left)
    before = after + float(along[4:] @ along[4:])
    return float(np.sqrt(before / (output.size - 4))), float(np.sqrt(after / (output.size - joined.shape[1])))
