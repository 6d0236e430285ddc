"""The tables of ``procedure.toml`` for what moves, for applied fields and for long rests."""

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from rig.description.device_settings import NotNegative, Positive
from rig.toml_file import StrictTable, as_tuple

Rate = Annotated[float, Field(gt=0.0, le=10_000.0)]
Angle = Annotated[float, Field(ge=-360.0, le=360.0)]


class Rates(StrictTable):
    """``[rates]``: constant rates of one axis after the other, each in both senses."""

    pitch_dps: tuple[Rate, ...] = ()
    yaw_dps: tuple[Rate, ...] = ()
    roll_dps: tuple[Rate, ...] = ()
    dwell_s: Positive = 60.0
    """Read for at least so long; prolonged to whole revolutions."""
    tolerance: Annotated[float, Field(gt=0.0, le=0.5)] = 0.02
    """How far a measured rate may be from its set value, as part of it."""
    at_rest: bool = True
    """Also read at rest, once before the rates and once behind them."""

    @field_validator("pitch_dps", "yaw_dps", "roll_dps", mode="before")
    @classmethod
    def _lists(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _some(self) -> Self:
        if not self.by_axis:
            raise ValueError("give pitch_dps, yaw_dps or roll_dps")
        return self

    @property
    def by_axis(self) -> dict[str, tuple[float, ...]]:
        """Axes that turn, from outside in."""
        given = {"pitch": self.pitch_dps, "yaw": self.yaw_dps, "roll": self.roll_dps}
        return {name: rates for name, rates in given.items() if rates}


class Profile(StrictTable):
    """``[profile]``: several axes at once along a motion over time; CR's own are a ramp and a harmonic motion."""

    shape: Literal["ramp", "harmonic"]
    duration_s: Positive = 10.0
    span_deg: dict[Literal["pitch", "yaw", "roll"], Angle] = Field(min_length=1)
    """Amplitude (harmonic), or where the axis goes from 0 (ramp)."""
    frequency_hz: dict[Literal["pitch", "yaw", "roll"], Positive] = {}
    update_s: Annotated[float, Field(ge=0.01, le=1.0)] = 0.02
    """Between two commands to an axis."""
    bin_s: Positive = 0.1
    """The solution takes mean rates and mean readings over so long."""

    @model_validator(mode="after")
    def _agree(self) -> Self:
        needs = set(self.span_deg) if self.shape == "harmonic" else set()
        if set(self.frequency_hz) != needs:
            wanted = "a frequency_hz for every axis of span_deg" if needs else "no frequency_hz"
            raise ValueError(f'shape = "{self.shape}" needs {wanted}')
        if abs(self.bin_s / self.update_s - round(self.bin_s / self.update_s)) > 1e-6:
            raise ValueError(
                f"bin_s = {self.bin_s:g} is no whole number of update_s = {self.update_s:g}; give a multiple of it"
            )
        if self.duration_s < 10.0 * self.bin_s:
            raise ValueError(
                f"duration_s = {self.duration_s:g} holds fewer than ten bins of {self.bin_s:g} s; give "
                f"{10.0 * self.bin_s:g} s or more, or a shorter bin_s"
            )
        return self


class Levels(StrictTable):
    """``[levels]``: each axis along and against a known field, with and without it."""

    coil: str | None = None
    """Which of the rig's fields; by default its only one."""
    applied_ut: tuple[float, ...] = Field(min_length=1)
    """Besides none; along the coil's direction."""
    surroundings_ut: tuple[float, float, float] | None = None
    """What stands without the coil where that is known, level axes: north, east, down; by a reference magnetometer, or
    nulled. None: it is estimated from both senses of every axis."""
    surroundings_uncertainty_ut: Annotated[float, Field(ge=0.0, le=1e6)] = 0.0
    """Standard uncertainty of each of its components, for as long as the run takes."""
    method: Literal["known", "magnet-difference"] = "known"
    """``magnet-difference``: SR 4.1.3, where nothing tells the magnet's field but the sensor itself."""
    rest_s: Positive = 30.0
    """Each level is read for so long."""

    @field_validator("applied_ut", "surroundings_ut", mode="before")
    @classmethod
    def _lists(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _sound(self) -> Self:
        if 0.0 in self.applied_ut:
            raise ValueError("applied_ut holds 0: without a field is measured anyway; remove it")
        if self.surroundings_uncertainty_ut > 0.0 and self.surroundings_ut is None:
            raise ValueError(
                "surroundings_uncertainty_ut belongs to surroundings_ut = [north, east, down], which is missing; "
                "surroundings that are estimated have their uncertainty from the readings"
            )
        if self.method == "magnet-difference" and len(self.applied_ut) != 1:
            raise ValueError(
                f'method = "magnet-difference" takes one field: applied_ut holds {len(self.applied_ut)}; leave one'
            )
        return self


class Static(StrictTable):
    """``[static]``: at rest for long: offset, Allan deviation, and whether the drift is small enough for the use."""

    duration_s: Positive = 600.0
    pitch_deg: Angle = 0.0
    roll_deg: Angle = 0.0
    use_s: Positive = 120.0
    """How long the sensor is used after it was zeroed."""
    allowed_deg: Positive = 0.1
    """What its angle may be wrong by at the end of that time. Source: CR II-B."""
    shortest_s: NotNegative = 0.0
    """Averaging times below are left out of the Allan deviation."""
    parts: dict[str, str] = {}
    """Sensor to the part of the reports' tables that it is, such as ADXL105."""
