"""Which axis of three is wrong, told by many rows of different attitude.

Three outputs of a package give a specific force û whose length is one. Where it is not, one row tells that something is
wrong and never what; over rows of different attitude each fault leaves a pattern of its own in |û|² − 1. Every
explanation is fitted in turn: one axis with a gain and an offset of its own, one axis that stands still at a value, all
axes with one gain and one offset (supply, meter, gravity). The calibration's errors are the same in every row, so they
are fitted with it, held by their covariance. An axis is named where it explains the rows by chi-square and nothing else
does, nor that nothing is wrong.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.inference.package.calibrated import CalibratedPackage, CalibratedSensor, covariance_root, parameter_parts
from ams.statistics.distributions import chi_square_quantile, normal_quantile, student_t_quantile

LEAST_ROWS: Final = 20
"""Fewer name no axis."""
LEVEL: Final = 0.999
"""At which an explanation is held against the rows."""
_AGAINST: Final = 0.9999
"""At which another explanation, or that nothing is wrong, is worse: three axes in two ways and all alike are tried."""
PROVEN: Final = 1.0 - 1e-6
"""At which rows that agree by themselves are held to be wrong as well."""
STANDS_SD: Final = 5.0
"""Of a reading, within which an axis stands at a value."""
_CLEAR_SD: Final = 3.0
_DISAGREES_SD: Final = 3.3
_STEPS: Final = 30
_SETTLED: Final = 1e-4
_MOST_NOISE_G: Final = 0.05
_LARGEST_SCALE: Final = 1e4
_LEAST_STANDING: Final = 3
"""Rows that disagree at one output, for it to be one that an axis stands at: a spike is none."""
_LEAST_NOISE: Final = 1e-8
"""Of |û|² against the largest: where û is next to nothing its square has no noise to first order."""
_BEND_STEPS: Final = 4


class Cause(Enum):
    """What the rows say together."""

    NOTHING = "nothing is wrong"
    AXIS = "one axis"
    ALIKE = "all axes alike"
    SEVERAL = "explanations that the rows do not part"
    UNEXPLAINED = "none of them"
    UNMOVED = "all outputs stand still"


@dataclass(frozen=True)
class Explanation:
    """One fault fitted to the rows."""

    axis: int | None
    """None: all axes alike."""
    chi_square: float
    dof: int
    gain: float
    """Of the output against its calibration."""
    gain_sd: float
    offset_v: float
    """Beyond its calibration's."""
    offset_sd_v: float
    standing: int = 0
    """Rows in which the axis stands still; 0 where it has a gain and an offset of its own."""
    stands_at_v: tuple[float, ...] = ()
    """Outputs in volts."""

    @property
    def explains(self) -> bool:
        """Whether nothing beyond the noise is left."""
        return self.chi_square <= float(chi_square_quantile(LEVEL, max(self.dof, 1)))

    def is_worse_than(self, other: "Explanation") -> bool:
        """Return whether the rows hold this one to be false where the other is true."""
        freedom = max(abs(self.dof - other.dof), 1)
        margin = float(chi_square_quantile(_AGAINST, freedom)) - freedom
        return not self.explains or (self.chi_square - self.dof) - (other.chi_square - other.dof) > margin


@dataclass(frozen=True)
class Judgement:
    """What many rows tell of the axes."""

    cause: Cause
    rows: int
    possible: tuple[Explanation, ...] = ()
    """The best first."""
    is_proven: bool = False
    """Whether chance makes no such rows where nothing is wrong: then those that agree are wrong as well."""

    @property
    def axis(self) -> int | None:
        """The one that is named."""
        return self.possible[0].axis if self.cause is Cause.AXIS else None


