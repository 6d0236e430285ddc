"""Pitch from one accelerometer with known roll, pitch and roll from two, block by block, with spread and flags.

One output and one roll fit two pitches, β + φ and 180° − β + φ with φ the tilt of the sensitive axis in the plane of
pitch: TP (76) to (82). Two outputs leave a line of possible f that pierces the unit sphere twice: TP (83) to (98),
solved exactly. One of the two is taken as the caller says; where the other answers the caller's description as well,
which happens within the coning angle of the vertical, the row is flagged. With two outputs nothing is left to weigh:
an error of f is B⁻¹ (δv₁, δv₂, 0) with rows k₁, k₂, f of B, and the rank is the determinant of B.
"""

from dataclasses import dataclass, replace

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.attitude.flag_codes import Codes
from ams.attitude.force_covariance import ParameterErrors, monomials, output_polynomials
from ams.attitude.spread import Spread, beside_singular
from ams.attitude.three_axes import (
    CLEARANCE_SD,
    LARGEST_SD_RAD,
    ROOT_CLEARANCE_SD,
    SMALLEST_SLOPE,
    AttitudeColumns,
    blocks,
    turns,
)
from ams.attitude.truncated_pivot import along_distance, factor_across, factor_along, factor_of_root
from ams.errors import DesignError


@dataclass(frozen=True)
class PitchRoots:
    """Pitch of one axis, (n,) each."""

    pitch_rad: FloatArray
    slope_v_per_rad: FloatArray
    amplitude_v: FloatArray
    """Volts of the swing through a full turn of pitch."""
    from_second_rad: FloatArray
    """How far the sensitive axis is from where both roots lie within ±90°; negative: they do, or neither does."""


def pitch_roots(
    k_v_per_g: FloatArray, offset_v: float | FloatArray, output_v: FloatArray, roll: FloatArray
) -> PitchRoots:
    """Return the pitch on the branch on which the sensor's own axis stays within 90° of the horizontal; NaN beyond 1 g.

    ``k_v_per_g`` is (3,) or (3, n). Source: TP (76), (79).
    """
    k_x, k_y, k_z = k_v_per_g
    sign = np.where(np.asarray(k_x) < 0, -1.0, 1.0)
    along, across = sign * k_x, sign * (k_y * np.sin(roll) + k_z * np.cos(roll))
    amplitude = np.hypot(along, across)
    sine = sign * (output_v - offset_v) / amplitude
    branch = np.arcsin(np.where(np.abs(sine) > 1.0, np.nan, sine))
    tilt = np.arctan2(across, along)
    slope = sign * amplitude * np.cos(branch)
    return PitchRoots(branch + tilt, slope, amplitude, np.pi / 2.0 - np.abs(branch) - np.abs(tilt))


@dataclass(frozen=True)
class OneAxis:
    """An accelerometer v = b + k·f near x that stays the same from row to row."""

    k_v_per_g: FloatArray
    """(3,)"""
    offset_v: float
    errors: ParameterErrors
    """Of one output."""

    def attitude(self, output_v: FloatArray, roll_rad: FloatArray, roll_sd_rad: float = 0.0) -> AttitudeColumns:
        """Return pitch of (N,) outputs at (N,) known roll; nothing is redundant."""
        powers, volts2 = output_polynomials(self.errors)
        known = volts2[:, 0, 0].sum(axis=0)
        found = replace(AttitudeColumns.empty(output_v.size), reasons=flag_codes.ONE_AXIS_WORDS)
        for block in blocks(output_v.size):
            roll = roll_rad[block]
            roots = pitch_roots(self.k_v_per_g, self.offset_v, output_v[block], roll)
            pitch = roots.pitch_rad
            sin_roll, cos_roll, cos_pitch = np.sin(roll), np.cos(roll), np.cos(pitch)
            force = np.stack([np.sin(pitch), -cos_pitch * sin_roll, -cos_pitch * cos_roll])
            by_roll = cos_pitch * (self.k_v_per_g[2] * sin_roll - self.k_v_per_g[1] * cos_roll) * roll_sd_rad
            variance = known @ monomials(force, powers) + self.errors.reading_v2[0] + by_roll * by_roll
            with np.errstate(divide="ignore", invalid="ignore"):
                sd = np.sqrt(variance) / np.abs(roots.slope_v_per_rad)
            codes = one_axis_codes(roots, sd, np.isfinite(output_v[block]) & np.isfinite(roll))
            lost = (codes & (flag_codes.LOST | flag_codes.PITCH_SINGULAR)) != 0
            found.pitch_rad[block] = np.where(lost, np.nan, pitch)
            found.pitch_sd_rad[block] = np.where(lost, np.nan, sd)
            found.roll_rad[block], found.roll_sd_rad[block], found.codes[block] = roll, roll_sd_rad, codes
        return found


