"""The board from its other side: it talks from the moment it is switched on and does not listen."""

import struct

from pulse_imu.device import PulseSettings
from rig.twins.physics.imu import MotionSource
from rig.twins.physics.metronome import Metronome
from rig.twins.physics.strapped_down import StrappedDown
from rig.twins.twin import Twin


class PulseTwin:
    """A :class:`rig.twins.twin.Twin`. ``source``: what the board feels on the stage."""

    def __init__(self, name: str, rate_hz: float, source: MotionSource) -> None:
        self._name, self._rate_hz, self._source = name, rate_hz, source
        self._beat = Metronome()

    def receive(self, data: bytes, now_s: float) -> None:
        """Do nothing: the board does not listen."""

    def transmit(self, now_s: float) -> bytes:
        if not self._beat.is_running:
            self._beat.start(now_s, self._rate_hz)
        return b"".join(self._packet(number, at_s) for number, at_s in self._beat.due(now_s))

    def next_event_s(self) -> float | None:
        return self._beat.next_s()

    def _packet(self, number: int, at_s: float) -> bytes:
        force_g = self._source.motion(self._name, at_s).force_g
        body = struct.pack(">Bhhh", number % 256, *(round(1000.0 * value) for value in force_g))
        return b"\xa5" + body + bytes([sum(body) % 256])


def twin(name: str, settings: PulseSettings, source: StrappedDown) -> Twin:
    """Make the twin of a rig file's board."""
    return PulseTwin(name, settings.rate_hz, source)
