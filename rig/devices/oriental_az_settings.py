"""What a rig file says of an Oriental Motor AZ driver, and whether the driver is set up as it says.

Source: docs/devices/oriental-az.md; the registers of gear and wrap are remembered.
"""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from rig.abilities import rates
from rig.description.device_settings import Positive
from rig.errors import DeviceNonsense, FileContradicted
from rig.toml_file import as_tuple
from rig.wire import oriental_az as wire

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
    signals: Literal["internal", "outputs"] = "internal"
    """Where its state is read: fixed signals from register 0x178 on, or the outputs as they are assigned (0x7F)."""
    home_end_bit: Bit = 4
    ready_bit: Bit = 5
    alarm_bit: Bit = 7
    move_bit: Bit = 13
    """Bits of the output status, register 0x7F, where ``signals`` says "outputs"."""
    wrap: bool | None = None
    """The drive's wrap function, which makes positions jump; None: it must be off, and the drive must say so."""
    electronic_gear: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = None
    """A and B that ``step_deg`` was reckoned with; the drive must have the same."""
    motor_direction: Annotated[int, Field(ge=0, le=3)] | None = None
    """The drive's parameter "motor rotation direction", with which its angles were seen to rise the right way."""
    watchdog_s: Annotated[float, Field(ge=2.0, le=wire.LONGEST_SILENCE_MS / 1000.0)] | None = None
    """Written to the driver's parameter "communication timeout" when a run begins; 0 is written when it ends."""
    watchdog_register: Annotated[int, Field(ge=0, le=0xFFFE)] = wire.SILENCE_MS
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 0.5

    @field_validator("electronic_gear", mode="before")
    @classmethod
    def _gear_pair(cls, value: object) -> object:
        return as_tuple(value)

    @property
    def stops_without_computer(self) -> bool:
        return self.watchdog_s is not None

    @property
    def speed_range_dps(self) -> tuple[float, float]:
        return self.step_deg, self.step_deg * wire.MOST_HZ

    def motion_complaints(self) -> Iterator[tuple[str, str]]:
        least, most = self.step_deg, self.step_deg * wire.MOST_RATE
        if not least <= self.acceleration_dps2 <= most:
            yield (
                "acceleration_dps2",
                f"got {self.acceleration_dps2:g} °/s², allowed is {least:g} to {most:g} °/s² (1 to {wire.MOST_RATE:_} "
                "steps/s², with step_deg); nothing moved; correct the number, or step_deg",
            )

    @property
    def modbus(self) -> tuple[str, int]:
        """What the line speaks, and the number of this device on it."""
        return "rtu", self.axis

    @model_validator(mode="after")
    def _turns_without_wrap(self) -> "OrientalAzSettings":
        if self.wrap and self.top_rate_dps is not None:
            raise ValueError("wrap = true makes positions jump, so no rate can be measured: leave out top_rate_dps")
        return self


def judge_set_up(name: str, settings: OrientalAzSettings, found: wire.Parameters | None) -> str:
    """Return what a driver is set up to, for the record; ``found`` is None where it does not tell.

    Raises: DeviceRefused where the rig file says otherwise, DeviceNonsense where neither of them says it.
    """
    return _without_parameters(name, settings) if found is None else _judged(name, settings, found)


def _without_parameters(name: str, settings: OrientalAzSettings) -> str:
    if settings.wrap is None:
        raise DeviceNonsense(
            f"{name}: the driver does not tell gear and wrap (registers {wire.PARAMETERS:#x} to"
            f" {wire.PARAMETERS + 2 * wire.PARAMETER_VALUES - 1:#x}); nothing moved; look at them with MEXE02 and"
            f" say wrap = false or true (axes.{name})"
        )
    return f"wrap {'on' if settings.wrap else 'off'} by the rig file, gear and software limits not told"


def _judged(name: str, settings: OrientalAzSettings, found: wire.Parameters) -> str:
    if found.wraps is not bool(settings.wrap):
        says = "without wrap = true" if settings.wrap is None else f"with wrap = {settings.wrap}".lower()
        raise FileContradicted(
            f"{name}: the driver's wrap function is {'on' if found.wraps else 'off'}, the rig file is {says}"
            f" (axes.{name}: wrap); nothing moved; with it positions jump at half its range: switch it off"
            " with MEXE02, or correct the file"
        )
    gear, wanted = found.gear, settings.electronic_gear
    if wanted not in (None, gear):
        raise FileContradicted(
            f"{name}: the electronic gear is {gear[0]}/{gear[1]}, the rig file says {wanted[0]}/{wanted[1]}"
            f" (axes.{name}: electronic_gear, with which step_deg was reckoned); nothing moved; correct one"
        )
    if settings.motor_direction not in (None, found.direction):
        raise FileContradicted(
            f"{name}: the driver's motor rotation direction is {found.direction}, the rig file says"
            f" {settings.motor_direction} (axes.{name}: motor_direction): its angles may rise the other way; nothing"
            " moved; see which way it turns with MEXE02, and set it back or correct the file"
        )
    if found.limits is not None:
        ends = sorted(settings.attitude_deg(steps * settings.step_deg) for steps in found.limits)
        if ends[0] > settings.limits_deg[0] or ends[1] < settings.limits_deg[1]:
            raise FileContradicted(
                f"{name}: the driver's software limits allow {ends[0]:g} to {ends[1]:g}° only"
                f" (axes.{name}: limits_deg); nothing moved; narrow the file's or widen the driver's"
            )
    return f"gear {gear[0]}/{gear[1]}, direction {found.direction}, wrap {'on' if found.wraps else 'off'}"
