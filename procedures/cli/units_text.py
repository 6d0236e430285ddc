"""Names of parameters as a person reads them: the quantity, and the unit that the name ends in."""

import re

UNITS = {
    "v": "V",
    "g": "g",
    "g2": "g²",
    "mps2": "m/s²",
    "dps": "°/s",
    "radps": "rad/s",
    "ut": "µT",
    "degc": "°C",
    "degc2": "°C²",
    "deg": "°",
    "h": "h",
    "s": "s",
}
"""Unit as the names of parameters end in it, and as it is printed."""
_ONE = "|".join(sorted(UNITS, key=len, reverse=True))
_NAME = re.compile(rf"(?P<label>.+?)(?:_(?P<unit>{_ONE}))?(?:_per_(?P<divisor>{_ONE}))?")


def label_and_unit(name: str) -> tuple[str, str]:
    """``sensitivity_v_per_dps`` as ``sensitivity`` and ``V/(°/s)``."""
    found = _NAME.fullmatch(name)
    if found is None:
        return name, ""
    unit = UNITS.get(found["unit"], "")
    if found["divisor"]:
        divisor = UNITS[found["divisor"]]
        unit = f"{unit or 1}/{f'({divisor})' if '/' in divisor else divisor}"
    return found["label"].replace("_", " "), unit
