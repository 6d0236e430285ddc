"""Which dwell it is, in words."""

import numpy as np

from ams.observations import Observations


def dwell_words(observations: Observations, row: int) -> str:
    """Return which dwell a row is."""
    step = "" if observations.step is None else f"step {observations.step[row]}, "
    pitch, roll = (float(np.rad2deg(angle[row])) for angle in (observations.pitch_rad, observations.roll_rad))
    return (
        f"{step}replication {observations.replication[row]}, point {observations.point[row]} "
        f"(pitch {_signed(pitch)}°, roll {_signed(roll)}°)"
    )


def _signed(value: float) -> str:
    return f"{round(value, 4) + 0.0:g}".replace("-", "−")
