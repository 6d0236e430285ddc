"""Pitch and roll at rest from the outputs of one, two or three accelerometers.

Every sensor reads v = b + k·f with f the specific force in package axes, |f| = 1. Known: (b, k) with their covariance
and the standard deviation of a reading where the set is used. Sought: the attitude. One sensor with known roll has the
closed form TP (76), (79); two sensors leave a line of possible f that pierces the unit sphere twice (closed form, TP
(83) to (98) solved exactly); three are a weighted least-squares problem, TP (99) to (108).

Every angle comes with its standard deviation and a flag. Where the geometry is singular the angle is NaN and the flag
says why: there is no silent number. Pitch is given in ±90°; (180° − α, R + 180°) is the same attitude of gravity.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude.spread import PackageErrors, Spread, UncertainSensor, output_errors, weighing_variances
from ams.errors import DesignError
from ams.frames import specific_force, specific_force_by_pitch, specific_force_by_roll
from ams.statistics.intervals import reading_halfwidth, t_quantile

LARGEST_SD_RAD: Final = float(np.deg2rad(5.0))
"""Above this standard deviation the linear propagation means nothing and the angle is called singular."""
SMALLEST_SLOPE: Final = 1e-6
"""Relative slope of outputs against angle below which an angle is singular whatever the noise."""
CLEARANCE_SD: Final = 3.0
"""An angle closer to the singular attitude than this many of its standard deviations is called singular."""
_ITERATIONS: Final = 20


class Sensor(UncertainSensor, Protocol):
    """A calibrated accelerometer as the inference sees it."""

    @property
    def offset_v(self) -> float | FloatArray:
        """Volts; (N,) where every reading is of a sensor of its own."""

    @property
    def k_v_per_g(self) -> FloatArray:
        """(3,), or (N, 3), in package axes, per local g of specific force."""

    def output_variance_v2(self, force: FloatArray) -> FloatArray:
        """(N,) variance of prediction plus reading at (N, 3) specific force."""


@dataclass(frozen=True)
class Angles:
    """Inferred angles, all arrays (N,), NaN where the flag is not empty."""

    pitch_rad: FloatArray
    pitch_sd_rad: FloatArray
    roll_rad: FloatArray
    roll_sd_rad: FloatArray
    flags: tuple[str, ...]
    """Empty where all is well, else the reason in words; roll alone may be missing."""
    pitch_half_95_rad: FloatArray
    """Half-width of the 95 % interval, with Student's factor for what the calibration rests on."""
    roll_half_95_rad: FloatArray


def pitch_with_known_roll(
    sensor: Sensor, output_v: FloatArray, roll_rad: FloatArray, roll_sd_rad: float = 0.0
) -> Angles:
    """Pitch from one sensor near x, roll known (zero for a package without roll). Source: TP (76) to (82).

    The branch is the one on which the sensor's own axis stays within 90° of the horizontal.
    """
    output, roll = np.broadcast_arrays(np.asarray(output_v, dtype=float), np.asarray(roll_rad, dtype=float))
    k_x, k_y, k_z = np.moveaxis(sensor.k_v_per_g, -1, 0)
    sign = np.where(k_x < 0, -1.0, 1.0)
    along, across = sign * k_x, sign * (k_y * np.sin(roll) + k_z * np.cos(roll))
    amplitude = np.hypot(along, across)
    sine = sign * (output - sensor.offset_v) / amplitude
    beyond = np.abs(sine) > 1.0
    pitch = np.arcsin(np.where(beyond, np.nan, sine)) + np.arctan2(across, along)
    force = specific_force(pitch, roll)
    slope = np.sum(specific_force_by_pitch(pitch, roll) * sensor.k_v_per_g, axis=-1)
    by_roll = np.sum(specific_force_by_roll(pitch, roll) * sensor.k_v_per_g, axis=-1)
    by_roll_v2 = (by_roll * roll_sd_rad) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt(sensor.output_variance_v2(force) + by_roll_v2) / np.abs(slope)
        half_95 = _known_roll_halfwidth(sensor, force, by_roll_v2) / np.abs(slope)
    from_vertical = np.abs(slope) / amplitude
    flat = (from_vertical < np.maximum(SMALLEST_SLOPE, CLEARANCE_SD * sd)) | (sd > LARGEST_SD_RAD)
    flags = _flags((beyond, "output beyond one g"), (flat, "pitch singular: sensor axis vertical"))
    lost = beyond | flat
    roll_sd = np.full(roll.shape, float(roll_sd_rad))
    halves = (_blank(half_95, lost), t_quantile(0.95, np.inf) * roll_sd)
    return Angles(_blank(pitch, lost), _blank(sd, lost), np.array(roll), roll_sd, flags, *halves)


