"""Twin of an operator at a coil: reads what is asked, brings the field there, presses Enter."""

import numpy as np

from rig.twins.manual import HANDLING_S
from rig.twins.physics.geometry import Vector
from rig.twins.physics.world import World
from rig.wire import manual as wire
from rig.wire.manual import ApplyField, LeaveIt


class FieldOperatorTwin:
    """A :class:`rig.twins.twin.Twin`. ``direction``: of a positive field, level axes."""

    def __init__(self, name: str, direction: tuple[float, float, float], world: World) -> None:
        self.answer = ""
        """What is typed before Enter."""
        self._name = name
        self._unit: Vector = np.array(direction) / float(np.linalg.norm(direction))
        self._world = world
        self._received = b""
        self._answers_s: float | None = None

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, self._received = (self._received + data).split(wire.TERMINATOR)
        for line in lines:
            order = wire.decode(line.decode("utf-8", errors="replace"))
            if isinstance(order, ApplyField) and order.axis == self._name:
                self._world.apply_field(self._name, order.field_ut * self._unit)
                self._answers_s = now_s + HANDLING_S
            elif isinstance(order, LeaveIt):
                self._answers_s = None

    def transmit(self, now_s: float) -> bytes:
        if self._answers_s is None or now_s < self._answers_s:
            return b""
        self._answers_s = None
        return self.answer.encode() + wire.TERMINATOR

    def next_event_s(self) -> float | None:
        return self._answers_s
