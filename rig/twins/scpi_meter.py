"""The twin of a single multimeter: 34401A, Truevolt, Keithley 2000 and 2002. DC volts; of the rest, that it measures.

Source: docs/devices/scpi-meters.md. What rests on memory there is so here: that ``CONF`` and ``*RST`` put the input of
a 34401A at 10 megohm, the factory set-up that a Keithley wakes with (it measures by itself, and then refuses
``READ?``), identities in the form seen. The over-range of a fifth and the overhead of a reading are assumptions. On a
Truevolt ``CONF`` is taken to reset the impedance too: what its manual leaves open, a driver must bear.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from rig.twins.scpi_port import ILLEGAL_VALUE, OUT_OF_RANGE, UNDEFINED_HEADER, Error, Refused
from rig.wire import scpi

OVERHEAD_S = 0.004
OVER_RANGE = 1.2
"""Of every range but the highest."""
OTHER_FUNCTIONS = ("VOLT:AC", "RES", "FRES", "CURR", "CURR:DC", "CURR:AC", "FREQ", "PER")
OTHER_READING = 1.20034
"""What any of them reads: a plain number, as volts are."""
INIT_IGNORED: Error = (-213, "Init ignored")
SWITCH = {"OFF": False, "0": False, "ON": True, "1": True}
TAKEN = "(what READ? fetches)"
"""No client can send this header."""
_SHORT = (
    "ABOR:ABORT AVER:AVERAGE AZER:AZERO CALC:CALCULATE CONF:CONFIGURE CONT:CONTINUOUS COUN:COUNT ELEM:ELEMENTS"
    " ERR:ERROR FORM:FORMAT FRSW:FRSWITCH FUNC:FUNCTION IMP:IMPEDANCE INIT:INITIATE INP:INPUT MEAS:MEASURE"
    " NPLC:NPLCYCLES PRES:PRESET RANG:RANGE REF:REFERENCE REM:REMOTE ROUT:ROUTE SAMP:SAMPLE SENS:SENSE"
    " SCAL:SCALE SOUR:SOURCE STAT:STATE SYST:SYSTEM TERM:TERMINALS TRIG:TRIGGER VERS:VERSION VOLT:VOLTAGE"
)


@dataclass(frozen=True, slots=True)
class MeterModel:
    """What tells one meter from the other."""

    identity: bytes
    ranges_v: tuple[float, ...]
    nplc: tuple[float, ...]
    is_keithley: bool = False
    impedance: str | None = None
    autozero: str = "SYST:AZER:STAT"


_HP_NPLC = (0.02, 0.2, 1.0, 10.0, 100.0)
MODELS: Mapping[str, MeterModel] = {
    "34401A": MeterModel(
        b"HEWLETT-PACKARD,34401A,0,11-5-2", (0.1, 1.0, 10.0, 100.0, 1000.0), _HP_NPLC,
        impedance="INP:IMP:AUTO", autozero="ZERO:AUTO",
    ),
    "34461A": MeterModel(
        b"Keysight Technologies,34461A,MY53201234,A.03.03-03.15-03.03-00.52-04-02", (0.1, 1.0, 10.0, 100.0, 1000.0),
        _HP_NPLC, impedance="VOLT:DC:IMP:AUTO", autozero="VOLT:DC:ZERO:AUTO",
    ),
    "keithley-2000": MeterModel(
        b"KEITHLEY INSTRUMENTS INC.,MODEL 2000,1234567,A08 /A02", (0.1, 1.0, 10.0, 100.0, 1000.0), (0.01, 10.0),
        is_keithley=True,
    ),
    "keithley-2002": MeterModel(
        b"KEITHLEY INSTRUMENTS INC.,MODEL 2002,0694321,B02  /A02", (0.2, 2.0, 20.0, 200.0, 1000.0), (0.01, 50.0),
        is_keithley=True,
    ),
}  # fmt: skip


IN_LOCAL = (550, "Command not allowed in local")
_RELATIVE: Mapping[str, tuple[str, ...]] = {
    "34401A": ("CALC:STAT",),
    "34461A": ("VOLT:DC:NULL:STAT", "CALC:SCAL:STAT"),
}
"""Headers that tell mathematics; the first is that of the key NULL or REL."""


class ScpiMeterTwin:
    """A :class:`rig.twins.scpi_port.ScpiUnit`; ``read_v`` takes one reading at a time of the rig, volts."""

    words: Mapping[str, str] = {long: short for short, _, long in (pair.partition(":") for pair in _SHORT.split())}

    def __init__(
        self,
        read_v: Callable[[float], float],
        *,
        model: str = "34401A",
        line_frequency_hz: float = 50.0,
        is_front: bool = True,
    ) -> None:
        self.is_front = is_front
        self.null_v: float | None = None
        """What every reading is told less, behind one press of NULL or REL at the panel; a reset ends it."""
        self.is_local = False
        """Behind one press of LOCAL on a serial line: nothing but SYST:REM is obeyed, and the rest is error 550."""
        self.function = ""
        """What measures, as the meter names it; a key at the panel changes it, and the ranges of volts stay."""
        self._read_v = read_v
        self._model = MODELS[model]
        self._relative = _RELATIVE.get(model, ("VOLT:DC:REF:STAT", "CALC:STAT"))
        self._line_frequency_hz = line_frequency_hz
        self._ready_s: float | None = None
        self._readings: list[float] = []
        self._queries, self._commands = self._query_table(), self._command_table()
        self._reset()
        self._runs_by_itself = self._model.is_keithley

    def format_error(self, number: int, text: str) -> bytes:
        """Return an entry as the error queue tells it: a Keithley writes no plus sign."""
        return (
            b'%d,"%s"' % (number, text.encode("ascii")) if self._model.is_keithley else scpi.format_error(number, text)
        )

    def expand(self, header: str, parameters: str) -> tuple[tuple[str, str], ...] | None:
        if header == "READ?":
            return (("INIT", ""), (TAKEN, ""))
        return (("CONF:VOLT:DC", parameters), ("INIT", ""), (TAKEN, "")) if header == "MEAS:VOLT:DC?" else None

    def answered_from_s(self, header: str) -> float | None:
        return self._ready_s if header in (TAKEN, "FETC?") and self._ready_s is not None else None

    def obey(self, header: str, parameters: str, now_s: float) -> bytes | None:
        header = _with_current(header)
        if self.is_local and header != "SYST:REM":
            raise Refused(IN_LOCAL)
        try:
            if header in self._queries:
                return self._queries[header]()
            if header in self._commands:
                self._commands[header](parameters, now_s)
                return None
        except (ValueError, KeyError) as error:
            raise Refused(ILLEGAL_VALUE) from error
        raise Refused(UNDEFINED_HEADER)

    def advance(self, now_s: float) -> None:
        if self._ready_s is not None and self._ready_s <= now_s:
            first_s = self._ready_s - self._reading_s() * (self._samples - 1)
            self._readings = [self._measured_v(first_s + n * self._reading_s()) for n in range(self._samples)]
            self._ready_s = None

    def _query_table(self) -> dict[str, Callable[[], bytes]]:
        table: dict[str, Callable[[], bytes]] = {
            "*IDN?": lambda: self._model.identity,
            "*OPC?": lambda: b"1",
            "FUNC?": lambda: b'"%s"' % self.function.encode("ascii"),
            "*ESR?": lambda: b"0" if self._model.is_keithley else b"+0",
            "SYST:VERS?": lambda: b"1991.0",
            "VOLT:DC:RANG?": lambda: self._number(self._range_v),
            "VOLT:DC:NPLC?": lambda: self._number(self._nplc),
            f"{self._model.autozero}?": lambda: b"%d" % self._autozero,
            "SAMP:COUN?": lambda: self._number(self._samples),
            "TRIG:SOUR?": lambda: b"IMM",
            TAKEN: self._taken,
            "FETC?": self._taken,
            "VOLT:DC:RANG:AUTO?": lambda: b"%d" % self._ranges_itself,
        }
        for header in self._relative:
            table[f"{header}?"] = partial(self._tells_mathematics, header)
        if self._model.impedance is not None:
            table[f"{self._model.impedance}?"] = lambda: b"%d" % self.is_high_impedance
        if self._model.is_keithley:
            table |= {
                "SYST:FRSW?": lambda: b"%d" % self.is_front,
                "FORM:ELEM?": lambda: self.elements.encode("ascii"),
                "UNIT:VOLT:DC?": lambda: self.unit.encode("ascii"),
                "VOLT:DC:AVER:STAT?": lambda: b"%d" % self._is_averaging,
                "INIT:CONT?": lambda: b"%d" % self._runs_by_itself,
                "CONF?": lambda: b'"VOLT:DC"',
            }
        else:
            table["ROUT:TERM?"] = lambda: b"FRON" if self.is_front else b"REAR"
        return table

    def _command_table(self) -> dict[str, Callable[[str, float], None]]:
        table: dict[str, Callable[[str, float], None]] = {
            "*RST": lambda _text, _now_s: self._reset(),
            "ABOR": lambda _text, _now_s: self._forget(),
            "CONF:VOLT:DC": lambda text, _now_s: self._configure(text),
            "VOLT:DC:RANG": lambda text, _now_s: self._set_range(float(text)),
            "VOLT:DC:NPLC": lambda text, _now_s: self._set_nplc(float(text)),
            self._model.autozero: lambda text, _now_s: setattr(self, "_autozero", SWITCH[text.upper()]),
            "TRIG:SOUR": lambda text, _now_s: _require(text.upper() in ("IMM", "IMMEDIATE"), ILLEGAL_VALUE),
            "TRIG:COUN": lambda text, _now_s: _require(float(text) == 1.0, ILLEGAL_VALUE),
            "SAMP:COUN": lambda text, _now_s: setattr(self, "_samples", int(float(text))),
            "INIT": lambda _text, now_s: self._initiate(now_s),
            "VOLT:DC:RANG:AUTO": lambda text, _now_s: setattr(self, "_ranges_itself", SWITCH[text.upper()]),
            "FUNC": lambda text, _now_s: self._choose(text.upper().strip("'\"")),
            "SYST:REM": lambda _text, _now_s: setattr(self, "is_local", False),
        }
        table[self._relative[0]] = lambda text, now_s: self._null(now_s, is_on=SWITCH[text.upper()])
        if self._model.impedance is not None:
            table[self._model.impedance] = lambda text, _now_s: setattr(self, "is_high_impedance", SWITCH[text.upper()])
        if self._model.is_keithley:
            table |= {
                "INIT:CONT": lambda text, _now_s: setattr(self, "_runs_by_itself", SWITCH[text.upper()]),
                "FORM:ELEM": lambda text, _now_s: setattr(self, "elements", text.upper().replace("READING", "READ")),
                "UNIT:VOLT:DC": lambda text, _now_s: setattr(self, "unit", text.upper()),
                "VOLT:DC:AVER:STAT": lambda text, _now_s: setattr(self, "_is_averaging", SWITCH[text.upper()]),
            }
        return table

    def _choose(self, function: str) -> None:
        is_volts = function in ("VOLT", "VOLT:DC")
        _require(is_volts or function in OTHER_FUNCTIONS, ILLEGAL_VALUE)
        self.function = self._volts if is_volts else function

    @property
    def _volts(self) -> str:
        return "VOLT:DC" if self._model.is_keithley else "VOLT"

    def _tells_mathematics(self, header: str) -> bytes:
        return b"%d" % (self.null_v is not None and header == self._relative[0])

    def _null(self, now_s: float, *, is_on: bool) -> None:
        self.null_v = self._read_v(now_s) if is_on else None

    def _reset(self) -> None:
        self._forget()
        self.null_v = None
        self._configure("")
        self._nplc = 1.0 if self._model.is_keithley else 10.0
        self.elements, self.unit = "READ", "V"
        self._is_averaging = self._runs_by_itself = False

    def _forget(self) -> None:
        self._ready_s = None
        self._readings = []

    def _configure(self, text: str) -> None:
        """Preset the function: what is not named goes to its default, the input to 10 megohm."""
        self.function = self._volts
        words = [word.strip() for word in text.split(",") if word.strip() and word.strip().upper() != "DEF"]
        self._set_range(float(words[0]) if words else self._model.ranges_v[-1])
        self._ranges_itself = not words
        self._nplc, self._autozero, self._samples = (1.0 if self._model.is_keithley else 10.0), True, 1
        self.is_high_impedance = self._model.impedance is None

    def _set_range(self, range_v: float) -> None:
        """Choose a range, which ends the meter's own choice (TV p. 221, K2000 p. 5-42)."""
        _require(0.0 <= range_v <= self._model.ranges_v[-1], OUT_OF_RANGE)
        self._ranges_itself = False
        self._range_v = min(offered_v for offered_v in self._model.ranges_v if offered_v >= range_v)

    def _set_nplc(self, nplc: float) -> None:
        low, high = self._model.nplc[0], self._model.nplc[-1]
        _require(low <= nplc <= high, OUT_OF_RANGE)
        offered = self._model.nplc
        self._nplc = nplc if self._model.is_keithley else min(cycles for cycles in offered if cycles >= nplc)

    def _initiate(self, now_s: float) -> None:
        _require(not self._runs_by_itself and self._ready_s is None, INIT_IGNORED)
        self._readings = []
        self._ready_s = now_s + self._samples * self._reading_s()

    def _reading_s(self) -> float:
        return (2.0 if self._autozero else 1.0) * self._nplc / self._line_frequency_hz + OVERHEAD_S

    def _measured_v(self, at_s: float) -> float:
        if self.function != self._volts:
            return OTHER_READING
        true_v = self._read_v(at_s) - (self.null_v or 0.0)
        highest = self._range_v == self._model.ranges_v[-1]
        if abs(true_v) <= self._range_v * (1.0 if highest else OVER_RANGE):
            return true_v
        return scpi.OVERLOAD if true_v > 0.0 else -scpi.OVERLOAD

    def _taken(self) -> bytes:
        _require(bool(self._readings), INIT_IGNORED)
        return b",".join(map(self._printed, self._readings))

    def _printed(self, value: float) -> bytes:
        """As ``+1.04530000E+01``; a Keithley's overload has no unit and is short, its unit stands without a space."""
        is_over = abs(value) >= scpi.OVERLOAD
        if not self._model.is_keithley:
            return scpi.format_reading(value)
        text = (b"+9.9E37" if value > 0.0 else b"-9.9E37") if is_over else scpi.format_reading(value)
        fields = {"READ": text, "UNIT": b"", "CHAN": b"0INTCHAN"}
        if "UNIT" in self.elements and not is_over:
            fields["READ"] = text + b"VDC"
        return b",".join(fields[word] for word in ("READ", "CHAN") if word in self.elements)

    def _number(self, value: float) -> bytes:
        return b"%.9g" % value if self._model.is_keithley else scpi.format_reading(value)


def _with_current(header: str) -> str:
    """Return a header with the node DC, which may be left out: ``VOLT:RANG`` is ``VOLT:DC:RANG``."""
    first, _, rest = header.partition(":")
    return header if first != "VOLT" or not rest or rest.startswith(("DC", "AC")) else f"VOLT:DC:{rest}"


def _require(is_so: bool, error: Error) -> None:
    if not is_so:
        raise Refused(error)
