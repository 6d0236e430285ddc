"""The package and the table in one fit: x, y, z and all replications share the table's own errors.

Every row's specific force is f + Σ n_j d_j: f at the commanded angles, d_j what one radian of a table error does to it,
n_j that error. Index errors (of every tooth, once and twice a turn of each axis), axis zeros, a tilt of the base,
squareness of the axes and droop are nuisance parameters under the priors of their certificates; the offsets and
sensitivities have none. The package sees M (f + …), M its mounting. Mounted a second time the other way round, table
errors change sign against the package and part from it; a mounting has three small seating errors of its own, known as
well as the datum faces are.

What the rows do not tell stays at its prior, enters the uncertainty of the package, and is said in words.
Source: TP 10, 'inclusion of calibration standard uncertainties'.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray, IntArray
from ams.calibration_result import VarianceComponent
from ams.errors import DesignError, SolveError
from ams.frames import specific_force
from ams.inputs.table_uncertainty import corrected
from ams.solve.extension import angles_of_points, without_drift
from ams.solve.layout import layout_of
from ams.solve.table_errors import Mounting, Nuisances, TablePriors, nuisances_of, seat_effects

OBSERVED_RATIO: Final = 0.5
"""A nuisance whose standard deviation fell below this part of its prior counts as observed."""
_ROUNDS: Final = 20


@dataclass(frozen=True)
class Nuisance:
    """One error of the table or of the seat."""

    name: str
    estimate_rad: float
    standard_deviation_rad: float
    prior_rad: float

    @property
    def is_observed(self) -> bool:
        return self.standard_deviation_rad < OBSERVED_RATIO * self.prior_rad


@dataclass(frozen=True)
class JointFit:
    """The package with the table's errors taken into account."""

    axes: tuple[str, ...]
    primary: Mapping[str, FloatArray]
    """Axis to (b, k_x, k_y, k_z); NaN for a component that no attitude excited (y where roll never moved)."""
    covariance: FloatArray
    """(4 A, 4 A) of all axes' primary parameters, in the order of ``axes``: noise, drift, table and seat."""
    nuisances: tuple[Nuisance, ...]
    confounded: tuple[str, ...]
    """Sentences on what the rows cannot tell."""
    standard_error_v: Mapping[str, float]
    """Scatter of a point's mean about the fit."""
    residuals_v: Mapping[str, tuple[FloatArray, ...]] = field(default_factory=dict)
    """Axis to one (K,) array per mounting, point means minus fit."""
    components: tuple[VarianceComponent, ...] = ()
    """(4 A, 4 A) independent parts of ``covariance``: replications (drift, precision), lack of fit, table and seat."""
    degrees_of_freedom: int = 0
    """Point means less package parameters."""
    replication_dof: int = 0
    """Of the spread between replications; 0 where nothing was replicated."""

    def axis_components(self, axis: str) -> tuple[VarianceComponent, ...]:
        """(4, 4) each."""
        at = slice(4 * self.axes.index(axis), 4 * self.axes.index(axis) + 4)
        return tuple(replace(part, covariance=part.covariance[at, at]) for part in self.components)

    def axis_covariance(self, axis: str) -> FloatArray:
        at = 4 * self.axes.index(axis)
        return self.covariance[at : at + 4, at : at + 4]

    def nuisance(self, name: str) -> Nuisance:
        return next(n for n in self.nuisances if n.name == name)


@dataclass(frozen=True)
class _Rows:
    """Point means of all mountings, one below the other."""

    mount: IntArray
    excited: NDArray[np.intp]
    """Places of the components of the specific force that any row excites, of 0 to 2."""
    force: FloatArray
    """(N, c) excited components in package axes at the commanded angles."""
    effects: FloatArray
    """(N, c, q) of one radian of each nuisance, package axes."""
    output_v: FloatArray
    """(N, A)"""
    precision_v2: FloatArray
    """(N, A) variance of each mean from the replications; 0 where there is one."""
    departures: FloatArray
    """(groups, N, A) what each replication of each mounting, alone in differing from the others, adds to the means."""
    spread_factor: FloatArray
    """(groups,) of the squares of what they do, for the variance of the mean."""
    spread_dof: int


