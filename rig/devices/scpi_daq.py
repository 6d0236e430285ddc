"""Keysight (Agilent, HP) 34970A and 34980A: a multimeter behind its own multiplexers, by LAN or GPIB.

A burst is a scan of one channel, swept as often as readings are asked for. What the unit was told is read back, each
reading comes with the number of its channel, and a burst counts only when the error queue is empty behind it.

Source: 34970A user's guide (scan list, sweeps, reading memory); the shape of a reading with its channel and the LAN
port 5025 are not confirmed, so ``channel_echo`` and the port in ``resource`` are settings.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from rig.clock import Clock
from rig.description.device_settings import Positive, ReadoutSettings
from rig.devices.abilities import Burst, MeterLook, Wait
from rig.devices.meter_checks import MeterChecks, proofs
from rig.devices.waiting import wait_until
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, LinkClosed, LinkLost, RequestRefused
from rig.link.messages import MessageLine
from rig.toml_file import StrictTable
from rig.wire import scpi

RANGES_V = (0.1, 1.0, 10.0, 100.0, 300.0)
POWER_LINE_CYCLES = (0.02, 0.2, 1.0, 2.0, 10.0, 20.0, 100.0, 200.0)
DEFAULT_ADDRESS = 9
OVERHEAD_S = 0.005
DATA_LIMIT_S, LATENESS = 3.0, 0.5
"""How much later than expected the readings may be there: seconds, and a part of the burst."""
READ_BACK_TOLERANCE = 1e-3
LONGEST_ERROR_LIST = 40


@dataclass(frozen=True, slots=True)
class Model:
    """What differs between the two units."""

    names: tuple[str, ...]
    """As ``*IDN?`` gives them."""
    slots: int
    slot_place: int
    """Channel 101 or 1001: the slot is the channel divided by this."""
    card_place: int
    """``SYST:CTYP?`` asks for slot × this."""


MODELS: Mapping[str, Model] = {
    "34970A": Model(("34970A", "34972A"), slots=3, slot_place=100, card_place=100),
    "34980A": Model(("34980A",), slots=8, slot_place=1000, card_place=1),
}


class DaqChannel(StrictTable):
    """One ``channels`` entry."""

    channel: Annotated[int, Field(ge=101, le=8999)]
    """Slot and channel: three digits on a 34970A, four on a 34980A."""
    range_v: float
    nplc: Positive | None = None
    """Instead of the readout's."""

    @field_validator("range_v")
    @classmethod
    def _is_a_range(cls, range_v: float) -> float:
        if range_v not in RANGES_V:
            raise ValueError(f"the unit has no such range, got {range_v:g} V (allowed: {_listed(RANGES_V)} V)")
        return range_v

    @field_validator("nplc")
    @classmethod
    def _is_offered(cls, nplc: float | None) -> float | None:
        return None if nplc is None else _offered(nplc)


class DaqChecks(MeterChecks):
    """``checks``: what the unit is made to prove about itself; it has no calibration to its own standards."""

    short_channel: Annotated[int, Field(ge=101, le=8999)] | None = None
    reference_channel: Annotated[int, Field(ge=101, le=8999)] | None = None

    def places(self) -> dict[str, int | None]:
        return {"short": self.short_channel, "reference": self.reference_channel}


