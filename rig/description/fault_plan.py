"""``faults.toml``: what goes wrong on the twins of a rig, line by line, as one frozen value.

Each table ``[fault.NAME]`` says on which line, what, and when. :mod:`rig.twins.serving.faulty` makes it happen, in
memory (:func:`rig.assembly.open_rig.open_rig`) and on real ports (``calrig simulate --faults``); the kinds that change
bytes are those of :mod:`rig.link.faults`.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from rig.description.drivers import DESCRIBED_DRIVERS
from rig.errors import DescriptionError
from rig.toml_file import StrictTable, TomlFile, read_toml

EVERY_LINE = "*"
Count = Annotated[int, Field(ge=1)]
Seconds = Annotated[float, Field(ge=0.0)]
Kind = Literal[
    "drop", "delay", "freeze", "duplicate", "truncate", "split", "flip-bit", "garble", "stale", "echo", "previous",
    "exception", "hang-up", "rename", "swap", "power-cycle", "stall", "slip", "lag",
]  # fmt: skip

NEEDS: Mapping[str, tuple[str, ...]] = {
    "delay": ("delay_s",),
    "freeze": ("delay_s",),
    "truncate": ("keep",),
    "split": ("keep", "delay_s"),
    "stale": ("text",),
    "exception": ("code",),
    "rename": ("away_s",),
    "swap": ("other",),
    "power-cycle": ("away_s",),
    "stall": ("for_s",),
    "slip": ("slip_deg",),
    "lag": ("lag_s",),
}
"""Keys that a kind cannot do without."""
MAY_HAVE: Mapping[str, tuple[str, ...]] = {
    "duplicate": ("delay_s",),
    "flip-bit": ("byte", "bit"),
    "hang-up": ("away_s",),
    "slip": ("seen",),
}
"""Keys that a kind understands besides."""
BOTH_WAYS = frozenset(
    {"drop", "delay", "freeze", "duplicate", "truncate", "split", "flip-bit", "garble", "stale", "power-cycle"}
    | {"hang-up", "rename", "swap", "stall", "slip", "lag"}
)
"""Kinds that may befall a question as well as a reply (``on``); the others are replies by their nature."""
MOTION = frozenset({"stall", "slip", "lag"})
ONE_LINE_ONLY = MOTION | {"swap"}
"""Kinds that need one line named."""
_TRIGGERS = ("nth", "every", "at_s", "probability")
_FIELDS_OF_KINDS = (
    "delay_s",
    "keep",
    "byte",
    "bit",
    "text",
    "code",
    "away_s",
    "other",
    "for_s",
    "slip_deg",
    "seen",
    "lag_s",
)


class FaultRule(StrictTable):
    """``[fault.NAME]``: one thing that goes wrong, and when."""

    line: str
    """A table of the rig file (``axes.pitch``), or ``*`` for every line."""
    kind: Kind
    on: Literal["question", "reply"] = "reply"
    """Which pieces are counted, and changed: those on the way to the device, or from it."""
    nth: tuple[Count, ...] | None = None
    """At these pieces, counted from 1."""
    every: Count | None = None
    """At every so manieth piece."""
    at_s: Seconds | None = None
    """Once, at the first piece (bytes) or at the moment (lines, power, motion) so many rig seconds after the start."""
    probability: Annotated[float, Field(gt=0.0, le=1.0)] | None = None
    """At each piece with this chance."""
    most: Count | None = None
    """At most so many times."""
    delay_s: Seconds | None = None
    keep: Annotated[int, Field(ge=0)] | None = None
    """Bytes that are kept, or that come first."""
    byte: int | None = None
    """Place in the piece, from the end when negative; drawn where it is left out. A shorter piece stays whole."""
    bit: Annotated[int, Field(ge=0, le=7)] | None = None
    text: str | None = None
    """Latin-1, with TOML's escapes."""
    code: Annotated[int, Field(ge=1, le=255)] | None = None
    away_s: Seconds | None = None
    """How long the line or the power is gone; left out: for good."""
    other: str | None = None
    """The line that changes places with this one."""
    for_s: Seconds | None = None
    slip_deg: float | None = None
    seen: bool | None = None
    """Whether the read-back shows the slip."""
    lag_s: Seconds | None = None

    @field_validator("nth", mode="before")
    @classmethod
    def _one_or_several(cls, value: object) -> object:
        return tuple(value) if isinstance(value, list) else (value,) if isinstance(value, int) else value

    @model_validator(mode="after")
    def _is_clear(self) -> "FaultRule":
        triggers = [name for name in _TRIGGERS if getattr(self, name) is not None]
        if len(triggers) != 1:
            given = " and ".join(triggers) or "none"
            raise ValueError(f"give one of {', '.join(_TRIGGERS)} that says when, got {given}")
        needed, known = NEEDS.get(self.kind, ()), MAY_HAVE.get(self.kind, ())
        missing = [name for name in needed if getattr(self, name) is None]
        if missing:
            raise ValueError(f"{self.kind} needs {' and '.join(missing)}")
        strange = [
            name for name in _FIELDS_OF_KINDS if getattr(self, name) is not None and name not in (*needed, *known)
        ]
        if strange:
            raise ValueError(f"{self.kind} has no {strange[0]} (allowed: {', '.join((*needed, *known)) or 'none'})")
        if self.kind in ONE_LINE_ONLY and self.line == EVERY_LINE:
            raise ValueError(f"{self.kind} happens on one line; name it in place of {EVERY_LINE!r}")
        if self.kind not in BOTH_WAYS and self.on != "reply":
            raise ValueError(f"{self.kind} happens to a reply; leave out `on`")
        if self.kind == "flip-bit" and (self.byte is None) != (self.bit is None):
            raise ValueError("flip-bit takes byte and bit together, or neither to have them drawn")
        return self


