"""Real ports with a twin behind each: a TCP listener on the loopback interface, or a pseudo-terminal.

A port has one client at a time, as a serial line has; a client may go and another come, the twin behind stays as it
was. Bytes that a client left unread are lost with it on TCP. A UART drops what nobody takes, and so does a port here:
what its client (or a pseudo-terminal that nobody has open) has not taken for a while is thrown away, with what the
terminal still holds.

A twin whose line is gone (LinkLost) hangs up: the TCP client is sent away, and so is every other until the line is
back; a pseudo-terminal vanishes and comes back under another node name, which its link then points to.
"""

import os
import selectors
import socket
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from rig.errors import LinkLost, RequestRefused
from rig.system_parts import module_here
from rig.twins.twin import Twin

_CHUNK = 65536


class Port(Protocol):
    """Where a twin is reachable."""

    twin: Twin
    address: str
    """As a rig file names the port."""

    @property
    def is_congested(self) -> bool:
        """Bytes wait because the client does not take them."""

    def register(self, selector: selectors.BaseSelector) -> None: ...

    def ready(self, selector: selectors.BaseSelector, file: object, now_s: float) -> None:
        """Take what came at ``file``."""

    def flush(self, now_s: float, patience_s: float) -> None:
        """Send what the twin has due by now; drop it where nothing was taken for ``patience_s``."""

    def close(self) -> None: ...


@dataclass
class TcpPort:
    """A listening socket on a free port of the loopback interface."""

    twin: Twin
    host: str = "127.0.0.1"
    address: str = field(init=False)

    def __post_init__(self) -> None:
        self._taken_s = float("-inf")
        self._listener = socket.create_server((self.host, 0))
        self._listener.setblocking(False)
        self._client: socket.socket | None = None
        self._unsent = b""
        self.address = f"socket://{self.host}:{self._listener.getsockname()[1]}"

    @property
    def is_congested(self) -> bool:
        return bool(self._unsent)

    def register(self, selector: selectors.BaseSelector) -> None:
        selector.register(self._listener, selectors.EVENT_READ, self)
        self._selector = selector

    def ready(self, selector: selectors.BaseSelector, file: object, now_s: float) -> None:
        if file is self._listener:
            self._accept(selector)
            return
        if self._client is None or file is not self._client:
            return
        try:
            data = self._client.recv(_CHUNK)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        try:
            if data:
                self.twin.receive(data, now_s)
            else:
                self._part()
        except LinkLost:
            self._part()

    def flush(self, now_s: float, patience_s: float) -> None:
        try:
            due = self.twin.transmit(now_s)
        except LinkLost:
            self._part()
            return
        if self._client is None:
            return
        self._unsent += due
        if self._unsent:
            try:
                self._unsent = self._unsent[self._client.send(self._unsent) :]
                self._taken_s = now_s
            except BlockingIOError:
                if now_s - self._taken_s > patience_s:
                    self._unsent = b""
            except OSError:
                self._unsent = b""  # the client is gone; its socket will say so when it is read

    def close(self) -> None:
        self._listener.close()
        if self._client is not None:
            self._client.close()

    def _accept(self, selector: selectors.BaseSelector) -> None:
        client, _ = self._listener.accept()
        if self._client is not None:
            client.close()  # taken: a line has two ends
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client
        selector.register(client, selectors.EVENT_READ, self)

    def _part(self) -> None:
        if self._client is not None:
            self._selector.unregister(self._client)
            self._client.close()
        self._client, self._unsent = None, b""


@dataclass
class PtyPort:
    """A pseudo-terminal. It enforces neither baud rate nor parity. ``link``: a name that outlives the node."""

    twin: Twin
    link: Path | None = None
    address: str = field(init=False)

    def __post_init__(self) -> None:
        self._taken_s = float("-inf")
        self._master, self._slave, self._node = _open_pty()
        self._unsent = b""
        self._is_away = False
        self._show()
        self.address = self._node if self.link is None else str(self.link)

    @property
    def is_congested(self) -> bool:
        return bool(self._unsent)

    def register(self, selector: selectors.BaseSelector) -> None:
        selector.register(self._master, selectors.EVENT_READ, self)
        self._selector = selector

    def ready(self, selector: selectors.BaseSelector, file: object, now_s: float) -> None:  # noqa: ARG002 one file
        try:
            self.twin.receive(os.read(self._master, _CHUNK), now_s)
        except BlockingIOError:
            return
        except LinkLost:
            self._hang_up()

    def flush(self, now_s: float, patience_s: float) -> None:
        try:
            self._unsent += self.twin.transmit(now_s)
        except LinkLost:
            self._hang_up()
            return
        if self._is_away:
            self._is_away = False
            self._show()
        if self._unsent:
            try:
                self._unsent = self._unsent[os.write(self._master, self._unsent) :]
                self._taken_s = now_s
            except BlockingIOError:
                if now_s - self._taken_s > patience_s:
                    # What waits here, and what waits unread at the other end.
                    self._unsent = b""
                    if terminals := module_here("termios"):
                        terminals.tcflush(self._slave, terminals.TCIFLUSH)

    def close(self) -> None:
        self._hide()
        os.close(self._master)
        os.close(self._slave)

    def _hang_up(self) -> None:
        """Open the node that will be there next before the old one goes: so it has another name."""
        if self._is_away:
            return
        self._is_away = True
        self._hide()
        gone, (self._master, self._slave, self._node) = (self._master, self._slave), _open_pty()
        self._selector.unregister(gone[0])
        for file in gone:
            os.close(file)
        self._selector.register(self._master, selectors.EVENT_READ, self)
        self._unsent = b""

    def _show(self) -> None:
        if self.link is not None:
            self.link.symlink_to(self._node)

    def _hide(self) -> None:
        if self.link is not None:
            self.link.unlink(missing_ok=True)


def _open_pty() -> tuple[int, int, str]:
    """Return both ends and the path of the slave, which stays open here, so a client may go and come."""
    raw = module_here("tty")
    if sys.platform != "win32" and raw is not None and hasattr(os, "openpty"):
        master, slave = os.openpty()
        raw.setraw(slave)
        os.set_blocking(master, False)
        return master, slave, os.ttyname(slave)
    raise RequestRefused(
        "pseudo-terminals: this system has none; nothing was served; leave --pty out: TCP ports serve the same"
    )
