"""Pitch and roll at rest from the outputs of one, two or three accelerometers.

Every sensor reads v = b + k·f with f the specific force in package axes, |f| = 1. Known: (b, k) with their covariance
and the standard deviation of a reading where the set is used. Sought: the attitude. One sensor with known roll has the
closed form TP (76), (79); two sensors leave a line of possible f that pierces the unit sphere twice (closed form, TP
(83) to (98) solved exactly); three are a weighted least-squares problem, TP (99) to (108).

The solutions are those of :mod:`ams.attitude.three_axes` and :mod:`ams.attitude.few_axes`; here sensors of every kind
are asked at every attitude for what is not known of them, and intervals stand beside the standard deviations. Every
angle comes with its standard deviation and a flag. Where the geometry is singular the angle is NaN and the flag
says why: there is no silent number. Pitch is given in ±90°; (180° − α, R + 180°) is the same attitude of gravity.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.attitude.few_axes import (
    beside_vertical,
    beside_vertical_factors,
    one_axis_codes,
    one_axis_factor,
    pierce,
    pitch_roots,
    two_axis_codes,
    two_axis_factors,
    two_axis_gains,
)
from ams.attitude.force_covariance import PACKED, PackedWeighing
from ams.attitude.spread import (
    PackageErrors,
    PredictionErrors,
    Spread,
    UncertainSensor,
    beside_singular,
    output_errors,
    weighing_variances,
)
from ams.attitude.three_axes import (
    CLEARANCE_SD,
    LARGEST_SD_RAD,
    SMALLEST_SLOPE,
    AttitudeColumns,
    check_three_directions,
    fitted,
    gains,
    judged_into,
    turns,
)
from ams.errors import DesignError
from ams.frames import specific_force, specific_force_by_roll
from ams.remembered import remembered
from ams.statistics.intervals import reading_halfwidth, t_quantile, tabled_t_quantile

__all__ = [
    "CLEARANCE_SD",
    "LARGEST_SD_RAD",
    "SMALLEST_SLOPE",
    "Angles",
    "Sensor",
    "onto_unit_sphere",
    "pitch_roll_from_three",
    "pitch_roll_from_two",
    "pitch_with_known_roll",
    "redundancy_limit",
    "tangents",
]


_ITERATIONS: Final = 20
_LEVEL: Final = 0.999
_STRICTNESS: Final = 0.6


class Sensor(UncertainSensor, Protocol):
    """A calibrated accelerometer as the inference sees it."""

    @property
    def offset_v(self) -> float | FloatArray:
        """Volts; (N,) where every reading is of a sensor of its own."""

    @property
    def k_v_per_g(self) -> FloatArray:
        """(3,), or (N, 3), in package axes, per local g of specific force."""

    def output_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the (N,) variance of prediction plus reading at (N, 3) specific force."""


@dataclass(frozen=True)
class Angles:
    """Inferred angles, all arrays (N,), NaN where they are lost; the flag then says why."""

    pitch_rad: FloatArray
    pitch_sd_rad: FloatArray
    roll_rad: FloatArray
    roll_sd_rad: FloatArray
    codes: flag_codes.Codes
    """0 where all is well, else the reasons; roll alone may be missing. Where outputs disagree, or a second attitude
    answers them as well, the angles stand with the flag beside them."""
    pitch_half_95_rad: FloatArray
    """Half-width of the 95 % interval, with Student's factor for what the calibration rests on."""
    roll_half_95_rad: FloatArray
    reasons: Mapping[int, str] = field(default_factory=lambda: flag_codes.WORDS)
    """What the codes mean."""

    @property
    def flags(self) -> tuple[str, ...]:
        """The codes in words."""
        return flag_codes.words(self.codes, self.reasons)


