"""What a rig file says of a multimeter behind its own multiplexers, and what the units of that family can be told.

Source: docs/devices/scpi-daq.md; the LAN port 5025 is not confirmed and stands in ``resource``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from rig.abilities.cards import card_of_slot, ranges_v
from rig.abilities.meter_checks import MeterChecks
from rig.abilities.scpi_talk import listed
from rig.description.device_settings import Positive, ScannedReadoutSettings
from rig.toml_file import StrictTable

RANGES_V = (0.1, 1.0, 10.0, 100.0, 300.0)
POWER_LINE_CYCLES = (0.02, 0.2, 1.0, 2.0, 10.0, 20.0, 100.0, 200.0)
OVERHEAD_S = 0.005
MOST_SAMPLES = 50_000
"""The reading memory of a 34970A, the smallest of the family."""
FIXED_OHM = 10.0e6
HIGH_IMPEDANCE_RANGES_V = (0.1, 1.0, 10.0)


@dataclass(frozen=True, slots=True)
class Model:
    """What differs between the units."""

    names: tuple[str, ...]
    """As ``*IDN?`` gives them."""
    slots: int
    numbers_per_slot: int
    """Channel 101 or 1001: the slot is the channel divided by this."""
    numbers_per_card: int
    """``SYST:CTYP?`` asks for slot × this."""
    most_channels: int
    """Of any multiplexer card."""
    impedance: bytes
    """The header that takes the input off its 10 megohm."""
    autozero: bytes = b"SENS:ZERO:AUTO"


MODELS: Mapping[str, Model] = {
    "34970A": Model(("34970A", "34972A"), 3, 100, 100, most_channels=40, impedance=b"INP:IMP:AUTO"),
    "34980A": Model(("34980A",), 8, 1000, 1, most_channels=80, impedance=b"VOLT:DC:IMP:AUTO"),
    "DAQ970A": Model(
        ("DAQ970A", "DAQ973A"),
        3,
        100,
        100,
        most_channels=40,
        impedance=b"VOLT:DC:IMP:AUTO",
        autozero=b"VOLT:DC:ZERO:AUTO",
    ),
}


CARD_CHANNELS: Mapping[str, int] = {
    "34901A": 20, "34902A": 16, "34908A": 40, "34921A": 40, "34922A": 70, "34923A": 80, "34924A": 70, "34925A": 80,
    "DAQM900A": 16, "DAQM901A": 20, "DAQM902A": 16, "DAQM908A": 40,
}  # fmt: skip
"""Highest channel for volts of the cards that are known; remembered, so a card that is not here is left to the unit."""


class DaqChannel(StrictTable):
    """One ``channels`` entry."""

    channel: Annotated[int, Field(ge=101, le=8999)]
    """Slot and channel: three digits on a 34970A and a DAQ970A, four on a 34980A."""
    range_v: float
    nplc: Positive | None = None
    """Instead of the readout's."""

    @field_validator("range_v")
    @classmethod
    def _is_a_range(cls, range_v: float) -> float:
        if range_v not in RANGES_V:
            raise ValueError(f"the unit has no such range, got {range_v:g} V (allowed: {listed(RANGES_V)} V)")
        return range_v

    @field_validator("nplc")
    @classmethod
    def _is_offered(cls, nplc: float | None) -> float | None:
        return None if nplc is None else _offered(nplc)


class DaqChecks(MeterChecks):
    """``checks``: what the unit is made to prove about itself; it has no calibration to its own standards."""

    short_channel: Annotated[int, Field(ge=101, le=8999)] | None = None
    reference_channel: Annotated[int, Field(ge=101, le=8999)] | None = None

    def channel_numbers(self) -> dict[str, int | None]:
        return {"short": self.short_channel, "reference": self.reference_channel}


class ScpiDaqSettings(ScannedReadoutSettings):
    """``driver = "scpi-daq"``."""

    driver: Literal["scpi-daq"]
    model: Literal["34970A", "34980A", "DAQ970A"]
    resource: str
    """``twin``, ``socket://host:5025``, ``prologix+…#address`` or ``visa:GPIB0::9::INSTR``."""
    nplc: float = 10.0
    line_frequency_hz: Literal[50, 60] = 50
    relay_settle_s: Annotated[float, Field(ge=0.0, le=60.0)] = 0.02
    """The unit waits this long after its relay closed, before every reading."""
    channel_echo: bool = True
    """Each reading names its channel; false only for a firmware that writes it otherwise."""
    autozero: bool = True
    """A second conversion for every reading: what the unit does from 1 power-line cycle on."""
    high_impedance: bool = True
    """More than 10 gigohm on the ranges up to 10 V; false: 10 megohm on every range, as the unit is after a reset."""
    channels: dict[str, DaqChannel] = Field(min_length=1)
    cards: dict[Literal["1", "2", "3", "4", "5", "6", "7", "8"], str] = Field(default_factory=dict)
    """The cards by slot, as the unit names them; what is not told is asked of the unit when the run begins."""
    checks: DaqChecks = DaqChecks()

    @field_validator("nplc")
    @classmethod
    def _is_offered(cls, nplc: float) -> float:
        return _offered(nplc)

    @model_validator(mode="after")
    def _channels_exist_once(self) -> "ScpiDaqSettings":
        model = MODELS[self.model]
        used = [entry.channel for entry in self.channels.values()]
        self.checks.refuse_conflicts(used, ranges_v(self.channels.values()))
        if absent := [slot for slot in card_of_slot(self.cards) if slot > model.slots]:
            raise ValueError(f"cards: a {self.model} has no slot {absent[0]} (allowed: 1 to {model.slots})")
        for number in [*used, *(channel for channel in self.checks.channel_numbers().values() if channel is not None)]:
            slot, channel = divmod(number, model.numbers_per_slot)
            if not (1 <= slot <= model.slots and 1 <= channel <= model.most_channels):
                first, last = model.numbers_per_slot + 1, model.slots * model.numbers_per_slot + model.most_channels
                raise ValueError(
                    f"a {self.model} has no channel {number} (allowed: {first} to {last}, the last two digits or three"
                    f" from 1 to {model.most_channels})"
                )
            if used.count(number) > 1:
                raise ValueError(f"channel {number} is used by more than one name; each needs its own")
            card = card_of_slot(self.cards).get(slot, "")
            last = CARD_CHANNELS.get(card, model.most_channels)
            if channel > last:
                raise ValueError(
                    f"channel {number}: the {card} in slot {slot} (cards) measures volts on channels 1 to "
                    f"{last} (allowed: {slot * model.numbers_per_slot + 1} to {slot * model.numbers_per_slot + last})"
                )
        return self

    def most_samples(self) -> int:
        return MOST_SAMPLES

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def range_of_channel_v(self, channel: str) -> float:
        return self.channels[channel].range_v

    @property
    def integrates_nplc(self) -> float:
        return self.nplc

    def input_ohm(self, channel: str) -> float | None:
        high = self.high_impedance and self.channels[channel].range_v in HIGH_IMPEDANCE_RANGES_V
        return None if high else FIXED_OHM

    @property
    def reads_beside_others(self) -> bool:
        return True

    def reading_s(self, nplc: float | None = None) -> float:
        conversions = 2.0 if self.autozero else 1.0
        cycles = self.nplc if nplc is None else nplc
        return conversions * cycles / self.line_frequency_hz + self.relay_settle_s + OVERHEAD_S


def _offered(nplc: float) -> float:
    if nplc not in POWER_LINE_CYCLES:
        raise ValueError(f"the unit has no such integration time, got {nplc:g} (allowed: {listed(POWER_LINE_CYCLES)})")
    return nplc
