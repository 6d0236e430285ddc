"""HP/Agilent/Keysight 3458A multimeter behind an HP 3488A scanner, by GPIB."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from rig.settings import NotNegative, Positive, ReadoutSettings
from rig.toml_file import StrictTable


class ScannedChannel(StrictTable):
    """One ``channels`` entry: where the scanner connects it and the range the meter measures it on."""

    scanner: Annotated[int, Field(ge=0, le=599)]
    """Three digits, slot and channel; below 100 it means slot 1."""
    range_v: Positive

    @property
    def scanner_channel(self) -> int:
        return self.scanner if self.scanner >= 100 else self.scanner + 100


class MeterChecks(StrictTable):
    """``checks``: what the meter is made to prove about itself."""

    autocalibrate: bool = False
    short_scanner: int | None = None
    reference_scanner: int | None = None
    reference_v: float | None = None
    every_s: Positive = 3600.0


class Hp3458aSettings(ReadoutSettings):
    """``driver = "hp3458a"``."""

    driver: Literal["hp3458a"]
    resource: str
    """``twin``, ``prologix+socket://host:port#address``, ``prologix+/dev/…#address`` or ``visa:GPIB0::22::INSTR``."""
    scanner_resource: str | None = None
    """Default: the same adapter, address 9."""
    nplc: Annotated[float, Field(gt=0.0, le=1000.0)] = 10.0
    settle_nplc: Annotated[float, Field(gt=0.0, le=1000.0)] = 1.0
    line_frequency_hz: Literal[50, 60] = 50
    relay_settle_s: NotNegative = 0.02
    channels: dict[str, ScannedChannel] = Field(min_length=1)
    checks: MeterChecks = MeterChecks()

    @model_validator(mode="after")
    def _each_scanner_channel_once(self) -> "Hp3458aSettings":
        used = [channel.scanner_channel for channel in self.channels.values()]
        twice = sorted({number for number in used if used.count(number) > 1})
        if twice:
            raise ValueError(f"scanner channel {twice[0]} is used by more than one name; each needs its own")
        return self

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def reading_s(self, nplc: float | None = None) -> float:
        """Autozero takes a second conversion for every reading."""
        return 2.0 * (self.nplc if nplc is None else nplc) / self.line_frequency_hz
