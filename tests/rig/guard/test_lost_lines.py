"""The guard of an engine whose lines are lost: as long as they are opened anew, nobody can look at what moves."""

import json
import socket
from collections.abc import Iterator

import pytest

from rig.abilities.longest_reading import LONGEST_READING_S
from rig.guard.outcomes import STOP_SENT
from rig.guard.process import Guard

START = {"record": "stop-guard.json", "folder": None, "rig": {}, "ring": []}


@pytest.fixture
def engine() -> Iterator[tuple[socket.socket, Guard]]:
    """Whose axis is on its way to a target; the engine's end of the channel, and its guard."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        guard = Guard(theirs, START)
        _say(ours, guard, {"lines": [], "moving": ["roll"], "silence_s": LONGEST_READING_S, "looked": True})
        yield ours, guard


def _say(ours: socket.socket, guard: Guard, message: dict[str, object]) -> None:
    ours.sendall(json.dumps(message).encode() + b"\n")
    assert guard.hear()


def test_an_engine_that_waits_for_a_line_that_is_lost_is_not_ended_for_not_looking(
    engine: tuple[socket.socket, Guard],
) -> None:
    """A cable that is out for longer than that would end a run which goes on by itself when it is back."""
    ours, guard = engine
    _say(ours, guard, {"released": True})
    guard.looked_s -= LONGEST_READING_S + 1.0
    _say(ours, guard, {})
    assert guard.why_stop() == ""
    _say(ours, guard, {"lines": []})
    assert guard.why_stop() == "", "it has the time to look again"
    guard.looked_s -= LONGEST_READING_S + 1.0
    assert guard.why_stop() == "the engine did not look at what moves for 120 s"


def test_an_engine_that_hangs_while_its_lines_are_lost_is_ended_all_the_same(
    engine: tuple[socket.socket, Guard],
) -> None:
    ours, guard = engine
    _say(ours, guard, {"released": True})
    guard.silent_s = guard.silence_s + 1.0
    assert guard.why_stop() == "the engine gave no sign of life for 120 s"


def test_a_line_that_stays_away_is_known_by_its_address_and_nobody_can_look_at_its_axis(
    engine: tuple[socket.socket, Guard],
) -> None:
    """The others are held meanwhile: the engine that dies then leaves an axis which only the guard can stop."""
    ours, guard = engine
    away = {
        "name": "axes.roll",
        "is_escaped": False,
        "axes": {"roll": [{"send": b"stop".hex()}]},
        "is_given_back": True,
    }
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = f"socket://127.0.0.1:{listener.getsockname()[1]}"
        _say(ours, guard, {"lines": [{**away, "address": address}]})
        guard.looked_s -= LONGEST_READING_S + 1.0
        assert guard.why_stop() == ""
        assert guard.stop_axes() == {"roll": STOP_SENT}
        caller, _ = listener.accept()
        with caller:
            assert caller.recv(4) == b"stop"
            _say(ours, guard, {"lines": [{**away, "address": address}]})
            assert caller.recv(4) == b"", "the engine is about to open it, and some lines take one caller alone"
    guard.take([])
