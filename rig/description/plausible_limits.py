"""Declared limits and uncertainties that nothing can have: a slip of the unit would make every interval empty of sense.

The bounds are what is possible at all and not what is usual: half a turn, the whole of a part, what an output swings by
between +1 g and −1 g. They are found by the name of a key and its unit, so a key that is added is bounded as well.
Asked of files alone: a run that was stored with such a number stays one.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from pydantic import BaseModel

from rig.description.rig_file import RigDescription
from rig.description.sensor import Sensor
from rig.toml_file import TomlFile

IS_DECLARED: Final = re.compile(r"uncertainty|^largest_|^capability|_limit_deg$|^about_(pitch|roll)_arcsec$")
"""Names of keys that state how wrong or how far off something is at most."""
TWIN: Final = "twin"
"""Its table is left out: a truth may be anything."""


POSSIBLE_DEGC: Final = (-100.0, 200.0)
"""What a sensor stands at most; readings of temperature beyond it are none."""
KELVIN: Final = 273.15


@dataclass(frozen=True)
class Bound:
    """What a declared limit must stay below."""

    largest: float
    unit: str
    reason: str


HALF_A_TURN = "half a turn"
BY_UNIT: Final[Mapping[str, Bound]] = {
    "arcsec": Bound(180.0 * 3600.0, "″", HALF_A_TURN),
    "deg": Bound(180.0, "°", HALF_A_TURN),
    "v_per_degc": Bound(1000.0, "V/°C", "the largest range of a meter, for a degree"),
    "per_degc": Bound(1.0, "1/°C", "the whole of it, for a degree"),
    "v": Bound(1000.0, "V", "the largest range of a meter"),
    "degc": Bound(100.0, "°C", "the way from ice to steam"),
    "ohm": Bound(1e9, "Ω", "what an insulator has"),
    "mps2": Bound(0.2, "m/s²", "what gravity may be from place to place, 9.7 to 9.9"),
    "dps_per_g": Bound(1000.0, "°/s/g", "more than any gyro's full range"),
    "ut": Bound(1e6, "µT", "what any coil makes, 1 T"),
    "shift": Bound(1.0, "", "the whole of it"),
}
"""By the end of the key's name, the longest that fits first."""


def implausible_limits(file: TomlFile, rig: RigDescription) -> Iterator[str]:
    """Yield every declared limit that is as large as nothing can be."""
    for key, name, value in _declared((), rig):
        bound = _bound(rig, key, name)
        if bound is not None and abs(value) >= bound.largest:
            unit = f" {bound.unit}" if bound.unit else ""
            yield file.complaint(
                key,
                f"got {value:g}{unit}, allowed is below {bound.largest:g}{unit} ({bound.reason}); correct the number, "
                "or its unit",
            )


def implausible_temperatures(file: TomlFile, rig: RigDescription) -> Iterator[str]:
    """Yield temperatures of use that no sensor stands: those of another unit."""
    low_degc, high_degc = POSSIBLE_DEGC
    for name, sensor in rig.sensors.items():
        used = sensor.use_temperature_degc
        if used is not None and not low_degc <= used[0] < used[1] <= high_degc:
            looks_like = all(low_degc <= value - KELVIN <= high_degc for value in used)
            to_do = "the numbers look like kelvin: subtract 273.15" if looks_like else "give both in °C"
            yield file.complaint(
                ("sensors", name, "use_temperature_degc"),
                f"got {used[0]:g} to {used[1]:g} °C, allowed is inside of {low_degc:g} to {high_degc:g} °C (servo "
                f"accelerometers end at −55 and 125 °C); {to_do}",
            )


def _declared(above: tuple[str, ...], table: object) -> Iterator[tuple[tuple[str, ...], str, float]]:
    """Yield key path, name and value of every declared limit below a table."""
    entries: Iterable[tuple[str, object]] = ()
    if isinstance(table, BaseModel):
        entries = ((name, getattr(table, name)) for name in type(table).model_fields)
    elif isinstance(table, Mapping):
        entries = table.items()
    for name, value in entries:
        if (*above, name) == (TWIN,):
            continue
        if isinstance(value, float) and IS_DECLARED.search(name):
            yield (*above, name), name, value
        elif isinstance(value, BaseModel | Mapping):
            yield from _declared((*above, name), value)


def _bound(rig: RigDescription, key: tuple[str, ...], name: str) -> Bound | None:
    """Return the bound of a key: that of the very sensor or coil where one is declared, else its unit's, if known."""
    unit = max((unit for unit in BY_UNIT if name.endswith(unit)), key=len, default="")
    if key[0] == "sensors" and unit in ("v", "v_per_degc"):
        swing_v = _swing_v(rig.sensors[key[1]])
        if swing_v is not None:
            return Bound(swing_v, BY_UNIT[unit].unit, "what its output swings by between +1 g and −1 g")
    if key[0] == "field" and unit == "ut":
        return Bound(max(map(abs, rig.field[key[1]].limits_ut)), "µT", "the largest level, by limits_ut")
    return BY_UNIT.get(unit)


def _swing_v(sensor: Sensor) -> float | None:
    """Return by how much the least sensitive axis changes between +1 g and −1 g; None where nothing is declared."""
    declared = [abs(sensor.nominal_v_per_g(axis)) for axis in sensor.channels]
    return 2.0 * min(declared) if all(declared) else None