class PackageRows:
    """Rows of three outputs beside what is known of their sensors."""

    def __init__(
        self, sensors: Sequence[CalibratedSensor], package: CalibratedPackage | None, outputs_v: FloatArray
    ) -> None:
        """Take (N, 3) outputs at the reference temperature."""
        self.sensors = sensors
        self.offset_v = np.array([sensor.offset_v for sensor in sensors])
        self.deviation_v = outputs_v.T - self.offset_v[:, None]
        self.k = np.stack([sensor.k_v_per_g for sensor in sensors])
        self._inverse = np.linalg.inv(self.k)
        self._factor = parameter_factor(sensors, package)
        level = np.tile([0.0, 0.0, -1.0], (self.rows, 1))
        self.reading_v2 = np.stack([np.broadcast_to(s.reading_variance_v2(level), self.rows) for s in sensors])

    @property
    def rows(self) -> int:
        return int(self.deviation_v.shape[1])

    def sensed(self, deviation_v: FloatArray) -> FloatArray:
        """Return û, (3, N), of outputs less their offsets."""
        straight = self._inverse @ deviation_v
        if all(sensor.is_linear for sensor in self.sensors):
            return np.asarray(straight)
        found = straight
        for _ in range(_BEND_STEPS):
            bend = np.stack([sensor.quadratic_v(_unit(found).T) for sensor in self.sensors])
            found = straight - self._inverse @ bend
        return np.asarray(found)

    def linear(self, scale: FloatArray, shift_v: FloatArray, zero_v: FloatArray) -> "_Linear":
        """Return |û|² − 1 of outputs that are corrected axis by axis, with what it depends on.

        Outputs are scaled about (3,) zeros: 0 V for a meter's gain, their offsets for a sensor's.
        """
        scaled = self.deviation_v + (self.offset_v - zero_v)[:, None]
        sensed = self.sensed(self.deviation_v + (scale[:, None] - 1.0) * scaled - shift_v[:, None])
        slope = 2.0 * self._inverse.T @ sensed
        force = _unit(sensed).T
        by_parameter = [sensor.rows(force) * -slope[axis][:, None] for axis, sensor in enumerate(self.sensors)]
        noise = np.einsum("in,in->n", slope**2, self.reading_v2 * scale[:, None] ** 2)
        return _Linear(
            np.einsum("in,in->n", sensed, sensed) - 1.0,
            slope * scaled,
            -slope,
            np.concatenate(by_parameter, axis=1) @ self._factor,
            np.sqrt(np.maximum(noise, _LEAST_NOISE * noise.max())),
        )

    def shortest(self, axis: int) -> tuple[FloatArray, FloatArray]:
        """Return the least |û|² − 1, (N,), that any output of one axis could give, and its standard deviation."""
        column = self._inverse[:, axis]
        sensed = self.sensed(self.deviation_v)
        sensed = sensed - np.outer(column, column @ sensed / (column @ column))
        slope = 2.0 * self._inverse.T @ sensed
        force = _unit(sensed).T
        by_parameter = [sensor.rows(force) * -slope[other][:, None] for other, sensor in enumerate(self.sensors)]
        known = np.sum((np.concatenate(by_parameter, axis=1) @ self._factor) ** 2, axis=1)
        excess = np.einsum("in,in->n", sensed, sensed) - 1.0
        return excess, np.sqrt(np.einsum("in,in->n", slope**2, self.reading_v2) + known)


@dataclass(frozen=True)
class _Linear:
    excess: FloatArray
    """(N,) |û|² − 1"""
    by_scale: FloatArray
    """(3, N)"""
    by_shift: FloatArray
    """(3, N) per volt"""
    by_calibration: FloatArray
    """(N, Q) per standard deviation of independent errors of the calibration"""
    sd: FloatArray
    """(N,) of the noise"""

    def solved(self, free: FloatArray, rows: BoolArray) -> tuple[FloatArray, FloatArray, float]:
        """Return the correction of (N, p) free parameters, their covariance, and the chi-square without it."""
        sd, count = self.sd[rows, None], free.shape[1]
        columns = np.concatenate([free[rows], self.by_calibration[rows]], axis=1) / sd
        size = np.concatenate([np.linalg.norm(columns[:, :count], axis=0), np.ones(columns.shape[1] - count)])
        size = np.where(size > 0.0, size, 1.0)
        columns = columns / size
        left = -self.excess[rows] / sd[:, 0]
        normal = columns.T @ columns
        held = np.arange(count, columns.shape[1])
        alone = normal[np.ix_(held, held)] + np.eye(held.size)
        chi_square = float(left @ left - _quadratic(alone, columns[:, count:].T @ left))
        normal[held, held] += 1.0
        inverse = np.linalg.pinv(normal, rcond=1e-13, hermitian=True)
        step = (inverse @ (columns.T @ left))[:count] / size[:count]
        return step, inverse[:count, :count] / np.outer(size[:count], size[:count]), chi_square


