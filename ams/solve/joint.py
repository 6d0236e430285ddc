"""The package and the table in one fit: x, y, z and all replications share the table's own errors.

Every row's specific force is f + Σ n_j d_j: f at the commanded angles, d_j what one radian of a table error does to it,
n_j that error. Index errors (of every tooth, once and twice a turn of each axis), axis zeros, a tilt of the base,
squareness of the axes and droop are nuisance parameters under the priors of their certificates; the offsets and
sensitivities have none. The package sees M (f + …), M its mounting. Mounted a second time the other way round, table
errors change sign against the package and part from it; a mounting has three small seating errors of its own, known as
well as the datum faces are.

The terms of second and third order of every axis (:mod:`ams.models.extended`) are parameters like offset and
sensitivities, without a prior. In one mounting they look like a table that is off once a turn; the reversed mounting
parts p·cos α of pitch and of roll from them, since it changes the sign of these errors in package axes and not that of
the terms.

What the rows do not tell stays at its prior, enters the uncertainty of the package, and is said in words.
Source: TP 10, 'inclusion of calibration standard uncertainties'.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.calibration_result import VarianceComponent
from ams.errors import DesignError, SolveError
from ams.inputs.table_uncertainty import corrected
from ams.solve.joint_rows import JointRows, joint_rows
from ams.solve.joint_sensor import JointSensor, sensors_of
from ams.solve.table_errors import Mounting, TablePriors, nuisances_of

OBSERVED_RATIO: Final = 0.5
"""A nuisance whose standard deviation fell below this part of its prior counts as observed."""
_ROUNDS: Final = 100


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
    """Axis to (b, k_x, k_y, k_z, terms); NaN for a component that no attitude excited (y where roll never moved)."""
    covariance: FloatArray
    """(Q, Q) of all axes' primary parameters, in the order of ``axes``: noise, drift, table and seat."""
    nuisances: tuple[Nuisance, ...]
    confounded: tuple[str, ...]
    """Sentences on what the rows cannot tell."""
    standard_error_v: Mapping[str, float]
    """Of one dwell about the fit: its precision, and what its point is off by beyond that."""
    sensors: Mapping[str, JointSensor]
    """With the terms of second and third order where the points determine them."""
    residuals_v: Mapping[str, tuple[FloatArray, ...]] = field(default_factory=dict)
    """Axis to one (K,) array per mounting, point means minus fit."""
    components: tuple[VarianceComponent, ...] = ()
    """(Q, Q) independent parts of ``covariance``: replications (drift, precision), lack of fit, table and seat."""
    degrees_of_freedom: int = 0
    """Point means less package parameters."""
    replication_dof: int = 0
    """Of the spread between replications; 0 where nothing was replicated."""
    has_terms: bool = True
    """Whether terms of second and third order were asked for; where the points do not determine them, none stand."""

    def slope(self, axis: str, force: FloatArray) -> FloatArray:
        """Return the (N, 3) derivatives of an axis' output by (N, 3) force; 0 for a component never excited."""
        sensor = self.sensors[axis]
        slope = np.zeros_like(force)
        slope[:, sensor.excited] = sensor.slope(self.primary[axis][sensor.solved], force[:, sensor.excited])
        return slope

    def axis_components(self, axis: str) -> tuple[VarianceComponent, ...]:
        """Return the components of one axis, (P, P) each."""
        at = self.block(axis)
        return tuple(replace(part, covariance=part.covariance[at, at]) for part in self.components)

    def axis_covariance(self, axis: str) -> FloatArray:
        at = self.block(axis)
        return self.covariance[at, at]

    def block(self, axis: str) -> slice:
        """Return where an axis' primary parameters stand among those of all."""
        sizes = [self.primary[name].size for name in self.axes]
        first = sum(sizes[: self.axes.index(axis)])
        return slice(first, first + self.primary[axis].size)

    def nuisance(self, name: str) -> Nuisance:
        return next(n for n in self.nuisances if n.name == name)