def pitch_with_known_roll(
    sensor: Sensor, output_v: FloatArray, roll_rad: FloatArray, roll_sd_rad: float = 0.0
) -> Angles:
    """Find pitch from one sensor near x, roll known (zero for a package without roll). Source: TP (76) to (82).

    The branch is the one on which the sensor's own axis stays within 90° of the horizontal; a row in which the other
    one lies within ±90° of pitch as well, or neither does, is flagged.
    """
    output, roll = np.broadcast_arrays(np.asarray(output_v, dtype=float), np.asarray(roll_rad, dtype=float))
    k = np.moveaxis(sensor.k_v_per_g, -1, 0)
    roots = pitch_roots(k, sensor.offset_v, output, roll)
    force = specific_force(roots.pitch_rad, roll)
    by_roll = np.sum(specific_force_by_roll(roots.pitch_rad, roll) * sensor.k_v_per_g, axis=-1)
    by_roll_v2 = (by_roll * roll_sd_rad) ** 2
    slope = np.abs(roots.slope_v_per_rad)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt(sensor.output_variance_v2(force) + by_roll_v2) / slope
        half_95 = one_axis_factor(roots, sd) * _known_roll_halfwidth(sensor, force, by_roll_v2) / slope
    codes = one_axis_codes(roots, sd, np.isfinite(output) & np.isfinite(roll))
    lost = (codes & (flag_codes.LOST | flag_codes.PITCH_SINGULAR)) != 0
    roll_sd = np.full(roll.shape, float(roll_sd_rad))
    return Angles(
        _blank(roots.pitch_rad, lost),
        _blank(sd, lost),
        np.array(roll),
        roll_sd,
        codes,
        _blank(half_95, lost),
        t_quantile(0.95, np.inf) * roll_sd,
        flag_codes.ONE_AXIS_WORDS,
    )


def _known_roll_halfwidth(sensor: Sensor, force: FloatArray, by_roll_v2: FloatArray) -> FloatArray:
    """Return the (N,) half-width in volts where roll is known."""
    parts = sensor.calibration_parts(force)
    reading = sensor.reading_variance_v2(force) + by_roll_v2
    return reading_halfwidth([variance for variance, _ in parts], [dof for _, dof in parts], reading)


