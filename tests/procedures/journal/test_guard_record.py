"""What the stop guard did is told by status until the next resume, which journals it."""

import json
from pathlib import Path

import pytest
from small_run import bench
from unattended_run import UnattendedRun, asks, events, run_unattended

from procedures.journal.guard_record import EVENT, guard_told, read_guard_record
from procedures.records.states import State
from procedures.run.resume import resume_on
from rig.assembly.open_rig import open_rig
from rig.guard.ask import FORMAT
from rig.guard.stop_guard import RECORD

DOCUMENT = {
    "format": FORMAT,
    "stopped_utc": "2026-11-22T11:02:59+00:00",
    "why": "the engine was frozen (SIGSTOP); it was ended",
    "pid": 4711,
    "moving": ["roll"],
    "axes": {"pitch": "told to stop", "roll": "told to stop"},
}


def test_fault_56_what_the_guard_did_is_told_and_then_journalled(tmp_path: Path) -> None:
    small = bench(tmp_path)
    run = UnattendedRun(tmp_path / "run", after={5: asks("stop")})
    run_unattended(small, run)
    (run.run_dir / RECORD).write_text(json.dumps(DOCUMENT), encoding="utf-8")
    record = read_guard_record(run.run_dir)
    assert record is not None
    assert "the engine was frozen (SIGSTOP); it was ended while roll could move" in guard_told(record)
    with open_rig(small.rig) as rig:
        assert resume_on(run.run_dir, rig, "carla").state is State.FINISHED
    (event,) = events(run.run_dir, EVENT)
    assert event.detail == DOCUMENT
    assert not (run.run_dir / RECORD).exists()


def test_an_axis_that_could_not_be_told_is_named() -> None:
    told = guard_told({**DOCUMENT, "axes": {"roll": "NOT told to stop: the line takes no bytes"}})
    assert told.endswith("but roll: NOT told to stop: the line takes no bytes; use the stop button at the machine")


@pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "another"}'])
def test_a_record_that_is_none_is_no_word_of_the_guard(tmp_path: Path, content: str) -> None:
    (tmp_path / RECORD).write_text(content, encoding="utf-8")
    assert read_guard_record(tmp_path) is None
