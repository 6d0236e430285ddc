"""Angles of sensors that are no straight lines: the terms of second and third order are taken off the outputs."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.static import Angles
from ams.frames import specific_force
from ams.inference.package.alignment import AlignedSensor
from ams.inference.package.calibrated import CalibratedSensor

_ROUNDS: Final = 30


def unbent(
    sensors: Sequence[CalibratedSensor | AlignedSensor], outputs_v: FloatArray, solve: Callable[[FloatArray], Angles]
) -> Angles:
    """Solve for angles with the quadratic terms taken off at the angles themselves, until they stand still."""
    found = solve(outputs_v)
    if all(sensor.is_linear for sensor in sensors):
        return found
    for _ in range(_ROUNDS):
        force = specific_force(found.pitch_rad, np.nan_to_num(found.roll_rad))
        bent = np.stack([sensor.quadratic_v(force) for sensor in sensors], axis=-1)
        before, found = found, solve(outputs_v - bent)
        moved = np.abs(np.nan_to_num(found.pitch_rad - before.pitch_rad))
        if np.all(moved < 1e-13):
            return found
    return found
