"""Serial ports, pseudo-terminals and ``rfc2217://`` through pyserial.

An unplugged port shows itself in three ways (SerialException, bare OSError, termios.error) and ``is_open`` stays
true: all three become :class:`rig.errors.LinkLost`. ``exclusive`` is an advisory lock: it keeps a second calrig out,
not every program.
"""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import serial

from rig.clock import WAIT_SLICE_S, Clock
from rig.errors import LinkClosed, LinkLost, RequestRefused, RigBusy
from rig.link.byte_stream import cause_of, named
from rig.system_parts import module_here

if TYPE_CHECKING:
    import serial

WRITE_TIMEOUT_S = 5.0
_PSEUDO_TERMINALS = Path("/dev/pts")


def _port_errors() -> tuple[type[Exception], ...]:
    terminals = module_here("termios")
    return (OSError,) if terminals is None else (OSError, terminals.error)


PORT_ERRORS = _port_errors()
"""Every way in which a broken port shows itself; pyserial's SerialException is an OSError."""


@dataclass(frozen=True, slots=True)
class LineSettings:
    """What a UART must agree on. A pseudo-terminal enforces none of it."""

    baud_rate: int = 9600
    data_bits: int = 8
    parity: str = "N"
    stop_bits: float = 1.0
    rts_cts: bool = False
    dtr_low: bool = False
    rts_low: bool = False
    """Whether the line is low from the opening on; the kernel raises it for a moment all the same."""


class SerialStream:
    """A device path or ``rfc2217://host:port``."""

    def __init__(self, url: str, clock: Clock, line: LineSettings, owner: str = "") -> None:
        self.name = named(url, owner)
        self.clock = clock
        self._port = _open(url, line, self.name)
        self._is_closed = False

    def write(self, data: bytes) -> None:
        self._require_open()
        with _losses(self.name):
            self._port.write(data)

    def read(self, deadline_s: float) -> bytes:
        self._require_open()
        while True:
            left_s = deadline_s - self.clock.monotonic_s()
            if left_s <= 0.0:
                return self.discard_input()
            with _losses(self.name):
                timeout_s = min(left_s, WAIT_SLICE_S)
                if self._port.timeout != timeout_s:  # setting it makes pyserial configure the port again
                    self._port.timeout = timeout_s
                if first := self._port.read(1):
                    return bytes(first) + bytes(self._port.read(self._port.in_waiting))

    def discard_input(self) -> bytes:
        self._require_open()
        with _losses(self.name):
            return bytes(self._port.read(waiting)) if (waiting := self._port.in_waiting) else b""

    def descriptor(self) -> int:
        """Return what the system knows the line by: the device, or the connection of ``rfc2217://``."""
        connection = getattr(self._port, "_socket", None)
        number: int = self._port.fileno() if connection is None else connection.fileno()
        return number

    def close(self) -> None:
        self._is_closed = True
        with _losses(self.name):
            self._port.close()

    def _require_open(self) -> None:
        if self._is_closed:
            raise LinkClosed(f"{self.name}: used after it was closed; nothing was sent; open it again")


def _open(url: str, line: LineSettings, name: str) -> serial.Serial:
    is_device = "://" not in url
    if is_device and Path(url).resolve().is_relative_to(_PSEUDO_TERMINALS):
        line = replace(line, parity="N")  # it has no parity, and refuses to be configured with one
    try:
        port = serial.serial_for_url(
            url,
            do_not_open=True,
            baudrate=line.baud_rate,
            bytesize=line.data_bits,
            parity=line.parity,
            stopbits=line.stop_bits,
            rtscts=line.rts_cts,
            timeout=WAIT_SLICE_S,
            write_timeout=WRITE_TIMEOUT_S,
            **({"exclusive": True} if is_device else {}),
        )
        if line.dtr_low:
            port.dtr = False
        if line.rts_low:
            port.rts = False
        port.open()
        return port
    except ValueError as error:
        raise RequestRefused(f"{name}: not a port or not its settings: {error}; nothing was opened") from error
    except PORT_ERRORS as error:
        if getattr(error, "errno", None) in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK):
            raise RigBusy(f"{name}: another program has this port open; nothing was opened; close it there") from error
        raise LinkLost(
            f"{name}: cannot be opened: {_why(error)}; nothing was sent; check the cable and the path"
        ) from error


def _why(error: Exception) -> str:
    """Return the cause of an error once: pyserial says the number, the path and the cause twice over."""
    if getattr(error, "errno", None) == errno.ENOENT:
        return (
            "no such port now: it is unplugged, or was plugged in again under another name"
            " (`calrig devices` lists what is there)"
        )
    return cause_of(error)


@contextmanager
def _losses(name: str) -> Iterator[None]:
    try:
        yield
    except PORT_ERRORS as error:
        raise LinkLost(
            f"{name}: the port is gone or broken: {_why(error)}; what was sent last is in doubt;"
            " check cable and adapter"
        ) from error
