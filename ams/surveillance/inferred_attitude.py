"""What a set tells of outputs that were measured at a known attitude: the angles that its user would have inferred.

Angles are inferred whole and not by the slope at the known attitude: with a gain that is off by 1 % the square of the
error is larger than the uncertainty. One axis tells pitch, roll being known (TP (76), (79)); three have a least-squares
solution; two leave a line of possible forces that pierces the unit sphere twice (TP (83) to (98)), of which the
attitude nearer to the known one counts.

Where both attitudes of two axes meet (x and y at roll ±90°, x and z at roll 0°) the component n across both axes is not
determined: one reading holds all f = p + L n up to the sphere, L² = 1 − |p|². An angle that n hardly moves is told all
the same, with ±L of n in its uncertainty, and any other is not determined. Where the gain of the set is too small p
lies beyond the sphere: those outputs are of no attitude, and no angle is told. Next to the vertical, where roll is not
determined, the error of pitch is the angle from the vertical, whatever it leans to.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude.three_axes import turns
from ams.frames import specific_force
from ams.inference.package.calibrated import CalibratedSensor

LARGEST_AMPLIFICATION: Final = 10.0
"""Points where an angle's error would be more than so many times that of an output at full slope are left out."""
_CLEAR_SD: Final = 10.0
"""The two attitudes of two axes are told apart where 1 − |p|² is so many of half its standard deviations."""
_POSSIBLE_SD: Final = 3.0
"""Outputs that are beyond one g by more standard deviations are of no attitude."""
_STEPS: Final = 6
_SMALLEST_COSINE: Final = 1e-12
SpreadOf = Callable[[FloatArray], FloatArray]
"""(K, m, A) angles per volt to (K, m) standard uncertainties, radians."""


@dataclass(frozen=True)
class InferredAngle:
    """One angle at K points; NaN where it is not determined."""

    error_rad: FloatArray
    """(K,) inferred minus true."""
    gain: FloatArray
    """(K, 2, A) radians per volt, along the angle and, next to the vertical, across it; else zero across."""
    known_rad: FloatArray
    """(K,) standard uncertainty of which of two attitudes, type B."""


@dataclass(frozen=True)
class Readings:
    """Mean outputs of A sensors at K known attitudes."""

    sensors: Sequence[CalibratedSensor]
    """Of the set that is asked."""
    deviation_v: FloatArray
    """(K, A) at the reference temperature, less offsets."""
    pitch_rad: FloatArray
    roll_rad: FloatArray

    @property
    def k(self) -> FloatArray:
        return np.stack([sensor.k_v_per_g for sensor in self.sensors])

    @property
    def force(self) -> FloatArray:
        """(K, 3) at the known attitudes."""
        return specific_force(self.pitch_rad, self.roll_rad)

    def solved(self, solve: Callable[[FloatArray, FloatArray], FloatArray]) -> FloatArray:
        """Return (K, 3) what ``solve`` makes of deviations less their terms of higher order, and the force before."""
        force = known = self.force
        for _ in range(_STEPS):
            at = np.where(np.isnan(force), known, force)
            bend = np.stack([sensor.quadratic_v(at) for sensor in self.sensors], axis=-1)
            force = solve(self.deviation_v - bend, at)
        return force


def inferred_angles(readings: Readings, spread_of: SpreadOf) -> dict[str, InferredAngle]:
    """Return the angles that a set tells of readings; ``spread_of``: what is not known of them."""
    count = len(readings.sensors)
    if count == 1:
        return {"pitch": _one_axis(readings)}
    return _two_axes(readings, spread_of) if count == 2 else _three_axes(readings)