def joint_fit(
    mountings: Sequence[Mounting], axes: Sequence[str], priors: TablePriors, *, has_terms: bool = True
) -> JointFit:
    """Fit all axes and the table's errors together.

    ``has_terms``: with the terms of second and third order, wherever the points determine them.

    Raises: DesignError where the points cannot determine the package even with the table known; SolveError where the
    scatter and the errors do not settle.
    """
    mountings = [replace(m, observations=corrected(m.observations, priors.table)) for m in mountings]
    nuisances = nuisances_of(mountings, priors)
    names, prior_rad = nuisances.names, nuisances.prior_rad
    rows = joint_rows(mountings, tuple(axes), nuisances)
    _refuse_rank_deficiency(rows)
    sensors = sensors_of(tuple(axes), rows.force, rows.excited, has_terms=has_terms)
    sd = np.maximum(np.sqrt(rows.precision_v2), 1e-12 * np.abs(rows.output_v).max(axis=0))
    errors = np.zeros(len(names))
    primary = _ordinary(rows, sensors)
    for _ in range(_ROUNDS):
        jacobian, right = _system(rows, sensors, primary, errors, sd, prior_rad)
        q, r = np.linalg.qr(jacobian)
        step = np.linalg.solve(r, q.T @ right)
        primary, errors = primary + step[: primary.size], errors + step[primary.size :]
        wider = _spread_with_residuals(rows, _residuals(rows, sensors, primary, errors), sd, q)
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
    jacobian, _ = _system(rows, sensors, primary, errors, sd, prior_rad)
    inverse = np.linalg.inv(np.linalg.qr(jacobian, mode="r"))
    whole = inverse @ inverse.T
    count = sd.size
    estimator = (whole @ jacobian[:count].T)[: primary.size] / sd.T.ravel()
    parts = _components(rows, estimator, sd, whole[: primary.size, : primary.size])
    found = _result(sensors, rows, names, prior_rad, primary, errors, sd, whole, parts)
    return replace(found, has_terms=has_terms)


def _refuse_rank_deficiency(rows: JointRows) -> None:
    basis = np.column_stack([np.ones(rows.force.shape[0]), rows.force])
    rank = int(np.linalg.matrix_rank(basis, tol=1e-9 * np.linalg.norm(basis)))
    if rank < basis.shape[1] or rows.excited.size < 2 or basis.shape[0] <= basis.shape[1]:
        raise DesignError(
            f"joint fit: {basis.shape[0]} points determine {rank} of offset and {rows.excited.size} sensitivities per "
            "axis; nothing was solved; add pitch and roll angles"
        )


def _ordinary(rows: JointRows, sensors: Sequence[JointSensor]) -> FloatArray:
    """Return the ordinary estimates of all axes, one behind the other."""
    return np.concatenate(
        [
            np.linalg.lstsq(sensor.basis(rows.force), rows.output_v[:, index], rcond=None)[0]
            for index, sensor in enumerate(sensors)
        ]
    )


def _by_sensor(sensors: Sequence[JointSensor], primary: FloatArray) -> list[FloatArray]:
    return np.split(primary, np.cumsum([sensor.size for sensor in sensors])[:-1])


