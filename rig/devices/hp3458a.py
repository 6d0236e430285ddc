"""HP/Agilent/Keysight 3458A multimeter behind an HP 3488A scanner, by GPIB.

Whatever the meter was told is read back before and behind every burst, and a burst counts only when the scanner shows
the same channel closed before and after it and no other, the meter reports no error and no loss of power, and no
reading and no byte is left over.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from rig.abilities.abilities import Burst, Wait
from rig.abilities.cards import card_of_slot, ranges_v
from rig.abilities.meter_checks import MeterChecks, proofs
from rig.abilities.selected_inputs import Inputs
from rig.abilities.self_checking import MeterLook
from rig.clock import Clock
from rig.description.device_settings import NotNegative, Positive, ScannedReadoutSettings
from rig.devices.hp3458a_meter import Hp3458aMeter, Setup
from rig.devices.hp3488a import Hp3488aScanner
from rig.errors import LinkClosed, LinkLost, RequestRefused
from rig.link.gpib import GpibBus, GpibResource, parse_resource
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
        return _scanner_channel(self.scanner)


class Hp3458aChecks(MeterChecks):
    """``checks``: what the meter is made to prove about itself."""

    autocalibrate: bool = False
    """ACAL DCV before the run and when the meter's own temperature has moved."""
    temperature_step_degc: Positive = 1.0
    autocalibrate_every_h: Positive = 24.0
    """Its specifications count from the last ACAL for so long, whatever the temperature did."""
    short_scanner: Annotated[int, Field(ge=0, le=599)] | None = None
    reference_scanner: Annotated[int, Field(ge=0, le=599)] | None = None
    """As in ``channels``: below 100 it means slot 1."""

    def channel_numbers(self) -> dict[str, int | None]:
        named = {"short": self.short_scanner, "reference": self.reference_scanner}
        return {name: None if number is None else _scanner_channel(number) for name, number in named.items()}

    @property
    def asks_for_anything(self) -> bool:
        return self.autocalibrate or super().asks_for_anything


class Hp3458aSettings(ScannedReadoutSettings):
    """``driver = "hp3458a"``."""

    driver: Literal["hp3458a"]
    resource: str
    """``twin``, ``prologix+socket://host:port#address``, ``prologix+/dev/…#address`` or ``visa:GPIB0::22::INSTR``."""
    scanner_resource: str | None = None
    """Default: the same adapter, address 9."""
    nplc: Annotated[float, Field(gt=0.0, le=1000.0)] = 10.0
    line_frequency_hz: Literal[50, 60] = 50
    relay_settle_s: NotNegative = 0.02
    terminals: Inputs | None = None
    """Which inputs must be selected at the meter; None: either, and the identity says which."""
    channels: dict[str, ScannedChannel] = Field(min_length=1)
    cards: dict[Literal["1", "2", "3", "4", "5"], Literal["44470", "44471", "44472"]] = Field(default_factory=dict)
    """The scanner's cards by slot, as it names them; what is not told is asked of the scanner when the run begins."""
    checks: Hp3458aChecks = Hp3458aChecks()

    @model_validator(mode="after")
    def _each_scanner_channel_once(self) -> "Hp3458aSettings":
        used = [channel.scanner_channel for channel in self.channels.values()]
        twice = sorted({number for number in used if used.count(number) > 1})
        if twice:
            names = [name for name, channel in self.channels.items() if channel.scanner_channel == twice[0]]
            raise ValueError(f"channels: scanner channel {twice[0]} is used by {', '.join(names)}; each needs its own")
        self.checks.refuse_conflicts(used, ranges_v(self.channels.values()))
        for slot, numbers in scanner_wire.by_slot(_scanner_channels(self)).items():
            self._refuse_what_no_card_has(slot, numbers)
        return self

    def _refuse_what_no_card_has(self, slot: int, numbers: Sequence[int]) -> None:
        for number in numbers:
            if not scanner_wire.cards_for([number]):
                raise ValueError(
                    f"scanner channel {number}: no card of a 3488A has it (allowed: slot 1 to 5, with the channels of"
                    f" {', '.join(scanner_wire.SWITCHED_BY)}, such as 100 to 109)"
                )
        fitting, card = scanner_wire.cards_for(numbers), card_of_slot(self.cards).get(slot)
        if card is not None and card not in fitting:
            lacking = next(number for number in numbers if not scanner_wire.has_channel(card, number))
            allowed = ", ".join(f"{100 * slot + number}" for number in sorted(scanner_wire.SWITCHED_BY[card]))
            raise ValueError(
                f"scanner channel {lacking}: the {card} in slot {slot} (cards) has no such channel (allowed: {allowed})"
            )
        if not fitting:
            raise ValueError(
                f"scanner channels {', '.join(map(str, numbers))}: no card of a 3488A has all of them, and they are of"
                f" one slot, {slot}; a 44472 has 00 to 03 and 10 to 13, the others 00 to 09"
            )

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def range_of_channel_v(self, channel: str) -> float:
        return self.channels[channel].range_v

    @property
    def integrates_nplc(self) -> float:
        return self.nplc

    def input_ohm(self, channel: str) -> float | None:
        """More than 10 gigohm up to 10 V, with FIXEDZ OFF as after PRESET."""
        return 10.0e6 if self.channels[channel].range_v > 10.0 else None

    @property
    def reads_beside_others(self) -> bool:
        return True

    def reading_s(self, nplc: float | None = None) -> float:
        """Return the seconds for one reading: autozero takes a second conversion for each."""
        return 2.0 * (self.nplc if nplc is None else nplc) / self.line_frequency_hz


