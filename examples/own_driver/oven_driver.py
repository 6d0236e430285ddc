"""A driver of your own: an oven that speaks lines of ASCII, as a distribution beside calrig (docs/drivers.md).

The oven is made up. 9600 baud, lines end with CR LF, and every reply repeats its question's word:

| question       | reply                    |                                        |
|----------------|--------------------------|----------------------------------------|
| ``ID?``        | ``ID OVEN-3 SN 17``      | who it is                              |
| ``TEMP?``      | ``TEMP +023.45``         | the air, °C, two decimals              |
| ``SET?``       | ``SET +025.00``          | the setpoint                           |
| ``SET +030.00``| ``SET +030.00``          | takes a setpoint; ``ERR 2`` refuses it |
"""

import re
from typing import Literal

from rig.description.device_settings import EnvironmentSettings
from rig.devices.abilities import Environment
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, RequestRefused
from rig.lines.open_lines import Lines
from rig.link.exchange import Exchange
from rig.twins.twin import Twin
from rig.twins.world import World

HUNDREDTHS = 100
PLAUSIBLE_DEGC = (-80.0, 300.0)
"""A temperature outside is a broken probe."""
_DEGC = re.compile(rb"(?P<word>TEMP|SET) (?P<degc>[+-]\d{3}\.\d{2})")
_IDENTITY = re.compile(rb"ID (?P<name>OVEN-\d+ SN \d+)")


class OvenSettings(EnvironmentSettings):
    """What ``[environment.NAME]`` may hold beside ``port``, ``limits_degc``, ``identity`` and ``standard``."""

    driver: Literal["oven"]
    baud_rate: Literal[9600, 19200] = 9600


class Oven:
    """A :class:`rig.devices.abilities.Environment`: those four methods and a name are all that calrig asks for."""

    def __init__(self, name: str, settings: OvenSettings, exchange: Exchange) -> None:
        self.name = name
        self._settings = settings
        self._exchange = exchange

    def identify(self) -> str:
        return self._exchange.ask(b"ID?\r\n", _identity, idempotent=True)

    def temperature_degc(self) -> float:
        degc = self._ask("TEMP", b"TEMP?")
        low_degc, high_degc = PLAUSIBLE_DEGC
        if not low_degc <= degc <= high_degc:
            raise DeviceFault(
                f"{self.name}: the air reads {degc:g} degC, allowed {low_degc:g} to {high_degc:g};"
                " nothing was changed; check the probe"
            )
        return degc

    def setpoint_degc(self) -> float:
        return self._ask("SET", b"SET?")

    def hold(self, setpoint_degc: float) -> None:
        """An absolute setpoint may be sent twice; what counts is what is read back."""
        self._settings.refuse_beyond_limits(self.name, setpoint_degc)
        wanted_degc = round(setpoint_degc * HUNDREDTHS) / HUNDREDTHS
        if wanted_degc != setpoint_degc:
            raise RequestRefused(
                f"{self.name}: setpoint {setpoint_degc:g} degC: the oven takes hundredths; nothing was changed;"
                " ask for one of them"
            )
        self._ask("SET", b"SET %+07.2f" % wanted_degc)
        told_degc = self.setpoint_degc()
        if told_degc != wanted_degc:
            raise DeviceFault(
                f"{self.name}: setpoint {wanted_degc:g} degC was acknowledged, but reads back {told_degc:g} degC;"
                " the oven may heat; look at its front panel"
            )

    def _ask(self, word: str, question: bytes) -> float:
        return self._exchange.ask(question + b"\r\n", lambda reply: _degc(self.name, word, reply), idempotent=True)


def _degc(name: str, word: str, reply: bytes) -> float:
    """The whole line or nothing: a number picked out of a damaged line is a wrong number."""
    if reply.startswith(b"ERR "):
        raise DeviceRefused(f"{name}: the oven refused it: {reply!r}; nothing was changed; see its manual for the code")
    line = _DEGC.fullmatch(reply)
    if line is None or line["word"] != word.encode():
        raise DeviceNonsense(f"need {word} and a temperature such as {word} +023.45")
    return float(line["degc"])


def _identity(reply: bytes) -> str:
    line = _IDENTITY.fullmatch(reply)
    if line is None:
        raise DeviceNonsense("need ID OVEN-n SN n")
    return line["name"].decode("ascii")


def connect(name: str, settings: OvenSettings, lines: Lines) -> Environment:
    """Called when a rig is opened; ``lines`` opens the port, or the twin's line, and shares it where it is shared."""
    stream = lines.stream(f"environment.{name}", settings.port, settings.baud_rate)
    return Oven(name, settings, Exchange(stream))


class OvenTwin:
    """The oven from its other side, before the air of the rig's world: bytes in, bytes out, time is an argument."""

    def __init__(self, name: str, world: World) -> None:
        self._name = name
        self._world = world
        self._received = b""
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, self._received = (self._received + data).split(b"\r\n")
        for line in lines:
            self._due += self._answer(line, now_s) + b"\r\n"

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def _answer(self, line: bytes, now_s: float) -> bytes:
        if line == b"ID?":
            return b"ID OVEN-3 SN 17"
        if line == b"TEMP?":
            return b"TEMP %+07.2f" % self._world.read_temperature_degc(self._name, now_s)
        if (wanted := _DEGC.fullmatch(line)) and wanted["word"] == b"SET":
            self._world.hold(self._name, float(wanted["degc"]), now_s)
        elif line != b"SET?":
            return b"ERR 1"
        return b"SET %+07.2f" % self._world.setpoint_degc(self._name)


def twin(name: str, settings: OvenSettings, world: World, time_factor: float) -> Twin:  # noqa: ARG001 it needs neither
    """Called for ``port = "twin"``, for rehearsals and by ``calrig simulate``."""
    return OvenTwin(name, world)