def joint_fit(mountings: Sequence[Mounting], axes: Sequence[str], priors: TablePriors) -> JointFit:
    """Fit all axes and the table's errors together.

    Raises: DesignError where the points cannot determine the package even with the table known; SolveError where the
    scatter and the errors do not settle.
    """
    mountings = [replace(m, observations=corrected(m.observations, priors.table)) for m in mountings]
    nuisances = nuisances_of(mountings, priors)
    names, prior_rad = nuisances.names, nuisances.prior_rad
    rows = _rows(mountings, tuple(axes), nuisances)
    _refuse_rank_deficiency(rows)
    sd = np.maximum(np.sqrt(rows.precision_v2), 1e-12 * np.abs(rows.output_v).max(axis=0))
    errors = np.zeros(len(names))
    primary = _ordinary(rows, errors)
    for _ in range(_ROUNDS):
        jacobian, right = _system(rows, primary, errors, sd, prior_rad)
        q, r = np.linalg.qr(jacobian)
        step = np.linalg.solve(r, q.T @ right)
        primary, errors = primary + step[: primary.size].reshape(primary.shape), errors + step[primary.size :]
        wider = _spread_with_residuals(rows, primary, errors, sd, q)
        steady = np.all(np.abs(step[primary.size :]) < 1e-6 * prior_rad)
        settled = bool(steady and np.all(np.abs(wider / sd - 1.0) < 1e-3))
        sd = wider
        if settled:
            break
    else:
        raise SolveError(
            f"joint fit: no convergence in {_ROUNDS} rounds: the scatter about the fit does not settle; nothing is "
            "reported; look at the residuals of a fit of one axis for a wrong row, and without joint for a table that "
            "is off by more than is declared"
        )
    jacobian, _ = _system(rows, primary, errors, sd, prior_rad)
    inverse = np.linalg.inv(np.linalg.qr(jacobian, mode="r"))
    whole = inverse @ inverse.T
    count = sd.size
    estimator = (whole @ jacobian[:count].T)[: primary.size] / sd.T.ravel()
    parts = _components(rows, estimator, sd, whole[: primary.size, : primary.size])
    return _result(tuple(axes), rows, names, prior_rad, primary, errors, sd, whole, parts)


def _rows(mountings: Sequence[Mounting], axes: tuple[str, ...], nuisances: Nuisances) -> _Rows:
    excited = _excited(mountings)
    parts = [_part(number, mounting, axes, nuisances, excited) for number, mounting in enumerate(mountings)]
    return _Rows(
        np.concatenate([p.mount for p in parts]),
        excited,
        np.concatenate([p.force for p in parts]),
        np.concatenate([p.effects for p in parts]),
        np.concatenate([p.output_v for p in parts]),
        np.concatenate([p.precision_v2 for p in parts]),
        _beneath([p.departures for p in parts]),
        np.concatenate([p.spread_factor for p in parts]),
        sum(p.spread_dof for p in parts),
    )


def _beneath(parts: Sequence[FloatArray]) -> FloatArray:
    """Return (groups, N, A): the groups of each mounting touch its own points only."""
    groups, points = (sum(part.shape[axis] for part in parts) for axis in (0, 1))
    whole = np.zeros((groups, points, parts[0].shape[2]))
    group = point = 0
    for part in parts:
        whole[group : group + part.shape[0], point : point + part.shape[1]] = part
        group, point = group + part.shape[0], point + part.shape[1]
    return whole


def _excited(mountings: Sequence[Mounting]) -> NDArray[np.intp]:
    largest = np.zeros(3)
    for mounting in mountings:
        force = specific_force(mounting.observations.pitch_rad, mounting.observations.roll_rad)
        largest = np.maximum(largest, np.abs(force @ np.asarray(mounting.package_from_table).T).max(axis=0))
    return np.flatnonzero(largest > 1e-9)


