"""Single multimeters that speak SCPI: 34401A, Truevolt, Keithley 2000 and 2002. One input, one ``READ?`` a reading.

What differs between them is a :class:`Preset`. Everything that a reading depends on is set behind the reset and read
back, and asked for again before every burst: range, integration time, input impedance, which inputs are selected (a
key or a switch at the panel), and that a reading is a plain number of volts. A burst counts only when the same inputs
are still selected and the error queue is empty behind it.

Source: docs/devices/scpi-meters.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from rig.abilities.abilities import Burst, Wait
from rig.abilities.scpi_talk import (
    NOT_TAKEN,
    as_sent,
    clear_earlier_errors,
    listed,
    quiet_unless_done,
    require,
    require_no_error,
)
from rig.abilities.selected_inputs import Inputs, SelectedInputs
from rig.clock import Clock
from rig.description.device_settings import Positive, ReadoutSettings
from rig.errors import DeviceNonsense, DeviceRefused, RequestRefused
from rig.link.messages import TALK_TIMEOUT_S, MessageLine
from rig.toml_file import StrictTable
from rig.wire import scpi

FIXED_OHM = 10.0e6
OVERHEAD_S = 0.01
LATENESS = 1.0
"""How much later than expected a reading may be there, as a part of its time; the line's own time-out comes to it."""
MOST_SAMPLES = 100_000


@dataclass(frozen=True, slots=True)
class Preset:
    """What differs between the meters."""

    names: tuple[str, ...]
    """As ``*IDN?`` gives them."""
    ranges_v: tuple[float, ...]
    high_impedance_ranges_v: tuple[float, ...]
    """Where the input can have more than 10 gigohm."""
    nplc: tuple[float, ...]
    """Every integration time that it offers; ``spans_nplc``: the ends of a continuous span."""
    spans_nplc: bool
    configure: tuple[bytes, ...]
    """Volts, and the range in place of %s."""
    impedance: bytes | None
    """The header that takes the input off its 10 megohm; None: there is none, each range has the best it can."""
    autozero: bytes
    terminals: bytes
    """The question which inputs are selected; ``front`` is its answer for those at the front."""
    front: bytes
    words: Mapping[bytes, bytes]
    """Questions whose answers say that a reading is a plain number of volts."""

    def offers(self, nplc: float) -> bool:
        if self.spans_nplc:
            return self.nplc[0] <= nplc <= self.nplc[-1]
        return nplc in self.nplc

    def nplc_choices(self) -> str:
        return f"{self.nplc[0]:g} to {self.nplc[-1]:g}" if self.spans_nplc else listed(self.nplc)


