"""Laws of the terminal as a line: no terminal, no line; answers by whole lines; an end of input is told."""

import io
import os
import pty
from collections.abc import Iterator

import pytest

from rig.clock import SystemClock
from rig.errors import LinkClosed, LinkLost, RequestRefused
from rig.link.ports import open_stream
from rig.link.terminal_stream import TerminalStream


@pytest.fixture
def desk() -> Iterator[tuple[TerminalStream, int, io.StringIO]]:
    """A terminal of our own: the stream, the side that types, what was shown."""
    typing, terminal = pty.openpty()
    shown = io.StringIO()
    with os.fdopen(terminal, encoding="utf-8") as typed:
        yield TerminalStream(SystemClock(), typed, shown), typing, shown
    os.close(typing)


def test_a_question_is_shown_and_an_answer_read(desk: tuple[TerminalStream, int, io.StringIO]) -> None:
    stream, typing, shown = desk
    stream.write(b"pitch: set the axis to its zero\n")
    assert shown.getvalue() == "pitch: set the axis to its zero\n"
    assert stream.read(stream.clock.monotonic_s()) == b""
    os.write(typing, b"29.9")
    assert stream.read(stream.clock.monotonic_s() + 0.01) == b""  # not before Enter
    os.write(typing, b"8\n")
    assert stream.read(stream.clock.monotonic_s() + 2.0) == b"29.98\n"


def test_what_was_typed_before_can_be_thrown_away(desk: tuple[TerminalStream, int, io.StringIO]) -> None:
    stream, typing, _ = desk
    os.write(typing, b"\n\n")
    assert stream.discard_input() == b"\n\n"
    assert stream.discard_input() == b""


def test_an_end_of_input_is_a_lost_line(desk: tuple[TerminalStream, int, io.StringIO]) -> None:
    stream, typing, _ = desk
    os.write(typing, b"\x04")  # Ctrl-D
    with pytest.raises(LinkLost, match="standard input was closed"):
        stream.read(stream.clock.monotonic_s() + 2.0)


def test_a_closed_line_says_so(desk: tuple[TerminalStream, int, io.StringIO]) -> None:
    stream, _, _ = desk
    stream.close()
    with pytest.raises(LinkClosed):
        stream.write(b"?")


def test_nobody_is_asked_where_standard_input_is_no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    with open(os.devnull, encoding="utf-8") as nothing:
        for typed in (nothing, io.StringIO("\n")):
            monkeypatch.setattr("sys.stdin", typed)
            with pytest.raises(RequestRefused, match="is no terminal, so nobody can answer; nothing was opened"):
                open_stream("terminal", clock=SystemClock())
