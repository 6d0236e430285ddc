"""How a port is written in a file: the forms that can be opened, and which port two of them are. Nothing is opened."""

import re
from pathlib import Path
from typing import Final

from rig.errors import RequestRefused
from rig.link.socket_stream import split_address
from rig.link.terminal_stream import TERMINAL

OVER_TCP: Final = ("socket://", "rfc2217://")
OF_PYSERIAL: Final = ("alt://", "cp2110://", "hwgrep://", "loop://", "spy://")
"""Schemes of its ``serial_for_url`` beside these. Source: pyserial's documentation, "URL Handlers"."""
FORMS: Final = (
    'allowed are "twin", the whole path of a device such as /dev/serial/by-id/… (COM3 on Windows), socket://host:port, '
    'rfc2217://host:port, and "terminal" for what a person does'
)
_WINDOWS_PORT = re.compile(r"(?:\\\\\.\\)?(COM\d+)", re.IGNORECASE)


def address_complaint(port: str) -> str:
    """Return why nothing can be reached by what a file says, as the end of a sentence; empty where something can."""
    if port == TERMINAL or port.startswith(("/", "\\\\", *OF_PYSERIAL)) or _WINDOWS_PORT.fullmatch(port):
        return ""
    for scheme in OVER_TCP:
        if port.startswith(scheme):
            return "" if _is_tcp(port.removeprefix(scheme)) else f"got {port!r}, no host and port; {FORMS}"
    return f"got {port!r}; {FORMS}"


def _is_tcp(address: str) -> bool:
    """Return whether it is ``host:port``; options of pyserial may stand behind."""
    try:
        split_address(re.split(r"[/?]", address, maxsplit=1)[0])
    except RequestRefused:
        return False
    return True


def canonical_port(port: str) -> str:
    """Return a port by one name: links to a device followed, host names in lower case."""
    if windows := _WINDOWS_PORT.fullmatch(port):
        return windows[1].upper()
    scheme, mark, rest = port.partition("://")
    return f"{scheme.lower()}{mark}{rest.lower()}" if mark else str(Path(port).resolve())