def one_axis_codes(roots: PitchRoots, sd: FloatArray, is_finite: BoolArray) -> Codes:
    """Return what is wrong with (n,) pitches of one axis."""
    codes = np.zeros(sd.size, dtype=np.uint32)
    with np.errstate(invalid="ignore"):
        from_vertical = np.abs(roots.slope_v_per_rad) / roots.amplitude_v
        flat = (from_vertical < np.maximum(SMALLEST_SLOPE, ROOT_CLEARANCE_SD * sd)) | (sd > LARGEST_SD_RAD)
        codes[roots.from_second_rad <= CLEARANCE_SD * sd] = flag_codes.SECOND_ROOT
    codes[flat] = flag_codes.PITCH_SINGULAR
    codes[np.isnan(roots.pitch_rad)] = flag_codes.BEYOND_ONE_G
    codes[~is_finite] = flag_codes.NOT_FINITE
    return codes


def one_axis_factor(roots: PitchRoots, sd: FloatArray) -> FloatArray:
    """Return what to widen the half-widths of (n,) pitches by next to the bounds of :func:`one_axis_codes`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        from_vertical = np.abs(roots.slope_v_per_rad) / roots.amplitude_v
        by_root = factor_of_root(0.5 * (from_vertical / sd - ROOT_CLEARANCE_SD))
        return np.fmax(by_root, factor_along(roots.from_second_rad / sd - CLEARANCE_SD))


@dataclass(frozen=True)
class TwoAxes:
    """Two accelerometers v = b + k·f that stay the same from row to row."""

    k_v_per_g: FloatArray
    """(2, 3)"""
    offset_v: FloatArray
    """(2,)"""
    errors: ParameterErrors
    is_upright: bool = True
    is_right_wing_down: bool = True

    def attitude(self, outputs_v: FloatArray) -> AttitudeColumns:
        """Return pitch and roll of (2, N) outputs; nothing is redundant. Raises: DesignError for parallel axes."""
        powers, volts2 = output_polynomials(self.errors)
        known = np.stack([volts2[:, 0, 0], volts2[:, 1, 1], volts2[:, 0, 1]], axis=1).sum(axis=0)
        found = AttitudeColumns.empty(outputs_v.shape[1])
        for block in blocks(outputs_v.shape[1]):
            deviation = outputs_v[:, block] - self.offset_v[:, None]
            pierced = pierce(self.k_v_per_g, deviation, self.is_upright, self.is_right_wing_down)
            covariance = known @ monomials(pierced.force, powers)
            covariance[:2] += self.errors.reading_v2[:, None]
            pitch_gain, roll_gain, rank_lost = two_axis_gains(self.k_v_per_g, pierced.force)
            across = turns(pierced.force)[2]
            with np.errstate(divide="ignore", invalid="ignore"):
                pitch_sd, along_sd = (_root(covariance, gain) for gain in (pitch_gain, roll_gain))
                roll_sd = along_sd / across
            codes = two_axis_codes(pierced, pitch_sd, along_sd, across, rank_lost)
            pitch_sd = beside_singular(pitch_sd, along_sd, beside_vertical(pierced, along_sd, across))
            _write(found, block, pierced.force, pitch_sd, roll_sd, codes)
        return found


@dataclass(frozen=True)
class Pierced:
    """Where the line of possible f pierces the unit sphere, of n rows."""

    force: FloatArray
    """(3, n) on the side asked for; NaN beyond one g."""
    length: FloatArray
    """(n,) half of the way to the other one."""
    leading: FloatArray
    """(n,) component of the force that tells the sides, negative on the side asked for."""
    other_leading: FloatArray
    """(n,) the same of the other one."""
    is_finite: BoolArray
    normal: FloatArray
    """(3, n), or (3, 1), across both axes: the direction of the line."""


def pierce(k_v_per_g: FloatArray, deviation_v: FloatArray, is_upright: bool, is_right_wing_down: bool) -> Pierced:
    """Return the attitude of (2, n) outputs less offsets; ``k_v_per_g`` is (2, 3) or (n, 2, 3).

    Upright asks for f_z < 0; where the two attitudes differ in f_y rather than in f_z, right wing down for f_y < 0.
    Raises: DesignError where the axes are parallel.
    """
    k = np.atleast_3d(np.moveaxis(k_v_per_g, (-2, -1), (0, 1)))
    normal = np.cross(k[0], k[1], axis=0)
    area = np.linalg.norm(normal, axis=0)
    if np.any(area < SMALLEST_SLOPE * np.prod(np.linalg.norm(k, axis=1), axis=0)):
        raise DesignError("two-axis package: the two sensitive axes are parallel: they resolve one direction only")
    normal = normal / area
    first, second = np.cross(k[1], normal, axis=0) / area, np.cross(normal, k[0], axis=0) / area
    nearest = deviation_v[0] * first + deviation_v[1] * second
    rest = 1.0 - np.einsum("in,in->n", nearest, nearest)
    length = np.sqrt(np.where(rest < 0.0, np.nan, rest))
    by_z = np.abs(normal[2]) >= np.abs(normal[1])
    sense = np.where(np.where(by_z, is_upright, is_right_wing_down), 1.0, -1.0)
    normal_component = np.where(by_z, normal[2], normal[1])
    side = -np.sign(normal_component) * sense * length
    middle = np.where(by_z, nearest[2], nearest[1])
    leading, other = sense * (middle + side * normal_component), sense * (middle - side * normal_component)
    is_finite = np.asarray(np.isfinite(deviation_v).all(axis=0))
    return Pierced(nearest + side * normal, length, leading, other, is_finite, normal)


def two_axis_gains(k_v_per_g: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return what pitch and cos α·roll take from errors of the two outputs, (2, n) each, and where rank is lost."""
    k = np.atleast_3d(np.moveaxis(k_v_per_g, (-2, -1), (0, 1)))
    meridian, parallel, _ = turns(force)
    first, second = np.cross(k[1], force, axis=0), np.cross(force, k[0], axis=0)
    determinant = np.einsum("in,in->n", np.cross(k[0], k[1], axis=0) + np.zeros_like(force), force)
    squares = np.sum(k**2, axis=1)
    # The product of the singular values over the sum of their squares: their ratio where it is small.
    spread = 2.0 - np.sum(np.einsum("ain,in->an", k + np.zeros_like(force), force) ** 2 / squares, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        rank_lost = ~(np.abs(determinant) >= SMALLEST_SLOPE * spread * np.sqrt(squares[0] * squares[1]))
        gains = [
            np.stack([np.einsum("in,in->n", turn, vector) for vector in (first, second)]) / determinant
            for turn in (meridian, parallel)
        ]
    return gains[0], gains[1], rank_lost


def two_axis_codes(
    pierced: Pierced, pitch_sd: FloatArray, along_sd: FloatArray, across: FloatArray, rank_lost: BoolArray
) -> Codes:
    """Return what is wrong with (n,) attitudes of two axes; ``along_sd`` is that of cos α·roll."""
    codes = np.zeros(pitch_sd.size, dtype=np.uint32)
    with np.errstate(invalid="ignore", divide="ignore"):
        margin = CLEARANCE_SD * np.maximum(pitch_sd, along_sd)
        codes[pierced.other_leading < margin] |= flag_codes.SECOND_ROOT
        codes[~rank_lost & (pierced.leading > np.maximum(margin, 1e-12))] = flag_codes.NO_ROOT
        pitch_lost = rank_lost | ~(pitch_sd <= LARGEST_SD_RAD) | ~(ROOT_CLEARANCE_SD * pitch_sd <= pierced.length)
        roll_lost = (
            rank_lost | ~(along_sd <= LARGEST_SD_RAD * across) | ~(ROOT_CLEARANCE_SD * along_sd <= pierced.length)
        )
        roll_lost |= across < SMALLEST_SLOPE
    codes[pitch_lost & roll_lost] = 0
    codes[pitch_lost] |= flag_codes.PITCH_SINGULAR
    codes[roll_lost] |= flag_codes.ROLL_SINGULAR
    codes[np.isnan(pierced.length)] = flag_codes.BEYOND_ONE_G
    codes[~pierced.is_finite] = flag_codes.NOT_FINITE
    return codes


def two_axis_factors(pierced: Pierced, spread: Spread, across: FloatArray) -> FloatArray:
    """Return what to widen the (n, 2) half-widths of pitch and roll by next to the bounds of :func:`two_axis_codes`.

    Towards where the two attitudes meet the distance is half of the way to the other one; towards the vertical it is
    pitch itself, and roll the angle about it.
    """
    meridian, parallel, _ = turns(pierced.force)
    by_length = np.stack([np.einsum("in,in->n", turn, pierced.normal) for turn in (meridian, parallel)], axis=-1)
    largest = spread.sd.max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        sd, share = along_distance(spread.covariance, by_length)
        root = 0.5 * (pierced.length - ROOT_CLEARANCE_SD * largest) / sd
        second = (pierced.other_leading - CLEARANCE_SD * largest) / sd
        factors = np.fmax(factor_of_root(root[:, None], share), factor_along(second[:, None], share))
        return np.fmax(factors, beside_vertical_factors(spread, across))


def beside_vertical_factors(spread: Spread, across: FloatArray) -> FloatArray:
    """Return what to widen the (n, 2) half-widths of pitch and roll by where roll is only just told."""
    sd, share = along_distance(spread.covariance, np.eye(1, 2).repeat(len(across), axis=0))
    with np.errstate(invalid="ignore", divide="ignore"):
        beyond = (across - spread.sd[:, 1] / LARGEST_SD_RAD) / sd
        factors = factor_along(beyond[:, None], share)
        factors[:, 1] = np.fmax(factors[:, 1], factor_across(across / sd, beyond))
    return factors


def beside_vertical(pierced: Pierced, along_sd: FloatArray, across: FloatArray) -> BoolArray:
    """Return where roll is lost because the vertical is near, not because both attitudes of the two outputs meet.

    Where they meet (an x-y package at ±90° roll) pitch is what x reads, however little is known of roll.
    """
    with np.errstate(invalid="ignore"):
        is_near = ~(along_sd <= LARGEST_SD_RAD * across) | (across < SMALLEST_SLOPE)
        return np.asarray(is_near & (ROOT_CLEARANCE_SD * along_sd <= pierced.length))


def _write(
    found: AttitudeColumns, block: slice, force: FloatArray, pitch_sd: FloatArray, roll_sd: FloatArray, codes: Codes
) -> None:
    across = np.hypot(force[1], force[2])
    pitch, roll = np.arctan2(force[0], across), np.arctan2(-force[1], -force[2])
    for code, angle, sd in (
        (flag_codes.PITCH_SINGULAR, pitch, pitch_sd),
        (flag_codes.ROLL_SINGULAR, roll, roll_sd),
    ):
        gone = (codes & (flag_codes.LOST | code)) != 0
        angle[gone], sd[gone] = np.nan, np.nan
    found.pitch_rad[block], found.pitch_sd_rad[block] = pitch, pitch_sd
    found.roll_rad[block], found.roll_sd_rad[block] = roll, roll_sd
    found.codes[block] = codes


def _root(covariance: FloatArray, gain: FloatArray) -> FloatArray:
    """Return the root of gᵀCg for (3, n) elements 11, 22, 12 and (2, n) gains."""
    first, second = gain
    square = covariance[0] * first * first + covariance[1] * second * second + 2.0 * covariance[2] * first * second
    return np.asarray(np.sqrt(square))
