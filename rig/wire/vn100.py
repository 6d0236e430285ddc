"""VectorNav VN-100, ASCII: ``$payload*XX`` with the XOR of the payload's bytes, registers and streamed outputs.

Source: VN-100 user manual UM001 (checksum, errors, register commands); the fields of VNYMR and VNIMU from lines seen
on real units. The rates that are offered and the register numbers as the maker's library has them.
"""

import re
from collections.abc import Mapping
from functools import reduce
from operator import xor

from rig.errors import DeviceNonsense
from rig.wire.stream_lines import NUMBER, Rows, checksums_hold, parse_lines

MODEL, SERIAL, FIRMWARE, BAUD_RATE, OUTPUT, RATE = 1, 3, 4, 5, 6, 7
"""Registers."""
COMPENSATION = (23, 25, 84)
"""The user's compensation of magnetometer, accelerometer and gyro: a matrix of 3 × 3 and an offset of three."""
NO_COMPENSATION = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
REFERENCE_VECTORS, ROTATION, HARD_SOFT_IRON, FILTERING = 21, 26, 44, 85
NO_ROTATION = NO_COMPENSATION[:9]
NOT_APPLIED = 1.0
"""HSIOutput, the second field of the real-time hard and soft iron: it is not applied to the measurements."""
FILTERED = ("field", "acceleration", "rate", "temperature", "pressure")
"""Quantities of the filtering: a window (samples averaged) of each, then a mode of each (0: none)."""
SETUP = (*COMPENSATION, ROTATION, FILTERING, HARD_SOFT_IRON, REFERENCE_VECTORS)
"""Registers that change what the unit measures."""
NO_SUCH_REGISTER = 8
BINARY_OUTPUTS = (75, 76, 77)
"""Registers of the binary outputs: ports (0 is none), divisor, groups and fields, the last two hexadecimal."""
IMU_REGISTER = 54
"""What the output IMU streams."""
RATES_HZ = (1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200)
BAUD_RATES = (9600, 19200, 38400, 57600, 115200, 128000, 230400, 460800, 921600)
OFF = 0
PAUSE, RESUME = b"VNASY,0", b"VNASY,1"
HEAD = b"$VN"
"""Of every line that a unit writes."""

YAW_PITCH_ROLL = (("yaw", "deg"), ("pitch", "deg"), ("roll", "deg"))
FIELD = (("mx", "gauss"), ("my", "gauss"), ("mz", "gauss"))
ACCELERATION = (("ax", "mps2"), ("ay", "mps2"), ("az", "mps2"))
RATES = (("gx", "radps"), ("gy", "radps"), ("gz", "radps"))
OUTPUTS: Mapping[str, tuple[int, tuple[tuple[str, str], ...]]] = {
    "YPR": (1, YAW_PITCH_ROLL),
    "MAG": (10, FIELD),
    "ACC": (11, ACCELERATION),
    "GYR": (12, RATES),
    "MAR": (13, (*FIELD, *ACCELERATION, *RATES)),
    "YMR": (14, (*YAW_PITCH_ROLL, *FIELD, *ACCELERATION, *RATES)),
    "IMU": (19, (*FIELD, *ACCELERATION, *RATES, ("t", "degc"), ("p", "kpa"))),
}
"""Name of a streamed output to its number in register 6, and its fields with their units."""
SHAPES: Mapping[str, bytes] = {
    "deg": b"%+08.3f",
    "gauss": b"%+08.4f",
    "mps2": b"%+07.3f",
    "radps": b"%+010.6f",
    "degc": b"%+05.1f",
    "kpa": b"%+08.3f",
}
"""How the unit writes a field: sign and leading zeros."""
LINE_BYTES: Mapping[str, int] = {"deg": 9, "gauss": 9, "mps2": 8, "radps": 11, "degc": 6, "kpa": 9}
"""Longest field with its comma, as seen on the wire."""

ERRORS: Mapping[int, str] = {
    1: "hard fault, it restarts",
    2: "its input buffer overflowed",
    3: "invalid checksum",
    4: "invalid command",
    5: "not enough parameters",
    6: "too many parameters",
    7: "invalid parameter",
    NO_SUCH_REGISTER: "invalid register",
    9: "unauthorised access",
    10: "watchdog reset",
    11: "its output buffer overflowed",
    12: "the baud rate is too low for this output and rate",
    255: "its error buffer overflowed",
}

_MESSAGE = re.compile(rb"\$(VN[A-Z]{3}(?:,[ -)+-~]*)?)\*([0-9A-F]{2}|XX)\r?\n?")


def checksum(payload: bytes) -> int:
    """Return the XOR of all bytes between ``$`` and ``*``."""
    return reduce(xor, payload, 0)


def message(payload: bytes) -> bytes:
    """Return a whole line around ``payload``."""
    return b"$%s*%02X\r\n" % (payload, checksum(payload))


