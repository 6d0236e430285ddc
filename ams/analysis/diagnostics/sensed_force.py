"""What an accelerometer senses at the rows of its calibration: the specific force in the axes of its package.

TP's package is pitched and rolled, CR's is pitched, yawed and rolled, or is on the sting where roll does not reach it.
CR's models are linear in gravity, which is the specific force with the other sign.
"""

import numpy as np

from ams.analysis.diagnostics.step_patterns import force, force_along
from ams.arrays import FloatArray
from ams.frames import AXES
from ams.models.accelerometer import PitchRoll
from ams.models.cr import model_gravity_g, sting_gravity_g
from ams.models.extended import ExtendedPitchRoll
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.observations import Observations
from ams.remembered import remembered

Accelerometer = PitchRoll | ExtendedPitchRoll | PitchYawRoll
"""A sensor that is linear in offset and three sensitivities, with terms of low order beside them or without."""


def sensed_force(base: Accelerometer, rows: Observations) -> FloatArray:
    """Return the (N, 3) specific force in package axes, g."""
    if not isinstance(base, PitchYawRoll):
        return force(rows.pitch_rad, rows.roll_rad)
    assert rows.yaw_rad is not None, "without yaw the model is not solved"
    return _force_of_yawed(rows.pitch_rad, rows.yaw_rad, rows.roll_rad if base.package == "model" else None)


def sensed_along(base: Accelerometer, rows: Observations) -> FloatArray:
    """Return the (N,) specific force along the nominal axis, g."""
    if not isinstance(base, PitchYawRoll):
        return force_along(base.nominal_axis, rows.pitch_rad, rows.roll_rad)
    return _column(sensed_force(base, rows), base.nominal_axis)


def along_force(base: Accelerometer, primary: FloatArray) -> FloatArray:
    """Return the (3,) sensitivities by the specific force, per g: CR's are by gravity."""
    return -primary[1:4] if isinstance(base, PitchYawRoll) else primary[1:4]


def yaw_of(base: Accelerometer | None, rows: Observations) -> FloatArray | None:
    """Return the (N,) yaw of rows where the model of a sensor takes it; None of a table without."""
    return rows.yaw_rad if isinstance(base, PitchYawRoll) else None


@remembered(16)
def _force_of_yawed(pitch_rad: FloatArray, yaw_rad: FloatArray, roll_rad: FloatArray | None) -> FloatArray:
    roll = np.zeros_like(pitch_rad) if roll_rad is None else roll_rad
    return np.asarray(-model_gravity_g(sting_gravity_g(pitch_rad, yaw_rad), roll))


@remembered(16)
def _column(components: FloatArray, nominal_axis: str) -> FloatArray:
    return components[:, AXES.index(nominal_axis)].copy()
