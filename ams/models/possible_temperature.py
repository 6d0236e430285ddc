"""Temperatures that a sensor stands: what lies beyond was read in another unit, or was never read.

Servo accelerometers are specified from −55 to 95 or 125 °C, those for wells to 177 °C; none is used beyond −100 to
200 °C. Kelvin of a laboratory and the overload code of a meter lie outside; degrees Fahrenheit of a laboratory do not.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray

COLUMN: Final = "temperature_degc"
COLDEST_DEGC: Final = -100.0
HOTTEST_DEGC: Final = 200.0
POSSIBLE: Final = "−100 to 200 °C (servo accelerometers end at −55 and 125 °C)"
_KELVIN: Final = 273.15


def impossible_temperatures(temperature_degc: FloatArray) -> BoolArray:
    """Return (…,) where no sensor has such a temperature; what is no number is none."""
    return np.asarray((temperature_degc < COLDEST_DEGC) | (temperature_degc > HOTTEST_DEGC))


def impossible_temperature(readings: Mapping[str, FloatArray]) -> BoolArray | None:
    """Return (n,) in which of n rows of columns the temperature is none that a sensor has; None where it always is."""
    read = readings.get(COLUMN)
    if read is None or not (beyond := impossible_temperatures(read)).any():
        return None
    return beyond


def possible_temperatures(temperature_degc: FloatArray) -> FloatArray:
    """Return the temperatures, NaN where no sensor has such a one."""
    return np.where(impossible_temperatures(temperature_degc), np.nan, temperature_degc)


def likely_unit(temperature_degc: FloatArray) -> str:
    """Return what to do about a column of numbers, in words that go behind a refusal."""
    if not impossible_temperatures(temperature_degc - _KELVIN).any():
        return "the numbers look like kelvin: subtract 273.15"
    if not impossible_temperatures(in_degc_of_degf(temperature_degc)).any():
        return "the numbers look like degrees Fahrenheit: subtract 32 and divide by 1.8"
    return "give the temperature in °C"


def in_degc_of_degf(temperature_degf: FloatArray) -> FloatArray:
    """Return degrees Celsius of degrees Fahrenheit."""
    return np.asarray((temperature_degf - 32.0) / 1.8)
