"""Watlow F4 chamber controller, Modbus RTU.

Register 0 says that it is one; only then do 606 (decimals of input 1) and 901 (unit: °F or °C) mean what they say: a
chamber set to no decimals reads ten times too little where that is ignored, one in °F heats or cools to another place.
Both never change while we are connected: they are asked for again with every temperature and before every set point. A
profile that runs would follow its own set points, so none is written then (register 200).

Source: docs/devices/watlow-f4.md (register list of the chamber maker's public library).
"""

from collections.abc import Container, Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from rig.abilities.setpoint_memory import Otherwise, SetpointMemory, settle, write_and_read_back
from rig.description.device_settings import EnvironmentSettings
from rig.errors import ChamberFault, DeviceNonsense, DeviceRefused, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.modbus import ModbusRtu
from rig.wire.temperatures import degc_of, of_degc

MODEL, PROCESS_VALUE, PROFILE, SETPOINT, LOW_LIMIT, HIGH_LIMIT = 0, 100, 200, 300, 602, 603
SENSOR, DECIMALS, KIND, UNIT = 600, 606, 608, 901
PROFILE_SETPOINT = 4122
SERIES_F4, TEMPERATURE, FAHRENHEIT, CELSIUS = 5270, 0, 0, 1
SENSORS = {0: "a thermocouple", 1: "an RTD", 2: "a process input", 3: "wet and dry bulb", 4: "off"}
SENSOR_OFF = 4
RUNNING = {2: "runs", 3: "is held"}
PLAUSIBLE_DEGC = (-100.0, 200.0)
"""A process value outside is a wrong scale or a broken probe."""
_MOST_DECIMALS = 3


class WatlowF4Settings(EnvironmentSettings):
    """``driver = "watlow-f4"``."""

    driver: Literal["watlow-f4"]
    unit: Annotated[int, Field(ge=1, le=247)] = 1
    baud_rate: Literal[9600, 19200] = 9600
    values: Literal["degc", "degf"] | None = None
    """What the controller must be set to; None: whichever it says that it is."""

    @property
    def modbus(self) -> tuple[str, int]:
        """What the line speaks, and the number of this device on it."""
        return "rtu", self.unit


@dataclass(frozen=True, slots=True)
class Scale:
    """How numbers stand in registers."""

    decimals: int
    is_fahrenheit: bool

    @property
    def name(self) -> str:
        """Of the unit, in ASCII: in what the controller is recognised by, and in the rig file."""
        return "degF" if self.is_fahrenheit else "degC"

    @property
    def sign(self) -> str:
        """Of the unit, as people read it."""
        return "°F" if self.is_fahrenheit else "°C"

    @property
    def step(self) -> float:
        return 10.0**-self.decimals

    def degc(self, raw: int) -> float:
        value = (raw - 65536 if raw >= 32768 else raw) / 10.0**self.decimals
        return degc_of(value, is_fahrenheit=self.is_fahrenheit)

    def raw(self, degc: float) -> float:
        """Not rounded."""
        return of_degc(degc, is_fahrenheit=self.is_fahrenheit) * 10.0**self.decimals


