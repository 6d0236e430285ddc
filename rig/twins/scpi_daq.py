"""The twin of a 34970A, 34980A or DAQ970A: scan list, sweeps in time, reading memory.

DC volts, and what else somebody may put a channel to (``FUNC``, ``RANG``, ``CALC:SCAL``). Source:
docs/devices/scpi-daq.md (``CONFigure`` redefines the scan list, puts the input at 10 megohm and switches off scaling
and what stands beside a reading; ``INITiate`` clears the memory and fills it, ``FETCh?`` waits for it and may be asked
again). The duration of a reading, the length of the error queue, the over-range of a fifth, the unit ``VDC`` beside a
reading and what an output shows to another function than DC volts are assumptions.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace

from rig.errors import DeviceNonsense
from rig.twins.physics.known_voltages import VoltageSource
from rig.twins.scpi_port import DATA_STALE, ILLEGAL_VALUE, OUT_OF_RANGE, SETTINGS_CONFLICT, UNDEFINED_HEADER, Refused
from rig.wire import scpi

OVERHEAD_S = 0.003
MOST_SWEEPS = 50_000
RANGES_V = (0.1, 1.0, 10.0, 100.0, 300.0)
OVER_RANGE = 1.2
"""Of every range but the highest."""
POWER_LINE_CYCLES = (0.02, 0.2, 1.0, 2.0, 10.0, 20.0, 100.0, 200.0)
LONGEST_DELAY_S = 60.0
VOLTS = "VOLT"
SHOWN_TO: Mapping[str, float] = {"VOLT:AC": 0.0, "RES": 2500.0, "FRES": 2500.0}
"""What an output shows to another function than DC volts: volts or ohms."""
SWITCH = {"OFF": False, "0": False, "ON": True, "1": True}
SHAPES = ("UNIT", "TIME", "ALAR", "CHAN")
"""What ``FORM:READ:…`` adds to a reading."""
TAKEN = "(what READ? fetches)"
"""No client can send this header."""


@dataclass(frozen=True, slots=True)
class DaqModel:
    """What tells one unit from the other."""

    identity: bytes
    numbers_per_slot: int
    numbers_per_card: int
    card: str
    card_channels: int
    slots: int
    impedance: tuple[str, ...]
    keeps_autozero: bool
    """Over a reset."""
    configure_empties_memory: bool
    autozero: str = "ZERO:AUTO"


MODELS: Mapping[str, DaqModel] = {
    "34970A": DaqModel(
        b"HEWLETT-PACKARD,34970A,0,13-2-2", 100, 100, "34901A", 20, 3, ("INP:IMP:AUTO",), True, False
    ),
    "34980A": DaqModel(
        b"Agilent Technologies,34980A,MY53151561,2.51-2.43-2.07-1.05",
        1000, 1, "34921A", 40, 8, ("VOLT:DC:IMP:AUTO", "VOLT:IMP:AUTO"), False, True,
    ),
    "DAQ970A": DaqModel(
        b"Keysight Technologies,DAQ970A,MY12345678,A.02.04-00.16-11.29-00.02-02-01",
        100, 100, "DAQM901A", 20, 3, ("VOLT:DC:IMP:AUTO",), False, False, autozero="VOLT:DC:ZERO:AUTO",
    ),
}  # fmt: skip
_SHORT = (
    "ABOR:ABORT ALAR:ALARM CALC:CALCULATE CHAN:CHANNEL CLOS:CLOSE CONF:CONFIGURE COUN:COUNT CTYP:CTYPE DEL:DELAY"
    " ERR:ERROR FETC:FETCH FORM:FORMAT FUNC:FUNCTION IMP:IMPEDANCE INIT:INITIATE INP:INPUT MEAS:MEASURE"
    " NPLC:NPLCYCLES OFFS:OFFSET POIN:POINTS PRES:PRESET RANG:RANGE READ:READING REM:REMOVE ROUT:ROUTE SCAL:SCALE"
    " SENS:SENSE SOUR:SOURCE STAT:STATE SYST:SYSTEM TRIG:TRIGGER VERS:VERSION VOLT:VOLTAGE"
)


@dataclass(frozen=True, slots=True)
class Channel:
    """How one channel is measured."""

    range_v: float = RANGES_V[-1]
    nplc: float = 1.0
    delay_s: float = 0.0
    high_impedance: bool = False
    function: str = VOLTS
    is_autorange: bool = True
    is_scaled: bool = False
    gain: float = 1.0
    offset: float = 0.0


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
        self.cards = dict.fromkeys(
            sorted({number // self._model.numbers_per_slot for number in wiring}), self._model.card
        )
        """Slot to card; what is not here is an empty slot."""
        self.card_channels: dict[int, int] = {}
        """Slot to the highest channel for volts, where its card is another than the model's usual one."""
        self._line_frequency_hz = line_frequency_hz
        self._queries = self._query_table()
        self._commands = self._command_table()
        self._autozero: dict[int, bool] = {}
        self._reset()

    def expand(self, header: str, parameters: str) -> tuple[tuple[str, str], ...] | None:
        reading = (("INIT", ""), (TAKEN, ""))
        if header == "READ?":
            return reading
        return (("CONF:VOLT:DC", parameters), *reading) if header == "MEAS:VOLT:DC?" else None

    def answered_from_s(self, header: str) -> float | None:
        if header not in ("FETC?", TAKEN) or not self._left:
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
            self._readings.append((self._measured_v(number), number, self._next_s - self._started_s))
            if self._left:
                self._next_s += self._reading_s(self._left[0])

    def _query_table(self) -> dict[str, Callable[[str], bytes]]:
        return {
            "*IDN?": lambda _: self._model.identity,
            "*OPC?": lambda _: b"1",
            "*ESR?": lambda _: b"+0",
            "SYST:VERS?": lambda _: b"1994.0",
            "SYST:CTYP?": self._card,
            "VOLT:DC:RANG?": lambda text: self._each(text, lambda n: scpi.format_reading(self._channel(n).range_v)),
            "VOLT:DC:RANG:AUTO?": lambda text: self._each(text, lambda n: b"%d" % self._channel(n).is_autorange),
            "FUNC?": lambda text: self._each(text, lambda n: b'"%s"' % self._channel(n).function.encode("ascii")),
            "CALC:SCAL:STAT?": lambda text: self._each(text, lambda n: b"%d" % self._channel(n).is_scaled),
            "VOLT:DC:NPLC?": lambda text: self._each(text, lambda n: scpi.format_reading(self._channel(n).nplc)),
            f"{self._model.autozero}?": lambda text: self._each(
                text, lambda number: b"%d" % self._autozero.get(number, True)
            ),
            "ROUT:CHAN:DEL?": lambda text: self._each(text, lambda n: scpi.format_reading(self._channel(n).delay_s)),
            "ROUT:CLOS?": lambda text: self._each(text, lambda number: b"%d" % (number in self._closed)),
            "ROUT:SCAN?": lambda _: scpi.format_block(scpi.channel_list(self._scan_list)),
            "ROUT:SCAN:SIZE?": lambda _: b"%+d" % len(self._scan_list),
            "TRIG:COUN?": lambda _: scpi.format_reading(self._sweeps),
            "TRIG:SOUR?": lambda _: self._trigger.encode("ascii"),
            "DATA:POIN?": lambda _: b"%+d" % len(self._readings),
            "FETC?": lambda _: self._fetched(),
            TAKEN: lambda _: self._removed(len(self._readings)),
            "DATA:REM?": lambda text: self._removed(int(text)),
            **{f"{name}?": self._impedance for name in self._model.impedance},
            **{f"FORM:READ:{name}?": self._shape_query(name) for name in SHAPES},
        }

    def _command_table(self) -> dict[str, Callable[[str, float], None]]:
        return {
            "*RST": lambda _text, _now_s: self._reset(),
            "ABOR": lambda _text, _now_s: self._left.clear(),
            "CONF:VOLT:DC": lambda text, _now_s: self._configure(text),
            "SYST:PRES": lambda _text, _now_s: self._preset(),
            "VOLT:DC:NPLC": lambda text, _now_s: self._set_nplc(text),
            "VOLT:DC:RANG": lambda text, _now_s: self._change(
                text, lambda word: {"range_v": _range_v(float(word)), "is_autorange": False}
            ),
            "VOLT:DC:RANG:AUTO": lambda text, _now_s: self._change(text, lambda word: {"is_autorange": SWITCH[word]}),
            "FUNC": lambda text, _now_s: self._change(text, _another_function),
            "CALC:SCAL:GAIN": lambda text, _now_s: self._change(text, lambda word: {"gain": float(word)}),
            "CALC:SCAL:OFFS": lambda text, _now_s: self._change(text, lambda word: {"offset": float(word)}),
            "CALC:SCAL:STAT": lambda text, _now_s: self._change(text, lambda word: {"is_scaled": SWITCH[word]}),
            self._model.autozero: lambda text, _now_s: self._set_autozero(text),
            "ROUT:CLOS": lambda text, _now_s: self._closed.update(self._existing(text)),
            "ROUT:OPEN": lambda text, _now_s: self._closed.difference_update(self._existing(text)),
            **dict.fromkeys(self._model.impedance, self._set_impedance),
            "ROUT:CHAN:DEL": lambda text, _now_s: self._set_delay(text),
            "ROUT:SCAN": lambda text, _now_s: self._scan(self._existing(text)),
            "TRIG:COUN": lambda text, _now_s: self._set_sweeps(text),
            "TRIG:SOUR": lambda text, _now_s: self._set_trigger(text.upper()),
            "INIT": lambda _text, now_s: self._initiate(now_s),
            **{f"FORM:READ:{name}": self._shape_command(name) for name in SHAPES},
        }

    def _reset(self) -> None:
        self._channels: dict[int, Channel] = {}
        self._scan_list: tuple[int, ...] = ()
        self._sweeps = 1
        self._trigger = "IMM"
        self._shape = dict.fromkeys(SHAPES, False)
        self._is_high_impedance = False
        """Of the internal meter of a 34980A, which no channel list names."""
        self._closed: set[int] = set()
        if not self._model.keeps_autozero:
            self._autozero.clear()
        self._preset()
        self._next_s = self._started_s = 0.0

    def _preset(self) -> None:
        """``SYST:PRES``: the readings are gone, what channels were set to stays."""
        self._readings: list[tuple[float, int, float]] = []
        """Volts, channel, seconds since the scan began."""
        self._left: list[int] = []
        """Channels still to be measured in this scan."""

    def _card(self, text: str) -> bytes:
        slot, between = divmod(int(text), self._model.numbers_per_card)
        _require(1 <= slot <= self._model.slots and not between, OUT_OF_RANGE)
        maker = self._model.identity.partition(b",")[0]
        card = self.cards.get(slot)
        return maker + (b",0,0,0" if card is None else b",%s,0,1.0" % card.encode("ascii"))

    def _channel(self, number: int) -> Channel:
        return self._channels.get(number, Channel())

    def _each(self, text: str, answer_of: Callable[[int], bytes]) -> bytes:
        return b",".join(answer_of(number) for number in self._existing(text))

    def _existing(self, text: str) -> tuple[int, ...]:
        """Return the channels of a list, upward; inside a range what the unit lacks is left out without a word."""
        scpi.parse_channel_list(text)
        found: set[int] = set()
        for part in filter(None, text.strip().removeprefix("(@").removesuffix(")").split(",")):
            span = scpi.parse_channel_list(f"(@{part})")
            _require(self._has(span[0]) and self._has(span[-1]), OUT_OF_RANGE)
            found |= set(filter(self._has, span))
        return tuple(sorted(found))

    def _has(self, number: int) -> bool:
        slot, channel = divmod(number, self._model.numbers_per_slot)
        return slot in self.cards and 1 <= channel <= self.card_channels.get(slot, self._model.card_channels)

    def _impedance(self, text: str) -> bytes:
        if text:
            return self._each(text, lambda number: b"%d" % self._channel(number).high_impedance)
        if self._model.keeps_autozero:
            return b",".join(b"%d" % self._channel(number).high_impedance for number in self._scan_list)
        return b"%d" % self._is_high_impedance

    def _set_impedance(self, text: str, _now_s: float) -> None:
        """Without a list a 34970A takes its scan list, a 34980A the meter inside."""
        word = text.partition("(")[0].strip(" ,").upper()
        if "(" in text or self._model.keeps_autozero:
            listed = text if "(" in text else f"{text} (@{','.join(map(str, self._scan_list))})"
            self._change(listed, lambda word: {"high_impedance": SWITCH[word]})
        else:
            self._is_high_impedance = SWITCH[word]

    def _set_autozero(self, text: str) -> None:
        word, at, listed = text.partition("(")
        self._autozero |= dict.fromkeys(self._existing(at + listed), SWITCH[word.strip(" ,").upper()])

    def _configure(self, text: str) -> None:
        """Obey ``CONF:VOLT:DC [range[,resolution],](@list)``: the channels start anew, and are the scan list."""
        values, at, listed = text.partition("(")
        numbers = self._existing(at + listed)
        words = [word.strip() for word in values.split(",") if word.strip()]
        channel = Channel(range_v=_range_v(float(words[0])), is_autorange=False) if words else Channel()
        self._channels |= dict.fromkeys(numbers, channel)
        self._shape = dict.fromkeys(SHAPES, False)
        if self._model.configure_empties_memory:
            self._readings.clear()
        self._scan(numbers)

    def _change(self, text: str, change: Callable[[str], dict[str, float | str]]) -> None:
        """Change a value of the channels it is for."""
        value, at, listed = text.partition("(")
        changes = change(value.strip(" ,").upper())
        for number in self._existing(at + listed):
            self._channels[number] = replace(self._channels.get(number, Channel()), **changes)  # type: ignore[arg-type]

    def _set_nplc(self, text: str) -> None:
        self._change(text, lambda word: {"nplc": _allowed(float(word), float(word) in POWER_LINE_CYCLES)})
        listed = text[text.index("(") :]
        if float(text.partition("(")[0].strip(" ,")) < 1.0:
            self._autozero |= dict.fromkeys(self._existing(listed), False)

    def _set_delay(self, text: str) -> None:
        self._change(text, lambda word: {"delay_s": _allowed(float(word), 0.0 <= float(word) <= LONGEST_DELAY_S)})

    def _set_sweeps(self, text: str) -> None:
        sweeps = float(text)
        _require(sweeps.is_integer() and 1 <= sweeps <= MOST_SWEEPS, OUT_OF_RANGE)
        self._sweeps = int(sweeps)

    def _set_trigger(self, source: str) -> None:
        """By ``BUS`` and ``EXT`` nothing is measured: nobody triggers."""
        _require(source in ("IMM", "IMMEDIATE", "BUS", "EXT"), SETTINGS_CONFLICT)
        self._trigger = source[:3]

    def _scan(self, numbers: tuple[int, ...]) -> None:
        self._scan_list = numbers
        self._readings.clear()
        self._left.clear()

    def _initiate(self, now_s: float) -> None:
        _require(bool(self._scan_list) and not self._left, SETTINGS_CONFLICT)
        self._readings.clear()
        if self._trigger == "IMM":
            self._left = list(self._scan_list) * self._sweeps
            self._started_s = now_s
            self._next_s = now_s + self._reading_s(self._left[0])

    def _reading_s(self, number: int) -> float:
        channel, conversions = self._channel(number), 2.0 if self._autozero.get(number, True) else 1.0
        return channel.delay_s + conversions * channel.nplc / self._line_frequency_hz + OVERHEAD_S

    def _measured_v(self, number: int) -> float:
        """Take one reading of a channel: of its function, on its range, scaled where it is."""
        channel = self._channel(number)
        shown = self._shown_v(number) if channel.function == VOLTS else SHOWN_TO[channel.function]
        is_scaled = channel.is_scaled and abs(shown) != scpi.OVERLOAD
        return channel.gain * shown + channel.offset if is_scaled else shown

    def _shown_v(self, number: int) -> float:
        channel, wired = self._channel(number), self._wiring.get(number)
        true_v = 0.0 if wired is None else self._source.read_voltage_v(wired, self._next_s)
        ranges_v = RANGES_V if channel.is_autorange else (channel.range_v,)
        holding_v = [
            range_v for range_v in ranges_v if abs(true_v) <= range_v * (1.0 if range_v == RANGES_V[-1] else OVER_RANGE)
        ]
        if channel.is_autorange:
            self._channels[number] = replace(channel, range_v=min(holding_v, default=RANGES_V[-1]))
        if holding_v:
            return true_v
        return scpi.OVERLOAD if true_v > 0.0 else -scpi.OVERLOAD

    def _fetched(self) -> bytes:
        _require(bool(self._readings), DATA_STALE)
        return b",".join(self._shaped(*reading) for reading in self._readings)

    def _removed(self, count: int) -> bytes:
        _require(1 <= count <= len(self._readings), OUT_OF_RANGE)
        removed = b",".join(self._shaped(*reading) for reading in self._readings[:count])
        del self._readings[:count]
        return removed

    def _shaped(self, value: float, number: int, since_s: float) -> bytes:
        """As ``+2.61950000E+01 C,000000000.017,1003,2``: value and unit, time, channel, alarm."""
        fields = [scpi.format_reading(value) + (b" VDC" if self._shape["UNIT"] else b"")]
        fields += [b"%013.3f" % since_s] if self._shape["TIME"] else []
        fields += [b"%d" % number] if self._shape["CHAN"] else []
        fields += [b"0"] if self._shape["ALAR"] else []
        return b",".join(fields)

    def _shape_query(self, name: str) -> Callable[[str], bytes]:
        return lambda _text: b"%d" % self._shape[name]

    def _shape_command(self, name: str) -> Callable[[str, float], None]:
        def command(text: str, _now_s: float) -> None:
            self._shape[name] = SWITCH[text.upper()]

        return command


def _require(is_so: bool, error: tuple[int, str]) -> None:
    if not is_so:
        raise Refused(error)


def _allowed(value: float, is_so: bool) -> float:
    _require(is_so, OUT_OF_RANGE)
    return value


def _range_v(wanted_v: float) -> float:
    """Return the smallest range that holds ``wanted_v``."""
    _require(wanted_v <= RANGES_V[-1], OUT_OF_RANGE)
    return min(offered_v for offered_v in RANGES_V if offered_v >= wanted_v)


def _another_function(quoted: str) -> dict[str, float | str]:
    """Return what ``FUNC`` changes: what was set for the function before goes to its defaults, scaling too."""
    function = VOLTS if (word := quoted.strip("\"'")) == "VOLT:DC" else word
    _require(function == VOLTS or function in SHOWN_TO, ILLEGAL_VALUE)
    kept, fresh = ("delay_s", "high_impedance"), Channel(function=function)
    return {field.name: getattr(fresh, field.name) for field in fields(Channel) if field.name not in kept}