_HP = Preset(
    ("34401A",), (0.1, 1.0, 10.0, 100.0, 1000.0), (0.1, 1.0, 10.0), (0.02, 0.2, 1.0, 10.0, 100.0), spans_nplc=False,
    configure=(b"CONF:VOLT:DC %s", b"TRIG:SOUR IMM"), impedance=b"INP:IMP:AUTO", autozero=b"ZERO:AUTO",
    terminals=b"ROUT:TERM?", front=b"FRON", words={b"FUNC?": b"VOLT", b"VOLT:DC:RANG:AUTO?": b"0", b"CALC:STAT?": b"0"},
)  # fmt: skip
_KEITHLEY = (b"INIT:CONT OFF", b"SENS:FUNC 'VOLT:DC'", b"VOLT:DC:RANG %s", b"VOLT:DC:AVER:STAT OFF", b"FORM:ELEM READ")
_PLAIN = {
    b"FUNC?": b"VOLT:DC", b"VOLT:DC:RANG:AUTO?": b"0", b"VOLT:DC:REF:STAT?": b"0", b"VOLT:DC:AVER:STAT?": b"0",
    b"CALC:STAT?": b"0",
}  # fmt: skip
"""Of a Keithley: volts on a range that stays, no relative reading (the key REL), no filter, no mathematics."""
PRESETS: Mapping[str, Preset] = {
    "34401A": _HP,
    "34461A": Preset(
        ("34461A", "34465A", "34470A"), _HP.ranges_v, _HP.high_impedance_ranges_v, _HP.nplc, spans_nplc=False,
        configure=_HP.configure, impedance=b"VOLT:DC:IMP:AUTO", autozero=b"VOLT:DC:ZERO:AUTO",
        terminals=b"ROUT:TERM?", front=b"FRON",
        words={b"FUNC?": b"VOLT", b"VOLT:DC:RANG:AUTO?": b"0", b"VOLT:DC:NULL:STAT?": b"0", b"CALC:SCAL:STAT?": b"0"},
    ),
    "keithley-2000": Preset(
        ("MODEL 2000",), (0.1, 1.0, 10.0, 100.0, 1000.0), (0.1, 1.0, 10.0), (0.01, 10.0), spans_nplc=True,
        configure=_KEITHLEY, impedance=None, autozero=b"SYST:AZER:STAT",
        terminals=b"SYST:FRSW?", front=b"1", words={b"FORM:ELEM?": b"READ", b"UNIT:VOLT:DC?": b"V"} | _PLAIN,
    ),
    "keithley-2002": Preset(
        ("MODEL 2002",), (0.2, 2.0, 20.0, 200.0, 1000.0), (0.2, 2.0, 20.0), (0.01, 50.0), spans_nplc=True,
        configure=_KEITHLEY, impedance=None, autozero=b"SYST:AZER:STAT",
        terminals=b"SYST:FRSW?", front=b"1", words={b"FORM:ELEM?": b"READ"} | _PLAIN,
    ),
}  # fmt: skip


class MeterInput(StrictTable):
    """The one ``channels`` entry."""

    range_v: float


class ScpiMeterSettings(ReadoutSettings):
    """``driver = "scpi-meter"``."""

    driver: Literal["scpi-meter"]
    model: Literal["34401A", "34461A", "keithley-2000", "keithley-2002"]
    resource: str
    """``twin``, ``socket://host:5025``, ``prologix+…#address``, ``visa:GPIB0::22::INSTR`` or a serial device."""
    nplc: Positive = 10.0
    line_frequency_hz: Literal[50, 60] = 50
    autozero: bool = True
    """A second conversion for every reading."""
    high_impedance: bool = True
    """More than 10 gigohm on the low ranges; false: 10 megohm on every range, as after a reset."""
    terminals: Inputs | None = None
    """Which inputs must be selected at the meter; None: either, and the identity says which."""
    baud_rate: Annotated[int, Field(ge=300, le=921600)] = 9600
    """Of a serial line, with the three that follow."""
    parity: Literal["N", "E", "O"] = "N"
    data_bits: Literal[7, 8] = 8
    stop_bits: Literal[1, 2] = 1
    channels: dict[str, MeterInput] = Field(min_length=1, max_length=1)
    """One name and its range: a meter has one input."""

    @property
    def preset(self) -> Preset:
        return PRESETS[self.model]

    @model_validator(mode="after")
    def _is_offered(self) -> "ScpiMeterSettings":
        preset, range_v = self.preset, self.range_v
        if range_v not in preset.ranges_v:
            raise ValueError(
                f"channels: a {self.model} has no range of {range_v:g} V (allowed: {listed(preset.ranges_v)} V)"
            )
        if not preset.offers(self.nplc):
            raise ValueError(
                f"nplc: a {self.model} has no integration time of {self.nplc:g} power-line cycles (allowed:"
                f" {preset.nplc_choices()})"
            )
        if preset.impedance is None and not self.high_impedance:
            raise ValueError(
                f"high_impedance: a {self.model} has no command for its input impedance, which is high on the ranges"
                " up to "
                f"{preset.high_impedance_ranges_v[-1]:g} V; leave the key out"
            )
        return self

    @property
    def range_v(self) -> float:
        return next(iter(self.channels.values())).range_v

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def range_of_channel_v(self, channel: str) -> float:  # noqa: ARG002 there is one
        return self.range_v

    @property
    def integrates_nplc(self) -> float:
        return self.nplc

    def input_ohm(self, channel: str) -> float | None:  # noqa: ARG002 there is one
        high = self.high_impedance and self.range_v in self.preset.high_impedance_ranges_v
        return None if high else FIXED_OHM

    @property
    def reads_beside_others(self) -> bool:
        return True

    def reading_s(self, nplc: float | None = None) -> float:
        conversions = 2.0 if self.autozero else 1.0
        return conversions * (self.nplc if nplc is None else nplc) / self.line_frequency_hz + OVERHEAD_S


