"""Prologix GPIB-USB and GPIB-ETHERNET: bytes between host and adapter.

A host line ends with an un-escaped CR or LF. A line that starts with an un-escaped ``++`` is for the adapter; any
other goes to the addressed instrument, where CR, LF, ESC and ``+`` must each follow an ESC. Answers of the adapter
end with CR LF; what an instrument says passes unmodified.

Source: Prologix GPIB-USB controller manual 6.107, pages 6 to 15.
"""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from rig.errors import DeviceNonsense

ESCAPE = b"\x1b"
READ_TO_EOI = b"++read eoi\n"
VERSION = b"++ver\n"
REAL_VERSION = b"++ver real\n"
"""What an AR488 answers with its own name even where it was given another."""
PROLOGIX = "Prologix GPIB-USB Controller version 6.107"
CLONE = "AR488"
RESET = b"++rst\n"
NO_AUTO = b"++auto 0\n"
INTERFACE_CLEAR = b"++ifc\n"
CLEAR = b"++clr\n"
UNRECOGNIZED = b"Unrecognized command"

TIMEOUT_RANGE_MS = (1, 3000)
"""``++read_tmo_ms``: time since the last character, also for ``++spoll``. The adapter refuses more."""

SETTINGS: Mapping[str, int] = MappingProxyType(
    {
        "mode": 1,  # controller
        "auto": 0,  # an instrument talks only when it is told to
        "eoi": 1,  # assert EOI with the last byte to an instrument
        "eos": 3,  # and nothing behind it: a line feed makes a 3458A hold the bus until its command has ended
        "eot_enable": 0,  # add nothing where an instrument asserts EOI
        "eot_char": 10,
        "read_tmo_ms": TIMEOUT_RANGE_MS[1],
    }
)
"""All settings the adapter may remember from somebody else, and what we need. ``savecfg 0`` goes first."""

_SPECIAL = re.compile(rb"[\r\n\x1b+]")
_ESCAPED = re.compile(rb"\x1b([\s\S])|\+")
_HOST_LINE = re.compile(rb"((?:\x1b[\s\S]|[^\x1b\r\n])*)[\r\n]")
_NUMBER = re.compile(rb"\d{1,5}")


class HostLine(NamedTuple):
    """One line from the host, unescaped."""

    for_adapter: bool
    text: bytes


def setting(name: str, value: int) -> bytes:
    return f"++{name} {value}\n".encode("ascii")


def setting_query(name: str) -> bytes:
    return f"++{name}\n".encode("ascii")


def address(primary: int) -> bytes:
    return setting("addr", primary)


def serial_poll(primary: int) -> bytes:
    return f"++spoll {primary}\n".encode("ascii")


def message(text: bytes) -> bytes:
    """Return the host line that carries ``text`` to the addressed instrument."""
    return _SPECIAL.sub(b"\x1b\\g<0>", text) + b"\n"


def parse_number(line: bytes) -> int:
    """Return the answer to a setting query or a serial poll. Raises: DeviceNonsense."""
    if _NUMBER.fullmatch(line) is None:
        raise DeviceNonsense("the adapter answers with a decimal number")
    return int(line)


def parse_status_byte(line: bytes) -> int:
    """Return the answer to ``++spoll``, 0 to 255. Raises: DeviceNonsense."""
    status = parse_number(line)
    if status > 255:
        raise DeviceNonsense("a status byte is 0 to 255")
    return status


def parse_version(line: bytes) -> str:
    """Parse a version such as ``Prologix GPIB-USB Controller version 6.107``. Raises: DeviceNonsense."""
    if b"GPIB" not in line or not line.isascii() or not line.decode("ascii").isprintable():
        raise DeviceNonsense("a GPIB adapter names itself with the word GPIB")
    return line.decode("ascii")


def parse_real_version(line: bytes) -> str:
    """Whatever the adapter answers: what it does not know it says it does not. Raises: DeviceNonsense."""
    if not line.isascii() or not line.decode("ascii").isprintable():
        raise DeviceNonsense("the adapter answers in ASCII")
    return line.decode("ascii")


def split_host_lines(received: bytes) -> tuple[list[HostLine], bytes]:
    """Return what the adapter sees: complete lines, and the rest that has no end yet.

    Empty lines are dropped.

    A ``+`` without an ESC inside a message is lost, as the manual warns.
    """
    lines, end = [], 0
    while match := _HOST_LINE.match(received, end):
        raw, end = match[1], match.end()
        if raw.startswith(b"++"):
            lines.append(HostLine(True, raw[2:]))
        elif raw:
            lines.append(HostLine(False, _unescaped(raw)))
    return lines, received[end:]


def _unescaped(raw: bytes) -> bytes:
    if ESCAPE not in raw and b"+" not in raw:
        return raw
    return _ESCAPED.sub(lambda match: match[1] or b"", raw)
