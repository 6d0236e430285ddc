"""The meter from its other side: ``ScpiPort`` takes messages apart, this says what they mean."""

from collections.abc import Mapping

from nano_meter.device import MAINS_HZ, NanoSettings
from rig.twins.physics.world import World
from rig.twins.scpi_port import OUT_OF_RANGE, UNDEFINED_HEADER, Refused, ScpiPort
from rig.twins.twin import Twin
from rig.wire import scpi

RANGE_V = 12.0
TAKEN = "(what READ? has taken)"
"""No client can send this header."""


class NanoTwin:
    """A :class:`rig.twins.scpi_port.ScpiUnit`. ``wiring``: input to a channel of the world."""

    words: Mapping[str, str] = {"INPUT": "INP"}

    def __init__(self, world: World, wiring: Mapping[int, str]) -> None:
        self._world, self._wiring = world, wiring
        self._input, self._nplc = 1, 10.0
        self._ready_s = 0.0

    def answered_from_s(self, header: str) -> float | None:
        return self._ready_s if header == TAKEN else None

    def expand(self, header: str, parameters: str) -> tuple[tuple[str, str], ...] | None:  # noqa: ARG002
        return (("(start)", ""), (TAKEN, "")) if header == "READ?" else None

    def obey(self, header: str, parameters: str, now_s: float) -> bytes | None:
        match header:
            case "*IDN?":
                return b"ACME,NANO-7,17,1.0"
            case "*RST":
                self._input, self._nplc = 1, 10.0
            case "INP?":
                return b"%d" % self._input
            case "NPLC?":
                return b"%g" % self._nplc
            case "INP" if parameters in ("1", "2", "3"):
                self._input = int(parameters)
            case "NPLC":
                self._nplc = float(parameters)
            case "(start)":
                self._ready_s = now_s + self._nplc / MAINS_HZ
            case "(what READ? has taken)":
                return self._reading(self._ready_s)
            case _:
                raise Refused(OUT_OF_RANGE if header == "INP" else UNDEFINED_HEADER)
        return None

    def advance(self, now_s: float) -> None:
        """Nothing happens by itself."""

    def _reading(self, at_s: float) -> bytes:
        channel = self._wiring.get(self._input)
        value_v = 0.0 if channel is None else self._world.read_voltage_v(channel, at_s)
        return scpi.format_reading(value_v if abs(value_v) <= RANGE_V else scpi.OVERLOAD)


def twin(name: str, settings: NanoSettings, world: World) -> tuple[Twin, str]:
    """Make the twin, and say how the rig file writes its address: as the port alone."""
    wiring = {number: f"{name}.{channel}" for channel, number in settings.channels.items()}
    return ScpiPort(NanoTwin(world, wiring)), "{port}"
