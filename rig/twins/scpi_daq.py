"""The twin of a 34970A or 34980A: scan list, sweeps in time, reading memory.

DC volts only. Source: 34970A user's guide (``CONFigure`` redefines the scan list; ``INITiate`` clears the memory and
fills it, ``FETCh?`` waits for it and may be asked again). The duration of a reading, the length of the error queue
and the over-range of a fifth are assumptions.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from rig.errors import DeviceNonsense
from rig.twins.scpi_port import DATA_STALE, ILLEGAL_VALUE, OUT_OF_RANGE, SETTINGS_CONFLICT, UNDEFINED_HEADER, Refused
from rig.wire import scpi

OVERHEAD_S = 0.003
MOST_SWEEPS = 50_000
RANGES_V = (0.1, 1.0, 10.0, 100.0, 300.0)
OVER_RANGE = 1.2
"""Of every range but the highest."""
POWER_LINE_CYCLES = (0.02, 0.2, 1.0, 2.0, 10.0, 20.0, 100.0, 200.0)
LONGEST_DELAY_S = 60.0
SWITCH = {"OFF": False, "0": False, "ON": True, "1": True}
SHAPES = ("UNIT", "TIME", "ALAR", "CHAN")
"""What ``FORM:READ:…`` adds to a reading; of these only the channel is modelled."""


@dataclass(frozen=True, slots=True)
class DaqModel:
    """What tells one unit from the other."""

    identity: bytes
    slot_place: int
    card_place: int
    card: str
    slots: int


MODELS: Mapping[str, DaqModel] = {
    "34970A": DaqModel(b"HEWLETT-PACKARD,34970A,0,13-2-2", 100, 100, "34901A", 3),
    "34980A": DaqModel(b"Agilent Technologies,34980A,MY53151561,2.51-2.43-2.07-1.05", 1000, 1, "34921A", 8),
}
_SHORT = (
    "ABOR:ABORT ALAR:ALARM CHAN:CHANNEL CONF:CONFIGURE COUN:COUNT CTYP:CTYPE DEL:DELAY ERR:ERROR FETC:FETCH"
    " FORM:FORMAT INIT:INITIATE NPLC:NPLCYCLES POIN:POINTS RANG:RANGE READ:READING ROUT:ROUTE SENS:SENSE"
    " SOUR:SOURCE SYST:SYSTEM TRIG:TRIGGER VERS:VERSION VOLT:VOLTAGE"
)


class VoltageSource(Protocol):
    """The physical world as the unit meets it."""

    def read_voltage_v(self, channel: str, now_s: float) -> float:
        """Take one reading of ``channel`` (such as ``daq.x``), volts, with its noise; asking again draws again."""


@dataclass(frozen=True, slots=True)
class Channel:
    """How one channel is measured."""

    range_v: float = RANGES_V[-1]
    nplc: float = 1.0
    delay_s: float = 0.0
    autozero: bool = True

    def reading_s(self, line_frequency_hz: float) -> float:
        return self.delay_s + (2.0 if self.autozero else 1.0) * self.nplc / line_frequency_hz + OVERHEAD_S


class ScpiDaqTwin:
    """A :class:`rig.twins.scpi_port.ScpiUnit`; ``wiring`` is channel number to a channel of the world."""

    words: Mapping[str, str] = {long: short for short, _, long in (pair.partition(":") for pair in _SHORT.split())}

    def __init__(
        self,
        source: VoltageSource,
        wiring: Mapping[int, str],
        *,
        model: str = "34970A",
        line_frequency_hz: float = 50.0,
    ) -> None:
        self._source = source
        self._wiring = dict(wiring)
        self._model = MODELS[model]
        self.cards = dict.fromkeys(sorted({number // self._model.slot_place for number in wiring}), self._model.card)
        """Slot to card; what is not here is an empty slot."""
        self._line_frequency_hz = line_frequency_hz
        self._queries = self._query_table()
        self._commands = self._command_table()
        self._reset()

    def answered_from_s(self, header: str) -> float | None:
        if header != "FETC?" or not self._left:
            return None
        return self._next_s + sum(map(self._reading_s, self._left[1:]))

    def obey(self, header: str, parameters: str, now_s: float) -> bytes | None:
        try:
            if header in self._queries:
                return self._queries[header](parameters)
            if header in self._commands:
                self._commands[header](parameters, now_s)
                return None
        except (DeviceNonsense, ValueError, KeyError) as error:
            raise Refused(ILLEGAL_VALUE) from error
        raise Refused(UNDEFINED_HEADER)

    def advance(self, now_s: float) -> None:
        while self._left and self._next_s <= now_s:
            number = self._left.pop(0)
            self._readings.append((self._measured_v(number), number))
            if self._left:
                self._next_s += self._reading_s(self._left[0])

    def _query_table(self) -> dict[str, Callable[[str], bytes]]:
        return {
            "*IDN?": lambda _: self._model.identity,
            "*OPC?": lambda _: b"1",
            "*ESR?": lambda _: b"+0",
            "SYST:VERS?": lambda _: b"1994.0",
            "SYST:CTYP?": self._card,
            "VOLT:DC:RANG?": lambda text: scpi.format_reading(self._one(text).range_v),
            "VOLT:DC:NPLC?": lambda text: scpi.format_reading(self._one(text).nplc),
            "ZERO:AUTO?": lambda text: b"%d" % self._one(text).autozero,
            "ROUT:CHAN:DEL?": lambda text: scpi.format_reading(self._one(text).delay_s),
            "ROUT:SCAN?": lambda _: scpi.format_block(scpi.channel_list(self._scan_list)),
            "ROUT:SCAN:SIZE?": lambda _: b"%+d" % len(self._scan_list),
            "TRIG:COUN?": lambda _: scpi.format_reading(self._sweeps),
            "TRIG:SOUR?": lambda _: b"IMM",
            "DATA:POIN?": lambda _: b"%+d" % len(self._readings),
            "FETC?": lambda _: self._fetched(),
            **{f"FORM:READ:{name}?": self._shape_query(name) for name in SHAPES},
        }

    def _command_table(self) -> dict[str, Callable[[str, float], None]]:
        return {
            "*RST": lambda _text, _now_s: self._reset(),
            "ABOR": lambda _text, _now_s: self._left.clear(),
            "CONF:VOLT:DC": lambda text, _now_s: self._configure(text),
            "VOLT:DC:NPLC": lambda text, _now_s: self._set_nplc(text),
            "ZERO:AUTO": lambda text, _now_s: self._change(text, lambda word: {"autozero": SWITCH[word]}),
            "ROUT:CHAN:DEL": lambda text, _now_s: self._set_delay(text),
            "ROUT:SCAN": lambda text, _now_s: self._scan(self._existing(text)),
            "TRIG:COUN": lambda text, _now_s: self._set_sweeps(text),
            "TRIG:SOUR": lambda text, _now_s: _require(text.upper() in ("IMM", "IMMEDIATE"), SETTINGS_CONFLICT),
            "INIT": lambda _text, now_s: self._initiate(now_s),
            **{f"FORM:READ:{name}": self._shape_command(name) for name in SHAPES},
        }

    def _reset(self) -> None:
        self._channels: dict[int, Channel] = {}
        self._scan_list: tuple[int, ...] = ()
        self._sweeps = 1
        self._shape = dict.fromkeys(SHAPES, False)
        self._readings: list[tuple[float, int]] = []
        self._left: list[int] = []
        """Channels still to be measured in this scan."""
        self._next_s = 0.0

    def _card(self, text: str) -> bytes:
        slot, between = divmod(int(text), self._model.card_place)
        _require(1 <= slot <= self._model.slots and not between, OUT_OF_RANGE)
        maker = self._model.identity.partition(b",")[0]
        card = self.cards.get(slot)
        return maker + (b",0,0,0" if card is None else b",%s,0,1.0" % card.encode("ascii"))

    def _one(self, text: str) -> Channel:
        (number,) = self._existing(text)
        return self._channels.get(number, Channel())

    def _existing(self, text: str) -> tuple[int, ...]:
        numbers = scpi.parse_channel_list(text)
        _require(all(number // self._model.slot_place in self.cards for number in numbers), OUT_OF_RANGE)
        return numbers

    def _configure(self, text: str) -> None:
        """Obey ``CONF:VOLT:DC [range[,resolution],](@list)``: the channels start anew, and are the scan list."""
        values, at, listed = text.partition("(")
        numbers = self._existing(at + listed)
        words = [word.strip() for word in values.split(",") if word.strip()]
        range_v = float(words[0]) if words else RANGES_V[-1]
        _require(range_v <= RANGES_V[-1], OUT_OF_RANGE)
        taken_v = min(offered_v for offered_v in RANGES_V if offered_v >= range_v)
        self._channels |= dict.fromkeys(numbers, Channel(range_v=taken_v))
        self._scan(numbers)

    def _change(self, text: str, change: Callable[[str], dict[str, float]]) -> None:
        """Change a value of the channels it is for."""
        value, at, listed = text.partition("(")
        changes = change(value.strip(" ,").upper())
        for number in self._existing(at + listed):
            self._channels[number] = replace(self._channels.get(number, Channel()), **changes)  # type: ignore[arg-type]

    def _set_nplc(self, text: str) -> None:
        self._change(text, lambda word: {"nplc": _allowed(float(word), float(word) in POWER_LINE_CYCLES)})

    def _set_delay(self, text: str) -> None:
        self._change(text, lambda word: {"delay_s": _allowed(float(word), 0.0 <= float(word) <= LONGEST_DELAY_S)})

    def _set_sweeps(self, text: str) -> None:
        sweeps = float(text)
        _require(sweeps.is_integer() and 1 <= sweeps <= MOST_SWEEPS, OUT_OF_RANGE)
        self._sweeps = int(sweeps)

    def _scan(self, numbers: tuple[int, ...]) -> None:
        self._scan_list = numbers
        self._readings.clear()
        self._left.clear()

    def _initiate(self, now_s: float) -> None:
        _require(bool(self._scan_list) and not self._left, SETTINGS_CONFLICT)
        self._readings.clear()
        self._left = list(self._scan_list) * self._sweeps
        self._next_s = now_s + self._reading_s(self._left[0])

    def _reading_s(self, number: int) -> float:
        return self._channels.get(number, Channel()).reading_s(self._line_frequency_hz)

    def _measured_v(self, number: int) -> float:
        wired = self._wiring.get(number)
        true_v = 0.0 if wired is None else self._source.read_voltage_v(wired, self._next_s)
        range_v = self._channels.get(number, Channel()).range_v
        if abs(true_v) <= range_v * (1.0 if range_v == RANGES_V[-1] else OVER_RANGE):
            return true_v
        return scpi.OVERLOAD if true_v > 0.0 else -scpi.OVERLOAD

    def _fetched(self) -> bytes:
        _require(bool(self._readings), DATA_STALE)
        if self._shape["CHAN"]:
            return b",".join(b"%s,%d" % (scpi.format_reading(value), number) for value, number in self._readings)
        return b",".join(scpi.format_reading(value) for value, _ in self._readings)

    def _shape_query(self, name: str) -> Callable[[str], bytes]:
        return lambda _text: b"%d" % self._shape[name]

    def _shape_command(self, name: str) -> Callable[[str, float], None]:
        def command(text: str, _now_s: float) -> None:
            state = SWITCH[text.upper()]
            _require(name == "CHAN" or not state, SETTINGS_CONFLICT)
            self._shape[name] = state

        return command


def _require(is_so: bool, error: tuple[int, str]) -> None:
    if not is_so:
        raise Refused(error)


def _allowed(value: float, is_so: bool) -> float:
    _require(is_so, OUT_OF_RANGE)
    return value
