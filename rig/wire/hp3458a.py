"""HP/Agilent/Keysight 3458A: its command words, its numbers, its lines.

The meter speaks its own language, neither SCPI nor IEEE 488.2: several commands a line separated by ``;``, one query
at a time. Under ``QFORMAT NORM`` (its reset state) queries answer in numbers, so the enumerations below are the
wire's. A reading in ASCII is a number and CR LF; its shape is not documented in public, so it is read as a number
and never by column.

Source: 3458A user's guide (commands END, ERRSTR?, FUNC, NPLC, NRDGS, OFORMAT, TARM, TRIG; status byte).
"""

import re
from collections.abc import Mapping
from enum import IntEnum, IntFlag
from typing import Literal

from rig.errors import DeviceNonsense

DEFAULT_ADDRESS = 22
IDENTITIES = (b"HP3458A", b"Keysight 3458A")
"""``ID?`` of HP and Agilent firmware, and as the Keysight manual prints it."""
OVERLOAD_V = 1.0e38
"""What an ASCII reading says instead of a value outside its range, with the sign of the input."""
NO_ERROR = b'0,"NO ERROR"'
DC_VOLTS, AC_VOLTS, OHMS = 1, 2, 4
"""Of ``FUNC?``."""
TERMINALS: Mapping[Literal["front", "rear"], int] = {"front": 1, "rear": 2}
"""Of ``TERM?``."""
FULL_SCALE_V: Mapping[float, float] = {0.1: 0.12, 1.0: 1.2, 10.0: 12.0, 100.0: 120.0, 1000.0: 1050.0}


class Event(IntEnum):
    """Arm, trigger and sample events share one numbering."""

    AUTO = 1
    EXT = 2
    SGL = 3
    HOLD = 4
    SYN = 5
    TIMER = 6
    LEVEL = 7
    LINE = 8


class End(IntEnum):
    """When EOI is asserted. RESET and power-on leave OFF, and then a read to EOI can only time out."""

    OFF = 0
    ON = 1
    ALWAYS = 2


class Status(IntFlag):
    """The status byte of a serial poll."""

    PROGRAM_DONE = 1
    LIMIT = 2
    SERVICE_REQUESTED = 4
    POWER_ON = 8
    READY = 16
    ERROR = 32
    SERVICE = 64
    DATA = 128


ERRORS: Mapping[int, str] = {
    1: "HARDWARE ERROR",
    2: "CALIBRATION ERROR",
    4: "TRIGGER TOO FAST",
    8: "SYNTAX ERROR",
    16: "COMMAND NOT ALLOWED FROM REMOTE",
    32: "UNDEFINED PARAMETER RECEIVED",
    64: "PARAMETER OUT OF RANGE",
    128: "MEMORY ERROR",
    256: "DESTRUCTIVE OVERLOAD DETECTED",
    512: "OUT OF CALIBRATION",
    1024: "CALIBRATION REQUIRED",
    2048: "SETTINGS CONFLICT",
    4096: "MATH ERROR",
    8192: "SUBPROGRAM ERROR",
    16384: "SYSTEM ERROR",
}
"""Bit of ``ERR?`` to its text; ``ERRSTR?`` numbers it 100 + position of the bit."""
HARMFUL_ERRORS = frozenset({100, 101, 108, 109, 110, 114})
LARGEST_READING_V = 1.0e30
"""Beyond this a reading is the overload mark, even with a damaged mantissa."""
SMALLEST_READING_V = 1.0e-98
"""Below this the exponent would need a third digit."""

READING_CHARACTERS = range(14, 19)
"""The guide says 15; logs of units show 16."""

_NUMBER = re.compile(rb" *[+-]?(?:\d{1,12}(?:\.\d{0,16})?|\.\d{1,16})(?:E[+-]?\d{1,2})?", re.IGNORECASE)
"""Settings come without a zero before the point: ``FUNC?`` on the 0.1 V range is ``1, .1``."""
_ERROR_STRING = re.compile(rb' *(\d{1,3}) *, *"([^"]*)"')