def _part(
    number: int, mounting: Mounting, axes: tuple[str, ...], nuisances: Nuisances, excited: NDArray[np.intp]
) -> _Rows:
    observations, M = mounting.observations, np.asarray(mounting.package_from_table, dtype=float)
    layout = layout_of(observations)
    pitch, roll = angles_of_points(observations, layout)
    readings = layout.sum_by_point(np.ones(layout.rows))
    rows_force = specific_force(observations.pitch_rad, observations.roll_rad) @ M.T
    basis = np.column_stack([np.ones(layout.rows), rows_force[:, excited]])
    means, precision, departures = [], [], []
    for axis in axes:
        steady, variance, _ = without_drift(basis, observations.outputs[axis], layout, readings)
        means.append(layout.sum_by_point(steady) / readings)
        precision.append(variance / readings)
        left = observations.outputs[axis] - means[-1][layout.point]
        by_group = left[:, None] * np.eye(layout.replications)[layout.replication]
        departures.append(layout.sum_by_point(by_group).T / readings)
    force = specific_force(pitch, roll) @ M.T
    effects = np.einsum("ij,njq->niq", M, nuisances.effects(number, pitch, roll))
    effects = effects + seat_effects(force, nuisances.names, number)
    return _Rows(
        np.full(layout.points, number),
        excited,
        force[:, excited],
        effects[:, excited],
        np.stack(means, 1),
        np.stack(precision, 1),
        np.stack(departures, -1) if layout.replications > 1 else np.zeros((0, layout.points, len(axes))),
        np.full(layout.replications, layout.replications / (layout.replications - 1.0))
        if layout.replications > 1
        else np.zeros(0),
        layout.replications - 1,
    )


def _refuse_rank_deficiency(rows: _Rows) -> None:
    basis = np.column_stack([np.ones(rows.force.shape[0]), rows.force])
    rank = int(np.linalg.matrix_rank(basis, tol=1e-9 * np.linalg.norm(basis)))
    if rank < basis.shape[1] or rows.excited.size < 2 or basis.shape[0] <= basis.shape[1]:
        raise DesignError(
            f"joint fit: {basis.shape[0]} points determine {rank} of offset and {rows.excited.size} sensitivities per "
            "axis; nothing was solved; add pitch and roll angles"
        )


def _ordinary(rows: _Rows, errors: FloatArray) -> FloatArray:
    """Return the ordinary estimates, (A, 1 + c)."""
    force = rows.force + rows.effects @ errors
    basis = np.column_stack([np.ones(force.shape[0]), force])
    return np.asarray(np.linalg.lstsq(basis, rows.output_v, rcond=None)[0].T)


