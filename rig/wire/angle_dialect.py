"""Dialect files of meters that read angles: inclinometers, tiltmeters and autocollimators that answer in lines of text.

A dialect names the question for a reading, its whole answer (several lines, where it has several), and the unit: fixed
by the manual, told with every reading, or answered to a question. Where the device does not tell it the rig file must;
there is no default. Those in ``rig/dialects/angle`` follow docs/devices/attitude-references.md.
"""

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator
from pydantic.json_schema import SkipJsonSchema

from rig.toml_file import StrictTable, read_toml
from rig.wire.dialect_files import name_or_file, shipped_in
from rig.wire.table_dialect import LineSettings, line_with
from rig.wire.template import FieldValue, Template

AngleUnit = Literal["deg", "arcmin", "arcsec", "rad", "mrad", "urad", "mm_per_m"]
_DEG_IN: dict[str, float] = {
    "deg": 1.0,
    "arcmin": 1.0 / 60.0,
    "arcsec": 1.0 / 3600.0,
    "rad": math.degrees(1.0),
    "mrad": math.degrees(1e-3),
    "urad": math.degrees(1e-6),
}


def to_deg(value: float, unit: AngleUnit) -> float:
    """Return an angle in degrees; millimetres a metre are a slope, the tangent of one."""
    return math.degrees(math.atan(1e-3 * value)) if unit == "mm_per_m" else value * _DEG_IN[unit]


def from_deg(angle_deg: float, unit: AngleUnit) -> float:
    """Return degrees in another unit."""
    return 1e3 * math.tan(math.radians(angle_deg)) if unit == "mm_per_m" else angle_deg / _DEG_IN[unit]


class QuietCommand(StrictTable):
    """Ends the stream that some devices begin by themselves. ``reply``: the bytes it answers with, without an end."""

    command: Annotated[str, line_with()]
    reply: Annotated[str, line_with()] = ""


class DeviceQuery(StrictTable):
    """Who it is."""

    command: Annotated[str, line_with()]
    reply: Annotated[str, line_with("text", "serial")]


class ReadingQuery(StrictTable):
    command: Annotated[str, line_with("axis")]
    reply: Annotated[str, line_with("axis", "x", "y", "unit", "text", "words", "serial")]


class UnitQuery(StrictTable):
    command: Annotated[str, line_with("axis")]
    reply: Annotated[str, line_with("axis", "unit", "text", "words", "serial")]


class AngleDialect(StrictTable):
    """A dialect file of a meter of angles."""

    name: str
    terminator: Annotated[str, Field(max_length=2)]
    """Of a command; may be nothing."""
    reply_terminator: Annotated[str, Field(min_length=1, max_length=6)]
    line: LineSettings = LineSettings()
    reply_timeout_s: Annotated[float, Field(gt=0.0, le=60.0)] = 1.0
    reading_s: Annotated[float, Field(gt=0.0, le=60.0)] = 0.1
    """Until the device has a new value: closer readings are the same one twice."""
    quiet: QuietCommand | None = None
    identity: DeviceQuery | None = None
    reading: ReadingQuery
    checksum: Literal["none", "xor"] = "none"
    """xor: every answer to a reading ends with * and two hexadecimal digits, over what stands between $ and *."""
    unit: AngleUnit | None = None
    """Where the manual leaves no other."""
    units: dict[str, AngleUnit] = Field(default_factory=dict)
    """What the device calls a unit, where it tells it; another word is refused."""
    unit_query: UnitQuery | None = None

    @model_validator(mode="after")
    def _tells_its_unit_in_one_way(self) -> "AngleDialect":
        with_reading = "unit" in Template(self.reading.reply).fields
        has_query = self.unit_query is not None
        if has_query and "unit" not in Template(self.unit_query.reply).fields:  # type: ignore[union-attr]
            raise ValueError("unit_query: its reply needs {unit}")
        if with_reading + has_query + (self.unit is not None) > 1:
            raise ValueError("unit: give one of unit, {unit} in the reading's reply, and unit_query")
        if bool(self.units) != (with_reading or has_query):
            raise ValueError(
                "units: {unit} in a reply and the table [units], which says what its words mean, go together"
            )
        return self

    @model_validator(mode="after")
    def _numbers_come_back(self) -> "AngleDialect":
        template = Template(self.reading.reply)
        numbers = template.fields & {"x", "y"}
        if not numbers:
            raise ValueError("reading: there is no {x:...} or {y:...} in its reply")
        filled: dict[str, FieldValue] = dict.fromkeys(("text", "words", "serial"), "1")
        filled |= {"axis": 1, "unit": next(iter(self.units), "deg")}
        for x, y in ((0.0, 0.0), (1.25, -0.5), (-0.125, 12.5)):
            line = template.render(**filled, x=x, y=y)
            matched = template.match(line)
            if matched is None or any(abs(float(matched[name]) - {"x": x, "y": y}[name]) > 0.5 for name in numbers):
                raise ValueError(
                    f"reading: it is written {line!r}, which does not read back; a blank or a comma parts numbers"
                )
        return self

    @property
    def values(self) -> frozenset[str]:
        """Return which of ``x`` and ``y`` it reads."""
        return Template(self.reading.reply).fields & {"x", "y"}

    @property
    def tells_unit(self) -> bool:
        return self.unit is not None or bool(self.units)


def angle_dialects() -> dict[str, AngleDialect]:
    """Return the shipped dialects, by name."""
    return shipped_in("dialects/angle", AngleDialect)


NamedAngleDialect = Annotated[
    Annotated[str, Tag("name")] | Annotated[SkipJsonSchema[AngleDialect], Tag("file")], Discriminator(name_or_file)
]
"""Name of a shipped dialect or path of a dialect file; what the file says once it is read."""


def load_angle_dialect(name: str | AngleDialect) -> AngleDialect:
    """Return a shipped dialect by name, or a dialect file by path; one that was read as it is.

    Raises: DescriptionError.
    """
    if isinstance(name, AngleDialect):
        return name
    shipped = angle_dialects()
    return shipped[name] if name in shipped else read_toml(Path(name)).validate(AngleDialect)