class ScpiDaqSettings(ReadoutSettings):
    """``driver = "scpi-daq"``."""

    driver: Literal["scpi-daq"]
    model: Literal["34970A", "34980A"]
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
    channels: dict[str, DaqChannel] = Field(min_length=1)
    checks: DaqChecks = DaqChecks()

    @field_validator("nplc")
    @classmethod
    def _is_offered(cls, nplc: float) -> float:
        return _offered(nplc)

    @model_validator(mode="after")
    def _channels_exist_once(self) -> "ScpiDaqSettings":
        model = MODELS[self.model]
        used = [entry.channel for entry in self.channels.values()]
        self.checks.refuse_conflicts(used, self.ranges_v())
        for number in [*used, *(place for place in self.checks.places().values() if place is not None)]:
            if not 1 <= number // model.slot_place <= model.slots:
                first, last = model.slot_place + 1, model.slots * model.slot_place + model.slot_place - 1
                raise ValueError(f"a {self.model} has no channel {number} (allowed: {first} to {last})")
            if used.count(number) > 1:
                raise ValueError(f"channel {number} is used by more than one name; each needs its own")
        return self

    def ranges_v(self) -> list[float]:
        """Return every range that a channel uses, as often as it does."""
        return [entry.range_v for entry in self.channels.values()]

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def reading_s(self, nplc: float | None = None) -> float:
        conversions = 2.0 if self.autozero else 1.0
        cycles = self.nplc if nplc is None else nplc
        return conversions * cycles / self.line_frequency_hz + self.relay_settle_s + OVERHEAD_S


