"""The supply as calrig uses it: its table in a rig file, and the members of a field.

The supply is made up. Lines end with a line feed: ``ISET 0.1250`` sets a current in ampere, ``IOUT?`` tells the one
that flows, ``*IDN?`` who it is.
"""

import math
import re
from typing import Literal

from rig.abilities.abilities import Field, FieldState
from rig.description.device_settings import FieldSettings, Positive
from rig.errors import DeviceNonsense, DeviceRefused, RequestRefused
from rig.lines.open_lines import Lines
from rig.link.exchange import Exchange

STEP_A = 0.0001
_CURRENT = re.compile(rb"[+-]\d\.\d{4}")


class CoilSettings(FieldSettings):
    """What ``[field.NAME]`` may hold beside the keys of every field."""

    driver: Literal["coil-supply"]
    ut_per_a: Positive
    """The coil's constant, from its certificate."""


class Coil:
    """A :class:`rig.abilities.abilities.Field`."""

    def __init__(self, name: str, settings: CoilSettings, exchange: Exchange) -> None:
        self.name = name
        self.limits_ut = settings.limits_ut
        self._ut_per_a = settings.ut_per_a
        self._exchange = exchange
        self._wanted_a: float | None = None
        """None: nobody has asked for a field yet, so it is not known."""

    def identify(self) -> str:
        identity = self._exchange.ask(b"*IDN?\n", _text, idempotent=True)
        if not identity.startswith("COIL-SUPPLY"):
            raise DeviceRefused(f"{self.name}: it is {identity!r}, need a COIL-SUPPLY; nothing was set; check the port")
        return identity

    def check_field(self, field_ut: float) -> None:
        low_ut, high_ut = self.limits_ut
        if not (math.isfinite(field_ut) and low_ut <= field_ut <= high_ut):
            raise RequestRefused(
                f"{self.name}: apply {field_ut:g} µT: allowed {low_ut:g} to {high_ut:g} µT (field.{self.name}:"
                " limits_ut); nothing was set; ask for a field inside"
            )

    def start_field(self, field_ut: float) -> None:
        self.check_field(field_ut)
        self._wanted_a = round(field_ut / self._ut_per_a, 4)
        self._exchange.tell(b"ISET %+.4f\n" % (self._wanted_a + 0.0))

    def state(self) -> FieldState:
        """Believe the current that flows and not the one that was sent."""
        flows_a = self._exchange.ask(b"IOUT?\n", _current, idempotent=True)
        if self._wanted_a is None or abs(flows_a - self._wanted_a) > 0.5 * STEP_A:
            return FieldState(None)
        return FieldState(flows_a * self._ut_per_a)

    def stop(self) -> None:
        self._wanted_a = None
        self._exchange.tell(b"ISET +0.0000\n")


def connect(name: str, settings: CoilSettings, lines: Lines) -> Field:
    """Open the supply when a rig is opened."""
    return Coil(name, settings, Exchange(lines.stream(f"field.{name}", settings.port), terminator=b"\n"))


def _text(line: bytes) -> str:
    if not line.isascii() or not line.strip():
        raise DeviceNonsense("it answers with a line of text")
    return line.decode("ascii")


def _current(line: bytes) -> float:
    if _CURRENT.fullmatch(line) is None:
        raise DeviceNonsense("IOUT? is answered by a current such as +0.1250")
    return float(line)
