"""The words of chambers that speak lines of text: Thermotron 8800 and 3800, Espec P-300 and SCP-220.

What each command does besides its purpose, and how sure that is: docs/devices/ascii-chambers.md. Every parser takes a
whole line without its end, or nothing: a number picked out of a damaged line is a wrong temperature.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from rig.errors import DeviceNonsense

Activity = Literal["stopped", "holding", "program"]
DECIMALS = 1
"""Of every temperature that is written."""

_TEMPERATURE = r"[+-]?\d{1,3}(?:\.\d{1,3})?"
_SINGLE = re.compile(rf"[ ]*({_TEMPERATURE})[ ]*".encode())
_FOUR = re.compile(rf"({_TEMPERATURE}),({_TEMPERATURE}),({_TEMPERATURE}),({_TEMPERATURE})".encode())
_CONSTANT = re.compile(rf"({_TEMPERATURE}),(ON|OFF)".encode())
_TEXT = re.compile(rb"[ -~]{1,80}")
_UNIT = re.compile(rb'[ ]*"?(?:deg|\xb0|\xf8)?[ ]*([CF])"?[ ]*')
_WHOLE = re.compile(rb"[ ]*(\d{1,3})[ ]*")
RUNNING = 1
"""``SCOD?`` of an 8800; the others are reasons why it stands."""
PROGRAM_BITS, MANUAL_BIT = 1 | 8, 16
"""``MODE?`` of a 3800: a program runs, or is edited while it is held; manual."""
_DONE = re.compile(rb"OK *: *(?:\d{1,2} *, *)?(.*)")
"""On RS-485 the address stands before the command."""
_REFUSED = re.compile(rb"NA *:")
_ESPEC_MODES: Mapping[bytes, Activity] = {b"OFF": "stopped", b"STANDBY": "stopped", b"CONSTANT": "holding"}


@dataclass(frozen=True, slots=True)
class Look:
    """What a chamber tells at once, in its own unit; None: not by this answer."""

    temperature: float
    setpoint: float | None = None
    highest: float | None = None
    lowest: float | None = None


_ALARM_CODES = re.compile(rb"\d{1,3}(?:,\d{1,3})*")
_ALARM_BITS = {1: "low deviation", 2: "high deviation", 16: "low process", 32: "high process"}
"""``ALRMn?`` of an 8800."""
STOP_CODE = b"SCOD?"
STOP_CODES: Mapping[int, str] = {
    2: "stop key",
    3: "end of test",
    4: "external input",
    5: "STOP by computer",
    6: "open input",
    7: "process alarm",
    8: "system monitor",
    9: "power fail",
    10: "Therm-Alarm",
}
"""``SCOD?`` of an 8800: why it stands."""


@dataclass(frozen=True, slots=True)
class ChamberWords:
    """How one family is spoken to. Commands are without their end."""

    name: str
    command_end: bytes
    identity: tuple[bytes, ...]
    look: bytes
    parse_look: Callable[[bytes], Look]
    setpoint: bytes
    """The set point in force once the chamber holds: what a write is compared with."""
    parse_setpoint: Callable[[bytes], float]
    write: bytes
    """With the temperature in place of %s."""
    start: bytes
    stop: bytes
    """It neither heats nor cools from then on, and keeps its set point."""
    activity: bytes
    parse_activity: Callable[[bytes], Activity]
    check_acknowledged: Callable[[bytes, bytes], str] | None
    """From what was sent and the line behind it: why it was refused, or nothing. None: a write has no answer."""
    unit: bytes | None
    """The question for the unit on the wire; None: there is none, the file must say."""
    alarms: bytes | None
    """The question for alarms; None: none is known."""
    parse_alarms: Callable[[bytes], tuple[str, ...]]
    starts_always: bool
    """A new set point is taken at the next start only."""
    pause_s: float
    """Rest behind a write."""


def parse_temperature(line: bytes) -> float:
    """Parse one temperature. Raises: DeviceNonsense."""
    if (found := _SINGLE.fullmatch(line)) is None:
        raise DeviceNonsense("the chamber answers with one temperature such as 25.3")
    return float(found[1])


def parse_text(line: bytes) -> str:
    """Parse what it says of itself. Raises: DeviceNonsense."""
    if _TEXT.fullmatch(line) is None or not line.strip():
        raise DeviceNonsense("the chamber answers with a line of text")
    return line.decode("ascii").strip()


def parse_is_fahrenheit(line: bytes) -> bool:
    """Parse the unit character of a channel. Raises: DeviceNonsense."""
    if (found := _UNIT.fullmatch(line)) is None:
        raise DeviceNonsense("the chamber answers with the unit of its channel, C or F")
    return found[1] == b"F"


def format_temperature(value: float) -> bytes:
    return b"%.*f" % (DECIMALS, value + 0.0)


def _single_look(line: bytes) -> Look:
    return Look(parse_temperature(line))


def _espec_look(line: bytes) -> Look:
    """Parse ``TEMP?``: measured, set point in force, upper and lower limit."""
    if (found := _FOUR.fullmatch(line)) is None:
        raise DeviceNonsense("TEMP? is answered by four numbers: measured, set point, upper and lower limit")
    return Look(*map(float, found.groups()))


def _espec_setpoint(line: bytes) -> float:
    """Parse ``CONSTANT SET?,TEMP``."""
    if (found := _CONSTANT.fullmatch(line)) is None:
        raise DeviceNonsense("CONSTANT SET?,TEMP is answered by a number and ON or OFF")
    return float(found[1])


def _stop_code(line: bytes) -> Activity:
    return "holding" if _whole(line) == RUNNING else "stopped"


def _mode_bits(line: bytes) -> Activity:
    bits = _whole(line)
    return "program" if bits & PROGRAM_BITS else "holding" if bits & MANUAL_BIT else "stopped"


def _espec_mode(line: bytes) -> Activity:
    if line.startswith((b"RUN", b"RMT RUN")):
        return "program"
    if line not in _ESPEC_MODES:
        raise DeviceNonsense("MODE? is answered by OFF, STANDBY, CONSTANT or RUN")
    return _ESPEC_MODES[line]


def _deviations(line: bytes) -> tuple[str, ...]:
    """Parse ``ALRMn?`` of an 8800: a sum. Raises: DeviceNonsense."""
    bits = _whole(line)
    named = [word for bit, word in _ALARM_BITS.items() if bits & bit]
    return (f"an alarm: {', '.join(named) or 'unknown'} (ALRM reads {bits})",) if bits else ()


def _espec_alarms(line: bytes) -> tuple[str, ...]:
    """Parse ``ALARM?``: how many, and their codes. Raises: DeviceNonsense."""
    if _ALARM_CODES.fullmatch(line) is None:
        raise DeviceNonsense("ALARM? is answered by the number of alarms and their codes")
    number, *codes = (int(word) for word in line.split(b","))
    if number != len(codes):
        raise DeviceNonsense(f"ALARM? tells {number} alarms and {len(codes)} codes")
    return tuple(f"alarm {code} (ALARM?)" for code in codes)


def parse_stop_reason(line: bytes) -> str:
    """Parse ``SCOD?`` of an 8800 that stands, in words; empty where it runs, or the code is not known."""
    code = _whole(line)
    return f" ({STOP_CODES[code]}, SCOD {code})" if code in STOP_CODES else ""


def _whole(line: bytes) -> int:
    if (found := _WHOLE.fullmatch(line)) is None:
        raise DeviceNonsense("the chamber answers with one whole number")
    return int(found[1])


def _zero(sent: bytes, line: bytes) -> str:  # noqa: ARG001 it does not repeat what was sent
    """Parse the answer of an 8800 to a write; 0 is done. Raises: DeviceNonsense."""
    return "" if (code := _whole(line)) == 0 else f"it answers {code}"


def _echoed(sent: bytes, line: bytes) -> str:
    """Parse an Espec's answer to a write: ``OK:`` and the command, blanks aside, or ``NA:`` and why not.

    Raises: DeviceNonsense.
    """
    if _REFUSED.match(line) is not None:
        return parse_text(line)
    found = _DONE.fullmatch(line)
    if found is None or found[1].replace(b" ", b"") != sent.replace(b" ", b""):
        raise DeviceNonsense("a write is answered by OK: and the command, or by NA: and the reason")
    return ""


def _thermotron(name: str, channel: int) -> ChamberWords:
    is_8800 = name == "thermotron-8800"
    return ChamberWords(
        name=name,
        command_end=b"\r",
        identity=(b"IDEN?", b"VRSN?") if is_8800 else (b"IDEN?",),
        look=b"PVAR%d?" % channel,
        parse_look=_single_look,
        setpoint=b"SETP%d?" % channel,
        parse_setpoint=parse_temperature,
        write=b"SETP%d,%%s" % channel,
        start=b"RUNM",
        stop=b"STOP",
        activity=STOP_CODE if is_8800 else b"MODE?",
        parse_activity=_stop_code if is_8800 else _mode_bits,
        check_acknowledged=_zero if is_8800 else None,
        unit=b"CCHR%d?" % channel if is_8800 else None,
        alarms=b"ALRM%d?" % channel if is_8800 else None,
        parse_alarms=_deviations,
        starts_always=not is_8800,
        pause_s=0.002 if is_8800 else 1.0,
    )


def _espec(name: str) -> ChamberWords:
    return ChamberWords(
        name=name,
        command_end=b"\r\n",
        identity=(b"TYPE?", b"ROM?"),
        look=b"TEMP?",
        parse_look=_espec_look,
        setpoint=b"CONSTANT SET?,TEMP",
        parse_setpoint=_espec_setpoint,
        write=b"TEMP, S%s",
        start=b"MODE,CONSTANT",
        stop=b"MODE,STANDBY",
        activity=b"MODE?",
        parse_activity=_espec_mode,
        check_acknowledged=_echoed,
        unit=None,
        alarms=b"ALARM?",
        parse_alarms=_espec_alarms,
        starts_always=False,
        pause_s=0.5,
    )


MODELS = ("thermotron-8800", "thermotron-3800", "espec-p300", "espec-scp220")


def chamber_words(model: str, channel: int = 1) -> ChamberWords:
    """Return how a model is spoken to; ``channel`` is a Thermotron's."""
    return _thermotron(model, channel) if model.startswith("thermotron") else _espec(model)