class FaultPlan(StrictTable):
    """The whole file."""

    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0
    """Of everything that is drawn."""
    fault: dict[str, FaultRule] = Field(min_length=1)

    def of_line(self, keys: Iterable[str]) -> dict[str, FaultRule]:
        """Return the rules of a line that carries the devices ``keys``, by name."""
        named = (EVERY_LINE, *keys)
        return {name: rule for name, rule in self.fault.items() if rule.line in named}


def read_faults(path: Path, drivers: Mapping[str, str]) -> FaultPlan:
    """Read and check a fault file for a rig. ``drivers``: each table of the rig file (``axes.pitch``) to its driver.

    Raises: DescriptionError naming file, line and key of every mistake.
    """
    file = read_toml(path)
    try:
        plan = file.validate(FaultPlan)
    except DescriptionError as error:
        raise DescriptionError("\n".join([str(error), *_unknown_lines(file, drivers)])) from None
    complaints = [
        file.complaint(("fault", name, key), text)
        for name, rule in plan.fault.items()
        for key, text in _strangers(rule, drivers)
    ]
    if complaints:
        raise DescriptionError("\n".join(complaints))
    return plan


def _unknown_lines(file: TomlFile, drivers: Mapping[str, str]) -> Iterable[str]:
    """Yield what the rig says against a file that is wrong already: all mistakes of a file are told at once."""
    rules = file.values.get("fault")
    for name, rule in rules.items() if isinstance(rules, dict) else ():
        for key in ("line", "other"):
            line = rule.get(key) if isinstance(rule, dict) else None
            if isinstance(line, str) and (unknown := _unknown_line(key, line, drivers)):
                yield file.complaint(("fault", name, key), unknown)


def _unknown_line(key: str, line: str, drivers: Mapping[str, str]) -> str:
    """Return what is wrong with a line that the rig does not have; empty where it has it."""
    if line in (*drivers, EVERY_LINE):
        return ""
    return f"got {line!r}, allowed {', '.join(drivers)}" + (f" and {EVERY_LINE}" if key == "line" else "")


def _strangers(rule: FaultRule, drivers: Mapping[str, str]) -> Iterable[tuple[str, str]]:
    """Yield the keys of a rule that do not fit the rig, each with what is wrong."""
    for key, line in (("line", rule.line), ("other", rule.other)):
        if line is not None and (unknown := _unknown_line(key, line, drivers)):
            yield key, unknown
    if rule.kind in MOTION and not rule.line.startswith("axes."):
        yield "line", f"got {rule.line!r}: {rule.kind} happens to an axis"
    talks = {driver for line, driver in drivers.items() if rule.line in (EVERY_LINE, line)}
    if rule.kind == "exception" and (
        strange := sorted(name for name in talks if not DESCRIBED_DRIVERS[name].speaks_modbus)
    ):
        yield "kind", f"exception is a reply of Modbus, which {strange[0]} does not talk"
