"""Units: how a name ends, what a file writes for it, what a person reads, and the conversions that are no library's.

A quantity's name ends in its unit (``offset_v``, ``gain_ut_per_counts``); readings carry theirs beside them, written in
the same way (``v``, ``dps``).
"""

import math
from dataclasses import dataclass

ARCSEC_PER_DEG = 3600.0
ARCSEC_PER_RAD = ARCSEC_PER_DEG * 180.0 / math.pi
RAD_PER_ARCSEC = math.radians(1.0 / ARCSEC_PER_DEG)


@dataclass(frozen=True, slots=True)
class Unit:
    """One unit in its three spellings."""

    ending: str
    """Of a name, without the underscore before it."""
    stored: str
    """As sets and exports have it: ASCII."""
    printed: str
    """As a person reads it."""


UNITS = (
    Unit("v_per_g2", "V/g^2", "V/g²"),
    Unit("v_per_mps2", "V/(m/s^2)", "V/(m/s²)"),
    Unit("v_per_g", "V/g", "V/g"),
    Unit("v_per_dps", "V/(deg/s)", "V/(°/s)"),
    Unit("v_per_degc", "V/degC", "V/°C"),
    Unit("v_per_h", "V/h", "V/h"),
    Unit("g_per_v", "g/V", "g/V"),
    Unit("per_degc", "1/degC", "1/°C"),
    Unit("degc", "degC", "°C"),
    Unit("deg", "deg", "°"),
    Unit("dps", "deg/s", "°/s"),
    Unit("mps2", "m/s^2", "m/s²"),
    Unit("v", "V", "V"),
    Unit("g", "g", "g"),
    Unit("s", "s", "s"),
)
"""Of the names in sets, the first ending that fits counts."""

_OF_READINGS = {"ut": "µT", "radps": "rad/s"} | {unit.ending: unit.printed for unit in UNITS}


def unit_in(name: str) -> Unit | None:
    """Return the unit that a name ends in, None where it ends in none of :data:`UNITS`."""
    return next((unit for unit in UNITS if name.endswith(f"_{unit.ending}")), None)


def unit_of(name: str) -> str | None:
    """Return the unit that a name ends in as files have it, None where it ends in none that sets know."""
    unit = unit_in(name)
    return None if unit is None else unit.stored


def printed(unit: str) -> str:
    """Return the unit of a reading as a person reads it: ``dps`` as ``°/s``; one that has no sign is as it is."""
    return _OF_READINGS.get(unit, unit)


def label_and_unit(name: str) -> tuple[str, str]:
    """Return ``sensitivity_v_per_g`` as ``sensitivity`` and ``V/g``."""
    unit = unit_in(name)
    if unit is None:
        return name.replace("_", " "), ""
    return name.removesuffix(f"_{unit.ending}").replace("_", " "), unit.printed