def _known_roll_halfwidth(sensor: Sensor, force: FloatArray, by_roll_v2: FloatArray) -> FloatArray:
    """(N,) volts."""
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
    """Pitch and roll from two sensors, ``outputs_v`` (N, 2). Source: TP (83) to (98), solved in closed form.

    Two outputs fit two attitudes. Of these the one with f_z < 0 (roll within ±90°) is taken for ``upright``; where the
    two differ in f_y rather than in f_z (an x-z package), the one with f_y < 0 for ``right_wing_down``.
    """
    K, offsets = _stack(sensors, 2)
    normal = np.cross(K[..., 0, :], K[..., 1, :])
    area = np.linalg.norm(normal, axis=-1, keepdims=True)
    if np.any(area[..., 0] < SMALLEST_SLOPE * np.prod(np.linalg.norm(K, axis=-1), axis=-1)):
        raise DesignError("two-axis package: the two sensitive axes are parallel: they resolve one direction only")
    normal = normal / area
    nearest = _times(np.asarray(np.linalg.pinv(K), dtype=np.float64), np.atleast_2d(outputs_v) - offsets)
    rest = 1.0 - np.sum(nearest**2, axis=1)
    beyond = rest < 0.0
    length = np.sqrt(np.where(beyond, np.nan, rest))
    by_z = np.abs(normal[..., 2]) >= np.abs(normal[..., 1])
    leading = np.where(by_z, normal[..., 2], normal[..., 1])
    side = np.sign(leading) * np.where(np.where(by_z, upright, right_wing_down), -1.0, 1.0)
    force = nearest + (side * length)[:, None] * normal
    return _judged(sensors, package, force, beyond, clearance_rad=length)


def pitch_roll_from_three(
    sensors: Sequence[Sensor], outputs_v: FloatArray, package: PackageErrors | None = None
) -> Angles:
    """Pitch and roll from three sensors, ``outputs_v`` (N, 3), by weighted least squares. Source: TP (99) to (108)."""
    K, offsets = _stack(sensors, 3)
    volts = np.atleast_2d(outputs_v) - offsets
    if np.any(np.abs(np.linalg.det(K)) < SMALLEST_SLOPE * np.prod(np.linalg.norm(K, axis=-1), axis=-1)):
        raise DesignError("three-axis package: the three sensitive axes lie in one plane: use two of them")
    force = np.linalg.solve(K, volts[..., None])[..., 0]
    length = np.linalg.norm(force, axis=1, keepdims=True)
    weights = 1.0 / np.maximum(weighing_variances(sensors, K, force / length), np.finfo(float).tiny)
    unit, settled = onto_unit_sphere(K, volts, weights, force / length)
    everywhere = np.full(unit.shape[0], np.pi)
    return _judged(sensors, package, unit, np.zeros_like(settled), clearance_rad=everywhere, unsettled=~settled)


def onto_unit_sphere(
    K: FloatArray, volts: FloatArray, weights: FloatArray, force: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Gauss-Newton for the unit f that fits best, in tangent coordinates: regular even at α = ±90°.

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
    """(N, i) from (i, j) or (N, i, j) and (N, j)."""
    return np.asarray((K @ vectors[..., None])[..., 0])


def tangents(force: FloatArray) -> FloatArray:
    """Two orthonormal directions across each unit vector, (N, 3, 2)."""
    aside = np.zeros_like(force)
    aside[np.arange(force.shape[0]), np.argmin(np.abs(force), axis=1)] = 1.0
    first = np.cross(force, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(force, first)], axis=-1)


