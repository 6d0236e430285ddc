"""The drives from their other side: frames in, frames out; a motor does the rest.

``struct`` again and not the driver's codec: a mistake in that would stand on both sides and none would see it.
"""

import struct
from collections.abc import Mapping

from rig.twins.physics.servo_axis import ServoAxis
from rig.twins.physics.world import World
from rig.twins.twin import Twin
from turner.device import TurnerSettings

TOP_DPS = 500.0


class TurnerTwin:
    """A :class:`rig.twins.twin.Twin`. ``drives``: number on the line to a motor."""

    def __init__(self, drives: Mapping[int, ServoAxis]) -> None:
        self.drives = drives
        self._received = self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self._received += data
        while len(self._received) >= 9:
            frame, rest = self._received[:9], self._received[9:]
            if sum(frame[:8]) % 256 != frame[8] or frame[0] not in self.drives:
                self._received = self._received[1:]  # no frame begins here
                continue
            self._received = rest
            self._answer(frame, now_s)

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        for motor in self.drives.values():
            motor.power_cycle(now_s)

    def _answer(self, frame: bytes, now_s: float) -> None:
        number, command, _, value, count = struct.unpack(">BBBiB", frame[:8])
        outcome = self._obey(self.drives[number], command, value, now_s)
        status, value = (3, 0) if outcome is None else (100, outcome)
        answer = struct.pack(">BBBiB", number, command, status, value, count)
        self._due += answer + bytes([sum(answer) % 256])

    def _obey(self, motor: ServoAxis, command: int, value: int, now_s: float) -> int | None:
        """Return what the drive tells, or None where it refuses."""
        if command in (1, 2) and not motor.is_homed(now_s):
            return None
        match command:
            case 1:
                motor.move(value / 1000.0, now_s)
            case 2 if abs(value) <= 1000.0 * TOP_DPS:
                motor.spin(value / 1000.0, now_s)
            case 3:
                motor.stop(now_s)
            case 4:
                motor.home(now_s)
            case 5:
                return round(1000.0 * motor.position_deg(now_s))
            case 6:
                return int(motor.is_moving(now_s)) + 2 * int(motor.is_homed(now_s))
            case 7 if 0 < value <= 1000.0 * TOP_DPS:
                motor.speed_dps = value / 1000.0
            case 8:
                return 7
            case _:
                return None
        return value


def twin(axes: Mapping[str, TurnerSettings], world: World, time_factor: float) -> Twin:  # noqa: ARG001 it answers at once
    """Make the twin of one line with its drives."""
    return TurnerTwin({axis.drive: ServoAxis(world.axes[name], world) for name, axis in axes.items()})
