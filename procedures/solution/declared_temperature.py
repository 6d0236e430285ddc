"""Temperatures of a file that are far from every one that its rig file declares: in another unit, or of another sensor.

One file alone does not tell degrees Fahrenheit of a laboratory from degrees Celsius of an oven.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from ams.models.possible_temperature import in_degc_of_degf
from ams.observations import Observations
from rig.description.rig_file import RigDescription, Sensor

_FAR_DEGC: Final = 20.0


def temperature_warnings(rows: Observations, rig: RigDescription, sensor: Sensor | None) -> tuple[str, ...]:
    """Return a warning where all temperatures lie far outside a range that the rig file declares."""
    read = rows.temperature_degc
    if read is None:
        return ()
    return tuple(
        f"{rows.source}: temperature_degc is {read.min():.4g} to {read.max():.4g} °C, and {what} is {low:g} to "
        f"{high:g} °C: {_doubt(rows, low, high)}; nothing was converted"
        for what, low, high in _declared(rig, sensor)
        if read.min() > high + _FAR_DEGC or read.max() < low - _FAR_DEGC
    )


def _declared(rig: RigDescription, sensor: Sensor | None) -> Iterator[tuple[str, float, float]]:
    if sensor is not None and sensor.use_temperature_degc is not None:
        yield "use_temperature_degc of the sensor", *sensor.use_temperature_degc
    for name, chamber in rig.environment.items():
        yield f"environment.{name}: limits_degc", *chamber.limits_degc


def _doubt(rows: Observations, low: float, high: float) -> str:
    assert rows.temperature_degc is not None
    as_degf = float(np.median(in_degc_of_degf(rows.temperature_degc)))
    if low - _FAR_DEGC <= as_degf <= high + _FAR_DEGC:
        return "degrees Fahrenheit? subtract 32 and divide by 1.8"
    return "look at the unit of the column, and at the rig file"
