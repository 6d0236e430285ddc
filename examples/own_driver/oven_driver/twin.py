"""The oven from its other side: for ``port = "twin"``, for rehearsals and for ``calrig simulate``."""

from oven_driver.codec import DEGC, write_degc
from rig.description.device_settings import EnvironmentSettings
from rig.twins.physics.world import World
from rig.twins.twin import Twin


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
            return write_degc("TEMP", self._world.read_temperature_degc(self._name, now_s))
        if (wanted := DEGC.fullmatch(line)) and wanted["word"] == b"SET":
            self._world.hold(self._name, float(wanted["degc"]), now_s)
        elif line != b"SET?":
            return b"ERR 1"
        return write_degc("SET", self._world.setpoint_degc(self._name))


def twin(name: str, settings: EnvironmentSettings, world: World, time_factor: float) -> Twin:  # noqa: ARG001 it needs neither
    """Make the twin for ``port = "twin"``, for rehearsals and by ``calrig simulate``."""
    return OvenTwin(name, world)