def parse_message(line: bytes, *, accept_bypass: bool = False) -> list[str]:
    """Return the comma separated parts of a line whose checksum holds, the name first.

    ``accept_bypass``: ``*XX`` stands for any checksum (to the unit, never from it). Raises: DeviceNonsense.
    """
    match = _MESSAGE.fullmatch(line)
    if match is None:
        raise DeviceNonsense("the unit writes $VN…*XX")
    if match[2] == b"XX":
        if not accept_bypass:
            raise DeviceNonsense("the unit's own lines have a checksum")
    elif int(match[2], 16) != checksum(match[1]):
        raise DeviceNonsense(f"the checksum is {checksum(match[1]):02X}, the line says {match[2].decode('ascii')}")
    return match[1].decode("ascii").split(",")


def parse_error(parts: list[str]) -> str | None:
    """Return what a ``VNERR`` line tells, None for any other. The code is hexadecimal."""
    if parts[0] != "VNERR":
        return None
    try:
        code = int(parts[1], 16)
    except (IndexError, ValueError):
        return "an error without a code"
    return ERRORS.get(code, f"error {code}")


def setup_words(replies: Mapping[int, str]) -> tuple[str, ...]:
    """Return what the registers :data:`SETUP` do to what is measured, with their content where they do something.

    ``replies``: the comma separated fields of each register that the unit has. The words are as many whatever the
    registers hold, and no word has a comma followed by a space: two setups differ in a word, never in their number.
    Raises: DeviceNonsense naming a register whose fields are no numbers.
    """
    numbers = {register: _numbers(register, reply) for register, reply in replies.items()}
    raw = {register: f"register {register}: {reply.replace(',', ' ')}" for register, reply in replies.items()}
    compensating = [raw[n] for n in COMPENSATION if numbers.get(n, NO_COMPENSATION) != NO_COMPENSATION]
    iron = numbers.get(HARD_SOFT_IRON, (0.0, NOT_APPLIED))
    is_rotated = numbers.get(ROTATION, NO_ROTATION) != NO_ROTATION
    filters = _filters(numbers.get(FILTERING, (0.0,) * 2 * len(FILTERED)))
    return (
        f"user compensation ({'; '.join(compensating)})" if compensating else "no user compensation",
        f"frame rotated ({raw[ROTATION]}; {_HOLDS})" if is_rotated else "no rotation of the frame",
        f"filter on {filters} ({raw[FILTERING]}; {_HOLDS})" if filters else _idle("no filter", raw.get(FILTERING)),
        _idle(
            "no hard and soft iron in real time"
            if iron[1:2] == (NOT_APPLIED,)
            else "hard and soft iron applied in real time",
            raw.get(HARD_SOFT_IRON),
        ),
        _idle("attitude by reference vectors", raw.get(REFERENCE_VECTORS)),
    )


_HOLDS = "the calibration holds with it only"


def _idle(words: str, raw: str | None) -> str:
    return words if raw is None else f"{words} ({raw})"


def _filters(numbers: tuple[float, ...]) -> str:
    """Return the quantities that are averaged and over how many samples; of unknown fields, that they are unknown."""
    if len(numbers) != 2 * len(FILTERED):
        return "unknown quantities"
    windows, modes = numbers[: len(FILTERED)], numbers[len(FILTERED) :]
    return " and ".join(
        f"{name} over {window:g} samples"
        for name, window, mode in zip(FILTERED, windows, modes, strict=True)
        if window > 1.0 and mode
    )


def _numbers(register: int, reply: str) -> tuple[float, ...]:
    try:
        return tuple(map(float, reply.split(",")))
    except ValueError as error:
        raise DeviceNonsense(f"register {register}: {reply!r} are no numbers") from error


def row_pattern(output: str) -> re.Pattern[bytes]:
    """Return the pattern of one whole streamed line."""
    fields = len(OUTPUTS[output][1])
    return re.compile(rb"\%s%s(?:,%s){%d}\*[0-9A-F]{2}\r?\n" % (HEAD, output.encode("ascii"), NUMBER, fields))


def parse_rows(piece: bytes, output: str, pattern: re.Pattern[bytes]) -> Rows:
    """Parse whole lines of a streamed output to their numbers; ``pattern`` is its :func:`row_pattern`."""
    header = b"%s%s," % (HEAD, output.encode("ascii"))
    return parse_lines(
        piece,
        pattern,
        len(OUTPUTS[output][1]),
        lambda lines: re.sub(rb"\*..\r?\n", b"\n", lines).replace(header, b""),
        lambda lines: checksums_hold(lines, b"$"),
    )


def format_row(output: str, values: tuple[float, ...]) -> bytes:
    """Return a streamed line as the unit writes it."""
    fields = OUTPUTS[output][1]
    texts = (SHAPES[unit] % value for (_, unit), value in zip(fields, values, strict=True))
    return message(b"VN%s,%s" % (output.encode("ascii"), b",".join(texts)))


def line_bytes(output: str) -> int:
    """Return the longest streamed line of an output."""
    return len(b"$VNYMR*00\r\n") + sum(LINE_BYTES[unit] for _, unit in OUTPUTS[output][1])
