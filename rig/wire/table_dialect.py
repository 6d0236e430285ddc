"""Dialect files: every maker's indexing table speaks another grammar of lines, so the grammar is a file.

A dialect names a template for each command and reply, the line and its ends, and what the words or bits of the state
mean. What a machine does not have is left out: a reply (it is silent), a stop, a state, an identity, a home. The
dialects in ``rig/dialects`` are calrig's own; those in ``rig/dialects/published`` follow published command sets, by
docs/devices/indexing-table.md; those in ``rig/dialects/rate`` are of machines that turn at a rate, by
docs/devices/rate-table.md. Dialects of meters that read angles: rig/wire/angle_dialect.py.
"""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, field_validator, model_validator
from pydantic.json_schema import SkipJsonSchema

from rig.errors import DescriptionError
from rig.toml_file import StrictTable, as_tuple, read_toml
from rig.wire.dialect_files import name_or_file, shipped_in
from rig.wire.template import Template


def angle_fields(angle: str) -> tuple[str, ...]:
    """Return the fields that an angle may be written in."""
    return tuple(f"{angle}_{part}" for part in ("deg", "counts", "d", "m", "s"))


def _template(text: str, allowed: frozenset[str]) -> str:
    extra = Template(text, counts_per_deg=1.0).fields - allowed
    if extra:
        raise ValueError(f"field {{{sorted(extra)[0]}}} has no meaning here (allowed: {', '.join(sorted(allowed))})")
    return text


def line_with(*fields: str) -> AfterValidator:
    """Return the check of one line of a dialect that may have these fields."""
    return AfterValidator(partial(_template, allowed=frozenset(fields)))


class PlainQuery(StrictTable):
    """A command about one axis that is only acknowledged, or not even that."""

    command: Annotated[str, line_with("axis")]
    reply: Annotated[str, line_with("axis", "text")] | None = None
    """``{text}``: any line will do."""


class StopCommand(PlainQuery):
    """A stop; ``bare`` where some machines obey the word alone, and others at the end of its line.

    Word and end are sent, so both stop. What is said to either is not known: it is thrown away.
    """

    bare: bool = False

    @model_validator(mode="after")
    def _says_what_nobody_knows(self) -> "StopCommand":
        if self.bare and self.reply is not None:
            raise ValueError("bare and reply: what a bare stop answers is thrown away; leave one of the two out")
        return self


class SpeedCommand(StrictTable):
    """How fast the machine goes to a position."""

    command: Annotated[str, line_with("axis", "speed_dps")]
    reply: Annotated[str, line_with("axis", "text")] | None = None


class RateCommand(StrictTable):
    """Turn on and on. ``release``: a question that fetches what the machine says late; its answer is thrown away."""

    command: Annotated[str, line_with("axis", "rate_dps")]
    reply: Annotated[str, line_with("axis")] | None = None
    release: Annotated[str, line_with("axis")] | None = None


class IdentityQuery(StrictTable):
    command: Annotated[str, line_with()]
    reply: Annotated[str, line_with("text")]


