"""Rotations written out, in the order in which a mechanism turns: forward, right, down; nose up, right wing down.

A matrix turns the components of a fixed vector from the old axes into the turned ones. Angles broadcast: an angle of
shape (...) gives a matrix (..., 3, 3).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ARCSEC = np.pi / 180.0 / 3600.0
LEVEL_FORCE = np.array([0.0, 0.0, -1.0])
"""Specific force of a package at rest and level, in g: the support pushes up, and down is +z."""


def _matrix(rows: list[list[Any]]) -> FloatArray:
    entries = np.broadcast_arrays(*[entry for row in rows for entry in row])
    return np.stack(entries, axis=-1).reshape(*entries[0].shape, 3, 3).astype(np.float64)


def pitch_matrix(angle_rad: Any) -> FloatArray:
    """Turn about y. Source: TP (110)."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return _matrix([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def roll_matrix(angle_rad: Any) -> FloatArray:
    """Turn about x. Source: TP (111)."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return _matrix([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])


def yaw_matrix(angle_rad: Any) -> FloatArray:
    """Turn about z. Source: TP (112)."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return _matrix([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def turn_matrix(vector_rad: FloatArray) -> FloatArray:
    """Turn about any axis by a rotation vector (..., 3): Rodrigues' formula, components in the turned axes."""
    vector = np.asarray(vector_rad, dtype=np.float64)
    angle = np.sqrt((vector**2).sum(axis=-1))[..., None, None]
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    zero = np.zeros_like(x)
    cross = _matrix([[zero, -z, y], [z, zero, -x], [-y, x, zero]])
    return np.eye(3) - np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2 * (cross @ cross)


def turned(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Return the vectors (..., 3) in turned axes."""
    return (matrix @ vector[..., None])[..., 0]


def specific_force(pitch_rad: Any, roll_rad: Any) -> FloatArray:
    """Return the specific force (..., 3) in package axes, in g: pitch first, then roll. Source: TP (113)."""
    return turned(roll_matrix(roll_rad), turned(pitch_matrix(pitch_rad), LEVEL_FORCE))


def gimbal_matrix(pitch_rad: Any, yaw_rad: Any, roll_rad: Any) -> FloatArray:
    """Turn from tunnel to package axes: half a turn about y, pitch, yaw, roll. Source: CR (III-B.2) to (III-B.6)."""
    return roll_matrix(roll_rad) @ yaw_matrix(yaw_rad) @ pitch_matrix(pitch_rad) @ pitch_matrix(np.pi)


def sensitive_axis(axis: str, coning_rad: Any, azimuth_rad: Any) -> FloatArray:
    """Return the unit vector (..., 3) of a sensor's axis in package axes, azimuth turned first.

    Source: TP (114) to (116): x by roll then yaw, y by pitch then roll, z by yaw then pitch.
    """
    coning, azimuth = np.broadcast_arrays(coning_rad, azimuth_rad)
    if axis == "x":
        return (yaw_matrix(coning) @ roll_matrix(azimuth))[..., 0, :]
    if axis == "y":
        return (roll_matrix(coning) @ pitch_matrix(azimuth))[..., 1, :]
    return (pitch_matrix(coning) @ yaw_matrix(azimuth))[..., 2, :]


def random_directions(chance: np.random.Generator, *shape: int) -> FloatArray:
    """Draw unit vectors (*shape, 3), uniform on the sphere."""
    vectors = chance.standard_normal((*shape, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
