"""Twin of Oriental Motor AZ drivers on one RS-485 line: direct data operation, inputs, outputs, feedback.

It keeps its absolute position without power, as the AZ does; what it does not know it refuses by exception. HOME-END
goes off when an operation starts, as the manual of the sibling series says; ABSPEN stays. Source:
docs/devices/oriental-az.md.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rig.twins.modbus_slave import ILLEGAL_ADDRESS, ILLEGAL_VALUE, ModbusSlave
from rig.twins.physics.servo_axis import ServoAxis
from rig.twins.physics.world import World
from rig.wire import oriental_az as wire

_BLOCK = range(wire.DIRECT_DATA, wire.DIRECT_DATA + 16)
_FIRST_BLOCK = tuple(word for value in (0, 1, 0, 1000, 1000, 1000, 1000, 0) for word in wire.words(value))
"""Of direct data, at power-on."""
_FIELDS_BY_TRIGGER = {-7: 0x58, -6: 0x5A, -5: 0x5C, -4: 0x5E, -3: 0x60, -2: 0x62, -1: 0x64}
_HOME_END, _READY, _ALARM_A, _MOVE, _IN_POS = 1 << 4, 1 << 5, 1 << 7, 1 << 13, 1 << 14
_TRAVEL_DEG = 100_000.0
OVERTRAVEL_ALARM = 0x67


@dataclass(frozen=True, slots=True)
class AzMotor:
    """What stands at the end of the cable."""

    step_deg: float
    is_homed: bool = True


class OrientalAzRegisters:
    """The registers of one driver: :class:`rig.twins.modbus_slave.Registers`."""

    def __init__(self, servo: ServoAxis, motor: AzMotor) -> None:
        self.servo = servo
        self.alarm = 0
        self._step_deg = motor.step_deg
        self._block = list(_FIRST_BLOCK)
        self._inputs = 0
        self._commanded = 0
        self._silence_ms = 0
        self._is_at_home = motor.is_homed
        """HOME-END: no operation started since the home was found."""
        self.has_signals = self.has_parameters = True
        """Whether this firmware has the registers of the internal signals, and of gear, direction, limits and wrap."""
        self.ignores_starts = False
        """A start is acknowledged and nothing happens."""
        self.wraps = False
        self.gear = (1, 1)
        self.direction = 1
        """Motor rotation direction, told only: the twin turns the same way whatever it is."""
        self.low_word_first = False
        """The drive's parameter "Byte & word order (Modbus)"."""
        self.software_limits: tuple[int, int] | None = None
        self._heard_s = math.inf
        """When its master was last heard; infinite where it is not waited for."""

    @property
    def gives_up_s(self) -> float:
        """When the silence of its master is noticed."""
        return self._heard_s + self._silence_ms / 1000.0 if self._silence_ms else math.inf

    def look(self, now_s: float) -> None:
        """Stop the motor, by an alarm, where the master is silent for too long."""
        if now_s >= (silent_s := self.gives_up_s):
            self._heard_s = math.inf
            self.servo.stop(silent_s)
            self.alarm = self.alarm or wire.SILENCE_ALARM

    def read(self, address: int, count: int, now_s: float) -> Sequence[int] | None:
        self.hear(now_s)
        known = self._registers(now_s)
        addresses = range(address, address + count)
        if not all(address in known for address in addresses):
            return None
        return self._ordered([known[address] for address in addresses])

    def write(self, address: int, values: Sequence[int], now_s: float) -> int:
        """Write the values; return the exception to answer with, 0 when written."""
        self.hear(now_s)
        values = self._ordered(values)
        addresses = range(address, address + len(values))
        if all(register in _BLOCK for register in addresses):
            return self._operate(addresses, values, now_s)
        if addresses[0] in (wire.INPUTS, wire.AUTO_INPUTS) and len(values) == 2:
            return self._switch(values[1], is_kept=addresses[0] == wire.INPUTS, now_s=now_s)
        if addresses == range(wire.INPUTS + 1, wire.INPUTS + 2):
            return self._switch(values[0], is_kept=True, now_s=now_s)
        if addresses == range(wire.SILENCE_MS, wire.SILENCE_MS + 2):
            silence_ms = wire.value_of(*values)
            if not 0 <= silence_ms <= wire.LONGEST_SILENCE_MS:
                return ILLEGAL_VALUE
            self._silence_ms = silence_ms
            return 0
        return ILLEGAL_ADDRESS

    def was_heard_at(self, now_s: float) -> bool:
        return self._heard_s == now_s

    def hear(self, now_s: float) -> None:
        """Take note that the master speaks on the line."""
        self.look(now_s)
        self._heard_s = now_s

    def power_cycle(self, now_s: float) -> None:
        """Lose power and get it back: the motor stands, and what was written by Modbus is gone.

        Its encoder keeps the coordinates without power; HOME-END stays where the place is home. What MEXE02 stores
        (gear, wrap, limits, order of words) stays.
        """
        self.servo.power_cycle(now_s, is_absolute=True)
        self._block, self._inputs, self._silence_ms, self.alarm = list(_FIRST_BLOCK), 0, 0, 0
        self._commanded = round(self.servo.position_deg(now_s) / self._step_deg)
        self._is_at_home = self._is_at_home and self._commanded == 0
        self._heard_s = math.inf

    def _ordered(self, words: Sequence[int]) -> list[int]:
        """Return the words of values of 32 bits as the drive is set to send and take them."""
        if not self.low_word_first or len(words) % 2:
            return list(words)
        return [words[index ^ 1] for index in range(len(words))]

    def _registers(self, now_s: float) -> dict[int, int]:
        position = round(self.servo.position_deg(now_s) / self._step_deg)
        rate_hz = round(self.servo.rate_dps(now_s) / self._step_deg)
        rpm = round(self.servo.rate_dps(now_s) / 6.0)
        words = dict(zip(_BLOCK, self._block, strict=True))
        signals = self._signals(now_s) if self.has_signals else ()
        words |= {wire.SIGNALS + index: word for index, word in enumerate(signals)}
        lower, upper = self.software_limits or (0, 0)
        overtravel = wire.NO_OVERTRAVEL if self.software_limits is None else 1
        parameters = (
            (*self.gear, self.direction, overtravel, upper, lower, 0, int(self.wraps)) if self.has_parameters else ()
        )
        for index, value in enumerate(parameters):
            first = wire.PARAMETERS + 2 * index
            words[first], words[first + 1] = wire.words(value)
        for address, value in (
            (wire.INPUTS, self._inputs),
            (wire.OUTPUTS, self._outputs(now_s)),
            (wire.ALARM, self.alarm),
            (wire.POSITION, position),
            (wire.FEEDBACK_RPM, rpm),
            (wire.FEEDBACK_HZ, rate_hz),
            (wire.SILENCE_MS, self._silence_ms),
        ):
            words[address], words[address + 1] = wire.words(value)
        return words

    def _is_ready(self, now_s: float) -> bool:
        return not (self.servo.is_moving(now_s) or self.alarm or self._inputs & (wire.STOP | wire.FREE))

    def _is_home_end(self, now_s: float) -> bool:
        return self._is_at_home and self.servo.is_homed(now_s)

    def _outputs(self, now_s: float) -> int:
        bits = _MOVE if self.servo.is_moving(now_s) else _IN_POS
        bits |= _READY if self._is_ready(now_s) else 0
        bits |= _HOME_END if self._is_home_end(now_s) else 0
        return bits | (_ALARM_A if self.alarm else 0)

    def _signals(self, now_s: float) -> tuple[int, ...]:
        first = (wire.HOME_END if self._is_home_end(now_s) else 0) | (wire.ABSPEN if self.servo.is_homed(now_s) else 0)
        second = wire.MOVE if self.servo.is_moving(now_s) else wire.IN_POSITION
        second |= wire.READY if self._is_ready(now_s) else 0
        second |= wire.ALARM_A if self.alarm else 0
        return (first, second, *(0,) * (wire.SIGNAL_WORDS - 2))

    def _operate(self, addresses: range, values: Sequence[int], now_s: float) -> int:
        for address, value in zip(addresses, values, strict=True):
            self._block[address - wire.DIRECT_DATA] = value
        trigger = wire.value_of(*self._block[14:16])
        starts = (
            wire.TRIGGER + 1 in addresses if trigger == wire.START_ALL else _FIELDS_BY_TRIGGER.get(trigger) in addresses
        )
        return self._start(now_s) if starts else 0

    def _start(self, now_s: float) -> int:
        operation = wire.decode(self._block)
        if operation.starting_rate < 1 or operation.kind not in (
            wire.ABSOLUTE,
            wire.INCREMENTAL,
            wire.CONTINUOUS_SPEED,
        ):
            return ILLEGAL_VALUE
        if self.alarm or self.ignores_starts or self._inputs & (wire.STOP | wire.FREE):
            return 0
        self._is_at_home = False
        self.servo.speed_dps = abs(operation.speed_hz) * self._step_deg
        self.servo.acceleration_dps2 = operation.starting_rate * self._step_deg
        if operation.kind == wire.CONTINUOUS_SPEED:
            self.servo.spin(operation.speed_hz * self._step_deg, now_s)
            return 0
        self._commanded = operation.position + (self._commanded if operation.kind == wire.INCREMENTAL else 0)
        if abs(self._commanded) * self._step_deg > _TRAVEL_DEG:
            self.alarm = OVERTRAVEL_ALARM
        else:
            self.servo.move(self._commanded * self._step_deg, now_s)
        return 0

    def _switch(self, inputs: int, *, is_kept: bool, now_s: float) -> int:
        """Switch inputs: they act when they go on."""
        risen = inputs & ~self._inputs
        self._inputs = inputs if is_kept else 0
        if risen & wire.ALARM_RESET:
            self.alarm = 0
        if inputs & wire.STOP:
            self.servo.stop(now_s)
        elif risen & wire.ZHOME and not (self.alarm or self.ignores_starts):
            self._commanded = 0
            self._is_at_home = True
            self.servo.home(now_s)
        return 0


