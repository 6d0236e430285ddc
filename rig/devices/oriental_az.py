"""Oriental Motor AZ series drivers by Modbus RTU: direct data operation, to positions and at rates.

One frame carries a whole operation and starts it; it is sent once, and where its acknowledgement is lost the driver is
asked whether it moves. An acknowledgement is no start: the motor must be seen to take it up. The operating current,
which only we write, is the sentinel after every doubt on the line. Values that are read have numbers of registers of
their own, so that no answer is as long as another's.

Homed is "the coordinates are set" (ABSPEN), as it keeps its absolute position without power; HOME-END goes off when an
operation starts. Both, with READY and MOVE, are internal signals that no assignment of outputs moves.

Source: docs/devices/oriental-az.md; the registers of gear and wrap are remembered.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from threading import RLock

from rig.abilities import rates
from rig.abilities.abilities import AxisState, StopStep, TurnLook, Wait
from rig.abilities.starting import TAKEN_UP_S, see_taken_up, start_once
from rig.abilities.targets import check_target, nearest_step, require_home
from rig.abilities.watchdog import prove
from rig.clock import Clock
from rig.devices.oriental_az_settings import OrientalAzSettings, judge_set_up
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, NoSuchRegister
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Patience
from rig.link.modbus import ModbusRtu
from rig.wire import oriental_az as wire
from rig.wire.oriental_az import Operation

GAP_S = 0.03
"""Between two frames, as in the maker's sample."""


@dataclass(frozen=True, slots=True)
class Signals:
    """The drive's own state."""

    is_at_home: bool
    """HOME-END: no operation was started since the return to home."""
    is_homed: bool
    is_ready: bool
    is_moving: bool
    is_alarmed: bool


