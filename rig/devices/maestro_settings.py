"""What a rig file says of a servo on a Pololu Maestro, ``driver = "maestro"``, and in which units it is sent."""

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from rig.abilities import rates
from rig.description.device_settings import COMMANDED, AxisSettings, Positive, WatchdogSeconds
from rig.errors import RequestRefused
from rig.toml_file import as_tuple
from rig.wire import maestro as wire
from rig.wire.pulses import PulseCalibration


class MaestroSettings(AxisSettings):
    """``driver = "maestro"``. ``axis`` is the servo's channel, from 0."""

    home_key: ClassVar[str] = "home_deg"
    driver: Literal["maestro"]
    axis: Annotated[int, Field(ge=0, le=23)] = 0
    model: Literal["micro", "mini"] = "micro"
    points: tuple[tuple[float, float], ...]
    """Calibration: pairs [pulse_us, table angle in degrees], two or more."""
    pulse_limits_us: tuple[Positive, Positive] = (992.0, 2000.0)
    """The controller's own limits of this channel: beyond them it would silently stop short."""
    acceleration: Annotated[int, Field(ge=0, le=255)] = 0
    """In 0.25 µs per 10 ms per 80 ms; 0 is unlimited."""
    period_ms: Annotated[int, Field(ge=3, le=20)] = 20
    """Pulse period; on a Mini with another than 20 ms the units of speed and acceleration follow it."""
    device_number: Annotated[int, Field(ge=0, le=127)] | None = None
    """Number for the Pololu form; without it the compact form is sent."""
    crc: bool = False
    """Whether the controller is set to expect a CRC."""
    home_deg: float = 0.0
    """Attitude that :meth:`MaestroAxis.home` goes to."""
    detect_baud: bool = False
    """The controller is in the mode "UART, detect baud rate": every command has the Pololu form, whose first byte
    tells it the rate; to device 12 where ``device_number`` is left out. That byte alone is never sent: a controller
    that knows its rate would take it for an unfinished command, an error, and send every servo home."""
    baud_rate: Literal[9600, 19200, 38400, 57600, 115200] = 9600
    watchdog_s: WatchdogSeconds | None = None
    """The serial time-out as set in the controller; without one the servos stay where they were sent last."""
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 0.5

    @property
    def stops_without_computer(self) -> bool:
        return self.watchdog_s is not None

    @property
    def home_attitude_deg(self) -> float:
        return self.home_deg

    @property
    def addressed_device(self) -> int | None:
        """Device number that commands carry; None for the compact form."""
        return wire.DEFAULT_DEVICE if self.device_number is None and self.detect_baud else self.device_number

    @field_validator("points", mode="before")
    @classmethod
    def _pairs(cls, value: object) -> object:
        return tuple(as_tuple(pair) for pair in value) if isinstance(value, list | tuple) else value

    @field_validator("pulse_limits_us", mode="before")
    @classmethod
    def _limits(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _reachable(self) -> "MaestroSettings":
        calibration = PulseCalibration(self.points)
        low_us, high_us = self.pulse_limits_us
        for attitude_deg in self.limits_deg:
            pulse_us = calibration.pulse_us(self.table_deg(attitude_deg))
            if not low_us <= pulse_us <= high_us:
                raise ValueError(
                    f"limits_deg reach {attitude_deg:g}°, a pulse of {pulse_us:g} µs,"
                    f" allowed {low_us:g} to {high_us:g} µs (pulse_limits_us)"
                )
        if speed_units(self, calibration) < 1.0:
            slowest_dps = self.speed_dps / speed_units(self, calibration)
            raise ValueError(
                f"speed_dps is {self.speed_dps:g}, but one unit of the servo's speed is {slowest_dps:.3g} °/s"
            )
        return self

    def pulse_us(self, attitude_deg: float) -> float:
        """Return the pulse at an attitude, microseconds."""
        return PulseCalibration(self.points).pulse_us(self.table_deg(attitude_deg))

    def pulse_attitude_deg(self, pulse_us: float) -> float:
        """Return the attitude at a pulse, degrees."""
        return self.attitude_deg(PulseCalibration(self.points).angle_deg(pulse_us))

    @property
    def pulse_limit_quarters(self) -> tuple[int, int]:
        """The controller's own limits of the channel, quarter-microseconds."""
        low_us, high_us = self.pulse_limits_us
        return math.ceil(low_us * wire.QUARTERS_PER_US), math.floor(high_us * wire.QUARTERS_PER_US)

    @property
    def speed_range_dps(self) -> tuple[float, float]:
        unit_dps = self.speed_dps / speed_units(self, PulseCalibration(self.points))
        return unit_dps, unit_dps * wire.HIGHEST_NUMBER

    @property
    def turning(self) -> Literal["no", "revolves", "sweeps"]:
        return "sweeps"

    def remarks(self) -> tuple[str, ...]:
        return (f"the pulse that it reads back is {COMMANDED}",)

    def refuse_rate(self, name: str, rate_dps: float) -> None:
        refuse_speed(name, self, rate_dps)


def refuse_speed(name: str, settings: MaestroSettings, rate_dps: float) -> None:
    """Refuse a rate below one unit of speed, the controller's smallest.

    Raises: RequestRefused.
    """
    rates.check_rate(name, rate_dps, settings.speed_dps)
    units = speed_units(settings, PulseCalibration(settings.points), abs(rate_dps))
    if round(units, 6) < 1.0:
        raise RequestRefused(
            f"{name}: cross at {rate_dps:g} °/s: one unit of the servo's speed is {abs(rate_dps) / units:.3g} °/s;"
            " nothing moved; ask for that or more"
        )


def speed_units(settings: MaestroSettings, calibration: PulseCalibration, rate_dps: float | None = None) -> float:
    """Return the controller's units of speed for a rate, by default ``speed_dps``, where the servo turns farthest."""
    rate_dps = settings.speed_dps if rate_dps is None else rate_dps
    quarters_per_s = rate_dps * calibration.smallest_us_per_deg * wire.QUARTERS_PER_US
    return quarters_per_s * wire.unit_s(settings.period_ms)
