"""Somebody moves, renames or removes the folder of a run that goes on: that is said, and can be acknowledged."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from command import call
from small_run import Bench, bench, dwells_of, measured
from unattended_run import UnattendedRun, run_unattended

from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.settings import AlertSettings, Escalation
from procedures.cli.run.attend import attended, ring_out
from procedures.cli.run.opening import Opening
from procedures.errors import ExitStatus
from procedures.journal.requests.corrections import is_acknowledged
from procedures.journal.sidecar.alert_record import is_acknowledged_elsewhere
from procedures.journal.sidecar.second_folder import second_folder
from procedures.records.progress import SilentObserver
from procedures.records.states import State
from procedures.run.ending import Outcome
from procedures.run.resume import resume
from procedures.run.services import RunServices
from rig.clock import VirtualClock


@pytest.fixture(autouse=True)
def _state_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("procedures.journal.sidecar.second_folder.user_state_path", lambda _name: tmp_path / "state")


@pytest.fixture
def small(tmp_path: Path) -> Bench:
    (tmp_path / "bench").mkdir()
    return bench(tmp_path / "bench")


def _run_that_is_taken_away(small: Bench, run_dir: Path, take: Callable[[], object]) -> tuple[Outcome, UnattendedRun]:
    unattended = UnattendedRun(run_dir, after={5: lambda _: take()})
    return run_unattended(small, unattended, RunServices(second_folder=second_folder())), unattended


def _alarm_of(unattended: UnattendedRun, clock: VirtualClock) -> AlertDispatcher:
    """The alarm as who started the run has it."""
    settings = AlertSettings(escalate=Escalation(after_min=30.0, command=("true",)))
    dispatcher = AlertDispatcher(settings, "small grid", clock, SilentObserver(), run=str(unattended.run_dir))
    dispatcher.on_event([heard for heard in unattended.heard if heard.event == "state"][-1])
    return dispatcher


@pytest.mark.parametrize("new_name", ["elsewhere/run", "renamed"])
def test_what_happened_is_said_and_the_run_is_taken_up_where_it_is(small: Bench, tmp_path: Path, new_name: str) -> None:
    run_dir, there = tmp_path / "run", tmp_path / new_name
    there.parent.mkdir(exist_ok=True)
    outcome, unattended = _run_that_is_taken_away(small, run_dir, lambda: run_dir.rename(there))
    assert (outcome.exit_status, outcome.cause) == (ExitStatus.FAILED, "moved")
    assert "the folder of the run is not there any more: it was moved, renamed or removed" in outcome.reason
    page = (second_folder() / "run" / "why.txt").read_text(encoding="utf-8")
    assert "not known: the folder of the run is not there" in page
    assert "Put it back where it was, or find where it is now" in page
    told = next(heard.message for heard in reversed(unattended.heard) if heard.event == "state")
    for text in (outcome.reason, page, told):
        assert "moved, renamed or removed" in text
        assert "free space" not in text, "advice for a full disk"
    assert not run_dir.exists(), "an empty folder in its place would be taken for the run"
    assert small.run(tmp_path / "clean").state is State.FINISHED
    assert resume(there, "tester").state is State.FINISHED
    assert measured(dwells_of(there)) == measured(dwells_of(tmp_path / "clean"))


def test_a_run_that_was_removed_is_said_to_be_gone(small: Bench, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    outcome, _ = _run_that_is_taken_away(small, run_dir, lambda: shutil.rmtree(run_dir))
    assert outcome.cause == "moved"
    assert not run_dir.exists()


@pytest.mark.parametrize("asked_by", ["old path", "old name", "new path"])
def test_its_alarm_is_acknowledged_by_where_it_was_and_by_where_it_is(
    small: Bench, tmp_path: Path, asked_by: str, capsys: pytest.CaptureFixture[str]
) -> None:
    run_dir, there = tmp_path / "run", tmp_path / "moved"
    _, unattended = _run_that_is_taken_away(small, run_dir, lambda: run_dir.rename(there))
    words = {"old path": run_dir, "old name": "run", "new path": there}[asked_by]
    told = call(capsys, "ack", words, "I have it", "--out", tmp_path / "none")
    assert told.status == 0, told.err
    assert asked_by != "new path" or is_acknowledged(there)
    clock = VirtualClock(unattended.now_utc())
    began_s = clock.monotonic_s()
    ring_out(run_dir, _alarm_of(unattended, clock))
    assert clock.monotonic_s() - began_s < 2.0


def test_without_an_acknowledgement_it_rings_on_and_an_old_one_counts_for_nothing(
    small: Bench, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_dir, there = tmp_path / "run", tmp_path / "moved"
    _, unattended = _run_that_is_taken_away(small, run_dir, lambda: run_dir.rename(there))
    assert call(capsys, "ack", run_dir, "before").status == 0
    with attended(Opening("small grid", is_virtual=False), None, run_dir):  # as whoever takes it up begins
        assert not is_acknowledged_elsewhere("run")
    clock = VirtualClock(unattended.now_utc())
    began_s = clock.monotonic_s()
    ring_out(run_dir, _alarm_of(unattended, clock))
    assert clock.monotonic_s() - began_s == pytest.approx(1800.0, abs=2.0)


def test_a_run_of_which_nobody_ever_heard_is_not_acknowledged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = call(capsys, "ack", tmp_path / "never", "I have it")
    assert told.status != 0
    assert "no run is there" in told.err
