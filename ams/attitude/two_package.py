"""Pitch, yaw and roll from gravity in sting axes and in model axes (CR IV-B).

Gravity in sting axes gives pitch and yaw, gravity in model axes against it gives roll: (IV-B.9) to (IV-B.11).

Gravity cannot tell (Θ, Ψ) from (−Θ, Ψ ± 180°): Ψ is taken within ±90°. At Θ = 0 yaw has no meaning, at Ψ = ±90° the
sign of Θ has none, and roll has none where the sting's x axis is vertical: NaN stands there.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray

SMALLEST_SINE: Final = 1e-6
"""Below this sine of the angle to a singular attitude, the angle concerned is not stated."""


@dataclass(frozen=True)
class EulerAngles:
    """Angles row by row, (N,), NaN where an angle has no meaning."""

    pitch_rad: FloatArray
    yaw_rad: FloatArray
    roll_rad: FloatArray


def angles_from_gravity(sting: FloatArray, model: FloatArray) -> EulerAngles:
    """Return the angles from gravity in sting axes and in model axes, (N, 3) each, in any unit."""
    g_x, g_y, g_z = np.moveaxis(np.atleast_2d(sting), -1, 0)
    _, m_y, m_z = np.moveaxis(np.atleast_2d(model), -1, 0)
    total = np.sqrt(g_x**2 + g_y**2 + g_z**2)
    level = np.hypot(g_x, g_y) < SMALLEST_SINE * total
    sideways = (np.abs(g_x) < SMALLEST_SINE * total) & ~level
    on_end = np.hypot(g_y, g_z) < SMALLEST_SINE * total
    sign = np.where(g_x > 0.0, -1.0, 1.0)
    yaw = np.arctan2(sign * g_y, np.abs(g_x))
    pitch = sign * np.arctan2(np.hypot(g_x, g_y), g_z)
    roll = np.arctan2(m_y * g_z - m_z * g_y, m_y * g_y + m_z * g_z)
    return EulerAngles(
        np.where(sideways, np.nan, pitch),
        np.where(level | sideways, np.nan, yaw),
        np.where(on_end, np.nan, roll),
    )