def _one_axis(readings: Readings) -> InferredAngle:
    """TP (76), (79): v − b = A sin(α − φ), on the side on which the known pitch is."""
    k_x, k_y, k_z = readings.k[0]
    across = k_y * np.sin(readings.roll_rad) + k_z * np.cos(readings.roll_rad)
    amplitude, tilt = np.hypot(k_x, across), np.arctan2(across, k_x)
    is_facing = np.cos(readings.pitch_rad - tilt) >= 0.0

    def solve(deviation: FloatArray, _: FloatArray) -> FloatArray:
        sine = deviation[:, 0] / amplitude
        near = np.arcsin(np.where(np.abs(sine) <= 1.0, sine, np.nan))
        return specific_force(np.where(is_facing, near, np.pi - near) + tilt, readings.roll_rad)

    force = readings.solved(solve)
    sin_roll, cos_roll = np.sin(readings.roll_rad), np.cos(readings.roll_rad)
    pitch = np.arctan2(force[:, 0], -force[:, 1] * sin_roll - force[:, 2] * cos_roll)
    slope = amplitude * np.cos(pitch - tilt)
    size = np.linalg.norm(readings.k[0]) / LARGEST_AMPLIFICATION
    is_determined = (np.abs(slope) >= size) & (np.abs(amplitude * np.cos(readings.pitch_rad - tilt)) >= size)
    gain = np.zeros((len(slope), 2, 1))
    gain[:, 0, 0] = 1.0 / np.where(is_determined, slope, np.nan)
    return _kept(InferredAngle(_turned(pitch - readings.pitch_rad), gain, np.zeros(len(slope))), is_determined)


def _three_axes(readings: Readings) -> dict[str, InferredAngle]:
    """Least squares over outputs at full scale each, from the known attitude on."""
    k, scale = readings.k, np.linalg.norm(readings.k, axis=1)

    def solve(deviation: FloatArray, force: FloatArray) -> FloatArray:
        gain, turn, _ = _gains(force, k, scale)
        step = np.einsum("nsa,na->ns", gain, deviation - force @ k.T)
        moved = force + np.einsum("ns,nsi->ni", step, turn)
        return np.asarray(moved / np.linalg.norm(moved, axis=1, keepdims=True))

    return _regular(readings, readings.solved(solve), scale)


def _two_axes(readings: Readings, spread_of: SpreadOf) -> dict[str, InferredAngle]:
    k, scale, known = readings.k, np.linalg.norm(readings.k, axis=1), readings.force
    inverse = np.linalg.pinv(k)
    normal = np.cross(k[0], k[1])
    normal /= np.linalg.norm(normal)
    towards = known @ normal
    side = np.where(towards < 0.0, -1.0, 1.0)

    def nearest(deviation: FloatArray) -> tuple[FloatArray, FloatArray]:
        p = deviation @ inverse.T
        return p, 1.0 - np.sum(p**2, axis=1)

    def solve(deviation: FloatArray, _: FloatArray) -> FloatArray:
        p, rest = nearest(deviation)
        return np.asarray(p + (side * np.sqrt(np.where(rest < 0.0, np.nan, rest)))[:, None] * normal)

    force = readings.solved(solve)
    at = np.where(np.isnan(force), known, force)
    bend = np.stack([sensor.quadratic_v(at) for sensor in readings.sensors], axis=-1)
    p, rest = nearest(readings.deviation_v - bend)
    half_sd = spread_of((p @ inverse)[:, None, :])[:, 0]
    length = np.sqrt(np.maximum(rest, 0.0))
    is_apart = (rest >= _CLEAR_SD * half_sd) & (rest > 0.0) & (2.0 * np.abs(towards) >= length)
    is_possible = rest + 2.0 * _POSSIBLE_SD * half_sd >= 0.0
    furthest = np.sqrt(np.maximum(rest, 0.0) + 2.0 * _POSSIBLE_SD * half_sd)
    regular = _regular(readings, np.where(is_apart[:, None], force, np.nan), scale)
    meeting = _meeting(readings, p, furthest * normal[:, None], inverse * scale)
    chosen = {}
    for angle, apart in regular.items():
        met = _kept(meeting[angle], is_possible & ~is_apart)
        pairs = zip(
            (apart.error_rad, apart.gain, apart.known_rad), (met.error_rad, met.gain, met.known_rad), strict=True
        )
        chosen[angle] = InferredAngle(
            *(np.where(is_apart.reshape(-1, *[1] * (far.ndim - 1)), far, near) for far, near in pairs)
        )
    return chosen


