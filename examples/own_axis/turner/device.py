"""The drive as calrig uses it: its table in a rig file, and the members of an axis and of a rate axis.

What each member must do stands in ``rig/abilities/abilities.py``. Beside them ``stop_steps``: the bytes that stop the
axis, for the stop guard, which sends them when this program is dead and waits for no answer.
"""

from collections.abc import Mapping, Sequence
from threading import Lock
from typing import Annotated, Literal

from pydantic import Field

from rig.abilities import rates
from rig.abilities.abilities import Axis, AxisState, StopStep, TurnLook
from rig.abilities.starting import start_once
from rig.abilities.targets import check_target, nearest_step, require_home
from rig.clock import Clock
from rig.errors import DeviceFault, DeviceRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from turner import codec
from turner.codec import Frame

COUNTS = 256


class TurnerSettings(rates.RevolvingSettings):
    """What ``[axes.NAME]`` may hold beside the keys of every axis; ``axis`` is the drive's number on its controller."""

    driver: Literal["turner"]
    axis: Annotated[int, Field(ge=1, le=15)] = 1
    address: Annotated[int, Field(ge=0, le=15)] = 0
    """Of the controller, as its switch stands: several share a line."""
    baud_rate: Literal[9600, 115200] = 115200
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 0.5

    @property
    def line_address(self) -> tuple[int, ...]:
        return (self.address, self.axis)

    @property
    def drive(self) -> int:
        """The number in its frames."""
        return 16 * self.address + self.axis


class Turner:
    """One drive: a :class:`rig.abilities.abilities.Axis` and a :class:`rig.abilities.abilities.RateAxis`."""

    def __init__(self, name: str, settings: TurnerSettings, exchange: Exchange, turn: Lock) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = settings.arrival_tolerance_deg
        self.top_rate_dps = settings.top_rate_dps or 0.0
        self._settings = settings
        self._exchange, self._turn = exchange, turn
        self._count = 0
        self._is_prepared = False

    def identify(self) -> str:
        model = self._ask(codec.MODEL).value
        if model != codec.MODEL_NUMBER:
            raise DeviceRefused(f"{self.name}: it is model {model}, need {codec.MODEL_NUMBER}; nothing moved")
        return f"TURNER {model}, drive {self._settings.drive}"

    def home(self) -> None:
        self._is_prepared = False  # a drive that lost power forgot its speed
        self._prepare()
        self._start(codec.HOME, 0)

    def check_target(self, target_deg: float) -> None:
        """Every target is checked here, in the plan and once more just before anything is sent."""
        check_target(self.name, self._settings, target_deg)

    def start_move(self, target_deg: float) -> None:
        self.check_target(target_deg)
        require_home(self.name, f"move to {target_deg:g}°", is_homed=self.state().is_homed)
        self._prepare()
        ends = tuple(self._settings.table_deg(end) * codec.UNITS_PER_DEG for end in self.limits_deg)
        self._start(codec.MOVE, nearest_step(self._settings.table_deg(target_deg) * codec.UNITS_PER_DEG, ends))

    def check_rate(self, rate_dps: float) -> None:
        rates.check_rate(self.name, rate_dps, self.top_rate_dps)

    def start_rate(self, rate_dps: float) -> None:
        self.check_rate(rate_dps)
        require_home(self.name, f"turn at {rate_dps:g} °/s", is_homed=self.state().is_homed)
        self._start(codec.TURN, codec.units(self._settings.sign * rate_dps))

    def turn_look(self, clock: Clock) -> TurnLook:
        return rates.look(self._position_deg, clock)

    def state(self) -> AxisState:
        bits = self._ask(codec.STATE).value
        return AxisState(
            position_deg=self._position_deg(),
            is_moving=bool(bits & codec.MOVING),
            is_homed=bool(bits & codec.HOMED),
            is_seated=True,
            fault="",
        )

    def stop(self) -> None:
        self._exchange.write_in_doubt(self._stop)  # a line on which something talks on and on keeps no stop back
        self._ask(codec.STOP)

    def stop_steps(self) -> Sequence[StopStep]:
        return (StopStep(self._stop),)

    @property
    def _stop(self) -> bytes:
        return codec.encode(Frame(self._settings.drive, codec.STOP))

    def _prepare(self) -> None:
        """Tell the drive its speed and read it back. Raises: DeviceFault."""
        if self._is_prepared:
            return
        wanted = codec.units(self.speed_dps)
        if (confirmed := self._ask(codec.SPEED, wanted).value) != wanted:
            raise DeviceFault(f"{self.name}: speed {wanted} was sent and reads back {confirmed}; nothing moved")
        self._is_prepared = True

    def _start(self, command: int, value: int) -> None:
        """Send a start once; where its answer is lost, the drive is asked whether it moves."""
        start_once(lambda: self._ask(command, value, idempotent=False), lambda: self.state().is_moving)

    def _position_deg(self) -> float:
        return self._settings.attitude_deg(self._ask(codec.POSITION).value / codec.UNITS_PER_DEG)

    def _ask(self, command: int, value: int = 0, *, idempotent: bool = True) -> Frame:
        """Ask and return the answer; ``idempotent``: asking twice does no harm, so it may be repeated.

        Raises: DeviceRefused where the drive refuses.
        """
        with self._turn:
            self._count = (self._count + 1) % COUNTS
            request = Frame(self._settings.drive, command, value, self._count)
            answer = self._exchange.ask(
                codec.encode(request),
                lambda data: codec.answer_to(request, data),
                idempotent=idempotent,
                length=codec.LENGTH,
            )
        if answer.status != codec.DONE:
            raise DeviceRefused(
                f"{self.name}: the drive refuses command {command} with {value}: status {answer.status}; nothing moved;"
                " look into its manual"
            )
        return answer


def connect(axes: Mapping[str, TurnerSettings], stream: ByteStream) -> Mapping[str, Axis]:
    """Return the drives of one line: they share it, and take turns on it."""
    timeout_s = next(iter(axes.values())).reply_timeout_s
    exchange, turn = Exchange(stream, patience=Patience(timeout_s=timeout_s)), Lock()
    return {name: Turner(name, settings, exchange, turn) for name, settings in axes.items()}