class ScpiMeter:
    """A :class:`rig.abilities.abilities.Readout`. ``needs_remote``: on a serial line it must be told so first."""

    def __init__(
        self, name: str, settings: ScpiMeterSettings, line: MessageLine, clock: Clock, *, needs_remote: bool = False
    ) -> None:
        self.name = name
        self.channels = tuple(f"{name}.{channel}" for channel in settings.channels)
        self._settings = settings
        self._preset = settings.preset
        self._line = line
        self._clock = clock
        self._needs_remote = needs_remote
        self._set_up_for: float | None = None
        """Power-line cycles; None: it is not set up."""
        self._inputs = SelectedInputs(name, settings.terminals)
        self._busy_until_s = 0.0
        """Rig seconds: a reading that was given up is still being taken, and everything else waits behind it."""

    def identify(self) -> str:
        maker, model, serial, firmware = self._line.ask(b"*IDN?", scpi.parse_identity, idempotent=True)
        if model not in self._preset.names:
            raise DeviceNonsense(
                f"{self.name}: *IDN? says model {model!r}, need {' or '.join(self._preset.names)}"
                f" (readouts.{self.name}: model); nothing was set; correct the rig file or the address"
            )
        terminals = self._selected()
        self._inputs.require_declared(terminals)
        return f"{f'{maker} {model} {serial} {firmware}'.strip()}, {terminals} inputs"

    def prepare(self) -> None:
        """Clear, reset, identify, set up, read it back. Raises: DeviceRefused."""
        self._set_up_for = None
        self._line.clear()
        if self._needs_remote:
            self._line.tell(b"SYST:REM")
        self.identify()
        self._inputs.require(self._selected(), "no reading is taken")
        self._line.tell(b"*RST")
        clear_earlier_errors(self._line, self.name)
        self._set_up(self._settings.nplc)
        self._require_as_set(self._settings.nplc, NOT_TAKEN)

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        cycles = self._checked(channel, samples, nplc)
        with quiet_unless_done(self._forget, self._line.clear):
            # A reading that was given up: on a line without device clear nothing is answered before it.
            if (left_s := self._busy_until_s - self._clock.monotonic_s()) > 0.0:
                wait(left_s)
                self._line.clear()
            self._busy_until_s = 0.0
            if cycles != self._set_up_for:
                self._set_up(cycles)
            self._require_as_set(cycles, NOT_TAKEN)
            started_s = self._clock.monotonic_s()
            values_v = np.array([self._reading(cycles, wait) for _ in range(samples)], dtype=np.float64)
            self._require_as_set(cycles, "the burst is dropped")
            require_no_error(self._line, self.name, "the burst", "it is dropped")
        overload = np.abs(values_v) > scpi.LARGEST_READING
        values_v[overload] = np.nan
        return Burst(channel, values_v, overload, started_s, self._settings.reading_s(cycles))

    def reading_s(self, nplc: float | None = None) -> float:
        return self._settings.reading_s(nplc)

    def checks(self) -> Mapping[str, float]:
        """Return nothing: the meters offer no temperature of their own."""
        return {}

    def _checked(self, channel: str, samples: int, nplc: float | None) -> float:
        """Return the power-line cycles of a burst. Raises: RequestRefused."""
        if channel not in self.channels:
            raise RequestRefused(
                f"{self.name}: no channel {channel!r} (allowed: {', '.join(self.channels)}); nothing was measured"
            )
        if not 1 <= samples <= MOST_SAMPLES:
            raise RequestRefused(
                f"{self.name}: {channel}: got {samples} readings, allowed 1 to {MOST_SAMPLES}; nothing was measured"
            )
        cycles = self._settings.nplc if nplc is None else nplc
        if not self._preset.offers(cycles):
            raise RequestRefused(
                f"{self.name}: got {cycles:g} power-line cycles (allowed: {self._preset.nplc_choices()});"
                " nothing was measured"
            )
        return cycles

    def _set_up(self, cycles: float) -> None:
        """Send what a reading depends on; what presets the function first: it takes the rest back to its defaults."""
        self._set_up_for = None
        if self._needs_remote:  # its LOCAL key and a loss of power take it out of remote
            self._line.tell(b"SYST:REM")
        self._line.tell(b"*CLS")  # what a burst that ended early left in the queue was told then
        for command in self._preset.configure:
            self._line.tell(command.replace(b"%s", as_sent(self._settings.range_v)))
        self._line.tell(b"VOLT:DC:NPLC " + as_sent(cycles))
        if self._preset.impedance is not None:
            self._line.tell(b"%s %s" % (self._preset.impedance, _switch(self._settings.high_impedance)))
        self._line.tell(b"%s %s" % (self._preset.autozero, _switch(self._settings.autozero)))
        require_no_error(self._line, self.name, "configuration", "nothing is measured")
        self._set_up_for = cycles

    def _selected(self) -> Inputs:
        answer = self._line.ask(self._preset.terminals, _word, idempotent=True)
        return "front" if answer == self._preset.front else "rear"

    def _require_as_set(self, cycles: float, outcome: str) -> None:
        """Ask all that a reading depends on: a key at the panel changes any of it at any time."""
        self._inputs.require(self._selected(), outcome)
        numbers = {b"VOLT:DC:RANG": self._settings.range_v, b"VOLT:DC:NPLC": cycles}
        switches = {self._preset.autozero: self._settings.autozero}
        if self._preset.impedance is not None:
            switches[self._preset.impedance] = self._settings.high_impedance
        for header, need in {**numbers, **switches}.items():
            require(self._line, self.name, header + b"?", need, outcome)
        # Range and integration of volts are told whatever function measures.
        for question, word in self._preset.words.items():
            said = self._line.ask(question, _word, idempotent=True)
            if said.removesuffix(_DIRECT) != word.removesuffix(_DIRECT):
                raise DeviceRefused(
                    f"{self.name}: {question.decode('ascii')} says {said.decode('ascii')}, need {word.decode('ascii')}:"
                    f" a reading is no plain number of volts; {outcome}; see what else uses the meter"
                )

    def _reading(self, cycles: float, wait: Wait) -> float:
        """Trigger one reading and let it be taken, volts; what is not a single reading is refused."""
        self._line.tell(b"READ?")
        reading_s = self._settings.reading_s(cycles)
        self._busy_until_s = self._clock.monotonic_s() + (1.0 + LATENESS) * reading_s
        wait(reading_s)
        reading_v = self._line.hear(b"READ?", _single_reading, timeout_s=LATENESS * reading_s + TALK_TIMEOUT_S)
        self._busy_until_s = 0.0
        return reading_v

    def _forget(self) -> None:
        self._set_up_for = None


_DIRECT = b":DC"
"""A node that may be left out: VOLT and VOLT:DC are one function."""


def _switch(state: bool) -> bytes:
    return b"ON" if state else b"OFF"


def _word(line: bytes) -> bytes:
    """Parse one word or digit, or the name of a function in quotes. Raises: DeviceNonsense."""
    word = line.strip().strip(b'"')
    if not (word.replace(b":", b"").isalnum() and len(word) <= 8):
        raise DeviceNonsense("the meter answers with one word")
    return word.upper()


def _single_reading(line: bytes) -> float:
    readings = scpi.parse_readings(line)
    if len(readings) != 1:
        raise DeviceNonsense("one READ? gives one reading; the sample count was changed by somebody else")
    return readings[0]
