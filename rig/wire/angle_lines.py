"""What a meter of angles is asked and says, by its dialect: commands and replies to bytes and back.

Fails with: a reply that is not whole, has a damaged checksum or a unit that the dialect has no word for. All refuse the
reply; no number is picked out of a damaged one.
"""

from dataclasses import dataclass
from functools import reduce
from operator import xor

from rig.errors import DeviceNonsense
from rig.wire.angle_dialect import AngleDialect, AngleUnit
from rig.wire.template import FieldValue, Template

_CHARACTERS = "latin-1"
"""Every byte is a character: some name a unit with one that is not ASCII."""
_CHECK_LENGTH = 3


@dataclass(frozen=True, slots=True)
class Reading:
    """What one answer told, in the device's unit; ``unit`` is None where it is not told with a reading."""

    values: dict[str, float]
    unit: AngleUnit | None


@dataclass(frozen=True, slots=True)
class Question:
    """What a device was asked: ``reading``, ``unit``, ``identity`` or ``quiet``, about one of its axes."""

    kind: str
    axis: int = 1


class AngleCodec:
    """Both sides of a line."""

    def __init__(self, dialect: AngleDialect) -> None:
        self.dialect = dialect
        self.reply_terminator = dialect.reply_terminator.encode(_CHARACTERS)
        self._reading = Template(dialect.reading.reply)
        self._unit = None if dialect.unit_query is None else Template(dialect.unit_query.reply)
        self._identity = None if dialect.identity is None else Template(dialect.identity.reply)

    def ask(self, question: Question) -> bytes:
        """Return the bytes of a question that the dialect has."""
        dialect = self.dialect
        commands = {
            "reading": dialect.reading,
            "unit": dialect.unit_query,
            "identity": dialect.identity,
            "quiet": dialect.quiet,
        }
        query = commands[question.kind]
        assert query is not None
        return (Template(query.command).render(axis=question.axis) + dialect.terminator).encode(_CHARACTERS)

    def reply_lines(self, kind: str) -> int:
        """Return how many lines the answer to a question has."""
        template = {"reading": self._reading, "unit": self._unit, "identity": self._identity}[kind]
        assert template is not None
        return template.text.count(self.dialect.reply_terminator) + 1

    def parse_reading(self, reply: bytes, axis: int) -> Reading:
        """Parse the whole answer to a reading, without its last end. Raises: DeviceNonsense."""
        if self.dialect.checksum == "xor":
            reply = _checked(reply)
        fields = self._fields_of(self._reading, reply, axis)
        unit = self._unit_called(str(fields["unit"])) if "unit" in fields else None
        return Reading({name: float(fields[name]) for name in ("x", "y") if name in fields}, unit)

    def parse_unit(self, reply: bytes, axis: int) -> AngleUnit:
        """Parse the answer to the question for the unit. Raises: DeviceNonsense."""
        assert self._unit is not None
        return self._unit_called(str(self._fields_of(self._unit, reply, axis)["unit"]))

    def parse_identity(self, reply: bytes) -> str:
        """Parse what it says of itself, on one line. Raises: DeviceNonsense."""
        assert self._identity is not None
        fields = self._fields_of(self._identity, reply, 1)
        said = " ".join(str(fields[name]).strip() for name in ("text", "serial") if name in fields).strip()
        if not said:
            raise DeviceNonsense("it says nothing about itself")
        return said

    def format_reading(self, x: float, y: float, unit: AngleUnit, axis: int) -> bytes:
        """Return the answer to a reading with its ends, values in the device's unit."""
        reply = self._reading.render(
            axis=axis, x=x + 0.0, y=y + 0.0, unit=self._called(unit), text="", words="1", serial="N1212"
        ).encode(_CHARACTERS)
        if self.dialect.checksum == "xor":
            reply += b"*%02X" % reduce(xor, reply.removeprefix(b"$"), 0)
        return reply + self.reply_terminator

    def format_unit(self, unit: AngleUnit, axis: int) -> bytes:
        """Return the answer to the question for the unit."""
        assert self._unit is not None
        reply = self._unit.render(axis=axis, unit=self._called(unit), text="RT,04512,1", words="00102", serial="00241")
        return reply.encode(_CHARACTERS) + self.reply_terminator

    def format_identity(self, text: str, serial: str) -> bytes:
        """Return the answer to the question who it is."""
        assert self._identity is not None
        return self._identity.render(text=text, serial=serial).encode(_CHARACTERS) + self.reply_terminator

    def _fields_of(self, template: Template, reply: bytes, axis: int) -> dict[str, FieldValue]:
        fields = template.match(reply.decode(_CHARACTERS))
        if fields is None:
            raise DeviceNonsense(f"the dialect {self.dialect.name} expects an answer such as {template.text!r}")
        if fields.get("axis", axis) != axis:
            raise DeviceNonsense(f"it answers for axis {fields['axis']}, asked was {axis}")
        return fields

    def _unit_called(self, word: str) -> AngleUnit:
        if word not in self.dialect.units:
            known = ", ".join(self.dialect.units)
            raise DeviceNonsense(
                f"its unit is {word!r}, which is none of angles (the dialect {self.dialect.name} knows: {known}); set"
                " it at the device"
            )
        return self.dialect.units[word]

    def _called(self, unit: AngleUnit) -> str:
        return next((word for word, meant in self.dialect.units.items() if meant == unit), unit)


def _checked(reply: bytes) -> bytes:
    """Return a reply without its checksum. Raises: DeviceNonsense where that is wrong."""
    body, check = reply[:-_CHECK_LENGTH], reply[-_CHECK_LENGTH:]
    if check != b"*%02X" % reduce(xor, body.removeprefix(b"$"), 0):
        raise DeviceNonsense("its checksum is wrong")
    return body
