"""A sensor that did what the others did not: turned on its mount, or changed itself.

All sensors of a rig stand on one rigid fixture. What is left of one of them when the common part is taken off is either
a rotation of its package, three angles for all its axes and attitudes, or no rotation: an offset moves an axis alike at
every attitude, a sensitivity as the force along it. A rotation is one only if K⁻¹ΔK is antisymmetric and Δb = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ams.arrays import FloatArray
from ams.frames import specific_force, specific_force_by_turn
from ams.statistics.distributions import f_tail

Culprit = Literal["mount", "sensor", "either"]
CONSISTENT = 0.01
"""A cause is contradicted where what it leaves over has less chance than this."""
_SAME = 1e-6


@dataclass(frozen=True)
class LeftOver:
    """What one sensor of A axes did by itself at K attitudes."""

    pitch_rad: FloatArray
    roll_rad: FloatArray
    change: FloatArray
    """(K, A) in the unit of the reading, NaN where an axis was not read."""
    variance: FloatArray
    """(K, A)"""
    k: FloatArray
    """(A, 3) units of the reading per g."""
    degrees_of_freedom: float
    """By which the variances are known."""
    yaw_rad: FloatArray | None = None
    """Of a gimbal."""


@dataclass(frozen=True)
class Attribution:
    """Whose doing it is."""

    culprit: Culprit
    turned_rad: float
    """How far the package turned, as far as these attitudes show it."""


UNATTRIBUTED = Attribution("either", 0.0)


def mount_or_sensor(left: LeftOver) -> Attribution:
    """Return whether a rotation of the package explains the change, a single change of an axis, or either."""
    turns = [change @ left.k.T for change in specific_force_by_turn(left.pitch_rad, left.roll_rad, left.yaw_rad)]
    angles, p_turned = _fitted(left, turns)
    force = specific_force(left.pitch_rad, left.roll_rad, left.yaw_rad) @ left.k.T
    alone = np.eye(left.k.shape[0])
    single = [_fitted(left, [column * direction])[1] for direction in alone for column in (np.ones_like(force), force)]
    is_turned, is_changed = p_turned >= CONSISTENT, max(single) >= CONSISTENT
    culprit: Culprit = "sensor" if not is_turned else "either" if is_changed else "mount"
    return Attribution(culprit, float(np.linalg.norm(angles)))


def _fitted(left: LeftOver, columns: Sequence[FloatArray]) -> tuple[FloatArray, float]:
    """Return the least squares estimate, and the chance of what it leaves over; 1 where it leaves nothing to judge."""
    read = np.isfinite(left.change)
    weight = 1.0 / np.sqrt(left.variance[read])
    matrix, y = np.stack([column[read] for column in columns], axis=1) * weight[:, None], left.change[read] * weight
    solved, _, rank, _ = np.linalg.lstsq(matrix, y, rcond=_SAME)
    found = np.asarray(solved, dtype=np.float64)
    rest, freedom = y - matrix @ found, int(y.size - rank)
    if freedom < 1:
        return found, 1.0
    return found, float(f_tail(float(rest @ rest) / freedom, freedom, left.degrees_of_freedom))
