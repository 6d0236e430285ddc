"""The oven as calrig uses it: its table in a rig file, and the members of an environment."""

from typing import Literal

from oven_driver.codec import HUNDREDTHS, read_degc, read_identity, write_degc
from rig.abilities.abilities import Environment
from rig.description.device_settings import EnvironmentSettings
from rig.errors import DeviceFault, RequestRefused
from rig.lines.open_lines import Lines
from rig.link.exchange import Exchange

PLAUSIBLE_DEGC = (-80.0, 300.0)
"""A temperature outside is a broken probe."""


class OvenSettings(EnvironmentSettings):
    """What ``[environment.NAME]`` may hold beside ``port``, ``limits_degc``, ``identity`` and ``standard``."""

    driver: Literal["oven"]
    baud_rate: Literal[9600, 19200] = 9600


class Oven:
    """A :class:`rig.abilities.abilities.Environment`: those four methods and a name are all that calrig asks for."""

    def __init__(self, name: str, settings: OvenSettings, exchange: Exchange) -> None:
        self.name = name
        self._settings = settings
        self._exchange = exchange

    def identify(self) -> str:
        return self._exchange.ask(b"ID?\r\n", read_identity, idempotent=True)

    def temperature_degc(self) -> float:
        degc = self._ask("TEMP", b"TEMP?")
        low_degc, high_degc = PLAUSIBLE_DEGC
        if not low_degc <= degc <= high_degc:
            raise DeviceFault(
                f"{self.name}: the air reads {degc:g} °C, allowed {low_degc:g} to {high_degc:g};"
                " nothing was changed; check the probe"
            )
        return degc

    def setpoint_degc(self) -> float:
        return self._ask("SET", b"SET?")

    def hold(self, setpoint_degc: float) -> None:
        """Send a setpoint; an absolute one may be sent twice, and what counts is what is read back."""
        self._settings.refuse_beyond_limits(self.name, setpoint_degc)
        wanted_degc = round(setpoint_degc * HUNDREDTHS) / HUNDREDTHS
        if wanted_degc != setpoint_degc:
            raise RequestRefused(
                f"{self.name}: setpoint {setpoint_degc:g} °C: the oven takes hundredths; nothing was changed;"
                " ask for one of them"
            )
        self._ask("SET", write_degc("SET", wanted_degc))
        confirmed_degc = self.setpoint_degc()
        if confirmed_degc != wanted_degc:
            raise DeviceFault(
                f"{self.name}: setpoint {wanted_degc:g} °C was acknowledged, but reads back {confirmed_degc:g} °C;"
                " the oven may heat; look at its front panel"
            )

    def _ask(self, word: str, question: bytes) -> float:
        return self._exchange.ask(question + b"\r\n", lambda reply: read_degc(self.name, word, reply), idempotent=True)


def connect(name: str, settings: OvenSettings, lines: Lines) -> Environment:
    """Open the oven when a rig is opened.

    ``lines`` opens the port, or the twin's line, and shares it where it is shared.
    """
    stream = lines.stream(f"environment.{name}", settings.port, settings.baud_rate)
    return Oven(name, settings, Exchange(stream))
