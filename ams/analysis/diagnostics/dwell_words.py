"""Which dwell it is, in words."""

import numpy as np

from ams.observations import Observations


def dwell_words(observations: Observations, row: int) -> str:
    """Return which dwell a row is."""
    step = "" if observations.step is None else f"step {observations.step[row]}, "
    angles = {"pitch": observations.pitch_rad, "yaw": observations.yaw_rad, "roll": observations.roll_rad}
    stood = [f"{axis} {_signed(float(np.rad2deg(angle[row])))}°" for axis, angle in angles.items() if angle is not None]
    level = observations.reference_level
    if level is not None:
        is_turned = any(angle is not None and angle.any() for angle in angles.values())
        stood = [*(stood if is_turned else []), f"level {_signed(float(level[row]))}"]
    return f"{step}replication {observations.replication[row]}, point {observations.point[row]} ({', '.join(stood)})"


def _signed(value: float) -> str:
    return f"{round(value, 4) + 0.0:g}".replace("-", "−")
