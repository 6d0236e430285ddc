"""Dialect files: every maker's indexing table speaks another grammar of lines, so the grammar is a file.

A dialect names a template for each command and reply, the terminator and what the words of the state mean. No maker
publishes such a protocol; the shipped dialects are calrig's own. They lie in ``rig/dialects``.
"""

from functools import partial
from importlib.resources import as_file, files
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, Field, model_validator

from rig.errors import DescriptionError
from rig.toml_file import StrictTable, read_toml
from rig.wire.template import Template


def _template(text: str, allowed: frozenset[str]) -> str:
    extra = Template(text).fields - allowed
    if extra:
        raise ValueError(f"field {{{sorted(extra)[0]}}} has no meaning here (allowed: {', '.join(sorted(allowed))})")
    return text


def _line(*fields: str) -> AfterValidator:
    return AfterValidator(partial(_template, allowed=frozenset(fields)))


class PlainQuery(StrictTable):
    """A command about one axis that is only acknowledged."""

    command: Annotated[str, _line("axis")]
    reply: Annotated[str, _line("axis")]


class IdentityQuery(StrictTable):
    command: Annotated[str, _line()]
    reply: Annotated[str, _line("text")]


class MoveCommand(StrictTable):
    command: Annotated[str, _line("axis", "target_deg")]
    reply: Annotated[str, _line("axis")]


class PositionQuery(StrictTable):
    command: Annotated[str, _line("axis")]
    reply: Annotated[str, _line("axis", "position_deg")]


class StateQuery(StrictTable):
    """The settle and lock query."""

    command: Annotated[str, _line("axis")]
    reply: Annotated[str, _line("axis", "words")]


class ErrorReply(StrictTable):
    reply: Annotated[str, _line("axis", "text")]


class StateWords(StrictTable):
    """What the words of the state mean. A dialect without words for a coupling or a home leaves them out."""

    resting: str
    moving: str
    seated: list[str] = Field(default_factory=list)
    lifted: list[str] = Field(default_factory=list)
    """The opposites of ``seated``, in the same order."""
    homed: str
    not_homed: str
    fault: str

    @model_validator(mode="after")
    def _opposites(self) -> "StateWords":
        if len(self.seated) != len(self.lifted):
            raise ValueError(f"seated and lifted must be as many words, got {len(self.seated)} and {len(self.lifted)}")
        return self


class Dialect(StrictTable):
    """A dialect file."""

    name: str
    increment_deg: Annotated[float, Field(gt=0.0)]
    terminator: Annotated[str, Field(min_length=1, max_length=2)]
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 2.0
    identity: IdentityQuery
    move: MoveCommand
    home: PlainQuery
    stop: PlainQuery
    position: PositionQuery
    state: StateQuery
    error: ErrorReply
    words: StateWords


def load_dialect(name: str | None, increment_deg: float) -> Dialect:
    """Return a shipped dialect by name, a dialect file by path, or for None the coarsest shipped one that fits.

    It fits where it has the increment.

    Raises: DescriptionError.
    """
    shipped = shipped_dialects()
    if name is not None:
        return shipped[name] if name in shipped else read_toml(Path(name)).validate(Dialect)
    fitting = [dialect for dialect in shipped.values() if _divides(dialect.increment_deg, increment_deg)]
    if not fitting:
        known = ", ".join(f"{dialect.name} ({dialect.increment_deg:g} deg)" for dialect in shipped.values())
        raise DescriptionError(
            f"increment_deg: got {increment_deg:g} deg, which is a multiple of no shipped dialect's increment: {known};"
            ' name a dialect of your own: dialect = "my-table.toml"'
        )
    return max(fitting, key=lambda dialect: dialect.increment_deg)


def dialect_name(text: str, folder: Path) -> str:
    """Return what a file in ``folder`` means by ``text``: a shipped dialect, or a path relative to that folder."""
    return text if text in shipped_dialects() else str(folder / text)


def shipped_dialects() -> dict[str, Dialect]:
    """Return the dialects that come with calrig, by name."""
    with as_file(files("rig") / "dialects") as folder:
        dialects = [read_toml(path).validate(Dialect) for path in sorted(folder.glob("*.toml"))]
    return {dialect.name: dialect for dialect in dialects}


def _divides(fine_deg: float, coarse_deg: float) -> bool:
    times = coarse_deg / fine_deg
    return times >= 0.5 and abs(times - round(times)) < 1e-6