def _meeting(readings: Readings, p: FloatArray, reach: FloatArray, relative: FloatArray) -> dict[str, InferredAngle]:
    """Return the angles halfway between both attitudes of two axes, where what is between them hardly moves an angle.

    ``reach``: (3, K) how far the force may lie off (K, 3) ``p``, either way; ``relative``: (3, A) the inverse of the
    axes for outputs at full slope.
    """
    scale = np.linalg.norm(readings.k, axis=1)
    across = np.hypot(p[:, 1], p[:, 2])
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.sqrt(np.where(np.abs(p[:, 0]) < 1.0, 1.0 - p[:, 0] ** 2, np.nan))
        slopes = {
            "pitch": np.stack([1.0 / cosine, np.zeros_like(cosine), np.zeros_like(cosine)], axis=-1),
            "roll": np.stack([np.zeros_like(across), p[:, 2], -p[:, 1]], axis=-1) / (across**2)[:, None],
        }
        errors = _errors(readings, np.stack([p[:, 0], *(cosine * p[:, i] / across for i in (1, 2))], axis=-1))
    found = {}
    for angle, slope in slopes.items():
        gain = np.zeros((len(p), 2, len(scale)))
        gain[:, 0] = slope @ relative
        half = np.abs(np.einsum("ni,in->n", slope, reach))
        length = np.linalg.norm(reach, axis=0)
        with np.errstate(invalid="ignore"):
            is_determined = (np.linalg.norm(gain[:, 0], axis=-1) <= LARGEST_AMPLIFICATION) & (
                half * LARGEST_AMPLIFICATION <= length
            )
        found[angle] = _kept(InferredAngle(errors[angle], gain / scale, half), is_determined)
    return found


def _regular(readings: Readings, force: FloatArray, scale: FloatArray) -> dict[str, InferredAngle]:
    """Return the angles of (K, 3) force; NaN: of none."""
    is_real: BoolArray = np.asarray(np.isfinite(force).all(axis=1))
    at = np.where(is_real[:, None], force, readings.force)
    gain, _, cosine_inferred = _gains(at, readings.k, scale)
    across: FloatArray = np.minimum(cosine_inferred, np.hypot(readings.force[:, 1], readings.force[:, 2]))
    errors, size = _errors(readings, at), np.linalg.norm(gain * scale, axis=-1)
    is_vertical: BoolArray = np.asarray(across * LARGEST_AMPLIFICATION < 1.0)
    nothing = np.zeros(len(at))
    pitch = np.stack([gain[:, 0], gain[:, 1] * is_vertical[:, None]], axis=1)
    of_pitch = np.where(is_vertical, size.max(axis=1), size[:, 0])
    roll = np.zeros_like(gain)
    with np.errstate(divide="ignore", invalid="ignore"):
        roll[:, 0] = gain[:, 1] / np.hypot(at[:, 1], at[:, 2])[:, None]
    is_determined = {
        "pitch": is_real & (of_pitch <= LARGEST_AMPLIFICATION),
        "roll": is_real & ~is_vertical & (size[:, 1] <= LARGEST_AMPLIFICATION * across),
    }
    return {
        angle: _kept(InferredAngle(errors[angle], of_angle, nothing), is_determined[angle])
        for angle, of_angle in (("pitch", pitch), ("roll", roll))
    }


def _gains(force: FloatArray, k: FloatArray, scale: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (K, 2, A) turns along pitch and cos α·roll per volt, the turns themselves, (K, 2, 3), and cos α."""
    with np.errstate(divide="ignore", invalid="ignore"):
        meridian, parallel, across = turns(np.ascontiguousarray(force.T))
    turn = np.stack([meridian.T, parallel.T], axis=1)
    slopes = np.einsum("ai,nsi->nas", k / scale[:, None], turn)
    return np.linalg.pinv(slopes, rcond=1e-12) / scale, turn, across


def _errors(readings: Readings, force: FloatArray) -> dict[str, FloatArray]:
    """Return inferred less known angles; an attitude beyond the vertical is taken as the same one before it."""
    pitch, roll = _angles(force)
    known_pitch, known_roll = _angles(readings.force)
    facing = np.where(np.cos(readings.pitch_rad) < -_SMALLEST_COSINE, -1.0, 1.0)
    return {"pitch": facing * (pitch - known_pitch), "roll": _turned(roll - known_roll)}


def _angles(force: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.arctan2(force[:, 0], np.hypot(force[:, 1], force[:, 2])), np.arctan2(-force[:, 1], -force[:, 2])


def _turned(angle: FloatArray) -> FloatArray:
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _kept(inferred: InferredAngle, is_determined: BoolArray) -> InferredAngle:
    return InferredAngle(
        np.where(is_determined, inferred.error_rad, np.nan),
        np.where(is_determined[:, None, None], inferred.gain, np.nan),
        np.where(is_determined, inferred.known_rad, np.nan),
    )
