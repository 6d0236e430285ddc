"""What the stop guard did is told by status until the next resume, which journals it."""

import json
import os
from datetime import timedelta
from pathlib import Path

import pytest
from resumed import resume_on
from small_run import bench, in_child
from unattended_run import UnattendedRun, asks, events, run_unattended

from procedures.journal.sidecar.guard_record import EVENT, guard_sentence, read_guard_record
from procedures.journal.sidecar.last_words import LastWords, keep_last_words
from procedures.journal.status.status import status
from procedures.records.states import State, is_unasked
from procedures.run.ending import DIED
from procedures.run.handover import handover
from rig.assembly.open_rig import open_rig
from rig.clock import SystemClock
from rig.guard.ask import SUFFIX, stop
from rig.guard.process import FORMAT
from rig.guard.stop_guard import RECORD, StopGuard

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
    text = "the engine was frozen (SIGSTOP); it was ended while roll could move"
    assert text in guard_sentence(record)
    assert text in handover(run.run_dir)
    with open_rig(small.rig) as rig:
        assert resume_on(run.run_dir, rig, "carla").state is State.FINISHED
    (event,) = events(run.run_dir, EVENT)
    assert event.detail == DOCUMENT
    assert text in handover(run.run_dir)
    assert not (run.run_dir / RECORD).exists()


@pytest.mark.parametrize("is_told", [True, False])
def test_a_death_that_people_were_told_of_is_journalled_by_the_resume_and_not_told_again(
    tmp_path: Path, is_told: bool
) -> None:
    small, run = bench(tmp_path), UnattendedRun(tmp_path / "run", after={5: lambda _: os._exit(0)})
    os.waitpid(in_child(lambda: run_unattended(small, run)), 0)
    sentence = guard_sentence(DOCUMENT)
    if is_told:
        keep_last_words(run.run_dir, None, LastWords(sentence, SystemClock().now_utc() + timedelta(days=9), DIED))
    later = UnattendedRun(run.run_dir)
    with open_rig(small.rig) as rig:
        assert resume_on(run.run_dir, rig, "carla", observer=later).state is State.FINISHED
    entered = [one for one in later.heard if (one.event, one.state) == ("state", State.INTERRUPTED)]
    assert bool(entered) is not is_told
    (journalled,) = [one for one in events(run.run_dir, "state") if one.detail["to"] == State.INTERRUPTED]
    assert journalled.detail["reason"] == (sentence if is_told else "the process ended without a last line")


@pytest.mark.parametrize(("by", "named"), [("ann", "ann"), ("", "somebody without a name")])
def test_a_run_that_was_aborted_through_the_guard_tells_who_asked(tmp_path: Path, by: str, named: str) -> None:
    """In status, handover, journal and to everybody who is told; a person's wish is no alarm."""
    small = bench(tmp_path)
    guard = StopGuard(tmp_path / "run" / RECORD, {}, tmp_path, SystemClock())

    def ask_the_guard(run: UnattendedRun) -> None:
        run.rig.axes["pitch"]._supervisor.warden = guard  # type: ignore[attr-defined]
        guard.begin()
        (found,) = tmp_path.glob(f"*{SUFFIX}")
        stop({"socket": found.name.removesuffix(SUFFIX)}, None, by)

    run = UnattendedRun(tmp_path / "run", after={5: ask_the_guard})
    outcome = run_unattended(small, run)
    guard.close()
    text = f"the stop guard told the axes to stop at once (asked for by {named})"
    assert (outcome.state, outcome.reason) == (State.ABORTED, text)
    stands = status(run.run_dir)
    assert (stands.requested_by, stands.why) == (named, text)
    assert f"{text}\n" in handover(run.run_dir)
    last = run.heard[-1]
    assert (last.requested_by, is_unasked(last.state, last.requested_by)) == (named, False)


def test_an_axis_that_could_not_be_told_is_named() -> None:
    found = guard_sentence({**DOCUMENT, "axes": {"roll": "NOT told to stop: the line takes no bytes"}})
    assert found.endswith("but roll: NOT told to stop: the line takes no bytes; use the stop button at the machine")


@pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "another"}'])
def test_a_record_that_is_none_is_no_word_of_the_guard(tmp_path: Path, content: str) -> None:
    (tmp_path / RECORD).write_text(content, encoding="utf-8")
    assert read_guard_record(tmp_path) is None
