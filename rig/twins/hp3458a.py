"""The twin of a 3458A: arm, trigger and sample events in time, DC volts, ASCII readings.

Other hands may set AC volts (0 of a steady input), ohms of two wires, the mathematics NULL and SCALE, RATIO, the
switch of its inputs (``is_front``; the volts are the same at both), and events that never come here (EXT, LEVEL,
LINE). What is not modelled says so by an error of the meter: other functions and mathematics, binary formats, reading
memory. Readings that nobody fetches wait without limit, which no source says (docs/devices/hp3458a.md).

Source: 3458A user's guide (reset state, events, EOI, mathematics, error and status registers). Overhead of a reading,
the answers' number shapes and the currents of ohms are assumptions.
"""

import math
import re
from collections import deque
from collections.abc import Callable, Mapping, Sequence

from rig.wire import hp3458a as wire
from rig.wire.hp3458a import End, Event, Status

OVERHEAD_S = 0.0006
"""What a reading takes beyond its integration."""
TEMPERATURE_DEGC = 36.4
AUTOCALIBRATION_S: Mapping[str, float] = {"DCV": 165.0, "AC": 165.0, "OHMS": 660.0, "ALL": 960.0}
RECORD: Mapping[str, bytes] = {"REV": b"9,2", "OPT": b"0", "CALNUM": b"2.47E+02"}
"""Firmware of both processors, options, times that it was adjusted."""
CALIBRATION, SYNTAX, UNDEFINED, OUT_OF_RANGE = 2, 8, 32, 64
LARGEST_COUNT = 16777215

FUNCTIONS: Mapping[str, int] = {"DCV": wire.DC_VOLTS, "ACV": wire.AC_VOLTS, "OHM": wire.OHMS}
OHM_CURRENTS_A: Mapping[float, float] = {
    **{10.0: 1e-2, 1e2: 1e-3, 1e3: 1e-3, 1e4: 1e-4, 1e5: 5e-5, 1e6: 5e-6, 1e7: 5e-7, 1e8: 5e-7, 1e9: 5e-7}
}
"""Ranges of ohms and the current through the resistance: a voltage at the input reads as that over the current."""
FULL_SCALES: Mapping[int, Mapping[float, float]] = {
    wire.DC_VOLTS: wire.FULL_SCALE_V,
    wire.AC_VOLTS: {0.01: 0.012, **wire.FULL_SCALE_V},
    wire.OHMS: {range_ohm: 1.2 * range_ohm for range_ohm in OHM_CURRENTS_A},
}
ARM_EVENTS = (Event.AUTO, Event.EXT, Event.SGL, Event.HOLD, Event.SYN)
TRIGGER_EVENTS = (*ARM_EVENTS, Event.LEVEL, Event.LINE)
NULL, SCALE = 7, 11
SENSE_V = 9.99
"""The reference at the Ω sense terminals, by which RATIO divides."""
REGISTERS: Mapping[str, float] = {"OFFSET": 0.0, "SCALE": 1.0}

SWITCH = {"OFF": 0, "ON": 1}
WORDS: Mapping[str, Mapping[str, int]] = {
    "ARANGE": SWITCH,
    "AZERO": {**SWITCH, "ONCE": 2},
    "BEEP": {**SWITCH, "ONCE": 2},
    "DISP": SWITCH,
    "FIXEDZ": SWITCH,
    "END": {"OFF": 0, "ON": 1, "ALWAYS": 2},
    "INBUF": SWITCH,
    "LOCK": SWITCH,
    "MEM": {"OFF": 0},
    "OFORMAT": {"ASCII": 1},
    "QFORMAT": {"NORM": 1},
    "RATIO": SWITCH,
}
"""Settings with named values; the number is what the query answers."""
RESET_STATE: Mapping[str, float] = {
    **{"AZERO": 1, "BEEP": 1, "DISP": 1, "END": 0, "INBUF": 0, "LOCK": 0, "MEM": 0, "OFORMAT": 1},
    **{"QFORMAT": 1, "FIXEDZ": 0, "NDIG": 7, "NPLC": 10, "LFREQ": 50, "NRDGS": 1, "RATIO": 0},
    **{"FUNC": wire.DC_VOLTS, "RANGE": 1000, "ARANGE": 1},
    **{"TARM": Event.AUTO, "TRIG": Event.AUTO, "SAMPLE": Event.AUTO},
}
PRESET_NORM: Mapping[str, float] = {
    **{"NPLC": 1, "NDIG": 6, "TRIG": Event.SYN, "INBUF": 0, "AZERO": 1, "NRDGS": 1, "FIXEDZ": 0, "RATIO": 0},
    **{"FUNC": wire.DC_VOLTS, "RANGE": 1000, "ARANGE": 1},
}

