"""SCPI as data-acquisition units speak it: channel lists, definite blocks, numbers, the error queue.

A message is ASCII and ends with a line feed. Headers have a short and a long form, the node ``SENSe`` may be left
out, and after a semicolon a header goes on where the one before it stood unless it starts with a colon.

Source: 34970A user's guide, remote interface reference (parameter types; ``ROUTe:SCAN?`` with its definite blocks);
SCPI-99 volume 1 (headers, compound messages); the overload ±9.9E+37 from the 34970A/34972A command reference.
"""

import re
from collections.abc import Iterator, Sequence

from rig.errors import DeviceNonsense

OVERLOAD = 9.9e37
"""What a reading says instead of a value outside its range, with the sign of the input."""
LARGEST_READING = 1.0e30
"""Beyond this a reading is the overload mark, or the 9.91E37 of a reading that does not exist."""
NO_ERROR = (0, "No error")
LONGEST_LIST = 4000
"""More channels than any unit holds: a list that asks for more is a mistake."""

_NUMBER = re.compile(rb"[ ]*[+-]?\d{1,12}(?:\.\d{0,16})?(?:[Ee][+-]?\d{1,2})?[ ]*")
_READING = re.compile(rb"[ ]*[+-]?(?:\d\.\d{4,12}E[+-]\d\d|9\.9[Ee]\+?37)[ ]*")
"""Two digits of exponent always: a reading that lost a character does not pass for another. The overload mark of a
Keithley is short (2000 user's manual, p. 5-28: ``+9.9e37``)."""
_WHOLE = re.compile(rb"[ ]*[+-]?\d{1,9}[ ]*")
_ERROR = re.compile(rb'[ ]*([+-]?\d{1,5})[ ]*,[ ]*(?:"([ !#-~]*)"|([A-Za-z][ !#-~]*))[ ]*')
"""A Keithley's manual prints the text without quotes."""
_CHANNELS = re.compile(r"\(@\s*((?:\d{3,4}(?::\d{3,4})?(?:\s*,\s*\d{3,4}(?::\d{3,4})?)*)?)\s*\)")


def channel_list(channels: Sequence[int]) -> bytes:
    """Return a list such as ``(@101,103)``, every channel by itself."""
    return b"(@%s)" % b",".join(b"%d" % channel for channel in channels)


def parse_channel_list(text: str) -> tuple[int, ...]:
    """Parse ``(@101:103,205)`` to its channels; ``(@)`` is empty. Raises: DeviceNonsense."""
    match = _CHANNELS.fullmatch(text.strip())
    if match is None:
        raise DeviceNonsense(f"{text[:40]!r} is no channel list such as (@101:103)")
    channels: list[int] = []
    for part in filter(None, match[1].split(",")):
        first, _, last = part.strip().partition(":")
        span = range(int(first), int(last or first) + 1)
        if not span or len(channels) + len(span) > LONGEST_LIST:
            raise DeviceNonsense(f"{part} is no range of channels")
        channels += span
    return tuple(channels)


def format_block(content: bytes) -> bytes:
    """Format a definite block: ``#``, the number of digits, the length, the content."""
    length = b"%d" % len(content)
    return b"#%d%s%s" % (len(length), length, content)


def parse_block(line: bytes) -> bytes:
    """Return the content of a definite block that is the whole line. Raises: DeviceNonsense."""
    digits = line[1:2]
    if line[:1] != b"#" or not (digits.isdigit() and digits != b"0"):
        raise DeviceNonsense("a definite block starts with # and a digit from 1 to 9")
    start = 2 + int(digits)
    length = line[2:start]
    if len(length) < int(digits) or not length.isdigit() or len(line) - start != int(length):
        raise DeviceNonsense(f"a definite block of {length.decode('latin-1')} bytes holds {len(line) - start}")
    return line[start:]


def parse_scan_list(line: bytes) -> tuple[int, ...]:
    """Parse ``ROUT:SCAN?``: a definite block with a channel list. Raises: DeviceNonsense."""
    return parse_channel_list(parse_block(line).decode("latin-1"))


