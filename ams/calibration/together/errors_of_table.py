"""What errors of the table do to the force at its points: what all outputs of a package share."""

from typing import Final

import numpy as np

from ams.analysis.diagnostics.step_patterns import What, slip_pattern
from ams.arrays import FloatArray
from ams.inputs.indices import standing_at

SQUARENESS_AND_TILT: Final = 2
"""The first columns, not in this order: axes out of square, and a base that stands off about its forward axis."""
NOTHING: Final = 1e-6
"""Of the square of a column: less is left beside others by rounding."""


def errors_of_table(pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None) -> FloatArray:
    """Return (K, 3, c) changes of the force per radian: tilt, squareness, and an error at each index of each axis."""
    angles: dict[What, FloatArray | None] = {"pitch": pitch_rad, "roll": roll_rad, "yaw": yaw_rad}
    sideways = np.stack([np.zeros_like(roll_rad), np.cos(roll_rad), -np.sin(roll_rad)], axis=1)
    of_axes = np.stack([sideways, sideways * np.sin(pitch_rad)[:, None]], axis=2)
    curves = [
        _curves(angle, slip_pattern(axis, pitch_rad, roll_rad, yaw_rad))
        for axis, angle in angles.items()
        if angle is not None
    ]
    return np.concatenate([of_axes, *curves], axis=2)


def directions_of(columns: FloatArray) -> FloatArray:
    """Return (N, r) orthonormal directions of (N, c) columns; what is left beside others by rounding is none."""
    squares, vectors = np.linalg.eigh(columns.T @ columns)
    kept = squares > NOTHING * squares.max(initial=0.0)
    return np.asarray(columns @ (vectors[:, kept] / np.sqrt(squares[kept])))


def _curves(angle_rad: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the (K, 3, i) change of the force by an error at each index of an axis, of (K, 3) a radian."""
    columns, _ = standing_at(angle_rad)
    return slope[:, :, None] * columns[:, None, :]
