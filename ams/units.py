"""Units: how a name ends, what a file writes for it, what a person reads, and the conversions that are no library's.

A quantity's name ends in its unit (``offset_v``, ``gain_ut_per_counts``); readings carry theirs beside them, written in
the same way (``v``, ``dps``).
"""

import math
import re
from collections.abc import Mapping

from ams.rounding import significant

ARCSEC_PER_DEG = 3600.0
ARCSEC_PER_RAD = ARCSEC_PER_DEG * 180.0 / math.pi
RAD_PER_ARCSEC = math.radians(1.0 / ARCSEC_PER_DEG)


def in_arcsec(angle_rad: float) -> float:
    """Return an angle in arc seconds."""
    return math.degrees(angle_rad) * ARCSEC_PER_DEG


_STORED = {"v": "V", "g": "g", "dps": "deg/s", "ut": "uT", "counts": "counts", "mps2": "m/s^2"}
"""Units of readings and of what is sensed, as a file writes them; of two, one is per the other."""


def _per(unit: str, divisor: str) -> str:
    return f"{unit if unit.isalpha() else f'({unit})'}/{divisor if divisor.isalpha() else f'({divisor})'}"


UNITS: Mapping[str, str] = {
    "v_per_g3": "V/g^3",
    "v_per_g2": "V/g^2",
    "v_per_mps2": "V/(m/s^2)",
    "v_per_g": "V/g",
    "v_per_dps3": "V/(deg/s)^3",
    "v_per_dps2": "V/(deg/s)^2",
    "v_per_dps": "V/(deg/s)",
    "v_per_degc2": "V/degC^2",
    "v_per_degc": "V/degC",
    "v_per_h": "V/h",
    **{f"{unit}_per_{other}": _per(_STORED[unit], _STORED[other]) for unit in _STORED for other in _STORED},
    "per_degc2": "1/degC^2",
    "per_degc": "1/degC",
    "degc": "degC",
    "deg": "deg",
    "dps": "deg/s",
    "mps2": "m/s^2",
    "counts": "counts",
    "ut": "uT",
    "v": "V",
    "g": "g",
    "s": "s",
}
"""Ending of a name in sets, without the underscore before it, to the unit as sets and exports have it: ASCII. The first
that fits counts."""

_PRINTED = {
    "v": "V",
    "g": "g",
    "g2": "g²",
    "g3": "g³",
    "mps2": "m/s²",
    "dps": "°/s",
    "dps2": "(°/s)²",
    "dps3": "(°/s)³",
    "radps": "rad/s",
    "ut": "µT",
    "counts": "counts",
    "degc": "°C",
    "degc2": "°C²",
    "deg": "°",
    "h": "h",
    "s": "s",
}
"""Units that others are made of, as a name ends in them or a reading carries them, and as they are printed."""
_ONE = "|".join(sorted(_PRINTED, key=len, reverse=True))
_NAME = re.compile(rf"(?P<label>.+?)(?:_(?P<unit>{_ONE}))?(?:_per_(?P<divisor>{_ONE}))?")


def unit_of(name: str) -> str | None:
    """Return the unit that a name ends in as files have it, None where it ends in none that sets know."""
    return next((stored for ending, stored in UNITS.items() if name.endswith(f"_{ending}")), None)


def printed(unit: str) -> str:
    """Return the unit of a reading as a person reads it: ``dps`` as ``°/s``; one that has no sign is as it is."""
    return _PRINTED.get(unit, unit)


def with_unit(number: str, unit: str) -> str:
    """Return a number with its unit as a person reads both: ``31°``, ``5 °/s``, ``22 °C``."""
    sign = printed(unit)
    return f"{number}{sign}" if sign in ("°", "″") else f"{number} {sign}"


def signed(value: float, digits: int) -> str:
    """Return a difference with its sign, to so many significant digits, and with a minus that reads as one."""
    text = significant(value, digits)
    return text if text.startswith("−") else f"+{text}"


def label_and_unit(name: str) -> tuple[str, str]:
    """Return ``sensitivity_v_per_dps`` as ``sensitivity`` and ``V/(°/s)``."""
    found = _NAME.fullmatch(name)
    if found is None:
        return name, ""
    unit = printed(found["unit"] or "")
    if found["divisor"]:
        unit = f"{_bracketed(unit or '1')}/{_bracketed(printed(found['divisor']))}"
    return found["label"].replace("_", " "), unit


def dof_words(count: float) -> str:
    """Return ``1 degree of freedom``, ``2 degrees of freedom``; whole numbers."""
    return f"{count:.0f} degree{'' if round(count) == 1 else 's'} of freedom"


def in_words(value: float, unit: str, digits: int = 2) -> str:
    """Return a size of a sentence in the unit that it is readable in: 1.2e-05 V/g² as ``12 µV/g²``."""
    shown, factor = small_unit(printed(unit))
    return with_unit(significant(factor * value, digits), shown).rstrip()


def signed_in_words(value: float, unit: str, digits: int = 2) -> str:
    """Return a difference as :func:`in_words` has a size, with its sign."""
    shown, factor = small_unit(printed(unit))
    return with_unit(signed(factor * value, digits), shown).rstrip()


def small_unit(unit: str) -> tuple[str, float]:
    """Return the printed unit that an uncertainty is readable in, and how many of it make one of ``unit``."""
    if unit == "°":
        return "″", ARCSEC_PER_DEG
    return (f"µ{unit}", 1e6) if unit.startswith(("V", "g")) else (unit, 1.0)


def _bracketed(unit: str) -> str:
    return f"({unit})" if "/" in unit and not unit.startswith("(") else unit
