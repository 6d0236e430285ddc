"""The supply and its coil from their other side: the current follows within a second, the world feels the field."""

import numpy as np

from coil_supply.device import CoilSettings
from rig.twins.physics.world import World
from rig.twins.twin import Twin

SETTLES_S = 1.0


class CoilTwin:
    """A :class:`rig.twins.twin.Twin`."""

    def __init__(self, name: str, settings: CoilSettings, world: World) -> None:
        self._name, self._world = name, world
        direction = np.array(settings.direction)
        self._ut_per_a = settings.ut_per_a * direction / float(np.linalg.norm(direction))
        self._current_a = self._before_a = 0.0
        self._settled_s = 0.0
        self._received = self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, self._received = (self._received + data).split(b"\n")
        for line in lines:
            if line == b"*IDN?":
                self._due += b"COIL-SUPPLY 3 SN 17\n"
            elif line == b"IOUT?":
                flows_a = self._current_a if now_s >= self._settled_s else self._before_a
                self._due += b"%+.4f\n" % (flows_a + 0.0)
            elif line.startswith(b"ISET "):
                self._before_a, self._current_a = self._current_a, float(line[5:])
                self._settled_s = now_s + SETTLES_S
                self._world.apply_field(self._name, self._current_a * self._ut_per_a)

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None


def twin(name: str, settings: CoilSettings, world: World) -> Twin:
    """Make the twin of a rig file's coil."""
    return CoilTwin(name, settings, world)