def _system(
    rows: JointRows,
    sensors: Sequence[JointSensor],
    primary: FloatArray,
    errors: FloatArray,
    sd: FloatArray,
    prior_rad: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the whitened Jacobian and right-hand side: all axes' rows, then one row per prior."""
    points, size = rows.force.shape[0], primary.size
    count = len(sensors) * points
    force = rows.force + rows.effects @ errors
    jacobian = np.zeros((count + errors.size, size + errors.size))
    right = np.empty(jacobian.shape[0])
    first = 0
    for a, (sensor, known) in enumerate(zip(sensors, _by_sensor(sensors, primary), strict=True)):
        at, weight, basis = slice(a * points, (a + 1) * points), 1.0 / sd[:, a], sensor.basis(force)
        jacobian[at, first : first + sensor.size] = weight[:, None] * basis
        jacobian[at, size:] = weight[:, None] * np.einsum("ni,niq->nq", sensor.slope(known, force), rows.effects)
        right[at] = weight * (rows.output_v[:, a] - basis @ known)
        first += sensor.size
    jacobian[count:, size:] = np.diag(1.0 / prior_rad)
    right[count:] = -errors / prior_rad
    return jacobian, right


def _spread_with_residuals(rows: JointRows, residuals: FloatArray, sd: FloatArray, q: FloatArray) -> FloatArray:
    """Return the (N, A) standard deviations of the means.

    They are the replications' precision, raised to the scatter that is there.
    """
    points, residuals = rows.force.shape[0], residuals / sd
    raised = np.empty_like(sd)
    for a in range(sd.shape[1]):
        leverage = np.sum(q[a * points : (a + 1) * points] ** 2, axis=1)
        ratio = float(np.sum(residuals[:, a] ** 2) / max(np.sum(1.0 - leverage), 1.0))
        raised[:, a] = np.maximum(sd[:, a] * np.sqrt(ratio), np.sqrt(rows.precision_v2[:, a]))
    return np.asarray(np.maximum(raised, 1e-15 * np.abs(rows.output_v).max(axis=0)), dtype=float)


def _components(
    rows: JointRows, estimator: FloatArray, sd: FloatArray, conditional: FloatArray
) -> tuple[VarianceComponent, ...]:
    """Return what the estimator (Q, N A) makes of the parts of the outputs' covariance.

    They are drift and precision, by the replications' departures; the points' own scatter beyond precision; and the
    errors of table and seat, within their priors.
    """
    points, size = rows.force.shape[0], -(-len(estimator) // sd.shape[1])
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


def _residuals(rows: JointRows, sensors: Sequence[JointSensor], primary: FloatArray, errors: FloatArray) -> FloatArray:
    """Return (N, A)."""
    force = rows.force + rows.effects @ errors
    each = zip(sensors, _by_sensor(sensors, primary), strict=True)
    return np.asarray(rows.output_v - np.stack([sensor.basis(force) @ known for sensor, known in each], axis=1))


def _result(
    sensors: tuple[JointSensor, ...],
    rows: JointRows,
    names: tuple[str, ...],
    prior_rad: FloatArray,
    primary: FloatArray,
    errors: FloatArray,
    sd: FloatArray,
    whole: FloatArray,
    parts: tuple[VarianceComponent, ...],
) -> JointFit:
    size, axes = primary.size, tuple(sensor.axis for sensor in sensors)
    spread = whole[size:, size:]
    nuisances = tuple(
        Nuisance(name, float(value), float(np.sqrt(variance)), float(prior))
        for name, value, variance, prior in zip(names, errors, np.diag(spread), prior_rad, strict=True)
    )
    residuals = _residuals(rows, sensors, primary, errors)
    parts = tuple(replace(part, covariance=_with_unexcited(part.covariance, sensors)) for part in parts)
    filled = {}
    for sensor, known in zip(sensors, _by_sensor(sensors, primary), strict=True):
        filled[sensor.axis] = np.full(len(sensor.model.primary_names), np.nan)
        filled[sensor.axis][sensor.solved] = known
    by_mount = {
        axis: tuple(residuals[rows.mount == m, a] for m in np.unique(rows.mount)) for a, axis in enumerate(axes)
    }
    return JointFit(
        axes,
        filled,
        np.asarray(sum(part.covariance for part in parts)),
        nuisances,
        _confounded(names, prior_rad, spread, int(rows.mount[-1]) + 1),
        dict(zip(axes, _of_a_dwell(rows, sd).tolist(), strict=True)),
        {sensor.axis: sensor for sensor in sensors},
        by_mount,
        parts,
        rows.output_v.size - primary.size,
        rows.spread_dof,
    )


def _of_a_dwell(rows: JointRows, sd: FloatArray) -> FloatArray:
    """Return (A,) the standard error of one dwell, the means having (N, A) standard deviations."""
    beyond = np.maximum(sd**2 - rows.precision_v2, 0.0)
    return np.asarray(np.sqrt((beyond + rows.precision_v2 * rows.readings[:, None]).mean(axis=0)))


def _with_unexcited(covariance: FloatArray, sensors: Sequence[JointSensor]) -> FloatArray:
    """Return (Q, Q), NaN where a component was never excited."""
    sizes = [len(sensor.model.primary_names) for sensor in sensors]
    firsts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    every = np.concatenate([first + sensor.solved for first, sensor in zip(firsts, sensors, strict=True)])
    whole = np.full((sum(sizes), sum(sizes)), np.nan)
    whole[np.ix_(every, every)] = covariance
    return whole


def _confounded(names: tuple[str, ...], prior_rad: FloatArray, spread: FloatArray, mountings: int) -> tuple[str, ...]:
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
            sentences.append(_sentence(members, float(np.sqrt(value)), mountings))
    return tuple(sentences)


def _sentence(members: list[str], ratio: float, mountings: int) -> str:
    remains = f"{100.0 * ratio:.0f} % of the prior standard deviation remains and is in the package's uncertainty"
    if len(members) == 1:
        advice = "; calibrate once more in a reversed mount" if mountings == 1 else ""
        return f"{members[0]}: not observable with these mountings: {remains}{advice}"
    return f"{' and '.join(members)}: these rows do not tell them apart: {remains}"
