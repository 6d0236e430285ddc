"""Oriental Motor AZ series drivers by Modbus RTU: direct data operation, to positions and at rates.

One frame carries a whole operation and starts it; it is sent once, and where its acknowledgement is lost the driver is
asked whether it moves. The operating current, which only we write, is the sentinel after every doubt on the line.
Outputs and alarm are read in one block, the position with the feedback behind it, so that no answer is as long as
another's. Homed is the driver's own output, as it keeps its absolute position without power.

Source: the maker's public samples and manual HM-60262E; the numbers of the output bits are remembered, so settings.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from threading import RLock
from typing import Annotated, Literal

from pydantic import Field

from rig.clock import Clock
from rig.description.device_settings import Positive
from rig.devices import rates
from rig.devices.abilities import AxisState, StopStep, TurnLook, Wait
from rig.devices.starting import start_once
from rig.devices.targets import check_target, nearest_step
from rig.devices.watchdog import prove
from rig.errors import DeviceFault, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Patience
from rig.link.modbus import ModbusRtu
from rig.wire import oriental_az as wire
from rig.wire.oriental_az import Operation

GAP_S = 0.03
"""Between two frames, as in the maker's sample."""
Bit = Annotated[int, Field(ge=0, le=15)]


class OrientalAzSettings(rates.RevolvingSettings):
    """``driver = "oriental-az"``. ``axis`` is the unit number on the line."""

    driver: Literal["oriental-az"]
    axis: Annotated[int, Field(ge=1, le=31)] = 1
    step_deg: Positive
    """What one step turns the table, gears included."""
    acceleration_dps2: Positive = 20.0
    current_percent: Annotated[float, Field(gt=0.0, le=100.0)] = 100.0
    baud_rate: Literal[9600, 19200, 38400, 57600, 115200, 230400] = 115200
    parity: Literal["N", "E", "O"] = "E"
    home_end_bit: Bit = 4
    alarm_bit: Bit = 7
    move_bit: Bit = 13
    """Bits of the output status, register 0x7F."""
    watchdog_s: Annotated[float, Field(ge=2.0, le=wire.LONGEST_SILENCE_MS / 1000.0)] | None = None
    """Written to the driver's parameter "communication timeout" when a run begins; 0 is written when it ends."""
    watchdog_register: Annotated[int, Field(ge=0, le=0xFFFE)] = wire.SILENCE_MS
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 0.5


