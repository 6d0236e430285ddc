"""Who holds a run: an engine runs it, a correction does not, and nobody asks a correction for anything."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from command import call
from run_folders import make_run

from procedures.errors import RequestError
from procedures.journal.journal import Journal
from procedures.journal.requests.corrections import acknowledge, add_note
from procedures.journal.sidecar import owner
from procedures.journal.sidecar.owner import OWNER_FILE, is_owned, owning
from procedures.journal.status.status import status
from procedures.records.states import State

HOLDS = """
import sys
from pathlib import Path
from procedures.journal.sidecar.owner import owning
with owning(Path(sys.argv[1]), None, sys.argv[2]):
    print("held", flush=True)
    sys.stdin.read()
"""


@contextmanager
def _held_by(run: Path, role: str) -> Iterator["subprocess.Popen[bytes]"]:
    """Another process that holds the run in this role until it is killed."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", HOLDS, str(run), role], **pipes) as process:  # type: ignore[call-overload]
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.parametrize("kind", ["stop", "pause", "abort"])
def test_a_correction_of_a_run_whose_engine_was_killed_takes_no_request(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    run = make_run(tmp_path / "run", State.RUNNING)
    with _held_by(run, "engine"):
        assert is_owned(run)
        assert status(run).state is State.RUNNING
    with _held_by(run, "correction"):
        assert not is_owned(run)
        assert status(run).state is State.INTERRUPTED
        answer = call(capsys, kind, run)
    assert answer.status == 2
    assert "no process runs this run: its process is gone; calrig resume continues it; nothing was asked" in answer.err
    assert not list(run.glob("requests/*"))


def test_what_the_lock_says_of_its_holder_before_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A correction has the lock and has not said so yet: the file speaks of the engine that was killed."""
    run = make_run(tmp_path / "run", State.RUNNING)
    with _held_by(run, "engine"):
        pass
    of_engine = (run / OWNER_FILE).read_text(encoding="utf-8")
    of_correction = json.dumps({"pid": os.getpid(), "role": "correction"})
    slept_s: list[float] = []

    def say(_clock: object, duration_s: float) -> None:
        slept_s.append(duration_s)
        (run / OWNER_FILE).write_text(of_correction, encoding="utf-8")

    monkeypatch.setattr(owner.SystemClock, "sleep", say)
    with owning(run):
        (run / OWNER_FILE).write_text(of_engine, encoding="utf-8")
        assert not is_owned(run)
    assert len(slept_s) == 1


@pytest.mark.parametrize("said", ["", "{", "[]", '{"pid": "x"}', '{"pid": 1e400}', '{"pid": 99999999999999999999}'])
def test_a_lock_that_says_nothing_is_an_engines(tmp_path: Path, said: str) -> None:
    """Of an older calrig, or of processes that are not seen from here."""
    run = make_run(tmp_path / "run", State.RUNNING)
    with owning(run):
        (run / OWNER_FILE).write_text(said, encoding="utf-8")
        assert is_owned(run)


def test_who_meets_a_correction_is_told_to_try_again(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run", State.RUNNING)
    with (
        _held_by(run, "correction") as process,
        pytest.raises(RequestError, match=rf"a correction by process {process.pid} since .* try again when it is done"),
        owning(run),
    ):
        pass


@pytest.mark.parametrize("correct", [partial(add_note, text="door open"), partial(acknowledge, text="on my way")])
def test_what_people_write_down_says_that_it_runs_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, correct: Callable[[Path, str], None]
) -> None:
    run = make_run(tmp_path / "run", State.RUNNING)
    append, owned = Journal.append_event, []

    def look(journal: Journal, *words: Any) -> None:
        owned.append(is_owned(run))
        append(journal, *words)

    monkeypatch.setattr(Journal, "append_event", look)
    correct(run, "anna")
    assert owned == [False]
