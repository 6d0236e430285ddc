"""Twin of an operator: reads what is asked, turns the axis by hand, presses Enter."""

from collections.abc import Collection

from rig.twins.physics.world import World
from rig.wire import manual as wire
from rig.wire.manual import LeaveIt, SetTo

HANDLING_S = 5.0
"""To read the line before, and to press the key after."""


class OperatorTwin:
    """A :class:`rig.twins.twin.Twin`. ``axes``: names of the world's bodies that stand before the operator."""

    def __init__(self, axes: Collection[str], world: World) -> None:
        self.answer = ""
        """What is typed before Enter."""
        self._axes = axes
        self._world = world
        self._received = b""
        self._answers_s: float | None = None

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, self._received = (self._received + data).split(wire.TERMINATOR)
        for line in lines:
            self._obey(line.decode("utf-8", errors="replace"), now_s)

    def transmit(self, now_s: float) -> bytes:
        if self._answers_s is None or now_s < self._answers_s:
            return b""
        self._answers_s = None
        return self.answer.encode() + wire.TERMINATOR

    def next_event_s(self) -> float | None:
        return self._answers_s

    def _obey(self, line: str, now_s: float) -> None:
        order = wire.decode(line)
        if order is None or order.axis not in self._axes:
            return
        if isinstance(order, LeaveIt):
            self._answers_s = None
            self._world.rotate(order.axis, self._world.axes[order.axis].table_deg(now_s), now_s)
            return
        target_deg = order.angle_deg if isinstance(order, SetTo) else 0.0
        self._answers_s = self._world.rotate(order.axis, target_deg, now_s + HANDLING_S) + HANDLING_S
