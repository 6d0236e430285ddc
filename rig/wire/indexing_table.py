"""Commands and replies of an indexing table as values, and as the lines of a dialect in both directions.

The driver encodes commands and decodes replies, the twin the other way round. A line is taken whole or not at all:
what is shortened, damaged or meant for another axis decodes to None.
"""

from dataclasses import dataclass

from rig.wire.table_dialect import Dialect
from rig.wire.template import FieldValue, Template


@dataclass(frozen=True, slots=True)
class Identify:
    """Ask who it is."""


@dataclass(frozen=True, slots=True)
class Move:
    """Go to an absolute table angle."""

    axis: int
    target_deg: float


@dataclass(frozen=True, slots=True)
class Home:
    axis: int


@dataclass(frozen=True, slots=True)
class Stop:
    axis: int


@dataclass(frozen=True, slots=True)
class AskPosition:
    axis: int


@dataclass(frozen=True, slots=True)
class AskState:
    axis: int


Command = Identify | Move | Home | Stop | AskPosition | AskState


@dataclass(frozen=True, slots=True)
class Identity:
    text: str


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """The command was taken."""


@dataclass(frozen=True, slots=True)
class Position:
    position_deg: float
    """Table angle by the machine's own read-back."""


@dataclass(frozen=True, slots=True)
class TableState:
    is_moving: bool
    is_seated: bool
    """Coupling engaged and locked."""
    is_homed: bool
    is_faulty: bool = False


@dataclass(frozen=True, slots=True)
class Refused:
    """The machine said no."""

    text: str


Reply = Identity | Acknowledged | Position | TableState | Refused


class TableCodec:
    """Commands and replies of one dialect as bytes."""

    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self.terminator = dialect.terminator.encode("ascii")
        self._commands: dict[type[Command], Template] = {
            AskState: Template(dialect.state.command),
            AskPosition: Template(dialect.position.command),
            Move: Template(dialect.move.command),
            Home: Template(dialect.home.command),
            Stop: Template(dialect.stop.command),
            Identify: Template(dialect.identity.command),
        }
        self._replies: dict[type[Command], Template] = {
            AskState: Template(dialect.state.reply),
            AskPosition: Template(dialect.position.reply),
            Move: Template(dialect.move.reply),
            Home: Template(dialect.home.reply),
            Stop: Template(dialect.stop.reply),
            Identify: Template(dialect.identity.reply),
        }
        self._error = Template(dialect.error.reply)

    def encode_command(self, command: Command) -> bytes:
        """Return the command as a line with its terminator."""
        fields: dict[str, FieldValue] = {name: getattr(command, name) for name in command.__slots__}
        return self._commands[type(command)].render(**fields).encode("ascii") + self.terminator

    def decode_command(self, line: bytes) -> Command | None:
        """Return the command of a whole line without terminator, or None where it is none."""
        text = _ascii(line)
        for kind, template in self._commands.items():
            fields = None if text is None else template.match(text)
            if fields is not None:
                return kind(**fields)  # type: ignore[arg-type]
        return None

    def encode_reply(self, reply: Reply, axis: int, command: type[Command] | None) -> bytes:
        """Return what the machine answers; ``command`` None where it did not understand which."""
        if isinstance(reply, Refused) or command is None:
            text = self._error.render(axis=axis, text=getattr(reply, "text", ""))
        else:
            text = self._replies[command].render(axis=axis, **self._fields(reply))
        return text.encode("ascii") + self.terminator

    def decode_reply(self, line: bytes, command: Command) -> Reply | None:
        """Return the reply that a whole line without terminator is to ``command``; None where it cannot be one."""
        text = _ascii(line)
        if text is None:
            return None
        asked = getattr(command, "axis", None)
        error = self._error.match(text)
        if error is not None and error.get("axis", asked) == asked:
            return Refused(str(error.get("text", "")))
        fields = self._replies[type(command)].match(text)
        if fields is None or fields.get("axis", asked) != asked:
            return None
        return self._reply(command, fields)

    def _reply(self, command: Command, fields: dict[str, FieldValue]) -> Reply | None:
        if isinstance(command, AskPosition):
            return Position(float(fields["position_deg"]))
        if isinstance(command, AskState):
            return self._state(frozenset(str(fields["words"]).split()))
        return Identity(str(fields["text"])) if isinstance(command, Identify) else Acknowledged()

    def _state(self, told: frozenset[str]) -> TableState | None:
        """Return the state that the words tell; None where one is unknown, missing or contradicts another."""
        words = self.dialect.words
        pairs = [
            (words.moving, words.resting),
            (words.homed, words.not_homed),
            *zip(words.seated, words.lifted, strict=True),
        ]
        if told - {word for pair in pairs for word in pair} - {words.fault} or any(
            (yes in told) == (no in told) for yes, no in pairs
        ):
            return None
        return TableState(
            is_moving=words.moving in told,
            is_seated=all(word in told for word in words.seated),
            is_homed=words.homed in told,
            is_faulty=words.fault in told,
        )

    def _fields(self, reply: Reply) -> dict[str, FieldValue]:
        if isinstance(reply, Position):
            return {"position_deg": reply.position_deg}
        if isinstance(reply, Identity):
            return {"text": reply.text}
        return {"words": " ".join(self._words(reply))} if isinstance(reply, TableState) else {}

    def _words(self, state: TableState) -> list[str]:
        words = self.dialect.words
        told = [words.moving if state.is_moving else words.resting]
        told += words.seated if state.is_seated else words.lifted
        told.append(words.homed if state.is_homed else words.not_homed)
        return [*told, words.fault] if state.is_faulty else told


def _ascii(line: bytes) -> str | None:
    try:
        return line.decode("ascii")
    except UnicodeDecodeError:
        return None
