"""Attitudes as a test states them."""

import numpy as np
from numpy.typing import ArrayLike

from ams.frames import Attitude


def attitude_from_degrees(pitch_deg: ArrayLike, roll_deg: ArrayLike) -> Attitude:
    """(N,) angles, degrees."""
    return Attitude(np.deg2rad(np.asarray(pitch_deg, dtype=float)), np.deg2rad(np.asarray(roll_deg, dtype=float)))
