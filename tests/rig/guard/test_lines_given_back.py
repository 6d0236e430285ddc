"""Lines that an engine opens anew: it waits until its guard gave them back, and no late stop goes to another port."""

import os
import socket
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from guarded_engine import until

from rig.clock import VirtualClock
from rig.errors import WaitEnded
from rig.guard.line import Line
from rig.guard.process import Guard
from rig.guard.stop_guard import RECORD, StopGuard
from rig.threads import begun

START = {"record": "stop-guard.json", "folder": None, "rig": {}, "ring": []}
BUSY = """
import json, socket, sys
channel = socket.socket(fileno=int(sys.argv[1]))
channel.sendall(b'{"ready": true}\\n')
for line in channel.makefile("rb"):
    message = json.loads(line)
    channel.sendall(b"{}\\n")
    if "released" in message:
        channel.sendall(b'{"stop": "ann", "told": {"roll": "told to stop"}}\\n')
        with open(FIFO) as fifo:
            fifo.read()
    if "holding" in message:
        channel.sendall(json.dumps({"given_back": message["holding"]}).encode() + b"\\n")
"""
"""A guard that has something else to say, an answer to a beat and that somebody stopped the axes, before it gives back
its lines when it is let.
"""
LIMIT_S = 20.0
ROLL = {"name": "axes.roll", "address": "loop://", "is_escaped": False}
TWO_PIECES = {"axes": {"roll": [{"send": b"st".hex(), "pause_s": 0.3}, {"send": b"op".hex()}]}}
"""A stop whose second piece follows after a pause."""


@pytest.fixture
def guard() -> Iterator[Guard]:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        yield Guard(theirs, START)


def test_an_engine_waits_for_its_lines_and_hears_what_else_its_guard_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A machine that allows one connection refuses an engine that opens it while its guard holds the one of before."""
    fifo, program = tmp_path / "let", tmp_path / "busy.py"
    os.mkfifo(fifo)
    program.write_text(BUSY.replace("FIFO", repr(str(fifo))))
    monkeypatch.setattr("rig.guard.stop_guard.PROCESS", program)
    monkeypatch.setattr("rig.guard.stop_guard.RELEASE_S", LIMIT_S)
    guard = StopGuard(tmp_path / RECORD, {}, None, VirtualClock(datetime(2026, 1, 1, tzinfo=UTC)))
    guard.expect_motion(["roll"], {})
    waiting = begun(guard.release, "lines given back")
    try:
        assert until(lambda: guard.why_stop() != "", LIMIT_S)
        assert waiting.is_alive, "it went on by a message that was no answer to it"
    finally:
        fifo.write_text("")
        assert waiting.join(LIMIT_S)
        trouble = guard.take_trouble()
        guard.close()
    assert isinstance(trouble, WaitEnded)
    assert str(trouble) == "the stop guard told the axes to stop at once, asked for by ann"


def test_no_descriptor_is_closed_while_a_stop_is_half_sent_on_it(guard: Guard) -> None:
    """The system gives the number to what is opened next: another port would get the rest of the stop."""
    machine, line = os.pipe()
    guard.descriptors = [line]
    guard.take([{**ROLL, **TWO_PIECES}])
    stopping = begun(guard.stop_axes, "a stop that is repeated")
    assert os.read(machine, 2) == b"st"
    guard.take([])
    one, other = socket.socketpair()
    with one, other:
        assert line in (one.fileno(), other.fileno()), "the number is used anew"
        assert stopping.join(LIMIT_S)
        for port in (one, other):
            port.setblocking(False)
            with pytest.raises(BlockingIOError):
                port.recv(100)
    assert os.read(machine, 100) == b"op"
    assert os.read(machine, 100) == b"", "given back: nobody else holds it"
    os.close(machine)


def test_a_stop_that_is_late_opens_no_line_that_another_took_the_place_of() -> None:
    """It would hold a machine that allows one connection, and nobody would give it back."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = f"socket://127.0.0.1:{listener.getsockname()[1]}"
        with socket.create_connection(listener.getsockname()) as engine:
            line = Line({**ROLL, "address": address, **TWO_PIECES}, engine.detach())
        first, _ = listener.accept()
        with first:
            line.retire()
            outcomes: dict[str, str] = {}
            line.stop(None, ["roll"], outcomes)
            assert outcomes == {"roll": "NOT told to stop: the line was opened anew meanwhile"}
        listener.setblocking(False)
        with pytest.raises(BlockingIOError):
            listener.accept()
