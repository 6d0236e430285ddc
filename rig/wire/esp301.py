"""Lines of the Newport ESP300, ESP301 and ESP302: ``[axis]CC[value]``, several in a line by ``;``, ended by CR.

Commands are never answered, wrong ones neither: what went wrong stands in a queue of ten, read one by one by ``TE?``
(number) or ``TB?`` (number, time stamp, text). An error of axis n has the number n × 100 + code. Replies end CR LF and
do not repeat the question.

Source: ESP300 user's manual, command descriptions (TB, TE, PA, MD) and error list.
"""

import re
from dataclasses import dataclass

TERMINATOR = b"\r"
REPLY_TERMINATOR = b"\r\n"
QUEUE_LENGTH = 10
CYCLE_S = 0.0004
"""Of a time stamp in the error queue."""
DEGREES = 7
"""``SN``: the axis counts in degrees."""
DECIMALS = 6
"""Of every number we send: 1e-6 deg is 0.004 arc second. Never by ``%g``, which keeps six digits in all."""

COMMAND_UNKNOWN, OUT_OF_RANGE, AXIS_OUT_OF_RANGE, AXIS_MISSING, PARAMETER_MISSING = 6, 7, 9, 37, 38
HARDWARE_LIMITS, SOFTWARE_LIMITS, MOTOR_OFF, HOMING_ABORTED = (4, 5), (6, 7), 13, 20
"""The first row concerns the line, the second one axis (add 100 × its number)."""

_NUMBER = re.compile(rb"[+-]?\d{1,12}(?:\.\d{0,12})?|[+-]?\.\d{1,12}")
_ERROR = re.compile(rb"(\d{1,4}), *(\d{1,12}), *([ -~]+)")
_VERSION = re.compile(rb"ESP30[012][ -~]*")
_COMMAND = re.compile(r"(\d{0,3}) *([A-Za-z]{2}) *([^;]*)")


@dataclass(frozen=True, slots=True)
class Command:
    """One command as both sides see it; ``value`` is the text after the letters, ``?`` for a question."""

    letters: str
    axis: int | None = None
    value: str = ""


@dataclass(frozen=True, slots=True)
class ErrorRecord:
    """One entry of the error queue; code 0 where the queue is empty."""

    code: int
    stamp: int
    """Servo cycles since power came on."""
    text: str

    @property
    def axis(self) -> int:
        """0 where the error concerns no single axis."""
        return self.code // 100

    @property
    def is_empty(self) -> bool:
        return self.code == 0


def encode(*commands: Command) -> bytes:
    """Return the line that carries ``commands``."""
    pieces = (f"{'' if command.axis is None else command.axis}{command.letters}{command.value}" for command in commands)
    return ";".join(pieces).encode("ascii") + TERMINATOR


def slowest_dps(tolerance: float) -> float:
    """Return the speed below which the last decimal is more than so much of it."""
    return 0.5 * 10.0**-DECIMALS / tolerance


def set_value(letters: str, axis: int, value: float) -> Command:
    """Return the command ``letters`` of an axis with a number of six decimals."""
    # Adding 0.0 turns −0.0 into 0.0.
    return Command(letters, axis, f"{round(value, DECIMALS) + 0.0:.{DECIMALS}f}")


def ask(letters: str, axis: int | None = None) -> Command:
    return Command(letters, axis, "?")


def decode_commands(line: bytes) -> list[Command | None]:
    """Return the commands of a line without terminator; None for each that is none."""
    text = line.decode("ascii", errors="replace").strip()
    return [_command(piece.strip()) for piece in text.split(";") if piece.strip()]


def decode_number(line: bytes) -> float | None:
    """Decode a whole reply that is one plain number; None where it is not."""
    return float(line) if _NUMBER.fullmatch(line.strip(b" ")) else None


def decode_flag(line: bytes) -> bool | None:
    """Decode a whole reply that is 0 or 1."""
    return {b"0": False, b"1": True}.get(line.strip(b" "))


def decode_error(line: bytes) -> ErrorRecord | None:
    """Decode a reply to ``TB?``."""
    found = _ERROR.fullmatch(line.strip(b" "))
    return None if found is None else ErrorRecord(int(found[1]), int(found[2]), found[3].decode("ascii").strip())


def decode_version(line: bytes) -> str | None:
    """Decode a reply to ``VE?``, such as ``ESP300 Version 3.01``."""
    return line.decode("ascii").strip() if _VERSION.fullmatch(line.strip(b" ")) else None


def encode_reply(text: str) -> bytes:
    return text.encode("ascii") + REPLY_TERMINATOR


def encode_error(error: ErrorRecord) -> bytes:
    return encode_reply(f"{error.code}, {error.stamp}, {error.text}")


def _command(piece: str) -> Command | None:
    found = _COMMAND.fullmatch(piece)
    if found is None:
        return None
    return Command(found[2].upper(), int(found[1]) if found[1] else None, found[3].strip())