def _system(
    rows: _Rows, primary: FloatArray, errors: FloatArray, sd: FloatArray, prior_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the whitened Jacobian and right-hand side: all axes' rows, then one row per prior."""
    count, size = primary.shape
    points = rows.force.shape[0]
    force = rows.force + rows.effects @ errors
    basis = np.column_stack([np.ones(points), force])
    jacobian = np.zeros((count * points + errors.size, count * size + errors.size))
    right = np.empty(jacobian.shape[0])
    for a in range(count):
        at, weight = slice(a * points, (a + 1) * points), 1.0 / sd[:, a]
        jacobian[at, a * size : (a + 1) * size] = weight[:, None] * basis
        jacobian[at, count * size :] = weight[:, None] * np.einsum("i,niq->nq", primary[a, 1:], rows.effects)
        right[at] = weight * (rows.output_v[:, a] - basis @ primary[a])
    jacobian[count * points :, count * size :] = np.diag(1.0 / prior_rad)
    right[count * points :] = -errors / prior_rad
    return jacobian, right


def _spread_with_residuals(
    rows: _Rows, primary: FloatArray, errors: FloatArray, sd: FloatArray, q: FloatArray
) -> FloatArray:
    """Return the (N, A) standard deviations of the means.

    They are the replications' precision, raised to the scatter that is there.
    """
    points = rows.force.shape[0]
    residuals = _residuals(rows, primary, errors) / sd
    raised = np.empty_like(sd)
    for a in range(sd.shape[1]):
        leverage = np.sum(q[a * points : (a + 1) * points] ** 2, axis=1)
        ratio = float(np.sum(residuals[:, a] ** 2) / max(np.sum(1.0 - leverage), 1.0))
        raised[:, a] = np.maximum(sd[:, a] * np.sqrt(ratio), np.sqrt(rows.precision_v2[:, a]))
    return np.asarray(np.maximum(raised, 1e-15 * np.abs(rows.output_v).max(axis=0)), dtype=float)


def _components(
    rows: _Rows, estimator: FloatArray, sd: FloatArray, conditional: FloatArray
) -> tuple[VarianceComponent, ...]:
    """Return what the estimator (P A, N A) makes of the parts of the outputs' covariance.

    They are drift and precision, by the replications' departures; the points' own scatter beyond precision; and the
    errors of table and seat, within their priors.
    """
    points, size = rows.force.shape[0], 1 + rows.excited.size
    beyond = np.maximum(sd**2 - (rows.precision_v2 if rows.spread_dof > 0 else 0.0), 0.0).T.ravel()
    scatter = (estimator * beyond) @ estimator.T
    stated = conditional - (estimator * sd.T.ravel() ** 2) @ estimator.T
    parts = [
        VarianceComponent("lack-of-fit", scatter, float(max(points - size, 1))),
        VarianceComponent("table", 0.5 * (stated + stated.T), float("inf")),
    ]
    if rows.spread_dof > 0:
        moved = np.swapaxes(rows.departures, 1, 2).reshape(rows.departures.shape[0], -1) @ estimator.T
        between = (rows.spread_factor[:, None] * moved).T @ moved
        parts.append(VarianceComponent("replications", between, float(rows.spread_dof)))
    return tuple(parts)


def _residuals(rows: _Rows, primary: FloatArray, errors: FloatArray) -> FloatArray:
    force = rows.force + rows.effects @ errors
    return np.asarray(rows.output_v - primary[:, 0] - force @ primary[:, 1:].T)


def _result(
    axes: tuple[str, ...],
    rows: _Rows,
    names: tuple[str, ...],
    prior_rad: FloatArray,
    primary: FloatArray,
    errors: FloatArray,
    sd: FloatArray,
    whole: FloatArray,
    parts: tuple[VarianceComponent, ...],
) -> JointFit:
    size = primary.size
    spread = whole[size:, size:]
    nuisances = tuple(
        Nuisance(name, float(value), float(np.sqrt(variance)), float(prior))
        for name, value, variance, prior in zip(names, errors, np.diag(spread), prior_rad, strict=True)
    )
    residuals = _residuals(rows, primary, errors)
    count = len(axes)
    parts = tuple(replace(p, covariance=_with_unexcited(p.covariance, count, rows.excited)) for p in parts)
    filled = np.full((count, 4), np.nan)
    filled[:, np.concatenate([[0], 1 + rows.excited])] = primary
    by_mount = {
        axis: tuple(residuals[rows.mount == m, a] for m in np.unique(rows.mount)) for a, axis in enumerate(axes)
    }
    return JointFit(
        axes,
        dict(zip(axes, filled, strict=True)),
        np.asarray(sum(part.covariance for part in parts)),
        nuisances,
        _confounded(names, prior_rad, spread),
        {axis: float(np.sqrt(np.mean(sd[:, a] ** 2))) for a, axis in enumerate(axes)},
        by_mount,
        parts,
        rows.force.shape[0] * count - primary.size,
        rows.spread_dof,
    )


def _with_unexcited(covariance: FloatArray, count: int, excited: NDArray[np.intp]) -> FloatArray:
    """Return (4 A, 4 A), NaN where a component was never excited."""
    components = np.concatenate([[0], 1 + excited])
    every = (4 * np.arange(count)[:, None] + components).ravel()
    whole = np.full((4 * count, 4 * count), np.nan)
    whole[np.ix_(every, every)] = covariance
    return whole


def _confounded(names: tuple[str, ...], prior_rad: FloatArray, spread: FloatArray) -> tuple[str, ...]:
    """Return the directions in the space of whole-table errors that the rows leave at their prior."""
    whole = [n for n, name in enumerate(names) if " tooth " not in name]
    if not whole:
        return ()
    scaled = spread[np.ix_(whole, whole)] / np.outer(prior_rad[whole], prior_rad[whole])
    values, vectors = np.linalg.eigh(scaled)
    sentences = []
    for value, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        if np.sqrt(max(value, 0.0)) >= OBSERVED_RATIO:
            members = [names[whole[n]] for n in np.argsort(-np.abs(vector)) if abs(vector[n]) > 0.3]
            sentences.append(_sentence(members, float(np.sqrt(value))))
    return tuple(sentences)


def _sentence(members: list[str], ratio: float) -> str:
    remains = f"{100.0 * ratio:.0f} % of the prior standard deviation remains and is in the package's uncertainty"
    if len(members) == 1:
        return f"{members[0]}: not observable with these mountings: {remains}; calibrate once more in a reversed mount"
    return f"{' and '.join(members)}: these rows do not tell them apart: {remains}"
