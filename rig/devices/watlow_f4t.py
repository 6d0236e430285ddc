"""Watlow F4T chamber controller, Modbus TCP or RTU.

Every number is a float in two registers. Which word comes first is a setting of the controller: read in the wrong
order 25 °C is 2e-41, so the order of the rig file is verified when we connect: process value, set point and both set
point limits must be plausible temperatures by it. The unit is a setting of each communications channel: it is read,
compared with the rig file, and asked for again with every temperature and before every set point.

Source: docs/devices/watlow-f4t.md (loop 1: 2782 set point, 2820 process value, 2774 and 2776 set point limits, 2730
control mode to write, 2814 to read, 10 automatic, 54 manual, 62 off; loop n is 160 further on). The registers of the
channels' units are in the chamber maker's library only: a controller without them needs its unit in the rig file.
"""

import math
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Literal, Protocol

from pydantic import Field, field_validator

from rig.abilities.setpoint_memory import DRIFTS, Otherwise, SetpointMemory, settle, write_and_read_back
from rig.description.device_settings import EnvironmentSettings
from rig.errors import ChamberFault, DeviceNonsense, DeviceRefused, NoSuchRegister, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.modbus import ModbusRtu
from rig.link.modbus_tcp import ModbusTcp
from rig.toml_file import as_tuple
from rig.wire.temperatures import degc_of, of_degc

LOOP = 160
LOW_LIMIT, HIGH_LIMIT, SETPOINT, PROCESS_VALUE = 2774, 2776, 2782, 2820
MODE_WRITE, MODE_READ = 2730, 2814
AUTO, MANUAL, OFF = 10, 54, 62
BY_HAND = "it heats or cools with a power that was set by hand, wherever that leads"
MODES = {AUTO: "automatic", MANUAL: "manual", OFF: "off"}
UNIT_OF_CHANNEL = {"rtu": 14080, "tcp": 6730}
Unit = Literal["degc", "degf"]
UNITS: Mapping[int, Unit] = {15: "degc", 30: "degf"}
NAMES: Mapping[Unit, str] = {"degc": "degC", "degf": "degF"}
PROFILE = 16568
RUNNING = {149: "runs", 146: "is held", 1783: "waits for its start time"}
SMALLEST = 1e-6
"""Degrees nearer to zero than this, but not zero, are words in the wrong order."""
ALARM_STATE, ALARM, MOST_ALARMS = 1356, 100, 6
STATUS, FINE, FAILED = 90, 138, 32
"""Device status: "OK (138)", "Fail (32)" (user's guide p. 225)."""
NO_ALARM = frozenset({88, 61, 12})
"""By the chamber maker's library; in which alarm it is, is not told by any source that was read."""
RTU_GAP_S = 0.03
"""The chamber maker's library waits this long: the controller does not keep to 3.5 characters."""

WordOrder = Literal["low-first", "high-first"]


class Registers(Protocol):
    """What the driver needs of Modbus: :class:`ModbusTcp` and :class:`ModbusRtu` have it."""

    def read_holding(self, address: int, count: int = 1) -> tuple[int, ...]: ...

    def write_registers(self, address: int, values: Sequence[int]) -> None: ...


class WatlowF4TSettings(EnvironmentSettings):
    """``driver = "watlow-f4t"``."""

    driver: Literal["watlow-f4t"]
    transport: Literal["tcp", "rtu"] = "tcp"
    """``tcp``: ``port`` is ``socket://host:502``."""
    unit: Annotated[int, Field(ge=1, le=247)] = 1
    baud_rate: Literal[9600, 19200, 38400, 57600, 115200] = 38400
    loop: Annotated[int, Field(ge=1, le=4)] = 1
    word_order: WordOrder = "low-first"
    values: Unit | None = None
    """Unit of the numbers on the wire, as set for this communications channel; None: as the controller says."""
    plausible_degc: tuple[float, float] = (-100.0, 250.0)

    @property
    def modbus(self) -> tuple[str, int]:
        """What the line speaks, and the number of this device on it."""
        return self.transport, self.unit

    @field_validator("plausible_degc", mode="before")
    @classmethod
    def _pair(cls, value: object) -> object:
        return as_tuple(value)


