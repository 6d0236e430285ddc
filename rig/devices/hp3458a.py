"""HP/Agilent/Keysight 3458A multimeter behind an HP 3488A scanner, by GPIB.

Whatever the meter was told is read back, a burst counts only when the scanner shows the same channel before and
after it, the meter reports no error and no loss of power, and no byte is left over on the line.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from rig.clock import Clock
from rig.devices.abilities import Burst, Wait
from rig.devices.hp3458a_meter import Hp3458aMeter, Setup
from rig.devices.hp3488a import Hp3488aScanner
from rig.errors import LinkClosed, LinkLost, RequestRefused
from rig.link.gpib import GpibBus, GpibResource, parse_resource
from rig.settings import NotNegative, Positive, ReadoutSettings
from rig.toml_file import StrictTable
from rig.wire import hp3458a as wire
from rig.wire import hp3488a as scanner_wire


class ScannedChannel(StrictTable):
    """One ``channels`` entry: where the scanner connects it and the range the meter measures it on."""

    scanner: Annotated[int, Field(ge=0, le=599)]
    """Three digits, slot and channel; below 100 it means slot 1."""
    range_v: Positive

    @field_validator("range_v")
    @classmethod
    def _is_a_range(cls, range_v: float) -> float:
        if range_v not in wire.FULL_SCALE_V:
            raise ValueError(f"the meter has no such range, got {range_v:g} V (allowed: 0.1, 1, 10, 100, 1000 V)")
        return range_v

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


class Hp3458aReadout:
    """A :class:`rig.devices.abilities.Readout`. ``clock`` is the rig's; the bus has its own for time-outs."""

    def __init__(
        self,
        name: str,
        settings: Hp3458aSettings,
        bus: GpibBus,
        clock: Clock,
        scanner_bus: GpibBus | None = None,
    ) -> None:
        self.name = name
        self.channels = tuple(f"{name}.{channel}" for channel in settings.channels)
        self._bus = bus
        self._nplc = settings.nplc
        self._clock = clock
        self._inputs = dict(zip(self.channels, settings.channels.values(), strict=True))
        address = parse_resource(settings.resource, wire.DEFAULT_ADDRESS).address
        self.meter = Hp3458aMeter(name, bus, address, settings.line_frequency_hz, clock)
        self.scanner = Hp3488aScanner(
            name,
            scanner_bus or bus,
            scanner_resource(settings).address,
            [entry.scanner_channel for entry in settings.channels.values()],
            settings.relay_settle_s,
            clock,
        )

    def identify(self) -> str:
        return f"{self.meter.identify()}, {self.scanner.identify()}, by {self._bus.identify()}"

    def prepare(self) -> None:
        self.meter.prepare()
        self.scanner.prepare(self._clock.sleep)

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        entry = self._entry(channel, samples)
        setup = Setup(entry.range_v, self._nplc if nplc is None else nplc, samples)
        with self._quiet_unless_done():
            self.scanner.select(entry.scanner_channel, wait)
            self.meter.set_up(setup)
            values_v, started_s = self.meter.burst(setup, wait)
            self.scanner.verify(entry.scanner_channel)
            self.meter.require_undisturbed()
        overload = np.abs(values_v) > wire.LARGEST_READING_V
        values_v[overload] = np.nan
        return Burst(channel, values_v, overload, started_s, self.meter.reading_s(setup.nplc))

    def reading_s(self, nplc: float | None = None) -> float:
        return self.meter.reading_s(self._nplc if nplc is None else nplc)

    def checks(self) -> Mapping[str, float]:
        return {"meter_temperature_degc": self.meter.temperature_degc()}

    def _entry(self, channel: str, samples: int) -> ScannedChannel:
        if channel not in self._inputs:
            raise RequestRefused(
                f"{self.name}: no channel {channel!r} (allowed: {', '.join(self.channels)}); nothing was switched"
            )
        if samples < 1:
            raise RequestRefused(f"{self.name}: {channel}: got {samples} readings, at least 1; nothing was switched")
        return self._inputs[channel]

    @contextmanager
    def _quiet_unless_done(self) -> Iterator[None]:
        """Whatever ends a burst early leaves the meter cleared and everything to be set up again."""
        needs_clear = True
        try:
            yield
            needs_clear = False
        except (LinkLost, LinkClosed):
            needs_clear = False  # there is no line to clear it by
            self.meter.forget()
            self.scanner.forget()
            raise
        finally:
            if needs_clear:
                self.scanner.forget()
                self.meter.clear()


def scanner_resource(settings: Hp3458aSettings) -> GpibResource:
    """Where the scanner is: by default on the meter's own controller, address 9. Raises: RequestRefused."""
    if settings.scanner_resource is None:
        return replace(parse_resource(settings.resource, wire.DEFAULT_ADDRESS), address=scanner_wire.DEFAULT_ADDRESS)
    return parse_resource(settings.scanner_resource, scanner_wire.DEFAULT_ADDRESS)
