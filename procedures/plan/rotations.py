"""Rotations of a gimbal and the axes of a package on it, for levels that are known as vectors.

Axes x forward, y right, z down. Matrices turn components in level axes into components in stage axes, pitch, yaw, roll
from outside in. Source: CR III-B, elementary matrices TP (110) to (112).
"""

import numpy as np

from ams.arrays import FloatArray
from ams.frames import from_level_axes
from rig.description.rig_file import Sensor

UP = np.array([0.0, 0.0, -1.0])
"""Specific force of a body at rest in level axes, local g."""


def to_stage(pitch_rad: float, yaw_rad: float, roll_rad: float) -> FloatArray:
    """Return (3, 3) from level axes into the axes of the stage that carries the package."""
    return from_level_axes(np.float64(pitch_rad), np.float64(yaw_rad), np.float64(roll_rad))  # type: ignore[arg-type]


def body_axis(sensor: Sensor, axis: str) -> FloatArray:
    """Return (3,) the package's nominal axis in stage axes, by its declared mount."""
    named = getattr(sensor.mount, axis)
    direction = np.zeros(3)
    direction["xyz".index(named[1])] = 1.0 if named[0] == "+" else -1.0
    return direction