class OrientalAzAxis:
    """One driver: an Axis, a RateAxis and a Watchdog of :mod:`rig.devices.abilities`.

    Drivers on one line share ``turn``, which lets one of them speak at a time.
    """

    def __init__(
        self, name: str, settings: OrientalAzSettings, modbus: ModbusRtu, turn: AbstractContextManager[object]
    ) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = max(settings.arrival_tolerance_deg, settings.step_deg)
        self.top_rate_dps = settings.top_rate_dps or 0.0
        self.watchdog_s = settings.watchdog_s
        self._settings = settings
        self._modbus = modbus
        self._turn = turn
        self._has_sentinel = False

    def identify(self) -> str:
        """Return the driver's unit and that its registers answer: it tells no name."""
        return f"Oriental AZ, unit {self._settings.axis}, current {self._current() / 10:g} %"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, target_deg, self._settings.table_deg(target_deg), self.limits_deg, self.increment_deg)

    def check_rate(self, rate_dps: float) -> None:
        rates.check_rate(self.name, rate_dps, self.top_rate_dps)

    def start_move(self, target_deg: float) -> None:
        self.check_target(target_deg)
        self._require_ready(f"move to {target_deg:g} deg")
        target = nearest_step(self._step(target_deg), (self._step(self.limits_deg[0]), self._step(self.limits_deg[1])))
        operation = self._operation(wire.ABSOLUTE, target, self._steps(self.speed_dps))
        self._start(lambda: self._operate(operation), lambda: self._position() == target)

    def start_rate(self, rate_dps: float) -> None:
        self.check_rate(rate_dps)
        self._require_ready(f"turn at {rate_dps:g} deg/s")
        operation = self._operation(wire.CONTINUOUS_SPEED, 0, self._steps(self._settings.sign * rate_dps))
        self._start(lambda: self._operate(operation), lambda: False)

    def home(self) -> None:
        """Return to home at speed (ZHOME).

        The alarm of a host that fell silent is reset, since its cause is known, and what is left of that host's
        watchdog is taken away.
        """
        if self._has_noticed() and self.watchdog_s is not None:
            self.disarm_watchdog()
        self._require_no_alarm("home")
        self._start(lambda: self._input(wire.ZHOME, idempotent=False), lambda: False)

    def turn_look(self, clock: Clock) -> TurnLook:
        return rates.look(lambda: self._attitude_deg(self._position()), clock)

    def state(self) -> AxisState:
        outputs, alarm = self._status()
        return AxisState(
            position_deg=self._attitude_deg(self._position()),
            is_moving=self._is_set(outputs, self._settings.move_bit),
            is_homed=self._is_set(outputs, self._settings.home_end_bit),
            is_seated=True,
            fault=_told(alarm) if alarm or self._is_set(outputs, self._settings.alarm_bit) else "",
        )

    def stop(self) -> None:
        self._input(wire.STOP, idempotent=True)

    def stop_steps(self) -> Sequence[StopStep]:
        """Return the frames that switch the input on, and off again, as :meth:`stop` does."""
        return tuple(
            StopStep(self._modbus.write_frame(wire.INPUTS, wire.words(bits)), GAP_S) for bits in (wire.STOP, 0)
        )

    def reset_alarm(self) -> None:
        """Clear an alarm whose cause is gone. Nothing moves."""
        self._input(wire.ALARM_RESET, idempotent=True)

    def arm_watchdog(self, wait: Wait) -> str:
        """Arm and prove the watchdog.

        A silence of an earlier host that died has left its alarm: that one is reset, any other is a fault.
        """
        assert self.watchdog_s is not None
        self._has_noticed()
        self._require_no_alarm("arm the watchdog")
        remedy = 'set "communication timeout" in the driver (MEXE02) and its register as watchdog_register'
        with ExitStack() as unless_proven:
            unless_proven.callback(self.disarm_watchdog)
            self._write_silence(self.watchdog_s)
            told = prove(self.name, self.watchdog_s, self._has_noticed, wait, remedy)
            unless_proven.pop_all()
        return told

    def feed_watchdog(self) -> None:
        self._status()

    def disarm_watchdog(self) -> None:
        self._write_silence(0.0)

    def _has_noticed(self) -> bool:
        """Return whether the alarm of a silent master stands; it is reset."""
        if self._status()[1] != wire.SILENCE_ALARM:
            return False
        self.reset_alarm()
        return True

    def _write_silence(self, silence_s: float) -> None:
        register, silence_ms = self._settings.watchdog_register, round(1000.0 * silence_s)
        with self._turn:
            self._modbus.write_registers(register, wire.words(silence_ms))
        if (told := self._read(register, 1)[0]) != silence_ms:
            raise DeviceFault(
                f"{self.name}: a communication timeout of {silence_ms} ms was acknowledged, but reads back {told} ms"
                f" (axes.{self.name}: watchdog_register); nothing moved; compare the register with the driver's manual"
            )

    def _start(self, send: Callable[[], None], is_there: Callable[[], bool]) -> None:
        start_once(send, lambda: self.state().is_moving or is_there())

    def _operate(self, operation: Operation) -> None:
        self._current()
        with self._turn:
            self._modbus.write_registers(wire.DIRECT_DATA, wire.encode(operation), idempotent=False)
            self._modbus.set_sentinel(wire.CURRENT + 1, operation.current)

    def _input(self, bits: int, *, idempotent: bool) -> None:
        """Switch inputs on and, whatever became of that, off again."""
        with self._turn:
            try:
                self._modbus.write_registers(wire.INPUTS, wire.words(bits), idempotent=idempotent)
            finally:
                self._modbus.write_registers(wire.INPUTS, wire.words(0))

    def _operation(self, kind: int, position: int, speed_hz: int) -> Operation:
        rate = max(self._steps(self._settings.acceleration_dps2), 1)
        return Operation(kind, position, speed_hz, rate, rate, round(self._settings.current_percent * 10.0))

    def _require_ready(self, task: str) -> None:
        self._require_no_alarm(task)
        if not self.state().is_homed:
            raise RequestRefused(f"{self.name}: {task}: the axis is not homed; nothing moved; home it first")

    def _require_no_alarm(self, task: str) -> None:
        _, alarm = self._status()
        if alarm:
            raise DeviceFault(f"{self.name}: {task}: {_told(alarm)}; nothing moved; find its cause and reset it")

    def _status(self) -> tuple[int, int]:
        """Return outputs and alarm."""
        outputs, alarm = self._read(wire.OUTPUTS, 2)
        return outputs, alarm

    def _position(self) -> int:
        return self._read(wire.POSITION, 3)[0]

    def _current(self) -> int:
        """Return the operating current; the first look makes it the line's sentinel."""
        (current,) = self._read(wire.CURRENT, 1)
        if not self._has_sentinel:
            self._modbus.set_sentinel(wire.CURRENT + 1, current & 0xFFFF)
            self._has_sentinel = True
        return current

    def _read(self, address: int, values: int) -> list[int]:
        """Read so many values of 32 bits.

        Every question here has a number of its own: a late answer fits no other.
        """
        with self._turn:
            words = self._modbus.read_holding(address, 2 * values)
        return [wire.value_of(words[place], words[place + 1]) for place in range(0, 2 * values, 2)]

    def _steps(self, angle_deg: float) -> int:
        return round(angle_deg / self._settings.step_deg)

    def _is_set(self, outputs: int, bit: int) -> bool:
        return bool(outputs >> bit & 1)

    def _step(self, attitude_deg: float) -> float:
        return self._settings.table_deg(attitude_deg) / self._settings.step_deg

    def _attitude_deg(self, steps: int) -> float:
        return self._settings.attitude_deg(steps * self._settings.step_deg)


def connect(axes: Mapping[str, OrientalAzSettings], stream: ByteStream) -> dict[str, OrientalAzAxis]:
    """Return the drivers of one line."""
    turn = RLock()
    return {name: OrientalAzAxis(name, settings, _master(settings, stream), turn) for name, settings in axes.items()}


def _told(alarm: int) -> str:
    return f"alarm {alarm:#04x}" + (" (its host fell silent; home resets it)" if alarm == wire.SILENCE_ALARM else "")


def _master(settings: OrientalAzSettings, stream: ByteStream) -> ModbusRtu:
    patience = Patience(timeout_s=settings.reply_timeout_s)
    return ModbusRtu(stream, settings.axis, baud_rate=settings.baud_rate, patience=patience, gap_s=GAP_S)
