"""Attitude as a quaternion q = (q₁, q₂, q₃, q₄), scalar last, after SR.

q turns a vector of the package (body axes) into the reference frame. Its kinematics are q̇ = ½ Ω(ω) q with ω the
angular velocity in body axes; a constant ω over a step is integrated exactly, and q is normalised at each step. The
Euler angles are those of the sequence yaw, pitch, roll (about z, y, x of the turning frame). SR's equation (1) lacks
the ½ and has two signs wrong (see the tests).
"""

from typing import Any, Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import rate_scan

IDENTITY: Final = (0.0, 0.0, 0.0, 1.0)
"""SR's initial attitude."""


def multiply(p: FloatArray, q: FloatArray) -> FloatArray:
    """Return Hamilton's product p ⊗ q, (..., 4): the turn q first, then p, both read in the reference frame."""
    p_v, p_s, q_v, q_s = p[..., :3], p[..., 3:], q[..., :3], q[..., 3:]
    vector = p_s * q_v + q_s * p_v + np.cross(p_v, q_v)
    scalar = p_s * q_s - np.sum(p_v * q_v, axis=-1, keepdims=True)
    return np.concatenate([vector, scalar], axis=-1)


def from_turn(turn_rad: FloatArray) -> FloatArray:
    """Return the quaternion of a turn by |turn| about its direction, (..., 4) of (..., 3)."""
    half = np.linalg.norm(turn_rad, axis=-1, keepdims=True) / 2.0
    return np.concatenate([turn_rad * np.sinc(half / np.pi) / 2.0, np.cos(half)], axis=-1)


def normalised(q: FloatArray) -> FloatArray:
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def advance(q: FloatArray, rate_rad_s: FloatArray, interval_s: float) -> FloatArray:
    """Return q after one interval of constant body rate: exact, and normalised."""
    return normalised(multiply(q, from_turn(np.asarray(rate_rad_s) * interval_s)))


def integrate(body_rate_rad_s: FloatArray, interval_s: float, start: FloatArray | None = None) -> FloatArray:
    """Integrate body rates (N, 3), evenly sampled, from ``start``: quaternions at every sample, (N, 4).

    The rate runs as a cubic through four samples, straight where there are fewer: fourth order in the interval.
    Raises: ObservationsError with fewer than two samples or a rate that is not a number
    (:func:`ams.attitude.rate_scan.integrate` bridges and marks it).
    """
    rates = np.ascontiguousarray(np.asarray(body_rate_rad_s, dtype=float).T)
    rate_scan.refuse_missing(rates)
    first = np.array(IDENTITY) if start is None else np.asarray(start, dtype=float)
    return rate_scan.integrate(rates, first, interval_s, "cubic" if rates.shape[1] >= 4 else "linear").quaternion.T


def from_euler(pitch_rad: Any, roll_rad: Any, yaw_rad: Any) -> FloatArray:
    """Return the quaternion of yaw, then pitch, then roll, (..., 4)."""
    pitch, roll, yaw = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (pitch_rad, roll_rad, yaw_rad)))
    zero = np.zeros_like(pitch)
    about_z = from_turn(np.stack([zero, zero, yaw], axis=-1))
    about_y = from_turn(np.stack([zero, pitch, zero], axis=-1))
    about_x = from_turn(np.stack([roll, zero, zero], axis=-1))
    return multiply(multiply(about_z, about_y), about_x)
