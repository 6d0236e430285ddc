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


@dataclass(frozen=True, slots=True)
class Prepare:
    """What some machines must be told before a move."""

    axis: int


@dataclass(frozen=True, slots=True)
class Enable:
    """Motor on, interlock closed: once before the first motion."""

    axis: int


@dataclass(frozen=True, slots=True)
class Speed:
    """How fast to go to positions."""

    axis: int
    speed_dps: float


@dataclass(frozen=True, slots=True)
class Rate:
    """Turn on and on."""

    axis: int
    rate_dps: float


@dataclass(frozen=True, slots=True)
class Release:
    """A question that fetches what the machine says late."""

    axis: int


Command = Enable | Prepare | Speed | Identify | Move | Rate | Release | Home | Stop | AskPosition | AskState


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
    is_homed: bool | None
    """None where the machine does not tell."""
    is_faulty: bool = False


@dataclass(frozen=True, slots=True)
class Refused:
    """The machine said no."""

    text: str


@dataclass(frozen=True, slots=True)
class Written:
    """A number as a template writes it."""

    template: str
    line: str
    value: float
    """What the machine reads in it; NaN where it reads none."""


Reply = Identity | Acknowledged | Position | TableState | Refused


class TableCodec:
    """Commands and replies of one dialect as bytes."""

    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self.terminator = dialect.terminator.encode("ascii")
        self.reply_terminator = dialect.answer_terminator.encode("ascii")
        queries = {
            AskState: dialect.state,
            AskPosition: dialect.position,
            Move: dialect.move,
            Home: dialect.home,
            Stop: dialect.stop,
            Identify: dialect.identity,
            Prepare: dialect.prepare,
            Enable: dialect.enable,
            Speed: dialect.speed,
            Rate: dialect.rate,
        }
        there = {kind: query for kind, query in queries.items() if query is not None}
        per_deg = dialect.counts_per_deg
        self._commands: dict[type[Command], Template] = {
            kind: Template(query.command, per_deg) for kind, query in there.items()
        }
        if dialect.rate is not None and dialect.rate.release is not None:
            self._commands[Release] = Template(dialect.rate.release)
        self._bare = frozenset({Stop} if dialect.stop is not None and dialect.stop.bare else ())
        self._replies: dict[type[Command], Template] = {
            kind: Template(query.reply, per_deg) for kind, query in there.items() if query.reply is not None
        }
        self._errors = () if dialect.error is None else tuple(map(Template, dialect.error.forms))

    def knows(self, kind: type[Command]) -> bool:
        """Return whether the machine has this command."""
        return kind in self._commands

    def is_answered(self, kind: type[Command]) -> bool:
        """Return whether the machine says anything to it."""
        return kind in self._replies

    def names_its_axis(self, kind: type[Command]) -> bool:
        """Return whether the machine says to it which axis took it."""
        return kind in self._replies and "axis" in self._replies[kind].fields

    def encode_command(self, command: Command) -> bytes:
        """Return the command as a line with its terminator."""
        fields: dict[str, FieldValue] = {name: getattr(command, name) for name in command.__slots__}
        return self._commands[type(command)].render(**fields).encode("ascii") + self.terminator

    def written(self, command: Move | Speed | Rate) -> Written:
        """Return the number of a command as the machine reads it: its format may have fewer decimals."""
        template = self._commands[type(command)]
        line = template.render(**{name: getattr(command, name) for name in command.__slots__})
        matched = template.match(line)
        value = float("nan") if matched is None else float(matched[command.__slots__[-1]])
        return Written(template.text, line, value)

    def is_bare(self, kind: type[Command]) -> bool:
        """Return whether some machines obey its word alone; what is said to the word or to its end is not known."""
        return kind in self._bare

    def bare_commands(self) -> frozenset[bytes]:
        """Return the words that some machines obey without a terminator behind them, of axis 1."""
        return frozenset(self._commands[kind].render(axis=1).encode("ascii") for kind in self._bare)

    def decode_command(self, line: bytes) -> Command | None:
        """Return the command of a whole line without terminator, or None where it is none."""
        text = _ascii(line)
        for kind, template in self._commands.items():
            fields = None if text is None else template.match(text)
            if fields is not None:
                number = {"axis": 1} if "axis" in kind.__slots__ else {}  # a machine with one axis has no number for it
                return kind(**(number | fields))  # type: ignore[arg-type]
        return None

    def encode_reply(self, reply: Reply, axis: int, command: type[Command] | None) -> bytes:
        """Return what the machine answers; ``command`` None where it did not understand which."""
        if isinstance(reply, Refused) or command is None:
            if not self._errors:
                return b""
            text = self._errors[0].render(axis=axis, text=getattr(reply, "text", ""))
        elif command not in self._replies:
            return b""
        else:
            text = self._replies[command].render(axis=axis, **self._fields(reply))
        return text.encode("ascii") + self.reply_terminator

    def decode_reply(self, line: bytes, command: Command) -> Reply | None:
        """Return the reply that a whole line without terminator is to ``command``; None where it cannot be one."""
        text = _ascii(line.strip(b"\r\n") if self.dialect.reply_terminator else line)
        if text is None or type(command) not in self._replies:
            return None
        addressed = getattr(command, "axis", None)
        for form in self._errors:
            error = form.match(text)
            if error is not None and error.get("axis", addressed) == addressed:
                # Of several forms the whole line is told: what stands in it besides the text tells something, too.
                return Refused(text if len(self._errors) > 1 else str(error.get("text", "")))
        fields = self._replies[type(command)].match(text)
        if fields is None or fields.get("axis", addressed) != addressed:
            return None
        if isinstance(command, AskPosition):
            return Position(float(fields["position_deg"]))
        if isinstance(command, AskState):
            if "status" in fields:
                return self._state_of_bits(int(fields["status"]))
            return self._state(frozenset(str(fields["words"]).split()))
        return Identity(str(fields["text"])) if isinstance(command, Identify) else Acknowledged()

    def _state(self, words_seen: frozenset[str]) -> TableState | None:
        """Return the state that the words tell; None where one is unknown, missing or contradicts another."""
        words = self.dialect.words
        assert words is not None, "the dialect was checked"
        home = [] if words.homed is None or words.not_homed is None else [(words.homed, words.not_homed)]
        pairs = [
            (words.moving, words.resting),
            *home,
            *zip(words.seated, words.lifted, strict=True),
        ]
        if words_seen - {word for pair in pairs for word in pair} - {words.fault} or any(
            (yes in words_seen) == (no in words_seen) for yes, no in pairs
        ):
            return None
        return TableState(
            is_moving=words.moving in words_seen,
            is_seated=all(word in words_seen for word in words.seated),
            is_homed=words.homed in words_seen if home else None,
            is_faulty=words.fault in words_seen,
        )

    def _state_of_bits(self, status: int) -> TableState:
        bits = self.dialect.bits
        assert bits is not None, "the dialect was checked"

        def has(wanted: list[int]) -> bool:
            return any(status >> bit & 1 for bit in wanted)

        return TableState(
            is_moving=has(bits.moving) if bits.moving else not has(bits.resting),
            is_seated=not bits.seated or has(bits.seated),
            is_homed=has(bits.homed) if bits.homed else None,
            is_faulty=has(bits.fault),
        )

    def _status(self, state: TableState) -> int:
        bits = self.dialect.bits
        assert bits is not None
        set_bits = bits.moving[:1] if state.is_moving else bits.resting[:1]
        set_bits = [*set_bits, *(bits.seated if state.is_seated else []), *(bits.homed if state.is_homed else [])]
        return sum(1 << bit for bit in {*set_bits, *(bits.fault[:1] if state.is_faulty else [])})

    def _fields(self, reply: Reply) -> dict[str, FieldValue]:
        if isinstance(reply, Position):
            return {"position_deg": reply.position_deg}
        if isinstance(reply, Identity):
            return {"text": reply.text}
        if not isinstance(reply, TableState):
            return {"text": "OK"}
        return {"words": " ".join(self._words(reply))} if self.dialect.words else {"status": self._status(reply)}

    def _words(self, state: TableState) -> list[str]:
        words = self.dialect.words
        assert words is not None, "the dialect was checked"
        shown = [words.moving if state.is_moving else words.resting]
        shown += words.seated if state.is_seated else words.lifted
        home = words.homed if state.is_homed else words.not_homed
        return [*shown, *([home] if home else []), *([words.fault] if state.is_faulty and words.fault else [])]


def _ascii(line: bytes) -> str | None:
    try:
        return line.decode("ascii")
    except UnicodeDecodeError:
        return None