def pitch_roll_from_two(
    sensors: Sequence[Sensor],
    outputs_v: FloatArray,
    *,
    upright: bool = True,
    right_wing_down: bool = True,
    package: PackageErrors | None = None,
) -> Angles:
    """Find pitch and roll from two sensors, ``outputs_v`` (N, 2). Source: TP (83) to (98), solved in closed form.

    Two outputs fit two attitudes. Of these the one with f_z < 0 (roll within ±90°) is taken for ``upright``; where the
    two differ in f_y rather than in f_z (an x-z package), the one with f_y < 0 for ``right_wing_down``. A row in which
    both, or neither, answer that is flagged.
    """
    K, offsets = _stack(sensors, 2)
    pierced = pierce(K, (np.atleast_2d(outputs_v) - offsets).T, upright, right_wing_down)
    force = np.where(np.isnan(pierced.force), np.array([[0.0], [0.0], [-1.0]]), pierced.force)
    pitch_gain, roll_gain, rank_lost = two_axis_gains(K, force)
    across = turns(force)[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(rank_lost, np.nan, np.stack([pitch_gain, roll_gain]))
        spread = output_errors(sensors, force.T, package).of_angles(np.moveaxis(gain, -1, 0))
    codes = two_axis_codes(pierced, spread.sd[:, 0], spread.sd[:, 1], across, rank_lost)
    factors = two_axis_factors(pierced, spread, across)
    is_vertical = beside_vertical(pierced, spread.sd[:, 1], across)
    return _angles(pierced.force, spread, across, codes, is_vertical, factors)


def pitch_roll_from_three(
    sensors: Sequence[Sensor],
    outputs_v: FloatArray,
    package: PackageErrors | None = None,
    *,
    gravity_relative_u: float = 0.0,
) -> Angles:
    """Find pitch and roll from three sensors, ``outputs_v`` (N, 3). Source: TP (99) to (108).

    They are found by weighted least squares.

    Rows whose outputs disagree are flagged, by Student's t at 99.9 %; ``gravity_relative_u`` is the uncertainty of
    gravity where the sensors are used, over gravity.
    """
    K, offsets = _stack(sensors, 3)
    check_three_directions(K)
    volts = np.atleast_2d(outputs_v) - offsets
    errors = _SampledErrors(sensors, package, K, np.asarray(np.linalg.inv(K), dtype=np.float64), len(volts))
    sensed = np.ascontiguousarray(_times(errors.inverse, volts).T)
    found = AttitudeColumns.empty(sensed.shape[1])
    force, weighing, codes = fitted(sensed, errors)
    judged_into(found, slice(None), (sensed, force, weighing, codes), errors, redundancy_limit, gravity_relative_u)
    safe = np.where(np.isfinite(force), force, np.array([[0.0], [0.0], [-1.0]]))
    meridian, parallel, across = turns(safe)
    gain = np.stack(gains(safe, meridian, parallel, weighing.times(safe)))
    spread = output_errors(sensors, safe.T, package).of_angles(np.moveaxis(gain, -1, 0) @ errors.inverse)
    roll_lost = (found.codes & (flag_codes.LOST | flag_codes.ROLL_SINGULAR)) != 0
    return _angles(force, spread, across, found.codes, roll_lost, beside_vertical_factors(spread, across))


def redundancy_limit(variances: FloatArray, dof: FloatArray) -> FloatArray:
    """Return what Student's t stays within in 99.9 %, for (C, m) parts of a variance with their degrees of freedom.

    So far out Welch and Satterthwaite's degrees of freedom are too generous (0.7 % of alarms instead of 0.1 % where a
    part with three is nearly all), Cochran and Cox's mean of Student's factors too strict (0.02 %). Between the two,
    four or more degrees of freedom raise 0.04 to 0.2 %, three 0.03 to 0.3 % (simulated at all shares of the parts).
    """
    total = variances.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        generous = tabled_t_quantile(_LEVEL, total**2 / np.sum(variances**2 / dof, axis=0))
        strict = np.sum(variances * _factors(dof), axis=0) / total
    return np.asarray(generous ** (1.0 - _STRICTNESS) * strict**_STRICTNESS)


@remembered(8)
def _factors(dof: FloatArray) -> FloatArray:
    """Return Student's factors; the degrees of freedom of sensors that stay the same are those of every block."""
    return t_quantile(_LEVEL, dof)


@dataclass(frozen=True)
class _SampledErrors:
    """The errors of sensors of any kind, asked at every attitude."""

    sensors: Sequence[Sensor]
    package: PackageErrors | None
    k_v_per_g: FloatArray
    inverse: FloatArray
    """(3, 3) or (N, 3, 3)."""
    rows: int

    def total(self, force: FloatArray) -> FloatArray:
        return np.asarray(np.sum(self._parts(force), axis=0))

    def parts(self, force: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
        return np.stack([part[:, rows] for part in self._parts(force)])

    def dof(self, rows: NDArray[np.intp]) -> FloatArray:
        level = np.tile([0.0, 0.0, -1.0], (self.rows, 1))
        stated = [np.asarray(dof) for _, dof in self._of_outputs(level).calibration]
        return np.stack([*(dof[rows] if dof.ndim else np.full(rows.size, dof) for dof in stated),
                         np.full(rows.size, np.inf)])  # fmt: skip

    def weighing(self, sensed: FloatArray, square: FloatArray) -> PackedWeighing:
        variances = weighing_variances(self.sensors, self.k_v_per_g, (sensed / np.sqrt(square)).T)
        variances = np.where(variances.any(axis=1, keepdims=True), variances, 1.0)
        return PackedWeighing(self._packed(variances[..., None] * np.eye(3)))

    def _parts(self, force: FloatArray) -> list[FloatArray]:
        errors = self._of_outputs(force.T)
        covariances = [covariance for covariance, _ in errors.calibration]
        return [self._packed(part) for part in (*covariances, errors.reading[..., None] * np.eye(3))]

    def _of_outputs(self, force: FloatArray) -> PredictionErrors:
        return output_errors(self.sensors, force, self.package)

    def _packed(self, of_outputs: FloatArray) -> FloatArray:
        in_force = self.inverse @ of_outputs @ np.swapaxes(self.inverse, -1, -2)
        return np.stack([in_force[..., a, b] for a, b in PACKED])


def onto_unit_sphere(
    K: FloatArray, volts: FloatArray, weights: FloatArray, force: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Find the unit f that fits best, by Gauss-Newton in tangent coordinates: regular even at α = ±90°.

    ``K`` is (S, 3), or (N, S, 3) where every reading is of a package of its own.
    """
    relative = weights / weights.max(axis=1, keepdims=True)
    change = np.full(force.shape[0], np.inf)
    for _ in range(_ITERATIONS):
        tangent = tangents(force)
        J = K @ tangent
        residual = volts - _times(K, force)
        normal = np.einsum("nis,ni,nit->nst", J, relative, J)
        gradient = np.einsum("nis,ni,ni->ns", J, relative, residual)
        step = np.linalg.solve(normal, gradient[..., None])[..., 0]
        moved = force + np.einsum("njt,nt->nj", tangent, step)
        force = moved / np.linalg.norm(moved, axis=1, keepdims=True)
        change = np.linalg.norm(step, axis=1)
        if np.all(change < 1e-13):
            break
    return force, np.asarray(change < 1e-9)


def _times(K: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return the products (N, i) of (i, j) or (N, i, j) and (N, j)."""
    return np.asarray((K @ vectors[..., None])[..., 0])


def tangents(force: FloatArray) -> FloatArray:
    """Return two orthonormal directions across each unit vector, (N, 3, 2)."""
    aside = np.zeros_like(force)
    aside[np.arange(force.shape[0]), np.argmin(np.abs(force), axis=1)] = 1.0
    first = np.cross(force, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(force, first)], axis=-1)


def _angles(
    force: FloatArray,
    spread: Spread,
    across: FloatArray,
    codes: flag_codes.Codes,
    is_vertical: BoolArray,
    factors: FloatArray,
) -> Angles:
    """Return the angles of (3, N) unit forces; the spread of roll is that along the parallel, cos α·roll.

    ``factors`` (N, 2) widen the half-widths of pitch and roll next to the bounds beyond which they are told.
    """
    pitch, roll = np.arctan2(force[0], np.hypot(force[1], force[2])), np.arctan2(-force[1], -force[2])
    pitch_lost, roll_lost = (
        (codes & (flag_codes.LOST | code)) != 0 for code in (flag_codes.PITCH_SINGULAR, flag_codes.ROLL_SINGULAR)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        in_angles = np.stack([np.ones_like(across), 1.0 / across], axis=-1)
        sd, half_95 = spread.sd * in_angles, spread.half_95 * in_angles
    pitch_sd, pitch_half = (
        beside_singular(pair[:, 0], pair[:, 1], is_vertical) for pair in (spread.sd, spread.half_95)
    )
    pitch_half, roll_half = pitch_half * np.where(is_vertical, 1.0, factors[:, 0]), half_95[:, 1] * factors[:, 1]
    return Angles(
        _blank(pitch, pitch_lost),
        _blank(pitch_sd, pitch_lost),
        _blank(roll, roll_lost),
        _blank(sd[:, 1], roll_lost),
        codes,
        _blank(pitch_half, pitch_lost),
        _blank(roll_half, roll_lost),
    )


def _stack(sensors: Sequence[Sensor], count: int) -> tuple[FloatArray, FloatArray]:
    if len(sensors) != count:
        raise DesignError(f"attitude: got {len(sensors)} sensors, needed {count}")
    K = np.stack([sensor.k_v_per_g for sensor in sensors], axis=-2)
    return K, np.stack([np.asarray(sensor.offset_v) for sensor in sensors], axis=-1)


def _blank(values: FloatArray, lost: BoolArray) -> FloatArray:
    return np.where(lost, np.nan, values)
