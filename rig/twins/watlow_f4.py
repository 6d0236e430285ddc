"""Twin of a Watlow F4 chamber controller: 16-bit registers with decimals, an environment of the world behind."""

from collections.abc import Sequence
from typing import Protocol

from rig.twins.modbus_slave import ILLEGAL_ADDRESS, ILLEGAL_VALUE, ModbusSlave

MODEL, PROCESS_VALUE, PROFILE, SETPOINT, LOW_LIMIT, HIGH_LIMIT = 0, 100, 200, 300, 602, 603
SENSOR, DECIMALS, KIND, UNITS, TERMINATE, PROFILE_SETPOINT = 600, 606, 608, 901, 1217, 4122
SERIES_F4, NO_PROFILE, RTD, SENSOR_OFF = 5270, 0, 1, 4


class Chamber(Protocol):
    """What the twin needs of the world."""

    def read_temperature_degc(self, environment: str, now_s: float) -> float: ...

    def setpoint_degc(self, environment: str) -> float: ...

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None: ...


class WatlowF4Twin:
    """A :class:`rig.twins.twin.Twin` by Modbus RTU."""

    def __init__(
        self,
        environment: str,
        world: Chamber,
        *,
        unit: int = 1,
        decimals: int = 1,
        limits_degc: tuple[float, float] = (-70.0, 180.0),
        gap_s: float = 1.0,
        fahrenheit: bool = False,
        profile: int = NO_PROFILE,
        model: int = SERIES_F4,
    ) -> None:
        """Make the chamber; ``gap_s`` as :class:`ModbusSlave` takes it. ``profile``: 2 runs, 3 is held."""
        self.is_fahrenheit = fahrenheit
        self.profile = profile
        self.sensor = RTD
        """Of input 1; an input that is off reads 0, without an exception."""
        self._model = model
        self._environment = environment
        self._world = world
        self._scale: int = 10**decimals
        self._decimals = decimals
        self._limits_degc = limits_degc
        self._slave = ModbusSlave(self, unit=unit, gap_s=gap_s)

    def receive(self, data: bytes, now_s: float) -> None:
        self._slave.receive(data, now_s)

    def transmit(self, now_s: float) -> bytes:
        return self._slave.transmit(now_s)

    def next_event_s(self) -> float | None:
        return self._slave.next_event_s()

    def read(self, address: int, count: int, now_s: float) -> Sequence[int] | None:
        values = [self._value(register, now_s) for register in range(address, address + count)]
        known = [value for value in values if value is not None]
        return known if len(known) == len(values) else None

    def _value(self, address: int, now_s: float) -> int | None:
        if address == PROCESS_VALUE and self.sensor == SENSOR_OFF:
            return 0
        if address == PROCESS_VALUE:
            return self._raw(self._world.read_temperature_degc(self._environment, now_s))
        constants = {
            MODEL: self._model,
            SENSOR: self.sensor,
            KIND: 0,
            PROFILE: self.profile,
            PROFILE_SETPOINT: self._raw(self._world.setpoint_degc(self._environment)),
            SETPOINT: self._raw(self._world.setpoint_degc(self._environment)),
            LOW_LIMIT: self._raw(self._limits_degc[0]),
            HIGH_LIMIT: self._raw(self._limits_degc[1]),
            DECIMALS: self._decimals,
            UNITS: 0 if self.is_fahrenheit else 1,
        }
        return constants.get(address)

    def write(self, address: int, values: Sequence[int], now_s: float) -> int:
        if address == TERMINATE and len(values) == 1:
            self.profile = NO_PROFILE
            return 0
        if address != SETPOINT or len(values) != 1:
            return ILLEGAL_ADDRESS
        value = (values[0] - 65536 if values[0] >= 32768 else values[0]) / self._scale
        degc = (value - 32.0) / 1.8 if self.is_fahrenheit else value
        low_degc, high_degc = self._limits_degc
        if not low_degc - 1e-9 <= degc <= high_degc + 1e-9:
            return ILLEGAL_VALUE
        if self.profile != NO_PROFILE:
            return 0  # written, and not followed
        self._world.hold(self._environment, degc, now_s)
        return 0

    def _raw(self, degc: float) -> int:
        value = degc * 1.8 + 32.0 if self.is_fahrenheit else degc
        raw: int = round(value * self._scale) % 65536
        return raw
