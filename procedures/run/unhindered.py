"""Streams on which nothing raises, and one that keeps no run waiting.

A terminal that is held (Ctrl-S), a pager, a link that hangs: none of them is gone, and none takes anything for hours.
Whoever writes to it stands still, with an axis turning perhaps. So a thread of its own writes, and what is shown next
takes the place of what nobody took.
"""

import io
import os
import sys
from collections import deque
from contextlib import suppress
from threading import Condition, Thread
from typing import Final, TextIO

_MOST_BYTES: Final = 65_536
"""That wait for a stream: with more, all of it gives way to what is newest."""
_PATIENCE_S: Final = 0.2
"""That a flush waits for a stream which has taken everything so far."""


class Unbreakable(io.TextIOBase):
    """A stream on which nothing raises once the terminal behind it has gone away."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__()
        self._stream = stream

    def write(self, text: str) -> int:
        with suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError, ValueError):
            self._stream.flush()

    def isatty(self) -> bool:
        return self._stream.isatty()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return self._stream.encoding or "utf-8"

    def fileno(self) -> int:
        return self._stream.fileno()


class Unhindered(Unbreakable):
    """The same, which waits for nobody either; where there is no file behind the stream, it is written to at once."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__(stream)
        self._handle = _handle_of(stream)
        self._waiting = deque[bytes]()
        self._changed = Condition()
        self._is_held = False
        if self._handle is not None:
            Thread(target=self._write_what_waits, name="what is shown", daemon=True).start()

    def write(self, text: str) -> int:
        if self._handle is None or not text:
            return super().write(text)
        data = text.encode(self.encoding, "backslashreplace")
        with self._changed:
            if sum(map(len, self._waiting)) + len(data) > _MOST_BYTES:
                self._waiting.clear()
            self._waiting.append(data)
            self._changed.notify_all()
        return len(text)

    def flush(self) -> None:
        """Wait until everything is written, or it is seen that the stream is held."""
        if self._handle is None:
            super().flush()
            return
        with self._changed:
            if not self._is_held:
                self._is_held = not self._changed.wait_for(lambda: not self._waiting, _PATIENCE_S)

    def _write_what_waits(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting)
                data = self._waiting[0]
            self._write_whole(data)
            with self._changed:
                if self._waiting and self._waiting[0] is data:
                    self._waiting.popleft()
                if not self._waiting:
                    self._is_held = False
                    self._changed.notify_all()

    def _write_whole(self, data: bytes) -> None:
        """Write with no lock held, past the stream's own buffer, whose lock a held stream would keep."""
        assert self._handle is not None
        with suppress(OSError):  # a stream that is gone takes nothing, and hinders nobody
            while data:
                data = data[os.write(self._handle, data) :]


def _handle_of(stream: TextIO) -> int | None:
    """Return the number of the file behind a stream; None where there is none, and on Windows."""
    if sys.platform == "win32":
        return None
    try:
        stream.flush()
        return stream.fileno()
    except (OSError, ValueError, AttributeError):
        return None