_COMMAND = re.compile(r"([A-Z]+\??)\s*(.*)")


class Hp3458aTwin:
    """A GPIB instrument that measures ``input_v(now_s)``."""

    def __init__(self, input_v: Callable[[float], float], *, decimals: int = 9) -> None:
        """``decimals`` of a reading: 8 are the 15 characters of the guide, 9 the 16 that logs of units show."""
        self._decimals = decimals
        self.inside_degc: Callable[[float], float] = lambda _now_s: TEMPERATURE_DEGC
        """What ``TEMP?`` tells at a time."""
        self.calibrated_s: list[float] = []
        """When it began to calibrate itself."""
        self.cannot_calibrate = False
        self.is_front = True
        """The switch of its inputs."""
        self._calibrated_from_s = -math.inf
        self._input_v = input_v
        self._ready: deque[bytes] = deque()
        self._reply = b""
        self._errors = 0
        self._is_fresh = True
        self._left = 0
        self._due_s = 0.0
        self._reading_s = 0.0
        self._settings = dict(RESET_STATE)
        self._operations: list[int] = []
        self._registers = dict(REGISTERS)
        self._is_offset_due = False
        self._actions: dict[str, Callable[[list[str], float], None]] = {
            "ACAL": self._autocalibrate,
            "ACV": lambda words, _now_s: self._set_function(["ACV", *words]),
            "DCV": lambda words, _now_s: self._set_function(["DCV", *words]),
            "OHM": lambda words, _now_s: self._set_function(["OHM", *words]),
            "FUNC": lambda words, _now_s: self._set_function(words),
            "LFREQ": lambda words, _now_s: self._set_number("LFREQ", words, 45.0, 440.0),
            "MATH": lambda words, _now_s: self._set_operations(words),
            "NDIG": lambda words, _now_s: self._set_number("NDIG", words, 3.0, 8.0),
            "NPLC": lambda words, _now_s: self._set_power_line_cycles(words),
            "NRDGS": lambda words, _now_s: self._set_count(words),
            "PRESET": lambda words, _now_s: self._preset(words),
            "RANGE": lambda words, _now_s: self._set_range(words),
            "SMATH": lambda words, _now_s: self._set_register(words),
            "RESET": lambda _words, _now_s: self._reset(),
            "CSB": lambda _words, _now_s: self._clear_status(),
            "TARM": self._set_arm,
            "TRIG": self._set_trigger,
        }

    def power_cycle(self, _now_s: float = 0.0) -> None:
        """Restart as if the mains had failed: nothing of the configuration is left."""
        self._reset()
        self._abort()
        self._errors = 0
        self._is_fresh = True

    def listen(self, message: bytes, now_s: float) -> float:
        self._reply = b""
        for text in message.decode("latin-1").upper().replace(";", "\n").split("\n"):
            if command := text.strip():
                self._execute(command, now_s)
        return now_s if self._settings["INBUF"] or not self._left else self._due_s + (self._left - 1) * self._reading_s

    def talk(self, now_s: float) -> tuple[bytes, bool]:
        if self._left:
            self.advance(now_s)
        end = self._settings["END"]
        if self._reply:
            reply, self._reply = self._reply, b""
            return reply, end != End.OFF
        if self._ready:
            line = self._ready.popleft()
            return line, end == End.ALWAYS or (end == End.ON and not self._left and not self._ready)
        if not self._left and self._is_triggered_by_talking():
            self._begin(now_s)
        return b"", False

    def next_talk_s(self) -> float | None:
        return self._due_s if self._left else None

    def serial_poll(self, now_s: float) -> int:
        self.advance(now_s)
        status = 0 if self._left or now_s < self._calibrated_from_s else Status.READY
        status |= Status.DATA if self._reply or self._ready else 0
        status |= Status.ERROR if self._errors else 0
        return int(status | (Status.POWER_ON if self._is_fresh else 0))

    def clear(self, now_s: float) -> None:
        self.advance(now_s)
        self._abort()

    def advance(self, now_s: float) -> None:
        while self._left and self._due_s <= now_s:
            self._ready.append(wire.format_reading(self._reading(self._input_v(self._due_s)), self._decimals))
            self._left -= 1
            self._due_s += self._reading_s

    def _reading(self, input_v: float) -> float:
        """Return what the function makes of the input, and mathematics of that."""
        function = int(self._settings["FUNC"])
        if self._settings["ARANGE"]:
            self._settings["RANGE"] = self._range_for(self._in_unit(function, input_v))
        value = self._in_unit(function, input_v)
        if abs(value) > FULL_SCALES[function][self._settings["RANGE"]]:
            return math.copysign(wire.OVERLOAD_V, value)
        if self._is_offset_due:
            self._registers["OFFSET"], self._is_offset_due = value, False
        for operation in self._operations:
            divisor = self._registers["SCALE"] if operation == SCALE else 1.0
            value = (value - self._registers["OFFSET"]) / divisor
        return value / SENSE_V if self._settings["RATIO"] else value

    def _in_unit(self, function: int, input_v: float) -> float:
        if function == wire.OHMS:
            return input_v / OHM_CURRENTS_A[self._settings["RANGE"]]
        return 0.0 if function == wire.AC_VOLTS else input_v

    def _range_for(self, largest: float) -> float:
        """Return the range that holds ``largest``, in the function's unit, or the last one."""
        full_scales = FULL_SCALES[int(self._settings["FUNC"])]
        return next((name for name, full_scale in full_scales.items() if abs(largest) <= full_scale), max(full_scales))

    def _is_triggered_by_talking(self) -> bool:
        implied = (Event.AUTO, Event.SYN)
        return self._settings["TARM"] in implied and self._settings["TRIG"] in implied

    def _begin(self, now_s: float) -> None:
        cycles = self._settings["NPLC"] * (2.0 if self._settings["AZERO"] == 1 else 1.0)
        self._reading_s = cycles / self._settings["LFREQ"] + OVERHEAD_S
        self._left = int(self._settings["NRDGS"])
        self._due_s = now_s + self._reading_s

    def _abort(self) -> None:
        self._left = 0
        self._ready.clear()
        self._reply = b""

    def _execute(self, text: str, now_s: float) -> None:
        match = _COMMAND.fullmatch(text)
        if match is None:
            self._errors |= SYNTAX
            return
        name, words = match[1], [word.strip() for word in match[2].split(",")]
        if name == "TEMP?":
            self._say(b"%.1f" % self.inside_degc(now_s))
        elif name.endswith("?"):
            self._answer(name[:-1])
        elif name in self._actions:
            self._actions[name](words, now_s)
        elif name in WORDS:
            self._set_word(name, words[0])
        else:
            self._errors |= SYNTAX

    def _answer(self, name: str) -> None:
        settings = self._settings
        if name == "ID":
            self._say(wire.IDENTITIES[0])
        elif name in RECORD:
            self._say(RECORD[name])
        elif name == "ERR":
            self._say(b"%d" % self._errors)
            self._errors = 0
        elif name == "ERRSTR":
            self._say(wire.format_error(self._errors))
            self._errors &= self._errors - 1
        elif name == "TERM":
            self._say(b"%d" % wire.TERMINALS["front" if self.is_front else "rear"])
        elif name == "AUXERR":
            self._say(b"0")
        elif name in ("FUNC", *FUNCTIONS):
            self._say(b"%d, %b" % (settings["FUNC"], wire.format_setting(settings["RANGE"])))
        elif name == "MATH":
            self._say(b"%d,%d" % tuple([*self._operations, 0, 0][:2]))
        elif name == "NRDGS":
            self._say(b"%d, %d" % (settings["NRDGS"], settings["SAMPLE"]))
        elif name in settings:
            self._say(wire.format_setting(settings[name]))
        else:
            self._errors |= SYNTAX

    def _say(self, text: bytes) -> None:
        self._reply = text + b"\r\n"

    def _autocalibrate(self, words: list[str], now_s: float) -> None:
        if words[0] not in AUTOCALIBRATION_S:
            self._errors |= UNDEFINED
            return
        self._abort()
        self.calibrated_s.append(now_s)
        self._calibrated_from_s = now_s + AUTOCALIBRATION_S[words[0]]
        self._errors |= CALIBRATION if self.cannot_calibrate else 0

    def _set_word(self, name: str, word: str) -> None:
        values = WORDS[name]
        if word in values:
            self._settings[name] = values[word]
        elif word.isdigit() and int(word) in values.values():
            self._settings[name] = int(word)
        else:
            self._errors |= UNDEFINED

    def _set_number(self, name: str, words: list[str], low: float, high: float) -> None:
        value = _number(words[0])
        if value is None or not low <= value <= high:
            self._errors |= UNDEFINED if value is None else OUT_OF_RANGE
        else:
            self._settings[name] = value

    def _set_power_line_cycles(self, words: list[str]) -> None:
        """Set whole cycles from 1 to 10, tens above: the meter takes the next step up."""
        self._set_number("NPLC", words, 0.0, 1000.0)
        cycles = self._settings["NPLC"]
        step = 10.0 if cycles > 10.0 else 1.0
        self._settings["NPLC"] = cycles if cycles < 1.0 else step * -(-cycles // step)

    def _set_count(self, words: list[str]) -> None:
        self._set_number("NRDGS", words, 1.0, LARGEST_COUNT)
        if len(words) > 1 and words[1] not in ("AUTO", "1"):
            self._errors |= UNDEFINED

    def _set_function(self, words: list[str]) -> None:
        number = FUNCTIONS.get(words[0]) or {str(number): number for number in FUNCTIONS.values()}.get(words[0])
        if number is None:
            self._errors |= UNDEFINED
            return
        if number != self._settings["FUNC"]:
            self._settings |= {"FUNC": number, "RANGE": max(FULL_SCALES[number])}
        self._set_range(words[1:])

    def _set_range(self, words: list[str]) -> None:
        if not words or words[0] in ("", "AUTO", "-1"):
            self._settings["ARANGE"] = 1
        elif (value := _number(words[0])) is None:
            self._errors |= UNDEFINED
        elif not 0.0 <= value <= max(FULL_SCALES[int(self._settings["FUNC"])]):
            self._errors |= OUT_OF_RANGE
        else:
            self._settings |= {"ARANGE": 0, "RANGE": self._range_for(value)}

    def _set_operations(self, words: list[str]) -> None:
        """NULL takes the first reading after it as its offset."""
        known = {"": 0, "OFF": 0, "0": 0, "NULL": NULL, "7": NULL, "SCALE": SCALE, "11": SCALE}
        if any(word not in known for word in words):
            self._errors |= UNDEFINED
            return
        self._operations = [known[word] for word in words[:2] if known[word]]
        self._is_offset_due = NULL in self._operations

    def _set_register(self, words: list[str]) -> None:
        value = _number(words[1]) if len(words) > 1 else None
        if words[0] not in REGISTERS or value is None or (words[0] == "SCALE" and value == 0.0):
            self._errors |= UNDEFINED
        else:
            self._registers[words[0]] = value

    def _set_arm(self, words: list[str], now_s: float) -> None:
        event = self._event(words[0], ARM_EVENTS)
        if event is Event.SGL:
            self._settings["TARM"] = Event.HOLD
            self._abort()
            if self._settings["TRIG"] == Event.AUTO:
                self._begin(now_s)
        elif event is not None:
            self._settings["TARM"] = event
            self._abort()

    def _set_trigger(self, words: list[str], now_s: float) -> None:
        event = self._event(words[0], TRIGGER_EVENTS)
        if event is Event.SGL:
            self._settings["TRIG"] = Event.HOLD
            if self._settings["TARM"] == Event.AUTO:
                self._begin(now_s)
        elif event is not None:
            self._settings["TRIG"] = event

    def _event(self, word: str, events: Sequence[Event]) -> Event | None:
        known = {event.name: event for event in events}
        event = known.get(word) or {str(int(event)): event for event in known.values()}.get(word)
        if event is None:
            self._errors |= UNDEFINED
        return event

    def _preset(self, words: list[str]) -> None:
        if words[0] not in ("NORM", ""):
            self._errors |= UNDEFINED
        else:
            self._settings |= {"TARM": Event.AUTO, **PRESET_NORM}
            self._operations = []

    def _reset(self) -> None:
        self._settings = dict(RESET_STATE)
        self._operations = []
        self._registers = dict(REGISTERS)
        self._abort()

    def _clear_status(self) -> None:
        self._is_fresh = False


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
