"""Rows from a socket and answers to one: ``socket://host:port`` and ``udp://host:port`` beside files and pipes.

A datagram holds whole lines, in (a header first, then rows) and out (one JSON document a row, many a datagram). Nobody
acknowledges a datagram: what was lost on the way shows in the column time_s, of which missing samples are told.
"""

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import IO, Final, cast
from urllib.parse import urlsplit

from procedures.errors import RequestError

SCHEMES: Final = ("socket", "udp")
LARGEST_DATAGRAM: Final = 65_536
_SENT_BYTES: Final = 1_400
"""Of answers in a datagram: what passes an Ethernet whole."""
_PATIENCE_S: Final = 10.0


def is_line(text: str) -> bool:
    """Return whether a text is the address of a socket."""
    return text.partition("://")[0] in SCHEMES and "://" in text


def address_of(text: str) -> tuple[str, str, int]:
    """Return scheme, host and port. Raises: RequestError where the text is no such address."""
    try:
        parts = urlsplit(text)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if host is None or port is None or parts.scheme not in SCHEMES:
        raise RequestError(
            f"{text}: is no address: allowed are socket://HOST:PORT and udp://HOST:PORT, such as udp://127.0.0.1:5005"
        )
    return parts.scheme, host, port


@contextmanager
def opened_source(text: str) -> Iterator[IO[bytes]]:
    """Yield what rows are read from: a connection that is made, or a port that is listened at.

    Raises: RequestError where nobody answers or the port is taken.
    """
    scheme, host, port = address_of(text)
    try:
        if scheme == "socket":
            with socket.create_connection((host, port), timeout=_PATIENCE_S) as connection:
                connection.settimeout(None)
                with connection.makefile("rb") as source:
                    yield source
            return
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
            listening.bind((host, port))
            yield cast("IO[bytes]", Datagrams(listening))
    except OSError as error:
        raise RequestError(f"{text}: {error.strerror or error}; nothing was read") from None


@dataclass
class Datagrams:
    """Datagrams as one stream of lines; an empty one is its end."""

    listening: socket.socket

    def read1(self, _most: int) -> bytes:
        """Return what has arrived, whole lines."""
        arrived = self.listening.recv(LARGEST_DATAGRAM)
        return arrived if not arrived or arrived.endswith(b"\n") else arrived + b"\n"

    read = read1


@dataclass
class DatagramTarget:
    """A file that is sent: whole lines, as many as pass in one datagram."""

    sending: socket.socket
    to: tuple[str, int]
    _kept: bytes = field(default=b"", init=False)

    def write(self, content: bytes) -> int:
        """Keep what is to be sent."""
        self._kept += bytes(content)
        return len(content)

    def flush(self) -> None:
        """Send every whole line that is kept."""
        *lines, self._kept = self._kept.split(b"\n")
        datagram = b""
        for line in lines:
            if datagram and len(datagram) + len(line) >= _SENT_BYTES:
                self.sending.sendto(datagram, self.to)
                datagram = b""
            datagram += line + b"\n"
        if datagram:
            self.sending.sendto(datagram, self.to)


@contextmanager
def opened_target(text: str) -> Iterator[IO[bytes]]:
    """Yield what answers are written to. Raises: RequestError for another scheme or an address that cannot be."""
    scheme, host, port = address_of(text)
    if scheme != "udp":
        raise RequestError(f"--out {text}: answers go to udp://HOST:PORT, a file or standard output")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sending:
        target = DatagramTarget(sending, (host, port))
        try:
            yield cast("IO[bytes]", target)
            target.flush()
        except socket.gaierror as error:
            raise RequestError(f"--out {text}: {error.strerror}") from None
