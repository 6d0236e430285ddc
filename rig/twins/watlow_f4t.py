"""Twin of a Watlow F4T chamber controller: floats in two registers each, an environment of the world behind loop n.

Source: F4T manual, Modbus appendix (loop 1: 2782 set point, 2820 process value, 2774 and 2776 set point limits, 2730
and 2814 control mode, 90 device status; loop n is 160 further on; low word first by default).
"""

import struct
from collections.abc import Sequence
from typing import Literal, Protocol

from rig.twins.modbus_slave import ILLEGAL_ADDRESS, ILLEGAL_VALUE

LOOP = 160
LOW_LIMIT, HIGH_LIMIT, SETPOINT, CURRENT_SETPOINT, PROCESS_VALUE = 2774, 2776, 2782, 2810, 2820
MODE_WRITE, MODE_READ = 2730, 2814
AUTO, MANUAL, OFF = 10, 54, 62
CHANNEL_UNITS, CELSIUS, FAHRENHEIT = (14080, 6730), 15, 30
PROFILE, NOT_STARTED = 16568, 251
ALARM_STATE, NO_ALARM = 1356, 61
STATUS, STATUS_OK = 90, 138


class Chamber(Protocol):
    """What the twin needs of the world."""

    def read_temperature_degc(self, environment: str, now_s: float) -> float: ...

    def setpoint_degc(self, environment: str) -> float: ...

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None: ...


class WatlowF4TTwin:
    """Registers for a :class:`rig.twins.modbus_slave.ModbusSlave`. ``mode`` is what the front panel left."""

    def __init__(
        self,
        environment: str,
        world: Chamber,
        *,
        loop: int = 1,
        word_order: Literal["low-first", "high-first"] = "low-first",
        fahrenheit: bool = False,
        limits_degc: tuple[float, float] = (-70.0, 180.0),
        mode: int = AUTO,
        profile: int = NOT_STARTED,
        tells_unit: bool = True,
    ) -> None:
        """``tells_unit``: whether this firmware has the registers of its channels' units."""
        self.mode = mode
        self.alarms = [NO_ALARM, NO_ALARM]
        """State of each, as its register tells it."""
        self.status: int | None = STATUS_OK
        """The controller's own; None: this firmware has no such register."""
        self._environment = environment
        self._world = world
        self._offset = LOOP * (loop - 1)
        self._is_low_first = word_order == "low-first"
        self.is_fahrenheit = fahrenheit
        self.profile = profile
        self._tells_unit = tells_unit
        self._limits_degc = limits_degc
        self._waiting_degc = None if mode == AUTO else world.setpoint_degc(environment)
        """Set point of a loop that is not in automatic, which the air does not follow."""

    def set_at_panel(self, now_s: float, *, mode: int | None = None, setpoint_degc: float | None = None) -> None:
        """Do what somebody does at the front panel, or another program."""
        if mode is not None:
            self._switch(mode, now_s)
        if setpoint_degc is not None:
            self._take(setpoint_degc, now_s)

    def _switch(self, mode: int, now_s: float) -> None:
        setpoint_degc, self.mode = self._setpoint_degc(), mode
        self._waiting_degc = None if mode == AUTO else setpoint_degc
        if mode == AUTO:
            self._world.hold(self._environment, setpoint_degc, now_s)
        else:  # nothing heats or cools
            self._world.hold(self._environment, self._world.read_temperature_degc(self._environment, now_s), now_s)

    def _take(self, setpoint_degc: float, now_s: float) -> None:
        if self._waiting_degc is None:
            self._world.hold(self._environment, setpoint_degc, now_s)
        else:
            self._waiting_degc = setpoint_degc

    def _setpoint_degc(self) -> float:
        return self._world.setpoint_degc(self._environment) if self._waiting_degc is None else self._waiting_degc

    def read(self, address: int, count: int, now_s: float) -> Sequence[int] | None:
        """Return words of neighbouring values; a value that is read half is read as it is at this instant."""
        if address == PROFILE and count == 1:
            return [self.profile]
        if address == STATUS and count == 1:
            return None if self.status is None else [self.status]
        if count == 1 and (address - ALARM_STATE) % 100 == 0 and 0 <= address - ALARM_STATE < 100 * len(self.alarms):
            return [self.alarms[(address - ALARM_STATE) // 100]]
        if address in CHANNEL_UNITS and count == 1 and self._tells_unit:
            return [FAHRENHEIT if self.is_fahrenheit else CELSIUS]
        first = (address - self._offset) & ~1
        words: list[int] = []
        for register in range(first, address - self._offset + count, 2):
            pair = self._pair(register, now_s)
            if pair is None:
                return None
            words += pair
        start = address - self._offset - first
        return words[start : start + count]

    def write(self, address: int, values: Sequence[int], now_s: float) -> int:
        register = address - self._offset
        if register == MODE_WRITE and len(values) == 1:
            mode = values[0]
            if mode not in (AUTO, MANUAL, OFF):
                return ILLEGAL_VALUE
            self._switch(mode, now_s)
            return 0
        if register != SETPOINT or len(values) != 2:
            return ILLEGAL_ADDRESS
        value = self._float(values)
        degc = (value - 32.0) / 1.8 if self.is_fahrenheit else value
        low_degc, high_degc = self._limits_degc
        if not low_degc <= degc <= high_degc:
            return ILLEGAL_VALUE
        self._take(degc, now_s)
        return 0

    def _pair(self, register: int, now_s: float) -> tuple[int, int] | None:
        if register in (MODE_READ, MODE_WRITE):
            return self.mode, 0
        values_degc = {
            SETPOINT: self._setpoint_degc(),
            CURRENT_SETPOINT: self._setpoint_degc(),
            LOW_LIMIT: self._limits_degc[0],
            HIGH_LIMIT: self._limits_degc[1],
        }
        if register == PROCESS_VALUE:
            return self._words(self._world.read_temperature_degc(self._environment, now_s))
        return self._words(values_degc[register]) if register in values_degc else None

    def _words(self, degc: float) -> tuple[int, int]:
        high, low = struct.unpack(">HH", struct.pack(">f", degc * 1.8 + 32.0 if self.is_fahrenheit else degc))
        return (low, high) if self._is_low_first else (high, low)

    def _float(self, words: Sequence[int]) -> float:
        low, high = words if self._is_low_first else reversed(words)
        value: float = struct.unpack(">f", struct.pack(">HH", high, low))[0]
        return value
