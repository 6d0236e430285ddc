"""Watlow F4 chamber controller, Modbus RTU.

Register 606 tells the decimals of input 1: a chamber set to none reads ten times too little where that is ignored.
It never changes while we are connected, so it is also the sentinel that must answer rightly after every doubt.

Source: register list of the chamber maker's public library (100 process value, 300 setpoint, 606 decimals).
"""

from typing import Annotated, Literal

from pydantic import Field

from rig.description.device_settings import EnvironmentSettings
from rig.errors import DeviceFault, DeviceNonsense, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.modbus import ModbusRtu

PROCESS_VALUE, SETPOINT, DECIMALS = 100, 300, 606
PLAUSIBLE_DEGC = (-100.0, 200.0)
"""A process value outside is a wrong scale or a broken probe."""
_MOST_DECIMALS = 3


class WatlowF4Settings(EnvironmentSettings):
    """``driver = "watlow-f4"``."""

    driver: Literal["watlow-f4"]
    unit: Annotated[int, Field(ge=1, le=247)] = 1
    baud_rate: Literal[9600, 19200] = 9600


class WatlowF4:
    """A chamber: a :class:`rig.devices.abilities.Environment`."""

    def __init__(self, name: str, settings: WatlowF4Settings, modbus: ModbusRtu) -> None:
        self.name = name
        self._modbus = modbus
        self._settings = settings
        self._scale: float | None = None

    def identify(self) -> str:
        scale = self._learned_scale()
        return f"Watlow F4 at unit {self._settings.unit}, steps of {1.0 / scale:g} degC"

    def temperature_degc(self) -> float:
        degc = self._read_degc(PROCESS_VALUE)
        low_degc, high_degc = PLAUSIBLE_DEGC
        if not low_degc <= degc <= high_degc:
            raise DeviceFault(
                f"{self.name}: process value {degc:g} degC is not plausible, allowed {low_degc:g} to {high_degc:g};"
                " nothing was changed; check the probe and the chamber's decimals (register 606)"
            )
        return degc

    def setpoint_degc(self) -> float:
        return self._read_degc(SETPOINT)

    def hold(self, setpoint_degc: float) -> None:
        self._settings.refuse_beyond_limits(self.name, setpoint_degc)
        scale = self._learned_scale()
        raw = round(setpoint_degc * scale)
        if abs(raw / scale - setpoint_degc) > 1e-9 or not -32768 <= raw <= 32767:
            raise RequestRefused(
                f"{self.name}: setpoint {setpoint_degc:g} degC: the chamber takes multiples of {1.0 / scale:g} degC"
                " in 16 bits; nothing was changed; ask for a multiple"
            )
        self._modbus.write_register(SETPOINT, raw % 65536)
        told_degc = self.setpoint_degc()
        if told_degc != raw / scale:
            raise DeviceFault(
                f"{self.name}: setpoint {setpoint_degc:g} degC was acknowledged, but reads back {told_degc:g} degC;"
                " the chamber may heat or cool; look at its front panel"
            )

    def _read_degc(self, register: int) -> float:
        scale = self._learned_scale()
        (raw,) = self._modbus.read_holding(register)
        return (raw - 65536 if raw >= 32768 else raw) / scale

    def _learned_scale(self) -> float:
        if self._scale is None:
            (decimals,) = self._modbus.read_holding(DECIMALS)
            if decimals > _MOST_DECIMALS:
                raise DeviceNonsense(
                    f"{self.name}: register 606 (decimals) reads {decimals}, allowed 0 to {_MOST_DECIMALS};"
                    " nothing was changed; check that this is a Watlow F4"
                )
            self._modbus.set_sentinel(DECIMALS, decimals)
            self._scale = 10.0**decimals
        return self._scale


def connect(name: str, settings: WatlowF4Settings, stream: ByteStream) -> WatlowF4:
    """Return the chamber behind a stream."""
    return WatlowF4(name, settings, ModbusRtu(stream, settings.unit, baud_rate=settings.baud_rate))
