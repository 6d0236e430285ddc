"""The axes of a rig in memory with both ends of each line at hand: what laws of death, damage and power need."""

import math
from collections.abc import Callable
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any, cast

from rig.abilities.abilities import Axis, RateAxis, ServoAim, StopStep
from rig.assembly.open_rig import Rig, open_rig
from rig.clock import VirtualClock
from rig.description.rig_file import RigDescription
from rig.drivers.twin_lines import twin_lines
from rig.guard.servo_stop import ServoStop
from rig.link.byte_stream import ByteStream
from rig.link.memory import MemoryStream
from rig.twins.physics.motion import AxisBody
from rig.twins.physics.world import World
from rig.twins.twin import Twin

ANSWER_S = 0.3


TALK_S = 0.05
"""From one part to the next, of a line on which something talks on and on."""


class LossyStream:
    """A line that loses one of the parts it hears: number ``loses``, from 0, since ``heard`` was set back.

    Where it ``says`` something, that comes on and on, in place of every answer.
    """

    def __init__(self, inner: ByteStream) -> None:
        self.name, self.clock = inner.name, inner.clock
        self.heard = 0
        self.loses: int | None = None
        self.says = b""
        self._inner = inner

    def write(self, data: bytes) -> None:
        self._inner.write(data)

    def read(self, deadline_s: float) -> bytes:
        if self.says:
            self.clock.sleep(min(TALK_S, max(deadline_s - self.clock.monotonic_s(), 0.0)))
            return self.says
        while data := self._inner.read(deadline_s):
            self.heard += 1
            if self.heard - 1 != self.loses:
                return data
        return b""

    def discard_input(self) -> bytes:
        return self._inner.discard_input()

    def close(self) -> None:
        self._inner.close()


class AxisBench:
    """One axis of a rig with its neighbours, each on its twin; no other device. A context manager.

    ``wakes_at``: the machine wakes at so many times the speed of the rig file.
    """

    def __init__(self, description: RigDescription, name: str, *, wakes_at: float = 1.0) -> None:
        nothing: dict[str, object] = {"readouts": {}, "environment": {}, "streams": {}, "field": {}}
        axes = description.all_on_twins().model_copy(update=nothing)
        woken = {
            key: axis.model_copy(update={"speed_dps": wakes_at * axis.speed_dps}) for key, axis in axes.axes.items()
        }
        self.clock = VirtualClock(datetime(2024, 1, 1, tzinfo=UTC))
        self.name = name
        self.settings = axes.axes[name]
        self._world = World(axes.model_copy(update={"axes": woken}))
        self._twins: dict[str, Twin] = {key: line.twin for line in twin_lines(axes, self._world) for key in line.keys}
        self.line: LossyStream
        self.rig: Rig = open_rig(axes, clock=self.clock, line_source=self._open_line)
        self.starts = 0
        """How often the machine began to go somewhere."""
        follow = self.body.follow

        def counted(path: Any) -> float:
            self.starts += 1
            return follow(path)

        self.body.follow = counted  # type: ignore[method-assign]

    @property
    def axis(self) -> Axis:
        return self.rig.axes[self.name]

    @property
    def body(self) -> AxisBody:
        """The machine itself."""
        return self._world.axes[self.name]

    @property
    def true_deg(self) -> float:
        """Attitude of the machine."""
        return self.settings.attitude_deg(self.body.table_deg(self.clock.monotonic_s()))

    @property
    def cut_power(self) -> Callable[[float], None] | None:
        """How the twin of this axis loses its power, where it knows that."""
        return getattr(self._twins[f"axes.{self.name}"], "power_cycle", None)

    def start_rate(self) -> None:
        """Let an axis that turns on and on do so, towards where its home is and no faster than it moves."""
        axis = cast(RateAxis, self.axis)
        towards = -self.settings.sign * math.copysign(1.0, self.body.table_deg(self.clock.monotonic_s()))
        axis.start_rate(towards * min(0.5 * axis.top_rate_dps, self.settings.speed_dps))

    def send(self, steps: tuple[StopStep, ...]) -> None:
        """Send what the stop guard would, as it does: nobody takes the answers."""
        for step in steps:
            self.line.write(step.send)
            self.clock.sleep(step.pause_s)
            if step.aim is not None:
                self.line.write(self._aimed(step.aim))

    def reconnect(self) -> None:
        """Be the next session: drivers that remember nothing."""
        self.clock.sleep(1.0)
        self.rig.reconnect()

    def _aimed(self, aim: ServoAim) -> bytes:
        stop = ServoStop(asdict(aim), list(aim.limits))
        self.line.discard_input()
        self.line.write(stop.question)
        return stop.order(stop.position(self.line.read(self.clock.monotonic_s() + ANSWER_S)))

    def _open_line(self, key: str, _open: Callable[[], ByteStream]) -> ByteStream:
        stream = LossyStream(MemoryStream(self._twins[key], self.clock, f"twin of {key}"))
        if self._twins[key] is self._twins[f"axes.{self.name}"]:
            self.line = stream
        return stream

    def __enter__(self) -> "AxisBench":
        return self

    def __exit__(self, *_error: object) -> None:
        self.rig.close()
