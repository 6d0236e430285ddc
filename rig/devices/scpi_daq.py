"""Keysight (Agilent, HP) 34970A, 34980A and DAQ970A: a multimeter behind its own multiplexers, by LAN or GPIB.

A burst is a scan of one channel, swept as often as readings are asked for. All that a reading depends on is asked for
before and behind every burst, each reading comes with the number of its channel, and a burst counts only when the
error queue is empty behind it. ``CONF`` puts the input at 10 megohm and switches off all that stands beside a reading:
both are set behind it. What somebody else changed is told, also where the next ``CONF`` would put it right.

Source: docs/devices/scpi-daq.md.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rig.abilities.abilities import Burst, Wait
from rig.abilities.cards import card_of_slot, ranges_v
from rig.abilities.meter_checks import proofs
from rig.abilities.scpi_talk import (
    NOT_TAKEN,
    as_sent,
    clear_earlier_errors,
    listed,
    quiet_unless_done,
    require,
    require_no_error,
)
from rig.abilities.self_checking import MeterLook
from rig.abilities.waiting import wait_until
from rig.clock import Clock
from rig.devices.scpi_daq_settings import (
    CARD_CHANNELS,
    MODELS,
    MOST_SAMPLES,
    POWER_LINE_CYCLES,
    DaqChannel,
    ScpiDaqSettings,
)
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, FileContradicted, RequestRefused
from rig.link.messages import TALK_TIMEOUT_S, MessageLine
from rig.wire import scpi

DEFAULT_ADDRESS = 9
PART = 1000
"""Readings in one answer: a longer burst is taken out of the unit's memory in parts."""
BYTES_PER_READING, SLOWEST_BYTES_PER_S = 21, 900.0
"""With its channel and commas; by serial line at 9600 baud."""
DATA_LIMIT_S, LATENESS = 3.0, 0.5
"""How much later than expected the readings may be there: seconds, and a part of the burst."""
DC_VOLTS = (b"VOLT", b"VOLT:DC")
"""As ``SENS:FUNC?`` may name them."""
NOBODY_ELSE = "check that nobody else uses the unit"
CHANGED_BEFORE = f"no reading is taken; {NOBODY_ELSE}"
CHANGED_BEHIND = f"the burst is dropped; {NOBODY_ELSE}"

SetUp = tuple[DaqChannel, float, int]
"""The channel with its range, power-line cycles, sweeps."""


