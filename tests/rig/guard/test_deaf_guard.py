"""A stop guard that lives and says nothing: how long the engine waits for it, also after a pause of its own."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from rig.abilities.longest_reading import LONGEST_READING_S
from rig.clock import VirtualClock
from rig.errors import GuardLost
from rig.guard.stop_guard import DEAF_S, RECORD, StopGuard

SILENT = """
import socket, sys
channel = socket.socket(fileno=int(sys.argv[1]))
channel.sendall(b'{"ready": true}\\n')
while channel.recv(65536):
    pass
"""
BEAT_S = 0.5


@pytest.mark.parametrize("pause_s", [0.0, 30.0])
def test_a_silent_guard_is_given_up_after_its_patience_from_the_first_beat_that_it_could_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pause_s: float
) -> None:
    """A run that is held beats for nobody: what was heard before it says nothing of a guard that is only late."""
    program = tmp_path / "silent.py"
    program.write_text(SILENT)
    monkeypatch.setattr("rig.guard.stop_guard.PROCESS", program)
    clock = VirtualClock(datetime(2026, 1, 1, tzinfo=UTC))
    guard = StopGuard(tmp_path / RECORD, {}, None, clock)
    guard.expect_motion(["roll"], {})
    clock.sleep(pause_s)
    silent_s = 0.0
    while silent_s <= DEAF_S:
        guard.beat(["roll"], LONGEST_READING_S)
        assert guard.take_trouble() is None, silent_s
        clock.sleep(BEAT_S)
        silent_s += BEAT_S
    guard.beat(["roll"], LONGEST_READING_S)
    trouble = guard.take_trouble()
    assert isinstance(trouble, GuardLost)
    assert "has not answered for 6 s" in str(trouble)