def _judged(
    sensors: Sequence[Sensor],
    package: PackageErrors | None,
    force: FloatArray,
    beyond: BoolArray,
    *,
    clearance_rad: FloatArray,
    unsettled: BoolArray | None = None,
) -> Angles:
    """Angles of the unit force with their standard deviations, by TP (89), (90), (103), (104)."""
    pitch = np.arctan2(force[:, 0], np.hypot(force[:, 1], force[:, 2]))
    roll = np.arctan2(-force[:, 1], -force[:, 2])
    spread, pitch_lost, roll_lost = _spread(sensors, package, pitch, roll, beyond)
    pitch_sd, roll_sd = spread.sd.T
    pitch_lost = pitch_lost | ~(CLEARANCE_SD * pitch_sd <= clearance_rad)
    roll_lost = roll_lost | ~(CLEARANCE_SD * roll_sd * np.cos(pitch) <= clearance_rad)
    unsettled = np.zeros_like(beyond) if unsettled is None else unsettled
    fine = ~beyond & ~unsettled
    flags = _flags(
        (beyond, "outputs beyond one g"),
        (unsettled, "no solution: iteration did not settle"),
        (fine & pitch_lost & roll_lost, "pitch and roll singular"),
        (fine & pitch_lost & ~roll_lost, "pitch singular"),
        (fine & roll_lost & ~pitch_lost, "roll singular"),
    )
    lost_pitch, lost_roll = pitch_lost | ~fine, roll_lost | ~fine
    return Angles(
        _blank(pitch, lost_pitch),
        _blank(pitch_sd, lost_pitch),
        _blank(roll, lost_roll),
        _blank(roll_sd, lost_roll),
        flags,
        _blank(spread.half_95[:, 0], lost_pitch),
        _blank(spread.half_95[:, 1], lost_roll),
    )


def _spread(
    sensors: Sequence[Sensor], package: PackageErrors | None, pitch: FloatArray, roll: FloatArray, beyond: BoolArray
) -> tuple[Spread, BoolArray, BoolArray]:
    """Standard deviations and intervals, and where pitch or roll is singular.

    The angles are taken as turns of f: pitch along the meridian, cos α·roll along the parallel. These stay regular at
    α = ±90° when the sensors resolve both, and roll alone is lost there.
    """
    K, _ = _stack(sensors, len(sensors))
    safe_pitch, safe_roll = np.where(beyond, 0.0, pitch), np.where(beyond, 0.0, roll)
    force = specific_force(safe_pitch, safe_roll)
    along_roll = np.stack([np.zeros_like(roll), -np.cos(safe_roll), np.sin(safe_roll)], axis=-1)
    J = np.stack([_times(K, specific_force_by_pitch(safe_pitch, safe_roll)), _times(K, along_roll)], axis=-1)
    floor = np.max(K**2) * np.finfo(float).tiny / np.finfo(float).eps
    weights = 1.0 / np.maximum(weighing_variances(sensors, K, force), floor)
    singular_values = np.linalg.svd(J / np.linalg.norm(K, axis=-1)[..., None], compute_uv=False)
    rank_lost = singular_values[:, 1] < SMALLEST_SLOPE * singular_values[:, 0]
    weighted = np.swapaxes(J, -1, -2) * weights[:, None, :]
    normal = weighted @ J
    normal[rank_lost] = np.eye(2)
    turns = output_errors(sensors, force, package).of_angles(
        np.asarray(np.linalg.solve(normal, weighted), dtype=np.float64)
    )
    cos_pitch = np.cos(safe_pitch)
    with np.errstate(divide="ignore", invalid="ignore"):
        in_angles = np.stack([np.ones_like(cos_pitch), 1.0 / cos_pitch], axis=-1)
        spread = Spread(turns.sd * in_angles, turns.half_95 * in_angles)
    pitch_lost = rank_lost | (spread.sd[:, 0] > LARGEST_SD_RAD)
    roll_lost = rank_lost | ~(spread.sd[:, 1] <= LARGEST_SD_RAD) | (cos_pitch < SMALLEST_SLOPE)
    return spread, pitch_lost, roll_lost


def _stack(sensors: Sequence[Sensor], count: int) -> tuple[FloatArray, FloatArray]:
    if len(sensors) != count:
        raise DesignError(f"attitude: got {len(sensors)} sensors, needed {count}")
    K = np.stack([sensor.k_v_per_g for sensor in sensors], axis=-2)
    return K, np.stack([np.asarray(sensor.offset_v) for sensor in sensors], axis=-1)


def _blank(values: FloatArray, lost: BoolArray) -> FloatArray:
    return np.where(lost, np.nan, values)


def _flags(*reasons: tuple[BoolArray, str]) -> tuple[str, ...]:
    chosen = np.full(np.shape(reasons[0][0]), "", dtype=object)
    for where, words in reversed(reasons):
        chosen[where] = words
    return tuple(str(flag) for flag in np.atleast_1d(chosen))
