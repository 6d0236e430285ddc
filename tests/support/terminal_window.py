"""A terminal window as a program sees one: a pseudo-terminal that is the program's controlling terminal, with an
emulator (pyte) on the other side that draws what is written and answers what is asked."""

import contextlib
import fcntl
import os
import select
import signal
import struct
import subprocess
import termios
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

import pyte
from signals import take_default_signals

from rig.clock import SystemClock

_CLOCK = SystemClock()


class _Screen(pyte.Screen):
    """Answers go back over the line, as a real terminal's do."""

    def __init__(self, columns: int, lines: int, answer: Callable[[bytes], None]) -> None:
        self.answer = answer
        super().__init__(columns, lines)

    def write_process_input(self, data: str) -> None:
        self.answer(data.encode())


def _without_a_size() -> dict[str, str]:
    """Our environment but for the size of another terminal, which test runners pass on to their workers."""
    return {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}


class TerminalWindow:
    """``command`` runs in it until :meth:`close`; a context manager."""

    def __init__(
        self, command: Sequence[str | Path], *, columns: int = 120, lines: int = 36, env: dict[str, str] | None = None
    ) -> None:
        self._master, slave = os.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))
        self.is_answering = True
        self._screen = _Screen(columns, lines, self._answer)
        self._stream = pyte.ByteStream(self._screen)
        self._lock = threading.Lock()
        self.process = subprocess.Popen(
            [str(part) for part in command],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            preexec_fn=_take_terminal,
            env={**_without_a_size(), "TERM": "xterm-256color", "LANG": "C.UTF-8", **(env or {})},
        )
        os.close(slave)
        self._is_open = True
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def type(self, text: str) -> None:
        """Keys as their bytes."""
        os.write(self._master, text.encode())

    @property
    def text(self) -> str:
        """What is on the screen now."""
        with self._lock:
            return "\n".join(line.rstrip() for line in self._screen.display)

    def wait_for(self, condition: Callable[[str], bool] | str, within_s: float = 20.0) -> str:
        """The screen when it shows a text or meets a condition."""
        deadline = _CLOCK.monotonic_s() + within_s
        while _CLOCK.monotonic_s() < deadline:
            is_over = self.process.poll() is not None and not self._reader.is_alive()
            text = self.text
            if (condition in text) if isinstance(condition, str) else condition(text):
                return text
            if is_over:
                break
            _CLOCK.sleep(0.02)
        raise AssertionError(f"not seen within {within_s} s: {condition!r}\n{self.text}")

    def wait_for_words(self, words: str) -> None:
        """Wait for words wherever the terminal wraps them: the length of a path before them must not matter."""
        self.wait_for(lambda text: "".join(words.split()) in "".join(text.split()))

    def hang_up(self) -> float:
        """Close the window, as a lost connection does; returns when, on the monotonic clock."""
        closed_s = _CLOCK.monotonic_s()
        self._close_master()
        return closed_s

    def freeze(self) -> None:
        """From now on it takes what is written and answers nothing, as a connection does that hangs."""
        self.is_answering = False

    def close(self) -> None:
        self._close_master()
        with contextlib.suppress(ProcessLookupError):
            self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def __enter__(self) -> "TerminalWindow":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _close_master(self) -> None:
        if self._is_open:
            self._is_open = False
            self._reader.join()
            os.close(self._master)

    def _read(self) -> None:
        while self._is_open:
            if not select.select([self._master], [], [], 0.02)[0]:
                continue
            try:
                data = os.read(self._master, 65536)
            except OSError:
                return
            with self._lock:
                self._stream.feed(data)

    def _answer(self, data: bytes) -> None:
        if self.is_answering:
            os.write(self._master, data)


def _take_terminal() -> None:
    take_default_signals()
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
