"""The twin of a meter that reads angles. It streams from power-on where its dialect has a command that ends that.

Source: docs/devices/attitude-references.md. Assumed: the rate of the stream, and that what it does not know it leaves
unanswered.
"""

from collections.abc import Callable, Mapping

from rig.twins.physics.metronome import Metronome
from rig.wire.angle_dialect import AngleUnit, from_deg
from rig.wire.angle_lines import AngleCodec, Question

STREAM_HZ = 10.0
AXES = range(1, 10)
_LONGEST_LINE = 64


class AngleMeterTwin:
    """A :class:`rig.twins.twin.Twin`. ``reading_deg``: axis of the device and value to an angle at a time."""

    def __init__(self, codec: AngleCodec, unit: AngleUnit, reading_deg: Callable[[int, str, float], float]) -> None:
        self.unit = unit
        self._codec = codec
        self._reading_deg = reading_deg
        self._questions = _questions(codec)
        self._received = self._due = b""
        self._beat = Metronome()
        self._wakes = codec.dialect.quiet is not None

    def receive(self, data: bytes, now_s: float) -> None:
        self._received += data
        while (found := self._next_question()) is not None:
            match found.kind:
                case "quiet":
                    self._wakes = False
                    self._beat.stop()
                    quiet = self._codec.dialect.quiet
                    self._due += b"" if quiet is None else quiet.reply.encode("latin-1")
                case "identity" if not self._beat.is_running:
                    self._due += self._codec.format_identity("CALRIG TWIN V1.0.0", "123456789")
                case "unit":
                    self._due += self._codec.format_unit(self.unit, found.axis)
                case "reading" if not self._beat.is_running:
                    self._due += self._reading(found.axis, now_s)

    def transmit(self, now_s: float) -> bytes:
        if self._wakes:
            self._beat.start(now_s, STREAM_HZ)
            self._wakes = False
        self._due += b"".join(self._reading(1, at_s) for _, at_s in self._beat.due(now_s))
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return self._beat.next_s()

    def power_cycle(self, now_s: float) -> None:  # noqa: ARG002 it streams when it is next looked at
        self._wakes = self._codec.dialect.quiet is not None

    def _next_question(self) -> Question | None:
        """Take the first question that came whole; what is none of the dialect's is dropped."""
        while self._received:
            for command, question in self._questions.items():
                if self._received.startswith(command):
                    self._received = self._received[len(command) :]
                    return question
            if len(self._received) < _LONGEST_LINE and any(c.startswith(self._received) for c in self._questions):
                return None
            self._received = self._received[1:]
        return None

    def _reading(self, axis: int, at_s: float) -> bytes:
        x, y = (from_deg(self._reading_deg(axis, name, at_s), self.unit) for name in ("x", "y"))
        return self._codec.format_reading(x, y, self.unit, axis)


def _questions(codec: AngleCodec) -> Mapping[bytes, Question]:
    dialect = codec.dialect
    about = [Question("reading", axis) for axis in AXES]
    about += [Question("unit", axis) for axis in AXES] if dialect.unit_query is not None else []
    about += [Question("identity")] if dialect.identity is not None else []
    about += [Question("quiet")] if dialect.quiet is not None else []
    known: dict[bytes, Question] = {}
    for question in about:
        known.setdefault(codec.ask(question), question)
    return known
