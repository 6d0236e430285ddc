"""``[interlocks]``: what has to stay inside its band while nobody looks, and what happens when it does not."""

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from rig.description.device_settings import NotNegative, Positive
from rig.toml_file import StrictTable, as_tuple

Action = Literal["hold", "trip"]
"""``hold`` goes on by itself when the value is back; ``trip`` waits for a person, through every restart."""


class TemperatureInterlock(StrictTable):
    """``[interlocks.temperature.NAME]``: an environment."""

    band_degc: tuple[float, float]
    hysteresis_degc: NotNegative = 0.0
    """So far inside the band it counts as back."""
    delay_s: NotNegative = 0.0
    """So long outside before anything happens, and so long inside before it is over."""
    action: Action = "hold"

    @field_validator("band_degc", mode="before")
    @classmethod
    def _pair(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _room_inside(self) -> "TemperatureInterlock":
        _require_room(self.band_degc, self.hysteresis_degc)
        return self


class VoltageInterlock(StrictTable):
    """``[interlocks.voltage."readout.channel"]``: any channel, such as a supply."""

    band_v: tuple[float, float]
    hysteresis_v: NotNegative = 0.0
    delay_s: NotNegative = 0.0
    action: Action = "hold"

    @field_validator("band_v", mode="before")
    @classmethod
    def _pair(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _room_inside(self) -> "VoltageInterlock":
        _require_room(self.band_v, self.hysteresis_v)
        return self


class RejectedDwells(StrictTable):
    """``rejected = { most = 5, within = 50 }``: a rig that became noisy or loose."""

    most: Annotated[int, Field(ge=1)]
    within: Annotated[int, Field(ge=2)] = 50


class Interlocks(StrictTable):
    """The whole table; everything in it is optional."""

    temperature: dict[str, TemperatureInterlock] = {}
    voltage: dict[str, VoltageInterlock] = {}
    rejected: RejectedDwells | None = None
    min_free_mb: Positive = 64.0
    """Of the disk that holds the run, beside what the dwells left to measure need."""
    max_link_error_rate: Annotated[float, Field(gt=0.0, le=1.0)] = 0.02
    """Share of a line's last questions that had no good answer at first."""


def _require_room(band: tuple[float, float], hysteresis: float) -> None:
    low, high = band
    if not high - low > 2.0 * hysteresis:
        raise ValueError(
            f"the band [{low:g}, {high:g}] must be wider than twice the hysteresis {hysteresis:g}; correct one of them"
        )