def judge(rows: PackageRows) -> Judgement:
    """Return what the rows tell of the axes together."""
    if rows.rows < LEAST_ROWS:
        return Judgement(Cause.NOTHING, rows.rows)
    whole = np.ones(rows.rows, dtype=bool)
    linear = rows.linear(np.ones(3), np.zeros(3), rows.offset_v)
    right = Explanation(None, linear.solved(np.empty((rows.rows, 0)), whole)[2], rows.rows, 1.0, 0.0, 0.0, 0.0)
    found = _all_followed(rows, 1.0)
    found += [_standing(rows, linear, axis) for axis in range(3)]
    if not any(fault.explains for fault in found):
        found += _all_followed(rows, -1.0)
    best = min(found, key=lambda fault: (not fault.explains, fault.chi_square - fault.dof))
    if right.explains and not right.is_worse_than(best):
        return Judgement(Cause.NOTHING, rows.rows)
    is_proven = right.chi_square > float(chi_square_quantile(PROVEN, right.dof))
    if sum(fault.standing == rows.rows for fault in found) == len(rows.sensors):
        return Judgement(Cause.UNMOVED, rows.rows, is_proven=is_proven)
    if not best.explains:
        return Judgement(Cause.UNEXPLAINED, rows.rows, is_proven=is_proven)
    left = sorted(
        (fault for fault in found if not fault.is_worse_than(best)), key=lambda fault: fault.chi_square - fault.dof
    )
    axes = dict.fromkeys(fault.axis for fault in left)
    if len(axes) > 1:
        possible = tuple(next(fault for fault in left if fault.axis == axis) for axis in axes)
        return Judgement(Cause.SEVERAL, rows.rows, possible, is_proven)
    # Of an axis that stands still the gain and the offset are nothing that a person would ask for.
    left.sort(key=lambda fault: not fault.standing)
    return Judgement(Cause.ALIKE if left[0].axis is None else Cause.AXIS, rows.rows, tuple(left[:1]), is_proven)


def _all_followed(rows: PackageRows, start: float) -> list[Explanation]:
    """Fit each axis by itself, and all: what a sensor does is about its offset, what a meter does about 0 V."""
    singly = [_followed(rows, (axis,), start, rows.offset_v) for axis in range(3)]
    return singly + [_followed(rows, (0, 1, 2), start, zero) for zero in (rows.offset_v, np.zeros(3))]


def _followed(rows: PackageRows, axes: tuple[int, ...], start: float, zero_v: FloatArray) -> Explanation:
    """Fit one gain and one offset to some of the axes by Gauss and Newton."""
    scale, shift, chosen = np.ones(3), np.zeros(3), list(axes)
    whole = np.ones(rows.rows, dtype=bool)
    scale[chosen] = start
    before = np.inf
    for _ in range(_STEPS):
        linear = rows.linear(scale, shift, zero_v)
        free = np.stack([linear.by_scale[chosen].sum(axis=0), linear.by_shift[chosen].sum(axis=0)], axis=1)
        step, covariance, chi_square = linear.solved(free, whole)
        sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        if np.all(np.abs(step) < 1e-3 * sd + 1e-15) or abs(before - chi_square) < _SETTLED * (1.0 + chi_square):
            break
        before = chi_square
        scale[chosen], shift[chosen] = scale[chosen] + step[0], shift[chosen] + step[1]
        if not 1.0 / _LARGEST_SCALE < abs(scale[chosen[0]]) < _LARGEST_SCALE:
            chi_square = np.inf
            break
    alpha, beta = float(scale[chosen[0]]), float(shift[chosen[0]])
    gain = 1.0 / alpha if alpha else np.inf
    # v = gain · (signal + shift): the offset's standard deviation counts the gain's where it matters, at the shift.
    along = np.array([-beta * gain, 1.0])
    offset_sd = float(abs(gain) * np.sqrt(max(float(along @ covariance @ along), 0.0)))
    single = axes[0] if len(axes) == 1 else None
    if not np.all(_noise_g(rows, alpha)[chosen] < _MOST_NOISE_G):
        chi_square = np.inf
    return Explanation(single, chi_square, rows.rows - 2, gain, float(sd[0]) * gain**2, gain * beta, offset_sd)