def parse_number(line: bytes) -> float:
    """Return a reading or a numeric answer: the whole line is one finite number.

    Raises: DeviceNonsense.
    """
    if _NUMBER.fullmatch(line) is None:
        raise DeviceNonsense("the meter answers with one decimal number")
    return float(line)


def parse_pair(line: bytes) -> tuple[float, float]:
    """Parse two numbers, such as ``FUNC?`` (function, range) and ``NRDGS?`` (count, event).

    Raises: DeviceNonsense.
    """
    first, comma, second = line.partition(b",")
    if not comma:
        raise DeviceNonsense("the meter answers with two numbers and a comma")
    return parse_number(first), parse_number(second)


def format_setting(value: float) -> bytes:
    """Return a setting as the meter writes it: the tenth of a volt is ``.1``, ten volts ``10``."""
    text = f"{value:.9g}".upper()
    return text.removeprefix("0").encode("ascii") if 0.0 < value < 1.0 else text.encode("ascii")


def parse_terminals(line: bytes) -> Literal["front", "rear"]:
    """Parse ``TERM?``: the inputs that the switch at the panel selects.

    Raises: DeviceNonsense.
    """
    number = parse_number(line)
    if number not in TERMINALS.values():
        raise DeviceNonsense("the meter answers TERM? with 1 for the inputs at its front or 2 for those at its rear")
    return next(inputs for inputs, code in TERMINALS.items() if code == number)


def parse_operations(line: bytes) -> float:
    """Return the first running operation of ``MATH?``, 0 for none: two may run, and one or two numbers answer.

    Raises: DeviceNonsense.
    """
    return next((number for number in map(parse_number, line.split(b",", 1)) if number), 0.0)


def parse_reading(line: bytes) -> tuple[float, int]:
    """Return a reading, volts, and the number of its characters: equal for all readings of a burst.

    Raises: DeviceNonsense.
    """
    if len(line) not in READING_CHARACTERS:
        raise DeviceNonsense(f"a reading of {len(line)} characters, a meter sends 14 to 18")
    return parse_number(line), len(line)


def is_harmful(error: int) -> bool:
    """Return whether a number of ``ERRSTR?`` speaks of the meter itself and not of what it was told."""
    return error in HARMFUL_ERRORS or error >= 200


def parse_identity(line: bytes) -> str:
    """Return the name of a 3458A in one of its two accepted spellings. Raises: DeviceNonsense."""
    if line.strip() not in IDENTITIES:
        raise DeviceNonsense(f"a 3458A answers ID? with {' or '.join(name.decode() for name in IDENTITIES)}")
    return line.strip().decode("ascii")


def parse_error(line: bytes) -> tuple[int, str]:
    """Parse ``ERRSTR?``: number and text, 0 when there is none (the lowest set bit is cleared by asking).

    Raises: DeviceNonsense.
    """
    match = _ERROR_STRING.fullmatch(line)
    if match is None or not (match[2].isascii() and match[2].decode("ascii").isprintable()):
        raise DeviceNonsense('the meter answers ERRSTR? with a number and a text, such as 0,"NO ERROR"')
    return int(match[1]), match[2].decode("ascii")


def format_reading(value_v: float, decimals: int = 9) -> bytes:
    """Format a reading as the meter sends it, and CR LF: sign or space, digit, point, decimals, exponent.

    Nine decimals are the 16 characters that logs of units show, eight the 15 of the guide (p. 149).
    """
    return b"% .*E\r\n" % (decimals, value_v if abs(value_v) >= SMALLEST_READING_V else 0.0)


def format_error(bits: int) -> bytes:
    """Format the answer to ``ERRSTR?`` for an error register: its lowest set bit."""
    if not bits:
        return NO_ERROR
    lowest = bits & -bits
    return b'%d,"%s"' % (99 + lowest.bit_length(), ERRORS[lowest].encode("ascii"))