class WatlowF4:
    """A chamber: a :class:`rig.abilities.abilities.Environment`."""

    def __init__(self, name: str, settings: WatlowF4Settings, modbus: ModbusRtu) -> None:
        self.name = name
        self._modbus = modbus
        self._settings = settings
        self._scale: Scale | None = None
        self._good_degc: float | None = None
        """The set point before the one that is being written, where it lies inside the limits of the rig file."""
        self.setpoint_memory = SetpointMemory(name, settings.limits_degc)

    def identify(self) -> str:
        scale = self._learned_scale()
        return f"Watlow F4 at unit {self._settings.unit}, steps of {scale.step:g} {scale.name}"

    def temperature_degc(self) -> float:
        scale = self._unchanged_scale()
        if self.setpoint_memory.is_set and (state := RUNNING.get(self._read(PROFILE))):
            raise ChamberFault(
                f"{self.name}: a profile {state} (register {PROFILE}), since the set point was written: the chamber"
                " follows the profile; end it at the front panel"
            )
        settle(self)
        self.setpoint_memory.require(self._set_otherwise)
        raw = self._read(PROCESS_VALUE)
        if raw == 0:
            self._require_sensor(ChamberFault)
        degc = scale.degc(raw)
        low_degc, high_degc = PLAUSIBLE_DEGC
        if not low_degc <= degc <= high_degc:
            raise ChamberFault(
                f"{self.name}: process value {degc:g} °C is not plausible, allowed {low_degc:g} to {high_degc:g};"
                " nothing was changed; check the probe and the chamber's decimals (register 606)"
            )
        return degc

    def setpoint_degc(self) -> float:
        """Return the set point that the chamber follows: a profile's while one runs."""
        scale = self._learned_scale()
        return scale.degc(self._read(PROFILE_SETPOINT if self._read(PROFILE) in RUNNING else SETPOINT))

    def hold(self, setpoint_degc: float) -> None:
        self._settings.refuse_beyond_limits(self.name, setpoint_degc)
        scale = self._unchanged_scale()
        if state := RUNNING.get(self._read(PROFILE)):
            raise DeviceRefused(
                f"{self.name}: a profile {state} (register {PROFILE}): the chamber would follow it and not a set"
                " point; nothing was changed; end it at the front panel"
            )
        self.setpoint_memory.require_before_writing(self._set_otherwise)
        # Some take a set point below their range for "off".
        low_degc, high_degc = (scale.degc(self._read(register)) for register in (LOW_LIMIT, HIGH_LIMIT))
        if not low_degc - 1e-9 <= setpoint_degc <= high_degc + 1e-9:
            raise RequestRefused(
                f"{self.name}: setpoint {setpoint_degc:g} °C: the chamber allows {low_degc:g} to {high_degc:g} °C"
                f" (its registers {LOW_LIMIT} and {HIGH_LIMIT}); nothing was changed; ask for one inside"
            )
        raw = round(scale.raw(setpoint_degc))
        if abs(raw - scale.raw(setpoint_degc)) > 1e-6 or not -32768 <= raw <= 32767:
            raise RequestRefused(
                f"{self.name}: setpoint {setpoint_degc:g} °C: the chamber takes multiples of {scale.step:g}"
                f" {scale.sign} in 16 bits; nothing was changed; ask for one of them, the nearest is"
                f" {scale.degc(raw % 65536):.6g} °C"
            )
        before_degc = scale.degc(self._read(SETPOINT))
        self._good_degc = before_degc if self.setpoint_memory.is_allowed(before_degc) else None
        self.setpoint_memory.begin(setpoint_degc, before_degc)
        write_and_read_back(self, setpoint_degc)
        self.setpoint_memory.confirm()

    def write_setpoint(self, setpoint_degc: float) -> None:
        self._modbus.write_register(SETPOINT, round(self._learned_scale().raw(setpoint_degc)) % 65536)

    def read_otherwise_degc(self, setpoint_degc: float) -> float | None:
        scale, raw = self._learned_scale(), self._read(SETPOINT)
        return None if raw == round(scale.raw(setpoint_degc)) % 65536 else scale.degc(raw)

    def make_harmless(self) -> str:
        """Go back to the set point from before: which event output stops a chamber is its maker's choice."""
        if self._good_degc is None:
            return ""
        self.write_setpoint(self._good_degc)
        is_back = self.read_otherwise_degc(self._good_degc) is None
        return f"calrig set it back to {self._good_degc:g} °C, where it is heading now" if is_back else ""

    def _set_otherwise(self) -> Iterator[Otherwise]:
        """Yield what is not as calrig set it."""
        scale, raw = self._learned_scale(), self._read(SETPOINT)
        if not self.setpoint_memory.is_as_written(lambda degc: raw == round(scale.raw(degc)) % 65536):
            yield Otherwise(
                f"the set point is {scale.degc(raw):g} °C (register {SETPOINT})",
                self.setpoint_memory.heading(scale.degc(raw)),
            )

    def _read(self, register: int) -> int:
        (raw,) = self._modbus.read_holding(register)
        return raw

    def _require_sensor(self, kind: type[ChamberFault | DeviceNonsense]) -> None:
        """Raise unless input 1 has a sensor: it reads 0 otherwise, which would be a temperature."""
        sensor = self._read(SENSOR)
        if sensor not in SENSORS or sensor == SENSOR_OFF:
            raise kind(
                f"{self.name}: input 1 is {SENSORS.get(sensor, 'of no known sensor')} (register {SENSOR} reads"
                f" {sensor}, allowed 0 to 3): its temperature reads 0 and is none; nothing was changed; set the sensor"
                " of input 1 at the front panel"
            )

    def _learned_scale(self) -> Scale:
        if self._scale is None:
            self._require(MODEL, "model", (SERIES_F4,), "a Series F4 says 5270")
            self._require(KIND, "kind of input 1", (TEMPERATURE,), "0 is a temperature")
            self._require_sensor(DeviceNonsense)
            decimals = self._require(DECIMALS, "decimals", range(_MOST_DECIMALS + 1), f"allowed 0 to {_MOST_DECIMALS}")
            unit = self._require(UNIT, "unit", (FAHRENHEIT, CELSIUS), "0 is °F, 1 is °C")
            scale = Scale(decimals, unit == FAHRENHEIT)
            if self._settings.values not in (None, scale.name.lower()):
                raise DeviceNonsense(
                    f"{self.name}: the controller is set to {scale.sign} (register {UNIT}), the rig file says"
                    f" {self._settings.values!r} (environment.{self.name}: values); nothing was changed; correct the"
                    " file, or the unit at the front panel"
                )
            self._modbus.set_sentinel(MODEL, SERIES_F4)
            self._scale = scale
        return self._scale

    def _unchanged_scale(self) -> Scale:
        """Return unit and decimals, as they were when we connected. Raises: ChamberFault."""
        if self._scale is None:
            return self._learned_scale()
        was = {DECIMALS: self._scale.decimals, UNIT: FAHRENHEIT if self._scale.is_fahrenheit else CELSIUS}
        for register, need in was.items():
            if (found := self._read(register)) != need:
                raise ChamberFault(
                    f"{self.name}: register {register} ({'unit' if register == UNIT else 'decimals'}) was {need} and"
                    f" reads {found}: somebody set the controller otherwise; nothing was changed; set it back, or start"
                    " anew"
                )
        return self._scale

    def _require(self, register: int, meaning: str, allowed: Container[int], words: str) -> int:
        found = self._read(register)
        if found not in allowed:
            raise DeviceNonsense(
                f"{self.name}: register {register} ({meaning}) reads {found}, {words}; nothing was changed; check that"
                " this is a Watlow F4"
            )
        return found


def connect(name: str, settings: WatlowF4Settings, stream: ByteStream) -> WatlowF4:
    """Return the chamber behind a stream."""
    return WatlowF4(name, settings, ModbusRtu(stream, settings.unit, baud_rate=settings.baud_rate))