def _noise_g(rows: PackageRows, scale: float) -> FloatArray:
    """Return the (3,) noise of outputs that are taken times a scale: what is next to nothing explains anything."""
    return np.asarray(abs(scale) * np.sqrt(rows.reading_v2.max(axis=1)) / np.linalg.norm(rows.k, axis=1))


def _standing(rows: PackageRows, linear: _Linear, axis: int) -> Explanation:
    """Leave out one axis where it stands at its lowest, its highest or the output of most rows that disagree."""
    read = rows.deviation_v[axis]
    total = np.hypot(linear.sd, np.sqrt(np.sum(linear.by_calibration**2, axis=1)))
    disagree = np.abs(linear.excess) > _DISAGREES_SD * total
    marks = [float(read.min()), float(read.max()), *([float(np.median(read[disagree]))] if disagree.any() else [])]
    near = STANDS_SD * np.sqrt(rows.reading_v2[axis])
    stands = np.zeros(rows.rows, dtype=bool)
    standing_v = []
    for mark in marks:
        at = np.abs(read - mark) <= near
        if np.count_nonzero(at & disagree) < _LEAST_STANDING:
            continue
        # A value that is passed is none that the axis stands at.
        if not np.any(at & stands & disagree):
            standing_v.append(float(np.median(read[at])) + float(rows.offset_v[axis]))
        stands |= at
    if not stands.any():
        return Explanation(axis, np.inf, rows.rows, 1.0, 0.0, 0.0, 0.0)
    moves = ~stands
    chi_square = linear.solved(np.empty((rows.rows, 0)), moves)[2] if moves.any() else 0.0
    excess, sd = rows.shortest(axis)
    impossible = np.maximum(excess / np.maximum(sd, np.finfo(float).tiny) - _CLEAR_SD, 0.0)[stands]
    dof = int(np.count_nonzero(moves)) + int(np.count_nonzero(impossible))
    chi_square += float(impossible @ impossible)
    return Explanation(axis, chi_square, dof, 1.0, 0.0, 0.0, 0.0, int(np.count_nonzero(stands)), tuple(standing_v))


def parameter_factor(sensors: Sequence[CalibratedSensor], package: CalibratedPackage | None) -> FloatArray:
    """Return a root of the covariance of all parameters, widened for the degrees of freedom that its parts have."""
    parts = parameter_parts(sensors, package)
    total = np.sum([part.covariance * _variance_factor(part.dof) for part in parts], axis=0)
    return covariance_root(np.asarray(total))


def _variance_factor(dof: float) -> float:
    """Return by how much a variance of few degrees of freedom is to be larger to be known at the level."""
    if not np.isfinite(dof):
        return 1.0
    ratio = student_t_quantile(0.5 + 0.5 * LEVEL, max(dof, 1.0)) / normal_quantile(0.5 + 0.5 * LEVEL)
    return float(ratio**2)


def _unit(sensed: FloatArray) -> FloatArray:
    return np.asarray(sensed / np.maximum(np.sqrt(np.einsum("in,in->n", sensed, sensed)), np.finfo(float).tiny))


def _quadratic(normal: FloatArray, vector: FloatArray) -> float:
    return float(vector @ np.linalg.solve(normal, vector)) if vector.size else 0.0
