"""The person at the terminal as a line of bytes: prompts go to standard error, answers come from standard input.

Where standard input is no terminal nobody can answer, so such a line does not open.
"""

import os
import select
import sys
from typing import TextIO

from rig.clock import Clock
from rig.errors import LinkClosed, LinkLost, RequestRefused

TERMINAL = "terminal"
"""The port's name in a rig file."""
_READ_SIZE = 4096


class TerminalStream:
    """A :class:`rig.link.byte_stream.ByteStream`. Answers come by whole lines, as the terminal edits them."""

    def __init__(self, clock: Clock, typed: TextIO | None = None, shown: TextIO | None = None) -> None:
        """Take the terminal. Raises: RequestRefused where ``typed`` (standard input) is none."""
        self.name = TERMINAL
        self.clock = clock
        self._typed = sys.stdin if typed is None else typed
        self._shown = sys.stderr if shown is None else shown
        self._is_closed = False
        if os.name == "nt":
            raise RequestRefused(
                "terminal: an axis is set by hand (driver manual), and a console of Windows cannot be listened to for a"
                " while; nothing was opened; run the command under WSL or on another system"
            )
        if self._typed.closed or not self._typed.isatty():
            raise RequestRefused(
                "terminal: an axis is set by hand (driver manual), but standard input is no terminal, so nobody can"
                " answer; nothing was opened; run the command in a terminal"
            )

    def write(self, data: bytes) -> None:
        self._require_open()
        self._shown.write(data.decode("utf-8"))
        self._shown.flush()

    def read(self, deadline_s: float) -> bytes:
        self._require_open()
        descriptor = self._typed.fileno()
        left_s = max(deadline_s - self.clock.monotonic_s(), 0.0)
        ready, _, _ = select.select([descriptor], [], [], left_s)
        return self._taken(descriptor) if ready else b""

    def discard_input(self) -> bytes:
        discarded = b""
        while more := self.read(self.clock.monotonic_s()):
            discarded += more
        return discarded

    def close(self) -> None:
        """Close the stream; the terminal is left as it is."""
        self._is_closed = True

    def _taken(self, descriptor: int) -> bytes:
        try:
            data = os.read(descriptor, _READ_SIZE)
        except OSError as error:
            raise LinkLost(f"terminal: standard input broke ({error}); an axis may stand anywhere; home it") from error
        if not data:
            raise LinkLost("terminal: standard input was closed; an axis may stand anywhere; home it")
        return data

    def _require_open(self) -> None:
        if self._is_closed:
            raise LinkClosed("terminal: used after it was closed; nothing was asked; open it again")
