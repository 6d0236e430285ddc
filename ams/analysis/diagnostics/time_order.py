"""Whether dwells know of the dwells before them, and whether time and attitude can be told apart at all.

Autocorrelation: r = eᵀSe / eᵀe with S ½ for dwells that follow one another within a replication. e = M x with the
residual maker M, so that r has the moments of a ratio of quadratic forms (Durbin and Watson 1950):
E r = tr(MS)/ν, E r² = (2 tr(MSMS) + (tr MS)²)/(ν(ν + 2)). As a correlation it lies between −1 and 1: about its mean it
is a beta variable of that variance (Durbin and Watson 1951), as the correlation of 1/var r + 1 pairs is.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.arrays import FloatArray, IntArray
from ams.models.drifting import SECONDS_PER_HOUR
from ams.models.model import Model
from ams.observations import Observations
from ams.remembered import remembered
from ams.solve.dwell_order import rows_by_laying, rows_in_time, settling_of_rows, turns_in_replication
from ams.solve.layout import Layout
from ams.solve.linear_form import orthogonal
from ams.statistics.distributions import f_tail

LEAST_DOF = 12
"""Degrees of freedom that a test between dwells needs."""
LARGEST_CORRELATION = 0.8
"""Of time with what the linear sensor takes from the attitude; the same as of time with temperature."""
_LARGEST: Final = 1.0 - 1e-12
"""Of a correlation."""
_FEW_RUNS: Final = 2
"""Of attitudes in a replication: nothing that comes back with each of them is asked for in so few."""
_FADING: Final = (0.03, 0.1, 0.25)
"""Of the run: time constants of a sensor that settles after it was switched on."""
_FREE_OF_FADING: Final = 2
"""Numbers: how fast, and how far."""
_WAVES: Final = (4, 6)
"""Half waves over the run that a walk is made of, more or less of it."""


class InOrder(Protocol):
    """Points as they follow one another, measured (:class:`~ams.analysis.diagnostics.evidence.Evidence`) or planned."""

    @property
    def rows(self) -> Observations: ...
    @property
    def layout(self) -> Layout: ...
    @property
    def models(self) -> Sequence[Model]: ...
    @property
    def basis(self) -> FloatArray:
        """(K, P) at the points."""
        ...


@dataclass(frozen=True)
class Autocorrelation:
    """Of m outputs."""

    r: FloatArray
    """(m,) correlation of a dwell with the next."""
    p_value: FloatArray
    """(m,)"""

    def of(self, output: int) -> tuple[float, float]:
        """Return correlation and p-value of one output."""
        return float(self.r[output]), float(self.p_value[output])


@dataclass(frozen=True)
class Slope:
    """How m outputs follow a column, each with its own error."""

    coefficient: FloatArray
    standard_uncertainty: FloatArray
    p_value: FloatArray


def row_time(points: InOrder) -> FloatArray | None:
    """Return the (N,) times of the rows; without times their order, evenly spaced.

    None where there are neither: rows that are not in the order of their replications were sorted by something else.
    """
    if points.rows.time_s is not None:
        return points.rows.time_s
    replication = points.layout.replication
    changes = int(np.count_nonzero(np.diff(replication)))
    return np.arange(float(replication.size)) if changes == points.layout.replications - 1 else None


def even_course(order: IntArray) -> FloatArray:
    """Return the (N,) course of a drift that goes evenly from 0 to 1 with the order of time."""
    passed = np.empty(order.size)
    passed[order] = np.linspace(0.0, 1.0, order.size)
    return passed


def courses_of_drift(order: IntArray) -> Iterator[tuple[FloatArray, int]]:
    """Yield (N, c) courses that a drift has over the whole run, and how many numbers each has to choose."""
    passed = even_course(order)
    yield np.stack([passed], axis=1), 1
    yield np.stack([passed, passed**2], axis=1), 2
    yield from ((np.exp(-passed / part)[:, None], _FREE_OF_FADING) for part in _FADING)
    yield from ((np.cos(np.pi * np.outer(passed, np.arange(1, most + 1))), most) for most in _WAVES)


def parts_of_replications(evidence: Evidence, parts: int) -> IntArray:
    """Return for each row the number of its part: every replication is so many of them, one after the other."""
    return _parts(evidence.time_order, evidence.layout.replication, evidence.layout.replications, parts)


@remembered(16)
def _parts(order: IntArray, replication: IntArray, replications: int, parts: int) -> IntArray:
    turn, sizes = turns_in_replication(order, replication, replications)
    return np.asarray(replication * parts + turn * parts // sizes[replication])


def settling(evidence: Evidence) -> FloatArray:
    """Return the (N,) column of a transient at the start of every replication: one at its first dwell, fading."""
    # Tested and never a term of the estimate: that would widen every clean offset by a tenth.
    return settling_of_rows(evidence.time_order, evidence.layout)


@remembered(16)
def means_of_points(layout: Layout, column: FloatArray) -> FloatArray:
    """Return the means at every point of what stands in rows, kept with the design."""
    return layout.mean_by_point(column)


def neighbours(evidence: Evidence) -> tuple[IntArray, IntArray, IntArray]:
    """Return replication, point and next point of dwells that follow one another within a replication."""
    return _neighbours(evidence.time_order, evidence.layout)


@remembered(16)
def _neighbours(order: IntArray, layout: Layout) -> tuple[IntArray, IntArray, IntArray]:
    replication, point = layout.replication[order], layout.point[order]
    together = replication[1:] == replication[:-1]
    return replication[1:][together], point[:-1][together], point[1:][together]


def autocorrelation(grid: GridResiduals, pairs: tuple[IntArray, IntArray, IntArray]) -> Autocorrelation:
    """Return the correlation of successive dwells, two-sided."""
    replication, here, following = pairs
    size, dof = grid.squares.size, grid.dof
    if dof < LEAST_DOF or replication.size == 0:
        return Autocorrelation(np.full(size, np.nan), np.full(size, np.nan))
    start = replication * grid.points
    first, second = (grid.residuals.take(start + point, axis=0) for point in (here, following))
    with np.errstate(invalid="ignore", divide="ignore"):
        r = np.einsum("im,im->m", first, second) / grid.squares
    trace, trace_of_square = _moments(grid.replications, grid.q, replication, here, following)
    mean = trace / dof
    variance = (2.0 * trace_of_square + trace**2) / (dof * (dof + 2.0)) - mean**2
    above, free = np.abs(r - mean), 1.0 / variance - 1.0
    p_value = f_tail(free * above**2 / (1.0 - np.minimum(above, _LARGEST) ** 2), 1.0, free)
    return Autocorrelation(r - mean, p_value)


@remembered(16)
def _moments(n: int, q: FloatArray, replication: IntArray, here: IntArray, following: IntArray) -> tuple[float, float]:
    """Return tr(MS) and tr(MSMS) of the whole grid of n replications, what is taken out neglected."""
    points = q.shape[0]
    between = np.eye(n) - 1.0 / n if n > 1 else np.ones((1, 1))
    turned = np.zeros((n, *q.shape))
    turned[replication, here] += 0.5 * q[following]  # a point stands once in a replication
    turned[replication, following] += 0.5 * q[here]
    inner = np.einsum("kp,rkq->rpq", q, turned)
    trace = -float(np.diag(between) @ np.trace(inner, axis1=1, axis2=2))
    edges = np.minimum(here, following) * points + np.maximum(here, following)
    kinds, kind = np.unique(edges, return_inverse=True)
    has = np.zeros((n, kinds.size))
    has[replication, kind] = 1.0
    shared = has @ has.T
    flat = turned.reshape(n, -1)
    squares = 0.5 * shared - 2.0 * flat @ flat.T + np.einsum("rpq,sqp->rs", inner, inner)
    return trace, float(np.sum(between**2 * squares))


def settling_between(evidence: Evidence) -> Slope:
    """Return how the outputs settle at the start of every replication, beside the effects of points and replications.

    Not known where the order of the points never differs.
    """
    grid, column = evidence.grid, settling(evidence)
    if evidence.order_repeats:
        return _unknown(evidence)
    left = grid.projected(evidence.on_grid(column[:, None]))[:, 0]
    square = float(left @ left)
    if evidence.sums is None or grid.dof < LEAST_DOF or not square > _LITTLE * float(column @ column):
        return _unknown(evidence)
    coefficient = left @ grid.residuals / square
    uncertainty = np.sqrt(evidence.precision_variance / square)
    p_value = f_tail((coefficient / uncertainty) ** 2, 1.0, float(grid.dof))
    return Slope(np.asarray(coefficient), uncertainty, p_value)


def slope_between(evidence: Evidence, column: FloatArray) -> Slope:
    """Return how the outputs follow a (N,) column from replication to replication, every point for itself."""
    z = _about_points(evidence.layout, column)
    square, dof = float(z @ z), evidence.grid.dof
    if evidence.sums is None or dof < LEAST_DOF or not square > _NOTHING * float(column @ column):
        return _unknown(evidence)
    coefficient = z @ evidence.departures / square
    uncertainty = np.sqrt(evidence.precision_variance / square)
    p_value = f_tail((coefficient / uncertainty) ** 2, 1.0, float(dof))
    return Slope(np.asarray(coefficient), uncertainty, p_value)


def _unknown(evidence: Evidence) -> Slope:
    nothing = np.full(evidence.left.shape[1], np.nan)
    return Slope(nothing, nothing, nothing)


@remembered(16)
def _about_points(layout: Layout, column: FloatArray) -> FloatArray:
    return layout.about_points(column)


def hours(evidence: Evidence) -> FloatArray | None:
    """Return the (N,) time of every row about the middle of the run; None where it is not known."""
    return None if evidence.rows.time_s is None else _hours(evidence.rows.time_s)


@remembered(16)
def _hours(time_s: FloatArray) -> FloatArray | None:
    if not np.ptp(time_s) > 0.0:
        return None
    return np.asarray((time_s - 0.5 * (time_s.min() + time_s.max())) / SECONDS_PER_HOUR)


def confounding(points: InOrder, linear: int, column: FloatArray | None) -> float | None:
    """Return the correlation of a (N,) column inside the replications with what a model takes from the points.

    It is that of the first columns of its basis, as many as the ``linear`` sensor has.

    Over all replications together, as the estimate is: what goes up in one and down in the next cancels. Adjusted for
    the number of rows; None where the column is not known or does not change, or where the rows are too few to say.
    """
    if column is None:
        return None
    return _confounding(points.layout.replication, points.layout.point, points.basis, linear, column)


def confounding_in_layings(points: InOrder, linear: int, column: FloatArray) -> float | None:
    """Return the same inside the runs of rows of one laying, over all of them together.

    What comes back with each of them is a saw-tooth over the replication, and goes with the points where the column
    does so inside the runs. None also where no replication has more than one of them, or of attitudes more than two:
    six points of a tumble are two runs, whose few points time follows in any order.
    """
    rows, layout = points.rows, points.layout
    yaw_rad = np.zeros(layout.rows) if rows.yaw_rad is None else rows.yaw_rad
    angles_rad = np.stack([rows.pitch_rad, yaw_rad, rows.roll_rad], axis=1)
    order = rows_in_time(column, layout.rows)
    run = rows_by_laying(order, layout.replication, angles_rad, rows.euler_rate_rad_s)
    few = _FEW_RUNS if rows.euler_rate_rad_s is None else 1
    if np.count_nonzero(np.bincount(run[run >= 0]) > 1) <= few * layout.replications:  # a row alone tells nothing
        return None
    return _confounding(run, layout.point, points.basis, linear, column)


@remembered(32)
def _confounding(group: IntArray, point: IntArray, basis: FloatArray, linear: int, column: FloatArray) -> float | None:
    """Return it inside the groups of rows that (N,) numbers name, those of −1 left out."""
    inside = group >= 0
    tested, q = _in_groups(group[inside], column[inside, None])[:, 0], _taken_in_groups(group, point, basis, linear)
    dof = tested.size - int(group.max()) - 1
    if dof <= q.shape[1] or not np.ptp(tested) > _NO_CHANGE:
        return None
    left = tested - q @ (q.T @ tested)
    share = 1.0 - float(left @ left) / (dof - q.shape[1]) / (float(tested @ tested) / dof)
    return float(np.sqrt(max(share, 0.0)))


@remembered(16)
def _taken_in_groups(group: IntArray, point: IntArray, basis: FloatArray, linear: int) -> FloatArray:
    """Return (M, q) orthonormal columns of what a linear sensor takes from the points inside groups of rows."""
    inside = group >= 0
    q, sizes, _ = np.linalg.svd(_in_groups(group[inside], basis[point[inside], :linear]), full_matrices=False)
    return np.asarray(q[:, sizes > _NOTHING_LEFT * max(float(sizes[0]), _NOTHING_LEFT)])


def _in_groups(group: IntArray, columns: FloatArray) -> FloatArray:
    """Return (M, c) columns less their mean over the rows of each group."""
    sums = np.stack([np.bincount(group, weights=column) for column in columns.T], axis=1)
    return np.asarray(columns - (sums / np.bincount(group)[:, None])[group])


@dataclass(frozen=True)
class EvenDrift:
    """How one output drifts evenly through the run, beside everything that its model takes from the points."""

    slope: float
    """Per second."""
    p_value: float
    seconds: FloatArray
    """(N,) about the mean time of the rows."""


def even_drift(basis: FloatArray, left: FloatArray, fitted: FloatArray, time_s: FloatArray) -> EvenDrift | None:
    """Return the even drift that an ordinary fit of a (N, P) basis left in (N,) residuals.

    None where the model takes time as it takes the points, so that nothing tells the two apart, and where nothing
    scatters.
    """
    seconds, z = _time_left(basis, time_s)
    square, dof = float(z @ z), left.size - basis.shape[1] - 1
    if dof < 1 or not square > _NOTHING_LEFT * float(seconds @ seconds):
        return None
    slope = float(z @ left) / square
    squares = float(left @ left) - slope**2 * square
    if not np.sqrt(max(squares, 0.0) / dof) > _ROUNDING * float(np.abs(fitted).max()):
        return None
    p_value = float(f_tail(np.array(slope**2 * square * dof / squares), 1.0, float(dof)))
    return EvenDrift(slope, p_value, seconds)


@remembered(16)
def _time_left(basis: FloatArray, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (N,) the times about their mean, and what a (N, P) basis leaves of them."""
    seconds = time_s - time_s.mean()
    q, _ = orthogonal(basis)
    return seconds, seconds - q @ (q.T @ seconds)


_NOTHING = 1e-18
"""Of the square of a column: less is left by rounding."""
_NOTHING_LEFT = 1e-9
"""Of the largest singular value, and of the square of a time in seconds: less is rounding."""
_LITTLE = 1e-3
"""Of the square of a column: with less left beside points and replications its size is not estimated."""
_ROUNDING = 1e-13
"""Of the largest output."""
_NO_CHANGE = 1e-6
"""Seconds, or °C."""