def parse_number(line: bytes) -> float:
    """Parse one decimal number. Raises: DeviceNonsense."""
    if _NUMBER.fullmatch(line) is None:
        raise DeviceNonsense("the unit answers with one decimal number")
    return float(line)


def parse_whole(line: bytes) -> int:
    """Parse one whole number such as ``+20``. Raises: DeviceNonsense."""
    if _WHOLE.fullmatch(line) is None:
        raise DeviceNonsense("the unit answers with one whole number")
    return int(line)


def parse_readings(line: bytes) -> tuple[float, ...]:
    """Parse readings and commas. Raises: DeviceNonsense."""
    return _readings(line.split(b","))


def parse_named_readings(line: bytes) -> tuple[tuple[float, int], ...]:
    """Parse readings each followed by its channel (``FORM:READ:CHAN ON``). Raises: DeviceNonsense."""
    parts = line.split(b",")
    if len(parts) % 2:
        raise DeviceNonsense(f"got {len(parts)} fields, readings and channels come in pairs")
    return tuple(zip(_readings(parts[::2]), map(parse_whole, parts[1::2]), strict=True))


def format_reading(value: float) -> bytes:
    """Format a reading as the unit writes it: ``+2.61920000E+01``."""
    return b"%+.8E" % (value if abs(value) >= 1.0e-98 else 0.0)


def is_harmful(number: int, text: str) -> bool:
    """Return whether an error speaks of the unit itself and not of what it was told.

    SCPI-99 vol. 2, 21.8.11: -310 to -313 are of system and memory, -330 and -340 of self-test and calibration. Of the
    makers' own numbers 600 to 799 are self-tests and calibration constants (34401A, Truevolt, 34970A), and whatever
    names a calibration.
    """
    return -313 <= number <= -310 or -349 <= number <= -330 or 600 <= number < 800 or "calibration" in text.lower()


def parse_error(line: bytes) -> tuple[int, str]:
    """Parse an entry of the error queue, oldest first: number and text, 0 when it is empty.

    Raises: DeviceNonsense.
    """
    match = _ERROR.fullmatch(line)
    if match is None:
        raise DeviceNonsense('the unit answers SYST:ERR? with a number and a text, such as +0,"No error"')
    return int(match[1]), (match[2] if match[3] is None else match[3]).decode("ascii")


def format_error(number: int, text: str) -> bytes:
    return b'%+d,"%s"' % (number, text.encode("ascii"))


def parse_identity(line: bytes) -> tuple[str, str, str, str]:
    """Parse ``*IDN?``, or the card in a slot: maker, model, serial number, firmware.

    Raises: DeviceNonsense.
    """
    parts = tuple(part.strip() for part in line.decode("latin-1").split(","))
    if len(parts) != 4 or not all(part.isascii() and part.isprintable() for part in parts) or not parts[1]:
        raise DeviceNonsense("the unit answers with maker, model, serial number and firmware")
    return parts[0], parts[1], parts[2], parts[3]


def split_message(message: str) -> Iterator[tuple[str, str]]:
    """Yield header in full (upper case, no leading colon) and parameters of every command of a compound message."""
    path = ""
    for text in _units(message):
        header, _, parameters = text.strip().partition(" ")
        header = header.upper()
        if header.startswith("*"):
            yield header, parameters.strip()
        elif header:
            full = header[1:] if header.startswith(":") else path + header
            path = full[: full.rfind(":") + 1]
            yield full, parameters.strip()


def _readings(texts: Sequence[bytes]) -> tuple[float, ...]:
    """Positive readings have their plus sign in all of an answer or nowhere: the 34980A's guide prints none."""
    if not all(map(_READING.fullmatch, texts)):
        raise DeviceNonsense("the unit writes a reading as +2.61920000E+01")
    if len({text.strip()[:1] == b"+" for text in texts if text.strip()[:1] != b"-"}) > 1:
        raise DeviceNonsense("some readings have a plus sign and some have none: a sign was lost")
    return tuple(map(float, texts))


def _units(message: str) -> list[str]:
    """Split at semicolons that stand in no string."""
    return re.findall(r"""(?:"[^"]*"|'[^']*'|[^;"'])+""", message)
