"""The stage as calrig uses it: its table in a rig file, and the members of an axis.

What the next session asks is the stage's own: its home is a bit of its state, so nothing is remembered here.
"""

from collections.abc import Mapping, Sequence
from threading import RLock
from typing import Annotated, Literal

from pydantic import Field

from rig.description.device_settings import AxisSettings
from rig.devices.abilities import AxisState, StopStep
from rig.devices.starting import see_taken_up, start_once
from rig.devices.targets import check_target, nearest_step
from rig.errors import DeviceFault, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from stage_axis import codec

PATIENCE = Patience(timeout_s=0.3)
"""The manual: an answer begins within 20 ms."""


class StageSettings(AxisSettings):
    """What ``[axes.NAME]`` may hold beside ``port``, ``limits_deg``, ``speed_dps`` and the other keys of an axis."""

    driver: Literal["turn-2"]
    axis: Annotated[int, Field(ge=1, le=2)] = 1
    """Number of the motor."""
    address: Annotated[int, Field(ge=1, le=31)] = 1
    """Of the controller: several share an RS-485 line."""
    baud_rate: Literal[9600, 115200] = 115200


class StageAxis:
    """A :class:`rig.devices.abilities.Axis` and :class:`rig.devices.abilities.Stoppable`.

    ``turn``: one axis of a line speaks at a time.
    """

    def __init__(self, name: str, settings: StageSettings, exchange: Exchange, turn: RLock) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = settings.arrival_tolerance_deg
        self._settings, self._exchange, self._turn = settings, exchange, turn

    def identify(self) -> str:
        serial = self._ask(codec.IDENTITY)
        return f"TURN-2 serial {serial}, motor {self._settings.axis}"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, target_deg, self._settings.table_deg(target_deg), self.limits_deg, self.increment_deg)

    def start_move(self, target_deg: float) -> None:
        """Check, set the speed, then start once: where the answer is lost, the stage is asked whether it began."""
        self.check_target(target_deg)
        if not self.state().is_homed:
            raise RequestRefused(
                f"{self.name}: move to {target_deg:g} deg: the axis is not homed; nothing moved; home it first"
            )
        self._set_speed()
        low, high = (self._steps(limit_deg) for limit_deg in self.limits_deg)
        target = nearest_step(self._steps(target_deg), (low, high))

        def has_begun() -> bool:
            return self.state().is_moving or self._ask(codec.POSITION) == target

        start_once(lambda: self._ask(codec.GO, target, twice=False), has_begun)

    def home(self) -> None:
        """Start the search and see it taken up: resting is no home."""
        self._set_speed()
        start_once(lambda: self._ask(codec.HOME, twice=False), lambda: self.state().is_moving)
        see_taken_up(
            lambda: self.state().is_moving,
            self._exchange.stream.clock,
            f"{self.name}: home: it was sent, but the stage does not move; there is no home; look at its switches",
        )

    def state(self) -> AxisState:
        bits = self._ask(codec.STATE)
        position_deg = self._settings.attitude_deg(self._ask(codec.POSITION) / codec.PER_DEG)
        return AxisState(
            position_deg=position_deg,
            is_moving=bool(bits & codec.MOVING),
            is_homed=bool(bits & codec.HOMED),
            is_seated=True,
            fault="the stage reports a fault" if bits & codec.FAULT else "",
        )

    def stop(self) -> None:
        self._ask(codec.STOP)

    def stop_steps(self) -> Sequence[StopStep]:
        """Return what the stop guard sends when calrig is dead; behind it the line must rest for a frame."""
        return (StopStep(codec.question(self._settings.address, self._settings.axis, codec.STOP), pause_s=0.02),)

    def _set_speed(self) -> None:
        """Set the speed of the file and read it back. Raises: DeviceFault."""
        speed = round(self.speed_dps * codec.PER_DEG)
        self._ask(codec.SET_SPEED, speed)
        if (told := self._ask(codec.SPEED)) != speed:
            raise DeviceFault(
                f"{self.name}: speed: sent {self.speed_dps:g} deg/s, it reads back {told / codec.PER_DEG:g}"
                f" (axes.{self.name}: speed_dps); nothing moved; ask for a speed that the stage has"
            )

    def _steps(self, attitude_deg: float) -> float:
        return self._settings.table_deg(attitude_deg) * codec.PER_DEG

    def _ask(self, word: bytes, value: int = 0, *, twice: bool = True) -> int:
        """Ask; ``twice`` says that it may be asked again, which a start may not."""
        address, motor = self._settings.address, self._settings.axis
        with self._turn:
            return self._exchange.ask(
                codec.question(address, motor, word, value),
                lambda answer: codec.read_answer(self.name, address, motor, answer),
                idempotent=twice,
                length=codec.LENGTH,
            )


def connect(axes: Mapping[str, StageSettings], stream: ByteStream) -> dict[str, StageAxis]:
    """Return the axes of one line, which share its exchange. Nothing is asked here."""
    exchange, turn = Exchange(stream, patience=PATIENCE), RLock()
    return {name: StageAxis(name, settings, exchange, turn) for name, settings in axes.items()}