class OrientalAzAxis:
    """One driver: an Axis, a RateAxis and a Watchdog of :mod:`rig.abilities.abilities`.

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
        self._was_at_home = False
        """Where only HOME-END is read: it was seen, and no alarm since."""
        self._set_up: str | None = None
        self._is_armed = False
        """Its watchdog was proven over this connection."""

    def identify(self) -> str:
        """Return the driver's unit, that its registers answer and what it is set up to: it tells no name."""
        current = self._current()
        self._signals()
        return f"Oriental AZ, unit {self._settings.axis}, current {current / 10:g} %, {self._require_set_up()}"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, self._settings, target_deg)

    def check_rate(self, rate_dps: float) -> None:
        rates.check_rate(self.name, rate_dps, self.top_rate_dps)

    def start_move(self, target_deg: float) -> None:
        self.check_target(target_deg)
        self._require_ready(f"move to {target_deg:g}°")
        target = nearest_step(self._step(target_deg), (self._step(self.limits_deg[0]), self._step(self.limits_deg[1])))
        operation = self._operation(wire.ABSOLUTE, target, self._steps(self.speed_dps))
        self._start(lambda: self._operate(operation), lambda: self._position() == target, f"move to {target_deg:g}°")

    def start_rate(self, rate_dps: float) -> None:
        self.check_rate(rate_dps)
        self._require_watchdog()
        self._require_ready(f"turn at {rate_dps:g} °/s", may_turn=True)
        speed_hz = self._steps(self._settings.sign * rate_dps)
        operation = self._operation(wire.CONTINUOUS_SPEED, 0, speed_hz)
        self._start(lambda: self._operate(operation), lambda: speed_hz == 0, f"turn at {rate_dps:g} °/s")

    def home(self) -> None:
        """Return to home at speed (ZHOME).

        The alarm of a host that fell silent is reset, since its cause is known, and what is left of a watchdog that
        another host armed is taken away.
        """
        if self._has_noticed() and self.watchdog_s is not None and not self._is_armed:
            self.disarm_watchdog()
        self._require_no_alarm("home")
        self._require_set_up()
        self._start(lambda: self._input(wire.ZHOME, idempotent=False), lambda: self._signals().is_at_home, "home")

    def turn_look(self, clock: Clock) -> TurnLook:
        return rates.look(lambda: self._attitude_deg(self._position()), clock)

    def state(self) -> AxisState:
        signals = self._signals()
        return AxisState(
            position_deg=self._attitude_deg(self._position()),
            is_moving=signals.is_moving,
            is_homed=signals.is_homed,
            is_seated=True,
            fault=_alarm_text(self._status()[1]) if signals.is_alarmed else "",
        )

    def stop(self) -> None:
        self._modbus.write_in_doubt(*(step.send for step in self.stop_steps()))
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
            outcome = prove(self.name, self.watchdog_s, self._has_noticed, wait, self._modbus.stream.clock, remedy)
            unless_proven.pop_all()
        self._is_armed = True
        return outcome

    def feed_watchdog(self) -> None:
        self._require_watchdog()

    def disarm_watchdog(self) -> None:
        self._is_armed = False
        self._write_silence(0.0)

    def _require_watchdog(self) -> None:
        """Read back the time-out that was armed: it is in RAM, so a drive that lost power for a moment has none."""
        if not self._is_armed or self.watchdog_s is None:
            return
        register, armed_ms = self._settings.watchdog_register, round(1000.0 * self.watchdog_s)
        if (found_ms := self._read(register, 1)[0]) != armed_ms:
            raise DeviceFault(
                f"{self.name}: its watchdog is gone: register {register:#06x} reads {found_ms} ms, {armed_ms} ms were"
                f" armed and proven (axes.{self.name}: watchdog_s); the driver lost power for a moment, or another"
                " program wrote it, and nothing stops the motor now when this computer dies; look at its supply and at"
                " who else is on its line; the next session arms and proves it anew"
            )

    def _has_noticed(self) -> bool:
        """Return whether the alarm of a silent master stands; it is reset, the watchdog stays armed."""
        if self._status()[1] != wire.SILENCE_ALARM:
            return False
        self.reset_alarm()
        return True

    def _write_silence(self, silence_s: float) -> None:
        register, silence_ms = self._settings.watchdog_register, round(1000.0 * silence_s)
        with self._turn:
            self._modbus.write_registers(register, wire.words(silence_ms))
        if (read_ms := self._read(register, 1)[0]) != silence_ms:
            raise DeviceFault(
                f"{self.name}: a communication timeout of {silence_ms} ms was acknowledged, but reads back {read_ms} ms"
                f" (axes.{self.name}: watchdog_register); nothing moved; compare the register with the driver's manual"
            )

    def _start(self, send: Callable[[], None], is_there: Callable[[], bool], task: str) -> None:
        """Start once, and see it taken up: READY goes off, or MOVE on, or the axis is where it shall be."""
        start_once(send, lambda: self.state().is_moving or is_there())

        def is_taken_up() -> bool:
            signals = self._signals()
            return signals.is_moving or not signals.is_ready or is_there()

        unseen = (
            f"{self.name}: {task}: it was acknowledged, but the motor does not start within {TAKEN_UP_S:g} s: READY"
            " stays on, MOVE off; nothing moved; look at the driver's inputs and information codes (MEXE02)"
        )
        see_taken_up(is_taken_up, self._modbus.stream.clock, unseen)

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
        rate = self._steps(self._settings.acceleration_dps2)
        return Operation(kind, position, speed_hz, rate, rate, round(self._settings.current_percent * 10.0))

    def _require_ready(self, task: str, *, may_turn: bool = False) -> None:
        self._require_set_up()
        signals = self._signals()
        if signals.is_alarmed:
            self._require_no_alarm(task)
        require_home(self.name, task, is_homed=signals.is_homed)
        if not (signals.is_ready or (may_turn and signals.is_moving)):
            held = self._read(wire.INPUTS, 1)[0]
            on = ", ".join(name for name, bit in (("STOP", wire.STOP), ("FREE", wire.FREE)) if held & bit)
            raise DeviceRefused(
                f"{self.name}: {task}: the driver is not READY{f' (inputs left on: {on})' if on else ''}; nothing"
                " moved; let it come to rest, and switch off what another program or a wired input holds on"
            )

    def _require_no_alarm(self, task: str) -> None:
        _, alarm = self._status()
        if alarm:
            raise DeviceFault(f"{self.name}: {task}: {_alarm_text(alarm)}; nothing moved; find its cause and reset it")

    def _require_set_up(self) -> str:
        """Gear, wrap and software limits against the rig file, before every start; what they are, for the record."""
        found = self._parameters()
        set_up = judge_set_up(self.name, self._settings, found)
        if self._set_up not in (None, set_up):
            raise DeviceFault(
                f"{self.name}: the driver was set to {self._set_up} and now is to {set_up}: somebody set it otherwise;"
                " nothing moved; set it back, or start anew"
            )
        self._set_up = set_up
        return set_up

    def _parameters(self) -> wire.Parameters | None:
        """Return gear, wrap and limits; None where the drive has no such registers, not where it is busy."""
        try:
            return wire.parameters_of(self._read(wire.PARAMETERS, wire.PARAMETER_VALUES))
        except (NoSuchRegister, ValueError):
            return None

    def _signals(self) -> Signals:
        if self._settings.signals == "outputs":
            return self._from_outputs()
        try:
            with self._turn:
                words = self._modbus.read_holding(wire.SIGNALS, wire.SIGNAL_WORDS)
        except NoSuchRegister as error:
            raise DeviceNonsense(
                f"{self.name}: the driver has no internal signals (registers from {wire.SIGNALS:#x} on); nothing moved;"
                " look up how its outputs are assigned and say signals = 'outputs' with home_end_bit, ready_bit,"
                f" alarm_bit and move_bit (axes.{self.name})"
            ) from error
        first, second = words[:2]
        return Signals(
            is_at_home=bool(first & wire.HOME_END),
            is_homed=bool(first & wire.ABSPEN),
            is_ready=bool(second & wire.READY),
            is_moving=bool(second & wire.MOVE),
            is_alarmed=bool(second & wire.ALARM_A),
        )

    def _from_outputs(self) -> Signals:
        """HOME-END goes off when an operation starts: it was seen, and the drive keeps its coordinates."""
        settings = self._settings
        outputs, alarm = self._status()
        is_alarmed = bool(alarm) or self._is_set(outputs, settings.alarm_bit)
        self._was_at_home = not is_alarmed and (self._was_at_home or self._is_set(outputs, settings.home_end_bit))
        return Signals(
            is_at_home=self._is_set(outputs, settings.home_end_bit),
            is_homed=self._was_at_home,
            is_ready=self._is_set(outputs, settings.ready_bit),
            is_moving=self._is_set(outputs, settings.move_bit),
            is_alarmed=is_alarmed,
        )

    def _status(self) -> tuple[int, int]:
        """Return outputs and alarm."""
        outputs, alarm = self._read(wire.OUTPUTS, 2)
        return outputs, alarm

    def _position(self) -> int:
        return self._read(wire.POSITION, 3)[0]

    def _current(self) -> int:
        """Return the operating current; the first look makes it the line's sentinel."""
        (current,) = self._read(wire.CURRENT, 1)
        if not 0 <= current <= wire.FULL_CURRENT:
            raise DeviceNonsense(
                f"{self.name}: the operating current reads {current} tenths of a percent, allowed 0 to"
                f' {wire.FULL_CURRENT}: the driver has the other word order; nothing moved; set its parameter "Byte &'
                ' word order (Modbus)" to the factory setting, high word first (MEXE02)'
            )
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
        return [wire.value_of(words[index], words[index + 1]) for index in range(0, 2 * values, 2)]

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


def _alarm_text(alarm: int) -> str:
    return f"alarm {alarm:#04x}" + (" (its host fell silent; home resets it)" if alarm == wire.SILENCE_ALARM else "")


def _master(settings: OrientalAzSettings, stream: ByteStream) -> ModbusRtu:
    patience = Patience(timeout_s=settings.reply_timeout_s)
    return ModbusRtu(stream, settings.axis, baud_rate=settings.baud_rate, patience=patience, gap_s=GAP_S)
