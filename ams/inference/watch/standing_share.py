"""What the forces across its axis make of an output that stands at its zero."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.inference.package.calibrated import CalibratedSensor
from ams.sets.sensed_quantity import PER_G

_ROUNDS: Final = 3
"""In which the forces of two axes are told by what is left of the third."""


@dataclass(frozen=True)
class Rows:
    """Rows of one or two accelerometers of one package."""

    sensors: Sequence[CalibratedSensor]
    outputs_v: FloatArray
    """(axes, n)."""
    roll_deg: FloatArray | None
    """(n,) where one axis has a roll that is known."""
    upright: bool
    right_wing_down: bool
    """The root that two axes have, as :class:`ams.inference.inference.Inference` takes it."""

    def part(self, start: int, end: int) -> "Rows":
        """Return the rows from ``start`` on to before ``end``."""
        roll_deg = None if self.roll_deg is None else self.roll_deg[start:end]
        return Rows(self.sensors, self.outputs_v[:, start:end], roll_deg, self.upright, self.right_wing_down)


def share_v(rows: Rows, axis: int, zero_v: float) -> tuple[FloatArray, FloatArray]:
    """Return what (n,) other forces make of an output at its zero, and (2, n) these in g; zero where they are not told.

    Of two axes the other one tells its own force, and the length of one g the third; of one axis the known roll.
    """
    sensors, count = rows.sensors, rows.outputs_v.shape[1]
    sensor, untold = sensors[axis], (np.zeros(count), np.zeros((2, count)))
    along = "xyz".index(sensor.nominal_axis)
    force, across = np.zeros((count, 3)), [index for index in range(3) if index != along]
    force[:, along] = np.clip((zero_v - sensor.offset_v) / sensor.k_v_per_g[along], -1.0, 1.0)
    if len(sensors) == 1:
        if rows.roll_deg is None:
            return untold
        roll, level = np.deg2rad(rows.roll_deg), np.sqrt(1.0 - force[:, along] ** 2)
        force[:, 1], force[:, 2] = -level * np.sin(roll), -level * np.cos(roll)
    else:
        other = sensors[1 - axis]
        beside = "xyz".index(other.nominal_axis)
        third = 3 - along - beside
        if third in (0, along) or beside == along:
            return untold
        is_negative = rows.upright if third == 2 else rows.right_wing_down
        for _ in range(_ROUNDS):
            of_others = force @ other.k_v_per_g - force[:, beside] * other.k_v_per_g[beside]
            sensed = (rows.outputs_v[1 - axis] - other.offset_v - of_others) / other.k_v_per_g[beside]
            force[:, beside] = np.clip(sensed, -1.0, 1.0)
            left = np.sqrt(np.maximum(1.0 - force[:, along] ** 2 - force[:, beside] ** 2, 0.0))
            force[:, third] = -left if is_negative else left
    k = np.where(np.arange(3) == along, 0.0, sensor.k_v_per_g)
    return np.asarray(force @ k + sensor.quadratic_v(force)), force[:, across].T


def share_variance_v2(sensor: CalibratedSensor) -> FloatArray:
    """Return the (2, 2) covariance of the sensitivities across the axis."""
    names = list(sensor.names)
    across = [name for index, name in enumerate(PER_G) if index != "xyz".index(sensor.nominal_axis)]
    known = [names.index(name) if name in names else None for name in across]
    found = np.zeros((2, 2))
    for row, first in enumerate(known):
        for column, second in enumerate(known):
            if first is not None and second is not None:
                found[row, column] = sensor.covariance[first, second]
    return found