class ScpiDaqReadout:
    """A :class:`rig.devices.abilities.Readout`. ``clock`` is the rig's; the line has its own for time-outs."""

    def __init__(self, name: str, settings: ScpiDaqSettings, line: MessageLine, clock: Clock) -> None:
        self.name = name
        self.channels = tuple(f"{name}.{channel}" for channel in settings.channels)
        self.earlier_errors: tuple[str, ...] = ()
        """Errors that :meth:`prepare` found left over from earlier use."""
        self.check_every_s = settings.checks.every_s if settings.checks.asks_for_anything else None
        self.check_action = settings.checks.action
        self._settings = settings
        self._model = MODELS[settings.model]
        self._line = line
        self._clock = clock
        self._inputs = dict(zip(self.channels, settings.channels.values(), strict=True))
        self._set_up_for: tuple[int, float, int] | None = None
        self._is_prepared = False

    def identify(self) -> str:
        maker, model, serial, firmware = self._line.ask(b"*IDN?", scpi.parse_identity, idempotent=True)
        if model not in self._model.names:
            raise DeviceNonsense(
                f"{self.name}: *IDN? says model {model!r}, need {' or '.join(self._model.names)}"
                f" (readouts.{self.name}: model); nothing was set; correct the rig file or the address"
            )
        numbers = [entry.channel for entry in self._inputs.values()]
        numbers += [place for place in self._settings.checks.places().values() if place is not None]
        slots = sorted({number // self._model.slot_place for number in numbers})
        cards = [f"{self._card(slot)} in slot {slot}" for slot in slots]
        carrier = self._line.identify()
        return ", ".join([f"{maker} {model} {serial} {firmware}".strip(), *cards, *([carrier] if carrier else [])])

    def prepare(self) -> None:
        """Clear, reset, identify, fix the shape of readings, read it back. Raises: DeviceRefused."""
        self._forget()
        self._line.clear()
        self._line.tell(b"ABOR")
        self._line.tell(b"*RST")
        self.earlier_errors = tuple(text for _, text in self._errors())
        self.identify()
        self._configure()

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        return self._burst(channel, self._entry(channel, samples), samples, wait, nplc)

    def _burst(self, channel: str, entry: DaqChannel, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        cycles = self._cycles(entry, nplc)
        with self._quiet_unless_done():
            if not self._is_prepared:
                self._configure()
            self._set_up(entry, cycles, samples)
            values_v, started_s = self._scan(entry.channel, cycles, samples, wait)
            self._require_no_error("the scan", "the burst is dropped")
        overload = np.abs(values_v) > scpi.LARGEST_READING
        values_v[overload] = np.nan
        return Burst(channel, values_v, overload, started_s, self._settings.reading_s(cycles))

    def reading_s(self, nplc: float | None = None) -> float:
        return self._settings.reading_s(nplc)

    def checks(self) -> Mapping[str, float]:
        """Return nothing: the unit offers no temperature of its own."""
        return {}

    def needs_check(self) -> bool:
        return False

    def check_itself(self, wait: Wait) -> MeterLook:
        checks = self._settings.checks

        def read(place: int, range_v: float) -> Burst:
            return self._burst(f"{self.name}, checks", DaqChannel(channel=place, range_v=range_v), checks.samples, wait)

        return MeterLook(proofs(checks, self._settings.ranges_v(), read), None, is_calibrated_anew=False)

    def _entry(self, channel: str, samples: int) -> DaqChannel:
        if channel not in self._inputs:
            raise RequestRefused(
                f"{self.name}: no channel {channel!r} (allowed: {', '.join(self.channels)}); nothing was switched"
            )
        if not 1 <= samples <= 50_000:
            raise RequestRefused(
                f"{self.name}: {channel}: got {samples} readings, allowed 1 to 50000 (the unit's reading memory);"
                " nothing was switched"
            )
        return self._inputs[channel]

    def _cycles(self, entry: DaqChannel, nplc: float | None) -> float:
        cycles = nplc if nplc is not None else entry.nplc if entry.nplc is not None else self._settings.nplc
        if cycles not in POWER_LINE_CYCLES:
            raise RequestRefused(
                f"{self.name}: got {cycles:g} power-line cycles (allowed: {_listed(POWER_LINE_CYCLES)});"
                " nothing was switched"
            )
        return cycles

    def _configure(self) -> None:
        """Set up what no burst changes.

        Readings without unit, time and alarm, with their channel; swept at once.
        """
        echo = self._settings.channel_echo
        for command, state in ((b"UNIT", 0), (b"TIME", 0), (b"ALAR", 0), (b"CHAN", int(echo))):
            self._line.tell(b"FORM:READ:%s %d" % (command, state))
            self._require(b"FORM:READ:%s?" % command, state)
        self._line.tell(b"TRIG:SOUR IMM")
        self._require_no_error("configuration", "it is not set up")
        self._is_prepared = True

    def _set_up(self, entry: DaqChannel, cycles: float, samples: int) -> None:
        """Send what one burst needs and read it back. ``CONF`` comes first, since it resets the channel."""
        wanted = (entry.channel, cycles, samples)
        if wanted == self._set_up_for:
            return
        self._set_up_for = None
        where = scpi.channel_list([entry.channel])
        zero = b"ON" if self._settings.autozero else b"OFF"
        self._line.tell(b"CONF:VOLT:DC %s,%s" % (_text(entry.range_v), where))
        self._line.tell(b"SENS:VOLT:DC:NPLC %s,%s" % (_text(cycles), where))
        self._line.tell(b"SENS:ZERO:AUTO %s,%s" % (zero, where))
        self._line.tell(b"ROUT:CHAN:DEL %s,%s" % (_text(self._settings.relay_settle_s), where))
        self._line.tell(b"ROUT:SCAN " + where)
        self._line.tell(b"TRIG:COUN %d" % samples)
        self._require_no_error(f"channel {entry.channel}", "nothing is measured on it")
        self._require(b"SENS:VOLT:DC:RANG? " + where, entry.range_v)
        self._require(b"SENS:VOLT:DC:NPLC? " + where, cycles)
        self._require(b"TRIG:COUN?", samples)
        self._require_scan_list(entry.channel)
        self._set_up_for = wanted

    def _scan(self, channel: int, cycles: float, samples: int, wait: Wait) -> tuple[NDArray[np.float64], float]:
        """Read one burst: all readings, volts, shape (samples,), and when it was started, rig seconds."""
        self._line.tell(b"INIT")
        started_s = self._clock.monotonic_s()
        burst_s = samples * self._settings.reading_s(cycles)
        limit_s = LATENESS * burst_s + DATA_LIMIT_S
        wait(burst_s)
        wait_until(
            lambda: self._line.ask(b"DATA:POIN?", scpi.parse_whole, idempotent=True) >= samples,
            wait,
            (self._clock, self._line.clock),
            limit_s,
            lambda: (
                f"{self.name}: channel {channel}: {samples} readings are not there {limit_s:g} s after their time;"
                " the burst is dropped; check line_frequency_hz and that nobody else scans with the unit"
            ),
        )
        return self._fetched(channel, samples), started_s

    def _fetched(self, channel: int, samples: int) -> NDArray[np.float64]:
        if not self._settings.channel_echo:
            readings = self._line.ask(b"FETC?", scpi.parse_readings, idempotent=True)
        else:
            named = self._line.ask(b"FETC?", scpi.parse_named_readings, idempotent=True)
            readings = tuple(reading for reading, _ in named)
            if others := {number for _, number in named} - {channel}:
                raise DeviceFault(
                    f"{self.name}: channel {channel} was scanned, but readings name {sorted(others)};"
                    " the burst is dropped; check that nobody else uses the unit"
                )
        if len(readings) != samples:
            raise DeviceFault(
                f"{self.name}: channel {channel}: got {len(readings)} readings, asked for {samples};"
                " the burst is dropped; check that nobody else uses the unit"
            )
        return np.array(readings)

    def _require(self, query: bytes, need: float) -> None:
        got = self._line.ask(query, scpi.parse_number, idempotent=True)
        if abs(got - need) > READ_BACK_TOLERANCE * abs(need):
            raise DeviceRefused(
                f"{self.name}: {query.decode('ascii')} reads back {got:g}, it was set to {need:g}; no reading is"
                " taken; compare the rig file with what the unit offers"
            )

    def _require_scan_list(self, channel: int) -> None:
        listed = self._line.ask(b"ROUT:SCAN?", scpi.parse_scan_list, idempotent=True)
        if listed != (channel,):
            raise DeviceFault(
                f"{self.name}: the scan list is {list(listed)}, it was set to [{channel}]; no reading is taken;"
                " check that nobody else uses the unit"
            )

    def _require_no_error(self, after: str, consequence: str) -> None:
        if errors := self._errors():
            self._set_up_for = None
            told = ", ".join(f"{number:+d} {text}" for number, text in errors)
            raise DeviceRefused(f"{self.name}: {after}: {told}; {consequence}; look at the unit's display")

    def _errors(self) -> list[tuple[int, str]]:
        """Ask until the queue is empty; asking takes the oldest one out."""
        errors: list[tuple[int, str]] = []
        while (error := self._line.ask(b"SYST:ERR?", scpi.parse_error, idempotent=False))[0]:
            errors.append(error)
            if len(errors) > LONGEST_ERROR_LIST:
                raise DeviceNonsense(f"{self.name}: more than {LONGEST_ERROR_LIST} errors; power it off and on")
        return errors

    def _card(self, slot: int) -> str:
        query = b"SYST:CTYP? %d" % (slot * self._model.card_place)
        _, card, _, _ = self._line.ask(query, scpi.parse_identity, idempotent=True)
        if card == "0":
            raise DeviceRefused(
                f"{self.name}: slot {slot} is empty, but the rig file uses its channels (readouts.{self.name}:"
                " channels); nothing was switched; put the card in or correct the file"
            )
        return card

    def _forget(self) -> None:
        self._set_up_for = None
        self._is_prepared = False

    @contextmanager
    def _quiet_unless_done(self) -> Iterator[None]:
        """Leave the unit at rest and everything to be set up again, whatever ends a burst early."""
        needs_stop = True
        try:
            yield
            needs_stop = False
        except (LinkLost, LinkClosed):
            needs_stop = False  # there is no line to stop it by
            self._forget()
            raise
        finally:
            if needs_stop:
                self._forget()
                self._line.clear()
                self._line.tell(b"ABOR")
                self._line.tell(b"*CLS")


def _listed(numbers: tuple[float, ...]) -> str:
    return ", ".join(f"{number:g}" for number in numbers)


def _offered(nplc: float) -> float:
    if nplc not in POWER_LINE_CYCLES:
        raise ValueError(f"the unit has no such integration time, got {nplc:g} (allowed: {_listed(POWER_LINE_CYCLES)})")
    return nplc


def _text(number: float) -> bytes:
    return b"%.9g" % number
