"""Attitude as a quaternion q = (q₁, q₂, q₃, q₄), scalar last, after SR.

q turns a vector of the package (body axes) into the reference frame. Its kinematics are q̇ = ½ Ω(ω) q with ω the
angular velocity in body axes. SR's equation (1) lacks the ½ and has two signs wrong (see the tests).
"""

import numpy as np

from ams.arrays import FloatArray


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