class Hp3458aReadout:
    """A :class:`rig.abilities.abilities.Readout`. ``clock`` is the rig's; the bus has its own for time-outs."""

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
        self.check_every_s = settings.checks.every_s if settings.checks.asks_for_anything else None
        self.check_action = settings.checks.action
        self._settings = settings
        self._calibrated_degc: float | None = None
        """The meter's own temperature when it last calibrated itself; None before."""
        self._calibrated_s = 0.0
        self._nplc = settings.nplc
        self._clock = clock
        self._inputs = dict(zip(self.channels, settings.channels.values(), strict=True))
        address = parse_resource(settings.resource, wire.DEFAULT_ADDRESS).address
        self.meter = Hp3458aMeter(name, bus, address, settings.line_frequency_hz, clock, settings.terminals)
        self.scanner = Hp3488aScanner(
            name,
            scanner_bus or bus,
            scanner_resource(settings).address,
            _scanner_channels(settings),
            settings.relay_settle_s,
            clock,
            card_of_slot(settings.cards),
        )

    def identify(self) -> str:
        return f"{self.meter.identify()}, {self.scanner.identify()}"

    def prepare(self) -> None:
        self.meter.prepare()
        self.scanner.prepare(self._clock.sleep)

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        if channel not in self._inputs:
            raise RequestRefused(
                f"{self.name}: no channel {channel!r} (allowed: {', '.join(self.channels)}); nothing was switched"
            )
        if samples < 1:
            raise RequestRefused(f"{self.name}: {channel}: got {samples} readings, at least 1; nothing was switched")
        return self._burst(channel, self._inputs[channel], samples, wait, nplc)

    def _burst(self, channel: str, entry: ScannedChannel, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        setup = Setup(entry.range_v, self._nplc if nplc is None else nplc, samples)
        with self._quiet_unless_done():
            self.scanner.select(entry.scanner_channel, wait)
            self.meter.set_up(setup)
            values_v, started_s = self.meter.burst(setup, wait)
            self.scanner.verify(entry.scanner_channel)
            self.meter.require_undisturbed(setup, wait)
        overload = np.abs(values_v) > wire.LARGEST_READING_V
        values_v[overload] = np.nan
        return Burst(channel, values_v, overload, started_s, self.meter.reading_s(setup.nplc))

    def reading_s(self, nplc: float | None = None) -> float:
        return self.meter.reading_s(self._nplc if nplc is None else nplc)

    def checks(self) -> Mapping[str, float]:
        return {"meter_temperature_degc": self.meter.temperature_degc()}

    def needs_check(self) -> bool:
        return self._settings.checks.autocalibrate and self._is_due(self.meter.temperature_degc())

    def check_itself(self, wait: Wait) -> MeterLook:
        """Check the meter by known voltages, calibrated anew where it has drifted.

        The scanner opens everything before the meter calibrates itself: its inputs must not be driven.
        """
        checks, degc = self._settings.checks, self.meter.temperature_degc()
        is_calibrated_anew = checks.autocalibrate and self._is_due(degc)
        if is_calibrated_anew:
            with self._quiet_unless_done():
                self.scanner.release(wait)
                self.meter.autocalibrate(wait)
            degc = self._calibrated_degc = self.meter.temperature_degc()
            self._calibrated_s = self._clock.monotonic_s()

        def read(channel: int, range_v: float) -> Burst:
            return self._burst(
                f"{self.name}, checks", ScannedChannel(scanner=channel, range_v=range_v), checks.samples, wait
            )

        return MeterLook(proofs(checks, ranges_v(self._settings.channels.values()), read), degc, is_calibrated_anew)

    def _is_due(self, degc: float) -> bool:
        before_degc = self._calibrated_degc
        if before_degc is None or abs(degc - before_degc) >= self._settings.checks.temperature_step_degc:
            return True
        age_h = (self._clock.monotonic_s() - self._calibrated_s) / 3600.0
        return age_h >= self._settings.checks.autocalibrate_every_h

    @contextmanager
    def _quiet_unless_done(self) -> Iterator[None]:
        """Leave the meter cleared and everything to be set up again, whatever ends a burst early."""
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


def _scanner_channel(number: int) -> int:
    return number if number >= 100 else number + 100


def _scanner_channels(settings: Hp3458aSettings) -> list[int]:
    """Return all scanner channels that are used, those of the checks included."""
    sensors = [entry.scanner_channel for entry in settings.channels.values()]
    return [*sensors, *(channel for channel in settings.checks.channel_numbers().values() if channel is not None)]


def scanner_resource(settings: Hp3458aSettings) -> GpibResource:
    """Return where the scanner is: by default on the meter's own controller, address 9.

    Raises: RequestRefused.
    """
    if settings.scanner_resource is None:
        return replace(parse_resource(settings.resource, wire.DEFAULT_ADDRESS), address=scanner_wire.DEFAULT_ADDRESS)
    return parse_resource(settings.scanner_resource, scanner_wire.DEFAULT_ADDRESS)