class MoveCommand(StrictTable):
    command: Annotated[str, line_with("axis", *angle_fields("target"))]
    reply: Annotated[str, line_with("axis", "text")] | None = None
    targets_deg: tuple[float, float] | None = None
    """Lowest and highest angle that the machine takes, as it counts them; None: whatever can be written."""

    @field_validator("targets_deg", mode="before")
    @classmethod
    def _pair(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _low_below_high(self) -> "MoveCommand":
        if self.targets_deg is not None and not self.targets_deg[0] < self.targets_deg[1]:
            low, high = self.targets_deg
            raise ValueError(f"targets_deg must be [low, high] with low < high, got [{low:g}, {high:g}]")
        return self


class PositionQuery(StrictTable):
    command: Annotated[str, line_with("axis")]
    reply: Annotated[str, line_with("axis", *angle_fields("position"))]


class StateQuery(StrictTable):
    """The settle and lock query."""

    command: Annotated[str, line_with("axis")]
    reply: Annotated[str, line_with("axis", "words", "status")]


ErrorLine = Annotated[str, line_with("axis", "text")]


class ErrorReply(StrictTable):
    """What the machine says in place of an answer; several forms where it has several, or where none is certain."""

    reply: ErrorLine | Annotated[list[ErrorLine], Field(min_length=1)]

    @property
    def forms(self) -> list[str]:
        return [self.reply] if isinstance(self.reply, str) else self.reply


class StateWords(StrictTable):
    """What the words of the state mean. A dialect without words for a coupling, a home or a fault leaves them out."""

    resting: str
    moving: str
    seated: list[str] = Field(default_factory=list)
    lifted: list[str] = Field(default_factory=list)
    """The opposites of ``seated``, in the same order."""
    homed: str | None = None
    not_homed: str | None = None
    fault: str | None = None

    @model_validator(mode="after")
    def _opposites(self) -> "StateWords":
        if len(self.seated) != len(self.lifted):
            raise ValueError(f"seated and lifted must be as many words, got {len(self.seated)} and {len(self.lifted)}")
        if (self.homed is None) != (self.not_homed is None):
            raise ValueError("homed and not_homed belong together: give both or neither")
        return self


Bit = Annotated[int, Field(ge=0, le=39)]


class StateBits(StrictTable):
    """What the bits of the status mean, each list any of them. A dialect without a bit for it leaves a list out."""

    moving: list[Bit] = Field(default_factory=list)
    resting: list[Bit] = Field(default_factory=list)
    """Instead of ``moving``: bits that are set at rest."""
    homed: list[Bit] = Field(default_factory=list)
    seated: list[Bit] = Field(default_factory=list)
    fault: list[Bit] = Field(default_factory=list)

    @model_validator(mode="after")
    def _tells_motion(self) -> "StateBits":
        if bool(self.moving) == bool(self.resting):
            raise ValueError("give the bits of moving, or those of resting, and not both")
        return self


class LineSettings(StrictTable):
    """What a serial line is set to."""

    baud_rate: Literal[150, 300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600] = (
        9600
    )
    parity: Literal["N", "E", "O"] = "N"
    data_bits: Literal[7, 8] = 8
    stop_bits: Literal[1, 2] = 1
    rts_cts: bool = False


class Dialect(StrictTable):
    """A dialect file."""

    name: str
    increment_deg: Annotated[float, Field(gt=0.0)]
    counts_per_turn: Annotated[float, Field(gt=0.0)] | None = None
    """Of the table, where the machine is told counts."""
    terminator: Annotated[str, Field(min_length=1, max_length=2)]
    reply_terminator: Annotated[str, Field(min_length=1, max_length=6)] | None = None
    """Where replies end otherwise, or with a prompt: line ends before it are then taken off."""
    line: LineSettings = LineSettings()
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 2.0
    position_is: Literal["measured", "commanded"] = "measured"
    """``commanded``: it tells how far the motor was sent, not where the table stands; ``calrig check`` says so."""
    position_wraps: bool = False
    """Positions begin again after a turn."""
    still_s: Annotated[float, Field(gt=0.0, le=10.0)] = 0.5
    """Without a state query: two positions so far apart tell whether it moves; longer than it takes to start."""
    identity: IdentityQuery | None = None
    prepare: PlainQuery | None = None
    """Sent before every move, such as the choice of absolute positions."""
    move: MoveCommand
    enable: PlainQuery | None = None
    """Sent once before the first motion of a connection: motor on, interlock closed."""
    speed: SpeedCommand | None = None
    rate: RateCommand | None = None
    """Of a machine that turns at a rate."""
    home: PlainQuery | None = None
    """Without one positions are absolute, and a home moves nothing."""
    stop: StopCommand | None = None
    position: PositionQuery
    state: StateQuery | None = None
    error: ErrorReply | None = None
    words: StateWords | None = None
    bits: StateBits | None = None

    @property
    def counts_per_deg(self) -> float | None:
        return None if self.counts_per_turn is None else self.counts_per_turn / 360.0

    @property
    def answer_terminator(self) -> str:
        return self.reply_terminator or self.terminator

    @model_validator(mode="after")
    def _tells_its_state(self) -> "Dialect":
        fields = Template(self.state.reply).fields if self.state else frozenset()
        for field, table, there in (("words", "words", self.words), ("status", "bits", self.bits)):
            if (field in fields) != (there is not None):
                raise ValueError(f"state: {{{field}}} in its reply and the table [{table}] belong together")
        if self.state is not None and len(fields & {"words", "status"}) != 1:
            raise ValueError("state: its reply needs {words} or {status:…}, and not both")
        return self

    @model_validator(mode="after")
    def _turns_can_be_stopped(self) -> "Dialect":
        if self.rate is not None and self.stop is None:
            raise ValueError("rate: a machine that turns on and on needs a stop")
        return self

    @model_validator(mode="after")
    def _numbers_come_back(self) -> "Dialect":
        """Refuse a template that cannot read what it writes: a field that runs into another, or too coarse counts."""
        for key, text, angle in (("move", self.move.command, "target"), ("position", self.position.reply, "position")):
            template = Template(text, self.counts_per_deg)
            if f"{angle}_deg" not in {f"{name.partition('_')[0]}_deg" for name in template.fields if "_" in name}:
                raise ValueError(f"{key}: there is no angle in {text!r}")
            quarter = round(90.0 / self.increment_deg)
            for steps in (0, 1, -1, 3, quarter, -quarter, 2 * quarter, 3 * quarter + 1):
                deg = steps * self.increment_deg
                line = template.render(axis=1, **{f"{angle}_deg": deg})
                matched = template.match(line)
                if matched is None or abs(float(matched[f"{angle}_deg"]) - deg) > 0.5 * self.increment_deg:
                    back = "as nothing" if matched is None else f"{float(matched[f'{angle}_deg']):g}°"
                    raise ValueError(
                        f"{key}: {deg:g}° is written {line!r}, which reads back {back}: a format that cannot be"
                        " parsed back, or too coarse for increment_deg"
                    )
        return self


NamedDialect = Annotated[
    Annotated[str, Tag("name")] | Annotated[SkipJsonSchema[Dialect], Tag("file")], Discriminator(name_or_file)
]
"""Name of a shipped dialect or path of a dialect file; what the file says once it is read."""


def load_dialect(name: str | Dialect | None, increment_deg: float) -> Dialect:
    """Return a shipped dialect by name, a dialect file by path, or for None the coarsest shipped one that fits.

    It fits where it has the increment. One that was read is returned as it is.

    Raises: DescriptionError.
    """
    if isinstance(name, Dialect):
        return name
    shipped = shipped_dialects()
    if name is not None:
        named = shipped | published_dialects() | rate_dialects()
        return named[name] if name in named else read_toml(Path(name)).validate(Dialect)
    fitting = [dialect for dialect in shipped.values() if _divides(dialect.increment_deg, increment_deg)]
    if not fitting:
        known = ", ".join(f"{dialect.name} ({dialect.increment_deg:g}°)" for dialect in shipped.values())
        raise DescriptionError(
            f"increment_deg: got {increment_deg:g}°, which is a multiple of no shipped dialect's increment: {known};"
            ' name a dialect of your own: dialect = "my-table.toml"'
        )
    return max(fitting, key=lambda dialect: dialect.increment_deg)


def shipped_dialects() -> dict[str, Dialect]:
    """Return the dialects of calrig's own twin, by name: a table gets one of them by its increment."""
    return shipped_in("dialects", Dialect)


def published_dialects() -> dict[str, Dialect]:
    """Return the dialects after published command sets, by name: a rig file names the one it wants."""
    return shipped_in("dialects/published", Dialect)


def rate_dialects() -> dict[str, Dialect]:
    """Return the dialects of rate tables, by name: calrig's own, and those after public programs."""
    return shipped_in("dialects/rate", Dialect)


def _divides(fine_deg: float, coarse_deg: float) -> bool:
    times = coarse_deg / fine_deg
    return times >= 0.5 and abs(times - round(times)) < 1e-6
