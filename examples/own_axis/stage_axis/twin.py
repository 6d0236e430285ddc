"""The controller from its other side, written from the manual once more: it shares no line with the codec.

What driver and twin read from one codec they get wrong together, and every law is green.
"""

from collections.abc import Mapping

from rig.twins.servo_axis import ServoAxis
from rig.twins.twin import Twin
from rig.twins.world import World
from stage_axis.device import StageSettings

SERIAL = 31007
FORGETS_S = 0.1
"""The manual: half a frame is forgotten after this silence."""
TOP_MDPS = 100_000


class StageTwin:
    """A :class:`rig.twins.twin.Twin`. ``motors``: number to motor, all of one address."""

    def __init__(self, address: int, motors: Mapping[int, ServoAxis], forgets_s: float) -> None:
        self._address, self._motors, self._forgets_s = address, motors, forgets_s
        self._frame, self._due = bytearray(), bytearray()
        self._heard_s = 0.0

    def receive(self, data: bytes, now_s: float) -> None:
        if now_s - self._heard_s > self._forgets_s:
            self._frame.clear()
        self._heard_s = now_s
        self._frame += data
        while len(self._frame) >= 8:
            self._obey(bytes(self._frame[:8]), now_s)
            del self._frame[:8]

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 what is due is due at once
        due = bytes(self._due)
        self._due.clear()
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        """Lose power and get it back: no motor has a home."""
        for motor in self._motors.values():
            motor.power_cycle(now_s)

    def _obey(self, frame: bytes, now_s: float) -> None:
        """Answer a frame with a right sum for this address; others are left unanswered."""
        address, number, word = frame[0], frame[1], chr(frame[2])
        if address != self._address or number not in self._motors or sum(frame[:7]) & 255 != frame[7]:
            return
        status, value = self._answer(self._motors[number], word, int.from_bytes(frame[3:7], "big", signed=True), now_s)
        answer = bytes([address, number, status]) + value.to_bytes(4, "big", signed=True)
        self._due += answer + bytes([sum(answer) & 255])

    def _answer(self, motor: ServoAxis, word: str, value: int, now_s: float) -> tuple[int, int]:
        match word:
            case "i":
                return 0, SERIAL
            case "s":
                return 0, int(motor.is_moving(now_s)) + 2 * int(motor.is_homed(now_s))
            case "p":
                return 0, round(1000.0 * motor.position_deg(now_s))
            case "v":
                return 0, round(1000.0 * motor.speed_dps)
            case "V":
                if not 0 < value <= TOP_MDPS:
                    return 2, 0
                motor.speed_dps = value / 1000.0
            case "g":
                if not motor.is_homed(now_s):
                    return 3, 0
                motor.move(value / 1000.0, now_s)
            case "h":
                motor.home(now_s)
            case "x":
                motor.stop(now_s)
            case _:
                return 1, 0
        return 0, value


def twin(axes: Mapping[str, StageSettings], world: World, time_factor: float) -> Twin:
    """Make the twin of one line; on it a silence of the line is ``time_factor`` times as long in rig seconds."""
    motors = {axis.axis: ServoAxis(world.axes[name], world) for name, axis in axes.items()}
    return StageTwin(next(iter(axes.values())).address, motors, FORGETS_S * time_factor)
