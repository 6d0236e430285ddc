"""What an accelerometer senses at the rows of its calibration: the specific force in the axes of its package.

TP's package is pitched and rolled, CR's is pitched, yawed and rolled, or is on the sting where roll does not reach it.
CR's models are linear in gravity, which is the specific force with the other sign.
"""

import numpy as np

from ams.analysis.diagnostics.step_patterns import force, force_along
from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.models.accelerometer import PitchRoll
from ams.models.extended import ExtendedPitchRoll
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.observations import Observations
from ams.solve.extension import angles_of_points
from ams.solve.layout import Layout

Accelerometer = PitchRoll | ExtendedPitchRoll | PitchYawRoll
"""A sensor that is linear in offset and three sensitivities, with terms of low order beside them or without."""


def sensed_force(base: Accelerometer, rows: Observations | Attitude) -> FloatArray:
    """Return the (N, 3) specific force in package axes, g."""
    return force(*turned_by(base, rows))


def sensed_along(base: Accelerometer, rows: Observations) -> FloatArray:
    """Return the (N,) specific force along the nominal axis, g."""
    return force_along(base.nominal_axis, *turned_by(base, rows))


def along_force(base: Accelerometer, primary: FloatArray) -> FloatArray:
    """Return the (3,) sensitivities by the specific force, per g: CR's are by gravity."""
    return -primary[1:4] if isinstance(base, PitchYawRoll) else primary[1:4]


def yaw_of(base: Accelerometer | None, rows: Observations | Attitude) -> FloatArray | None:
    """Return the (N,) yaw of rows where the model of a sensor takes it; None of a table without."""
    if not isinstance(base, PitchYawRoll):
        return None
    assert rows.yaw_rad is not None, "without yaw the model is not solved"
    return rows.yaw_rad


def attitude_of_points(base: Accelerometer, rows: Observations, layout: Layout) -> Attitude:
    """Return where the axes of the table stood at the (K,) points, with yaw where the model takes it."""
    yaw = yaw_of(base, rows)
    at_points = None if yaw is None else yaw[np.unique(layout.point, return_index=True)[1]]
    return Attitude(*angles_of_points(rows, layout), at_points)


def is_rolled(base: Accelerometer) -> bool:
    """Tell whether roll reaches the package of a sensor: not that on CR's sting."""
    return not isinstance(base, PitchYawRoll) or base.package == "model"


def turned_by(base: Accelerometer, rows: Observations | Attitude) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Return the (N,) pitch, roll and yaw that turn the package: no roll where that does not reach it."""
    roll = rows.roll_rad if is_rolled(base) else np.zeros_like(rows.roll_rad)
    return rows.pitch_rad, roll, yaw_of(base, rows)