class WatlowF4T:
    """A chamber: a :class:`rig.abilities.abilities.Environment`."""

    def __init__(self, name: str, registers: Registers, settings: WatlowF4TSettings) -> None:
        self.name = name
        self._registers = registers
        self._settings = settings
        self._offset = LOOP * (settings.loop - 1)
        self._limits_degc: tuple[float, float] | None = None
        self._values: Unit = settings.values or "degc"
        self._unit_code: int | None = None
        """What the register of the channel's unit said when we connected; None where the controller has none."""
        self.setpoint_memory = SetpointMemory(name, settings.limits_degc)

    def identify(self) -> str:
        low_degc, high_degc = self._verified_limits_degc()
        settings = self._settings
        unit = "" if self._values == "degc" else f", numbers in {NAMES[self._values]}"
        return (
            f"Watlow F4T at unit {settings.unit}, loop {settings.loop},"
            f" set points from {low_degc:g} to {high_degc:g} degC, {settings.word_order}{unit}"
        )

    def temperature_degc(self) -> float:
        self._require_same_unit()
        if self.setpoint_memory.is_set and (state := self._profile()):
            raise ChamberFault(
                f"{self.name}: a profile {state} (register {PROFILE}), since the set point was written: the chamber"
                " follows the profile; end it at the front panel"
            )
        settle(self)
        self.setpoint_memory.require(self._set_otherwise)
        degc = self._read_degc(PROCESS_VALUE)
        if not self._is_plausible(degc):
            low_degc, high_degc = self._settings.plausible_degc
            raise ChamberFault(
                f"{self.name}: process value {degc:g} °C is not plausible, allowed {low_degc:g} to {high_degc:g}"
                f" (environment.{self.name}: plausible_degc); nothing was changed; check the probe"
            )
        return degc

    def alarms(self) -> tuple[str, ...]:
        """Ask for the controller's own status, then alarm by alarm, as far as it has registers for them."""
        found: list[str] = []
        status = self._if_there(STATUS)
        if status not in (None, FINE):
            word = "that it has failed" if status == FAILED else "an unknown status"
            found.append(f"{word} (register {STATUS} reads {status})")
        for number in range(1, MOST_ALARMS + 1):
            register = ALARM_STATE + ALARM * (number - 1)
            code = self._if_there(register)
            if code is None:
                break
            if code not in NO_ALARM:
                found.append(f"alarm {number} (register {register} reads {code})")
        return tuple(found)

    def setpoint_degc(self) -> float:
        self._verified_limits_degc()
        return self._read_degc(SETPOINT)

    def hold(self, setpoint_degc: float) -> None:
        """Write the set point, switch a loop on that was off when we came, read both back.

        Raises: ChamberFault where somebody set it otherwise since.
        """
        self._settings.refuse_beyond_limits(self.name, setpoint_degc)
        low_degc, high_degc = self._verified_limits_degc()
        self._require_same_unit()
        if state := self._profile():
            raise DeviceRefused(
                f"{self.name}: a profile {state} (register {PROFILE}): the chamber would follow it and not a set"
                " point; nothing was changed; end it at the front panel"
            )
        if not low_degc <= setpoint_degc <= high_degc:
            raise RequestRefused(
                f"{self.name}: set point {setpoint_degc:g} °C: the chamber allows {low_degc:g} to {high_degc:g} °C"
                " (its registers 2774 and 2776); nothing was changed; ask for one inside"
            )
        self.setpoint_memory.require_before_writing(self._set_otherwise)
        mode = self._mode()
        if mode not in (AUTO, OFF):
            raise DeviceRefused(
                f"{self.name}: loop {self._settings.loop} is in mode {MODES.get(mode, mode)}, need automatic or off;"
                " nothing was changed; somebody set it by hand: set it to automatic at the front panel"
            )
        self.setpoint_memory.begin(setpoint_degc, self._read_degc(SETPOINT))
        write_and_read_back(self, setpoint_degc)
        if mode == OFF:
            self._switch_on()
        self.setpoint_memory.confirm()

    def write_setpoint(self, setpoint_degc: float) -> None:
        self._registers.write_registers(SETPOINT + self._offset, self._words_of(setpoint_degc))

    def read_otherwise_degc(self, setpoint_degc: float) -> float | None:
        words = self._registers.read_holding(SETPOINT + self._offset, 2)
        return None if words == self._words_of(setpoint_degc) else self._from_wire(words)

    def make_harmless(self) -> str:
        if self._mode() == OFF:
            return "its loop was not switched on, and is off"
        self._registers.write_registers(MODE_WRITE + self._offset, [OFF])
        return "calrig switched its loop off, and it reads off" if self._mode() == OFF else ""

    def _set_otherwise(self) -> Iterator[Otherwise]:
        """Yield what is not as calrig set it."""
        mode = self._mode()
        if self.setpoint_memory.is_on and mode != AUTO:
            loop = f"loop {self._settings.loop} is in mode {MODES.get(mode, mode)}"
            yield Otherwise(f"{loop} (register {MODE_READ + self._offset})", DRIFTS if mode == OFF else BY_HAND)
        found = self._registers.read_holding(SETPOINT + self._offset, 2)
        if not self.setpoint_memory.is_as_written(lambda degc: found == self._words_of(degc)):
            found_degc = self._from_wire(found)
            clause = f"the set point is {found_degc:g} °C (register {SETPOINT + self._offset})"
            yield Otherwise(clause, self.setpoint_memory.heading(found_degc))

    def _words_of(self, degc: float) -> tuple[int, int]:
        return _words(self._to_wire(degc), self._settings.word_order)

    def _switch_on(self) -> None:
        self._registers.write_registers(MODE_WRITE + self._offset, [AUTO])
        if (mode := self._mode()) != AUTO:
            raise ChamberFault(
                f"{self.name}: automatic control was acknowledged, but the mode reads {MODES.get(mode, mode)};"
                " the set point is written and not controlled; look at the front panel"
            )

    def _mode(self) -> int:
        (mode,) = self._registers.read_holding(MODE_READ + self._offset)
        return mode

    def _profile(self) -> str | None:
        code = self._if_there(PROFILE)
        return None if code is None else RUNNING.get(code)

    def _if_there(self, register: int) -> int | None:
        """Return what a register holds; None where this firmware does not have it.

        A controller that is busy, or refuses for another reason, tells nothing of what it has: that is passed on.
        """
        try:
            (code,) = self._registers.read_holding(register)
        except NoSuchRegister:
            return None
        return code

    def _learn_unit(self) -> None:
        """Learn the unit of this communications channel, which the rig file may not contradict."""
        register, wanted = UNIT_OF_CHANNEL[self._settings.transport], self._settings.values
        code = self._if_there(register)
        unit = None if code is None else UNITS.get(code)
        if unit is None and wanted is None:
            raise DeviceNonsense(
                f"{self.name}: the controller does not tell the unit of its {self._settings.transport} channel"
                f" (register {register} reads {'nothing' if code is None else code}, need 15 or 30); nothing was"
                f" changed; look at its communications settings and say values = 'degc' or 'degf'"
                f" (environment.{self.name})"
            )
        if unit is not None and wanted not in (None, unit):
            raise DeviceNonsense(
                f"{self.name}: the controller sends {NAMES[unit]} on this channel (register {register}), the rig file"
                f" says {wanted!r} (environment.{self.name}: values); nothing was changed; correct the file or the"
                " channel's unit"
            )
        self._values = unit or wanted or "degc"
        self._unit_code = None if unit is None else code

    def _require_same_unit(self) -> None:
        self._verified_limits_degc()
        if self._unit_code is not None:
            register = UNIT_OF_CHANNEL[self._settings.transport]
            (code,) = self._registers.read_holding(register)
            if code != self._unit_code:
                raise ChamberFault(
                    f"{self.name}: register {register} (unit of this channel) was {self._unit_code} and reads {code}:"
                    " somebody set the controller otherwise; nothing was changed; set it back, or start anew"
                )

    def _verified_limits_degc(self) -> tuple[float, float]:
        """Set point limits, read once, after every value was plausible in the word order of the rig file."""
        if self._limits_degc is None:
            self._learn_unit()
            addresses = (LOW_LIMIT, HIGH_LIMIT, SETPOINT, PROCESS_VALUE)
            pairs = [self._registers.read_holding(address + self._offset, 2) for address in addresses]
            self._require_order(pairs)
            # Replies on RTU have no number: a word of the upper limit must answer rightly after every doubt.
            constant = pairs[1]
            if isinstance(self._registers, ModbusRtu):
                first = 0 if constant[0] else 1
                self._registers.set_sentinel((HIGH_LIMIT + self._offset) + first, constant[first])
            self._limits_degc = self._from_wire(pairs[0]), self._from_wire(pairs[1])
        return self._limits_degc

    def _require_order(self, pairs: Sequence[Sequence[int]]) -> None:
        values_degc = [self._from_wire(pair) for pair in pairs]
        if all(map(self._is_plausible, values_degc)) and any(values_degc):
            return
        swapped = [self._from_wire(pair[::-1]) for pair in pairs]
        other = "high-first" if self._settings.word_order == "low-first" else "low-first"
        would_do = all(map(self._is_plausible, swapped)) and any(swapped)
        raise DeviceNonsense(
            f"{self.name}: set point limits, set point and process value read"
            f" {', '.join(f'{degc:g}' for degc in values_degc)} °C with word_order = {self._settings.word_order!r},"
            f" allowed {self._settings.plausible_degc[0]:g} to {self._settings.plausible_degc[1]:g}; nothing was"
            f" changed; {f'set word_order = {other!r}' if would_do else 'check loop, values and the probe'}"
            f" (environment.{self.name})"
        )

    def _is_plausible(self, degc: float) -> bool:
        low_degc, high_degc = self._settings.plausible_degc
        wire = self._to_wire(degc)
        return math.isfinite(degc) and low_degc <= degc <= high_degc and (wire == 0.0 or abs(wire) >= SMALLEST)

    def _read_degc(self, register: int) -> float:
        return self._from_wire(self._registers.read_holding(register + self._offset, 2))

    def _from_wire(self, words: Sequence[int]) -> float:
        value = _float(words, self._settings.word_order)
        return degc_of(value, is_fahrenheit=self._values == "degf")

    def _to_wire(self, degc: float) -> float:
        return of_degc(degc, is_fahrenheit=self._values == "degf")


def _words(value: float, order: WordOrder) -> tuple[int, int]:
    high, low = struct.unpack(">HH", struct.pack(">f", value))
    return (low, high) if order == "low-first" else (high, low)


def _float(words: Sequence[int], order: WordOrder) -> float:
    first, second = words
    high, low = (second, first) if order == "low-first" else (first, second)
    value: float = struct.unpack(">f", struct.pack(">HH", high, low))[0]
    return value


def connect(name: str, settings: WatlowF4TSettings, stream: ByteStream) -> WatlowF4T:
    """Return the chamber behind a stream."""
    registers: Registers
    if settings.transport == "tcp":
        registers = ModbusTcp(stream, settings.unit)
    else:
        registers = ModbusRtu(stream, settings.unit, baud_rate=settings.baud_rate, gap_s=RTU_GAP_S)
    return WatlowF4T(name, registers, settings)