class ScpiDaqReadout:
    """A :class:`rig.abilities.abilities.Readout`. ``clock`` is the rig's; the line has its own for time-outs."""

    def __init__(self, name: str, settings: ScpiDaqSettings, line: MessageLine, clock: Clock) -> None:
        self.name = name
        self.channels = tuple(f"{name}.{channel}" for channel in settings.channels)
        self.check_every_s = settings.checks.every_s if settings.checks.asks_for_anything else None
        self.check_action = settings.checks.action
        self._settings = settings
        self._model = MODELS[settings.model]
        self._line = line
        self._clock = clock
        self._inputs = dict(zip(self.channels, settings.channels.values(), strict=True))
        self._set_up_for: SetUp | None = None
        self._is_prepared = False

    def identify(self) -> str:
        maker, model, serial, firmware = self._line.ask(b"*IDN?", scpi.parse_identity, idempotent=True)
        if model not in self._model.names:
            raise DeviceNonsense(
                f"{self.name}: *IDN? says model {model!r}, need {' or '.join(self._model.names)}"
                f" (readouts.{self.name}: model); nothing was set; correct the rig file or the address"
            )
        numbers = [entry.channel for entry in self._inputs.values()]
        numbers += [channel for channel in self._settings.checks.channel_numbers().values() if channel is not None]
        slots = sorted({number // self._model.numbers_per_slot for number in numbers})
        cards = [f"{self._card(slot, numbers)} in slot {slot}" for slot in slots]
        return ", ".join([f"{maker} {model} {serial} {firmware}".strip(), *cards])

    def prepare(self) -> None:
        """Clear, reset, identify, fix the shape of readings, read it back. Raises: DeviceRefused."""
        self._forget()
        self._line.clear()
        self._line.tell(b"ABOR")
        self._line.tell(b"*RST")
        clear_earlier_errors(self._line, self.name)
        self.identify()
        self._configure()

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        if channel not in self._inputs:
            raise RequestRefused(
                f"{self.name}: no channel {channel!r} (allowed: {', '.join(self.channels)}); nothing was switched"
            )
        if not 1 <= samples <= MOST_SAMPLES:
            raise RequestRefused(
                f"{self.name}: {channel}: got {samples} readings, allowed 1 to {MOST_SAMPLES} (the unit's reading"
                " memory); nothing was switched"
            )
        return self._burst(channel, self._inputs[channel], samples, wait, nplc)

    def _burst(self, channel: str, entry: DaqChannel, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        cycles = self._cycles(entry, nplc)
        with quiet_unless_done(self._forget, self._quieten):
            if not self._is_prepared:
                self._configure()
            wanted = (entry, cycles, samples)
            if self._set_up_for is not None:
                self._require_as_set(self._set_up_for, CHANGED_BEFORE)
            if wanted != self._set_up_for:
                self._set_up_for = None
                self._tell_setup(entry, cycles, samples)
                self._require_as_set(wanted, NOT_TAKEN)
                self._set_up_for = wanted
            values_v, started_s = self._scan(entry.channel, cycles, samples, wait)
            self._require_as_set(wanted, CHANGED_BEHIND)
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

        def read(channel: int, range_v: float) -> Burst:
            return self._burst(
                f"{self.name}, checks", DaqChannel(channel=channel, range_v=range_v), checks.samples, wait
            )

        return MeterLook(
            proofs(checks, ranges_v(self._settings.channels.values()), read), None, is_calibrated_anew=False
        )

    def _cycles(self, entry: DaqChannel, nplc: float | None) -> float:
        cycles = nplc if nplc is not None else entry.nplc if entry.nplc is not None else self._settings.nplc
        if cycles not in POWER_LINE_CYCLES:
            raise RequestRefused(
                f"{self.name}: got {cycles:g} power-line cycles (allowed: {listed(POWER_LINE_CYCLES)});"
                " nothing was switched"
            )
        return cycles

    def _configure(self) -> None:
        """Set up what no burst and no ``CONF`` changes: swept at once."""
        self._line.tell(b"TRIG:SOUR IMM")
        self._require_no_error("configuration", "it is not set up")
        self._is_prepared = True

    def _beside_a_reading(self) -> tuple[tuple[bytes, int], ...]:
        return (b"UNIT", 0), (b"TIME", 0), (b"ALAR", 0), (b"CHAN", int(self._settings.channel_echo))

    def _tell_setup(self, entry: DaqChannel, cycles: float, samples: int) -> None:
        """``CONF`` comes first: it starts the channel anew, at 10 megohm, and switches off what is beside readings.

        It switches off scaling too, and autorange where it names a range; both are told once more.
        """
        where = scpi.channel_list([entry.channel])
        zero = b"ON" if self._settings.autozero else b"OFF"
        impedance = b"ON" if self._settings.high_impedance else b"OFF"
        self._line.tell(b"CONF:VOLT:DC %s,%s" % (as_sent(entry.range_v), where))
        self._line.tell(b"SENS:VOLT:DC:RANG:AUTO OFF," + where)
        self._line.tell(b"CALC:SCAL:STAT OFF," + where)
        self._line.tell(b"SENS:VOLT:DC:NPLC %s,%s" % (as_sent(cycles), where))
        self._line.tell(b"%s %s,%s" % (self._model.impedance, impedance, where))
        self._line.tell(b"%s %s,%s" % (self._model.autozero, zero, where))
        self._line.tell(b"ROUT:CHAN:DEL %s,%s" % (as_sent(self._relay_settle_s()), where))
        self._line.tell(b"ROUT:SCAN " + where)
        self._line.tell(b"TRIG:COUN %d" % samples)
        for switch, state in self._beside_a_reading():
            self._line.tell(b"FORM:READ:%s %d" % (switch, state))
        self._require_no_error(f"channel {entry.channel}", "nothing is measured on it")

    def _require_as_set(self, set_up: SetUp, consequence: str) -> None:
        """Ask for all that a reading depends on. Raises: DeviceRefused, DeviceFault where something is otherwise."""
        number = set_up[0].channel
        self._require_word(b"SENS:FUNC? " + scpi.channel_list([number]), DC_VOLTS, consequence)
        self._require_word(b"TRIG:SOUR?", (b"IMM",), consequence)
        for query, need in self._numbers_as_set(*set_up):
            require(self._line, self.name, query, need, consequence)
        scan_list = self._line.ask(b"ROUT:SCAN?", scpi.parse_scan_list, idempotent=True)
        if scan_list != (number,):
            scanned = " and ".join(map(str, scan_list)) or "no channel"
            raise DeviceFault(
                f"{self.name}: the scan list holds {scanned}, it was set to {number} alone; {consequence}"
            )

    def _numbers_as_set(self, entry: DaqChannel, cycles: float, samples: int) -> Iterator[tuple[bytes, float]]:
        """Yield each question that is answered by a number, and that number."""
        where = scpi.channel_list([entry.channel])
        yield b"SENS:VOLT:DC:RANG:AUTO? " + where, 0
        yield b"SENS:VOLT:DC:RANG? " + where, entry.range_v
        yield b"SENS:VOLT:DC:NPLC? " + where, cycles
        yield self._model.autozero + b"? " + where, self._settings.autozero
        yield self._model.impedance + b"? " + where, self._settings.high_impedance
        yield b"CALC:SCAL:STAT? " + where, 0
        yield b"ROUT:CHAN:DEL? " + where, self._relay_settle_s()
        yield b"TRIG:COUN?", samples
        for switch, state in self._beside_a_reading():
            yield b"FORM:READ:%s?" % switch, state

    def _require_word(self, query: bytes, allowed: tuple[bytes, ...], consequence: str) -> None:
        word = self._line.ask(query, _word, idempotent=True)
        if word not in allowed:
            raise DeviceRefused(
                f"{self.name}: {query.decode('ascii')} reads back {word.decode('ascii')}, it was set to"
                f" {allowed[0].decode('ascii')}; {consequence}"
            )

    def _relay_settle_s(self) -> float:
        """Return the delay in the unit's steps of a millisecond."""
        return round(self._settings.relay_settle_s, 3)

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
        """Fetch a short burst by an answer that may be asked for again, a long one by parts that leave the memory."""
        if samples <= PART:
            return np.array(self._answered(b"FETC?", channel, samples, idempotent=True))
        counts = [min(PART, samples - start) for start in range(0, samples, PART)]
        parts = [self._answered(b"DATA:REM? %d" % count, channel, count, idempotent=False) for count in counts]
        if left := self._line.ask(b"DATA:POIN?", scpi.parse_whole, idempotent=True):
            raise DeviceFault(
                f"{self.name}: channel {channel}: got {samples + left} readings, asked for {samples};"
                " the burst is dropped; check that nobody else uses the unit"
            )
        return np.concatenate(parts)

    def _answered(self, query: bytes, channel: int, count: int, *, idempotent: bool) -> tuple[float, ...]:
        """One answer of ``count`` readings, volts; it has the time that its length needs on the slowest line."""
        limit_s = TALK_TIMEOUT_S + count * BYTES_PER_READING / SLOWEST_BYTES_PER_S
        parse = scpi.parse_named_readings if self._settings.channel_echo else _unnamed
        named = self._line.ask(query, parse, idempotent=idempotent, timeout_s=limit_s)
        if others := {number for _, number in named} - {channel, None}:
            named_ones = " and ".join(map(str, sorted(filter(None, others))))
            raise DeviceFault(
                f"{self.name}: channel {channel} was scanned, but readings name {named_ones};"
                " the burst is dropped; check that nobody else uses the unit"
            )
        if len(named) != count:
            raise DeviceFault(
                f"{self.name}: channel {channel}: got {len(named)} readings, asked for {count};"
                " the burst is dropped; check that nobody else uses the unit"
            )
        return tuple(reading for reading, _ in named)

    def _require_no_error(self, after: str, consequence: str) -> None:
        try:
            require_no_error(self._line, self.name, after, consequence)
        except DeviceRefused:
            self._set_up_for = None
            raise

    def _card(self, slot: int, numbers: Sequence[int]) -> str:
        query = b"SYST:CTYP? %d" % (slot * self._model.numbers_per_card)
        _, card, _, _ = self._line.ask(query, scpi.parse_identity, idempotent=True)
        if card == "0":
            raise FileContradicted(
                f"{self.name}: slot {slot} is empty, but the rig file uses its channels (readouts.{self.name}:"
                " channels); nothing was switched; put the card in or correct the file"
            )
        stated = card_of_slot(self._settings.cards).get(slot, card)
        if stated != card:
            raise FileContradicted(
                f"{self.name}: slot {slot} has a {card}, the rig file says {stated} (readouts.{self.name}: cards);"
                " nothing was switched; put that card in or correct the file"
            )
        last = CARD_CHANNELS.get(card, self._model.most_channels)
        for number in numbers:
            if number // self._model.numbers_per_slot == slot and number % self._model.numbers_per_slot > last:
                raise FileContradicted(
                    f"{self.name}: the {card} in slot {slot} measures volts on channels 1 to {last}, the rig file uses"
                    f" channel {number} (readouts.{self.name}: channels); nothing was switched; correct the file"
                )
        return card

    def _forget(self) -> None:
        self._set_up_for = None
        self._is_prepared = False

    def _quieten(self) -> None:
        self._line.clear()
        self._line.tell(b"ABOR")
        self._line.tell(b"*CLS")


def _unnamed(line: bytes) -> tuple[tuple[float, None], ...]:
    return tuple((reading, None) for reading in scpi.parse_readings(line))


def _word(line: bytes) -> bytes:
    """Parse one word such as ``IMM`` or ``"VOLT"``. Raises: DeviceNonsense."""
    word = line.strip().strip(b'"')
    if not (word.replace(b":", b"").isalnum() and len(word) <= 16):
        raise DeviceNonsense("the unit answers with one word")
    return word.upper()
