"""The one shape every port has: bytes out, bytes in by a deadline, and a name for messages.

A stream knows no message and no device. It carries the clock its deadlines are read from: the machine's clock for
a real port (always unscaled), the rig's own clock in memory. :func:`rig.link.ports.open_stream` opens real ports;
it stands apart so that a driver, which knows this protocol, imports no port.
"""

import re
from typing import Protocol

from rig.clock import Clock


class ByteStream(Protocol):
    """A two-way line of bytes."""

    name: str
    """The port as the file names it, for messages."""
    clock: Clock
    """Deadlines of :meth:`read` are in this clock's ``monotonic_s``."""

    def write(self, data: bytes) -> None:
        """Send all of ``data``. Raises: LinkLost, LinkClosed."""

    def read(self, deadline_s: float) -> bytes:
        """Read at least one byte as soon as there is one, or ``b""`` at the deadline.

        Raises: LinkLost, LinkClosed.
        """

    def discard_input(self) -> bytes:
        """Take whatever is waiting without waiting for more. Raises: LinkLost, LinkClosed."""

    def close(self) -> None:
        """Give the port back; closing twice is harmless."""


_ERROR_NUMBER = re.compile(r"\[Errno -?\d+\] ")


def cause_of(error: object) -> str:
    """Return what the system says of a broken line, without its numbers."""
    return _ERROR_NUMBER.sub("", str(error))


def named(url: str, owner: str) -> str:
    """Return what messages call a line: its device and its port, or the port alone."""
    return f"{owner} at {url}" if owner else url