class OrientalAzTwin:
    """A :class:`rig.twins.twin.Twin`. ``motors``: unit numbers to the world's bodies and what each motor is."""

    def __init__(self, motors: Mapping[int, tuple[str, AzMotor]], world: World, *, gap_s: float = 1.0) -> None:
        self.units = {
            number: OrientalAzRegisters(ServoAxis(world.axes[name], world, is_homed=motor.is_homed), motor)
            for number, (name, motor) in motors.items()
        }
        self.slaves = {unit: ModbusSlave(registers, unit=unit, gap_s=gap_s) for unit, registers in self.units.items()}

    def receive(self, data: bytes, now_s: float) -> None:
        for slave in self.slaves.values():
            slave.receive(data, now_s)
        if any(unit.was_heard_at(now_s) for unit in self.units.values()):
            for unit in self.units.values():  # a frame for another unit of the line is no silence
                unit.hear(now_s)

    def power_cycle(self, now_s: float) -> None:
        """Lose power and get it back, all drivers of the line at once."""
        for unit in self.units.values():
            unit.power_cycle(now_s)

    def transmit(self, now_s: float) -> bytes:
        for unit in self.units.values():
            unit.look(now_s)
        return b"".join(slave.transmit(now_s) for slave in self.slaves.values())

    def next_event_s(self) -> float | None:
        first_s = min(unit.gives_up_s for unit in self.units.values())
        return None if math.isinf(first_s) else first_s
