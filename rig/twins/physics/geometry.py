"""Explicit rotation matrices: the twins' own geometry, sharing nothing with the solvers that are judged by it.

Axes x forward, y right, z down. A matrix here turns components in the outer axes into components in the inner ones
(a passive rotation), so the specific force of a package at rest is ``roll @ yaw @ pitch @ UP``.
"""

import math

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
"""Shape (3, 3)."""
Vector = NDArray[np.float64]
"""Shape (3,)."""

ARCSEC_RAD = math.pi / 648000.0
UP = np.array([0.0, 0.0, -1.0])
"""Specific force of a body at rest in level axes, in local g: the table pushes upwards and z points down."""


def about_x(angle_rad: float) -> Matrix:
    """Return the matrix of roll, right wing down."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])


def about_y(angle_rad: float) -> Matrix:
    """Return the matrix of pitch, nose up."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def about_z(angle_rad: float) -> Matrix:
    """Return the matrix of yaw, nose right."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def permutation(x: str, y: str, z: str) -> Matrix:
    """Return rows that say which outer axis each inner axis points along, such as ``("+x", "-z", "+y")``."""
    rows = np.zeros((3, 3))
    for row, name in enumerate((x, y, z)):
        rows[row, "xyz".index(name[1])] = 1.0 if name[0] == "+" else -1.0
    return rows


def sensitive_direction(axis: str, coning_rad: float, azimuth_rad: float) -> Vector:
    """Return the unit vector of a sensor's sensitive axis in package axes.

    Nominal axis i, azimuth counted from i+1 towards i+2.

    Source: TP (2), (4), (5).
    """
    i = "xyz".index(axis)
    direction = np.zeros(3)
    direction[i] = math.cos(coning_rad)
    direction[(i + 1) % 3] = math.sin(coning_rad) * math.cos(azimuth_rad)
    direction[(i + 2) % 3] = math.sin(coning_rad) * math.sin(azimuth_rad)
    return direction
