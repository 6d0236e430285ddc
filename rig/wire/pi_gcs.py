"""GCS 2.0 of Physik Instrumente: lines of text with single characters between them.

A command is a line that ends with LF; ``#5`` and alike are one byte and no line. A query of one axis answers
``<axis>=<value>``. Source: docs/devices/pi-gcs.md (C-863 manual MS249E, EPICS, traffic of the maker's own client).
"""

import re
from collections.abc import Mapping

from rig.errors import DeviceNonsense

MOVING, STOP = b"\x05", b"\x18"
"""``#5`` asks for the moving axes, ``#24`` stops them all; neither has an end."""
NO_ERROR, UNKNOWN_COMMAND, NOT_REFERENCED, OUT_OF_LIMITS, VELOCITY, STOPPED = 0, 2, 5, 7, 8, 10
ERRORS: Mapping[int, str] = {
    1: "parameter syntax error",
    UNKNOWN_COMMAND: "unknown command",
    3: "command too long",
    NOT_REFERENCED: "unallowable move attempted on unreferenced axis, or move attempted with servo off",
    OUT_OF_LIMITS: "position out of limits",
    VELOCITY: "velocity out of limits",
    STOPPED: "controller was stopped by command",
    15: "invalid axis identifier",
    16: "unknown stage name",
}
"""M863 p. 207."""
UNIT = 0x7000601
"""Parameter with the name of the axis' unit; its number is remembered."""

_NUMBER = re.compile(r"[+-]?\d{1,7}\.\d{1,9}(?:[Ee][+-]?\d{1,2})?")
_ERROR = re.compile(rb"-?\d{1,5}")
_MASK = re.compile(rb"[0-9A-Fa-f]{1,4}")
_WORD = re.compile(r"[A-Za-z%°]{1,12}")
_IDENTITY = re.compile(rb"[ -~]{4,120}")


def command(word: str, axis: str, *values: str) -> bytes:
    """Return a command of one axis, such as ``MOV 1 12.5``."""
    return " ".join([word, axis, *values]).encode("ascii") + b"\n"


def format_number(value: float) -> str:
    return f"{value + 0.0:.6f}"


def parse_value(line: bytes, axis: str) -> str:
    """Return what stands behind ``<axis>=``. Raises: DeviceNonsense."""
    text = line.decode("latin-1").rstrip(" ")
    if not text.startswith(f"{axis}=") or not (text.isascii() and text.isprintable()):
        raise DeviceNonsense(f"a query of axis {axis} is answered by {axis}= and a value")
    return text.removeprefix(f"{axis}=")


def parse_number(line: bytes, axis: str) -> float:
    """Parse a position, a limit or a velocity: it has decimals always. Raises: DeviceNonsense."""
    if _NUMBER.fullmatch(value := parse_value(line, axis)) is None:
        raise DeviceNonsense(f"axis {axis} answers with a number such as {axis}=12.500000")
    return float(value)


def parse_flag(line: bytes, axis: str) -> bool:
    """Parse servo, reference or on-target state. Raises: DeviceNonsense."""
    if (value := parse_value(line, axis)) not in ("0", "1"):
        raise DeviceNonsense(f"axis {axis} answers {axis}=0 or {axis}=1")
    return value == "1"


def parse_unit(line: bytes, axis: str) -> str:
    """Parse ``SPA? 1 0x7000601`` → ``1 0x7000601=DEG`` to capital letters. Raises: DeviceNonsense.

    The number of the parameter may come back in decimal digits: the maker's client sends it so.
    """
    setting, _, unit = line.decode("latin-1").rstrip(" ").partition("=")
    parameters = (f"0x{UNIT:x}", str(UNIT))
    words = setting.lower().split(" ")
    if len(words) != 2 or words[0] != axis.lower() or words[1] not in parameters or _WORD.fullmatch(unit) is None:
        raise DeviceNonsense(f"the unit is answered as {axis} 0x{UNIT:X}=DEG")
    return unit.upper()


def parse_error(line: bytes) -> int:
    """Parse ``ERR?``. Raises: DeviceNonsense."""
    if _ERROR.fullmatch(line) is None:
        raise DeviceNonsense("ERR? is answered by a number")
    return int(line)


def parse_moving(line: bytes) -> int:
    """Parse ``#5``: bits of the moving axes, the first of ``SAI?`` is bit 0. Raises: DeviceNonsense."""
    if _MASK.fullmatch(line) is None:
        raise DeviceNonsense("#5 is answered by hexadecimal bits of the moving axes")
    return int(line, 16)


def parse_identity(line: bytes) -> str:
    """Parse ``*IDN?``. Raises: DeviceNonsense."""
    if _IDENTITY.fullmatch(line) is None or line.count(b",") < 2:
        raise DeviceNonsense("*IDN? is answered by maker, model, serial number and firmware")
    return line.decode("ascii").strip()
