"""Another hand takes the files of a journal away under a run, or writes over them: no dwell of it is lost."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from command import call
from job_files import job, simulated
from small_run import Bench, bench, dwells_of, measured
from unattended_run import UnattendedRun, asks, run_unattended
from visited_console import Visited

from procedures.errors import ExitStatus, JournalError, JournalTakenAway
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.alert_record import is_acknowledged_elsewhere
from procedures.journal.sidecar.second_folder import second_folder
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE, CommittedCount
from procedures.records.states import State
from procedures.run.ending import Outcome
from procedures.run.resume import resume
from procedures.run.services import RunServices
from rig.clock import SystemClock

Take = Callable[[Path, Path], object]
"""Given the journal of the run that goes on, and that of another run."""
LOG, INDEX = JOURNAL_FILE + "-wal", JOURNAL_FILE + "-shm"
AT = 5
"""Dwells of the design that are done when it happens."""
OPEN_AND_CLOSE = "import sqlite3, sys; c = sqlite3.connect(sys.argv[1]); c.execute('SELECT * FROM header'); c.close()"
WRITES = "import sys; open(sys.argv[1], 'a').write(sys.stdin.read())"


@pytest.fixture(autouse=True)
def _state_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("procedures.journal.sidecar.second_folder.user_state_path", lambda _name: tmp_path / "state")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    assert small.run(small.folder / "clean").state is State.FINISHED
    return small.folder / "clean"


def _remove(*endings: str) -> Take:
    return lambda journal, _: [journal.with_name(journal.name + ending).unlink() for ending in endings]


def _replace(journal: Path, by: Path) -> None:
    """As a synchroniser does, which gives a name to a file that is whole."""
    shutil.copyfile(by, journal.with_name("new"))
    journal.with_name("new").rename(journal)


TAKEN: Mapping[str, tuple[Take, str]] = {
    "all removed": (_remove("", "-wal", "-shm"), f"{JOURNAL_FILE}: is not there any more"),
    "the file removed": (_remove(""), f"{JOURNAL_FILE}: is not there any more"),
    "the log removed": (_remove("-wal"), f"{LOG}: is not there any more"),
    "the index removed": (_remove("-shm"), f"{INDEX}: is not there any more"),
    "replaced by its copy": (lambda journal, _: _replace(journal, journal), f"{JOURNAL_FILE}: is another file"),
    "replaced by another run's": (_replace, f"{JOURNAL_FILE}: is another file"),
    "the log replaced": (
        lambda journal, _: _replace(journal.with_name(LOG), journal.with_name(LOG)),
        f"{LOG}: is another file",
    ),
    "the file emptied": (lambda journal, _: os.truncate(journal, 0), "another program wrote to it"),
    "the log emptied": (lambda journal, _: os.truncate(journal.with_name(LOG), 0), "another program wrote to it"),
    "overwritten by another run's": (
        lambda journal, other: shutil.copyfile(other, journal),
        "another program wrote to it",
    ),
    "the folder removed": (lambda journal, _: shutil.rmtree(journal.parent), "the folder of the run is not there"),
    "another folder in its place": (
        lambda journal, other: (
            journal.parent.rename(journal.parent.with_name("kept")),
            shutil.copytree(other.parent, journal.parent),
        ),
        f"{JOURNAL_FILE}: is another file",
    ),
}


def _run_while(small: Bench, run_dir: Path, other: Path, take: Take) -> tuple[Outcome, UnattendedRun]:
    run = UnattendedRun(run_dir, after={AT: lambda _: take(run_dir / JOURNAL_FILE, other / JOURNAL_FILE)})
    return run_unattended(small, run, RunServices(second_folder=second_folder())), run


def _measured_by(run: UnattendedRun) -> int:
    return sum(heard.event in ("dwell", "rejected") for heard in run.heard)


@pytest.mark.parametrize("how", TAKEN)
def test_fault_93_a_journal_that_is_taken_away_under_a_run_costs_no_dwell(
    small: Bench, clean: Path, tmp_path: Path, how: str
) -> None:
    """Detected: which file stands under each name, its size and when it was written, before and behind every commit.
    Response: stopped, and people are told; everything is copied to a second place out of the files that are still
    open, with a page that names it; a resume of the copy goes on with the first missing dwell.
    """
    take, sentence = TAKEN[how]
    run_dir, untouched = tmp_path / "run", {file.name: file.read_bytes() for file in clean.glob("journal*")}
    outcome, run = _run_while(small, run_dir, clean, take)
    assert (outcome.state, outcome.exit_status) == (State.INTERRUPTED, ExitStatus.FAILED)
    assert sentence in outcome.reason
    assert outcome.copy == second_folder() / "run"
    assert f"copied to {outcome.copy} ({_measured_by(run)} dwells" in outcome.reason
    pages = [*run_dir.rglob("why.txt"), *second_folder().rglob("why.txt")]
    assert len(pages) == 1
    page = pages[0].read_text(encoding="utf-8")
    assert sentence in page
    assert str(outcome.copy) in page
    assert f"calrig resume {outcome.copy}" in page
    assert {file.name: file.read_bytes() for file in clean.glob("journal*")} == untouched
    assert resume(outcome.copy, "anna", "out of the copy").state is State.FINISHED
    assert measured(dwells_of(outcome.copy)) == measured(dwells_of(clean))
    with JournalReader.open(outcome.copy) as reader:
        entered = [str(event.detail.get("reason")) for event in reader.events("state")]
    assert any(sentence in reason for reason in entered), "the record says why it was interrupted"


def test_a_file_that_is_taken_away_behind_the_last_dwell_costs_none(small: Bench, clean: Path, tmp_path: Path) -> None:
    """The run was told to end, or is at its end: its last lines find it."""
    last = len(small.plan.design_dwells)
    run = UnattendedRun(tmp_path / "run", after={last: lambda _: (tmp_path / "run" / JOURNAL_FILE).unlink()})
    outcome = run_unattended(small, run, RunServices(second_folder=second_folder()))
    assert (outcome.cause, outcome.copy) == ("replaced", second_folder() / "run")
    assert resume(second_folder() / "run", "anna", "out of the copy").state is State.FINISHED
    assert measured(dwells_of(second_folder() / "run")) == measured(dwells_of(clean))


def test_a_file_that_is_taken_away_in_a_pause_is_noticed_before_anybody_says_continue(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    journal = tmp_path / "run" / JOURNAL_FILE
    run = UnattendedRun(tmp_path / "run", at={20: lambda _: journal.unlink()}, after={AT: asks("pause")})
    outcome = run_unattended(small, run, RunServices(second_folder=second_folder()))
    assert (outcome.cause, outcome.dwells_done) == ("replaced", AT)
    assert run.rests < 100
    assert resume(second_folder() / "run", "anna", "out of the copy").state is State.FINISHED
    assert measured(dwells_of(second_folder() / "run")) == measured(dwells_of(clean))


def test_a_folder_that_takes_no_copy_leaves_it_beside_the_run(small: Bench, clean: Path, tmp_path: Path) -> None:
    """What ends with the process is copied wherever it can be, and never among files that are left of a journal."""
    (tmp_path / "state").write_text("a file", encoding="utf-8")
    outcome, run = _run_while(small, tmp_path / "run", clean, _remove(""))
    assert outcome.copy == tmp_path / "run-2"
    assert status(outcome.copy).state is State.INTERRUPTED
    assert len(dwells_of(outcome.copy)) == _measured_by(run)


@pytest.mark.parametrize("how", ["touched", "written over by itself"])
def test_a_hand_that_changes_nothing_stops_nothing(small: Bench, clean: Path, tmp_path: Path, how: str) -> None:
    """As a backup does that sets times back, or a copy that is put where it came from."""

    def change(journal: Path, _: Path) -> None:
        for path in (journal, journal.with_name(LOG)):
            if how != "touched":
                path.write_bytes(path.read_bytes())
            os.utime(path)

    outcome, run = _run_while(small, tmp_path / "run", clean, change)
    assert outcome.state is State.FINISHED
    assert measured(dwells_of(run.run_dir)) == measured(dwells_of(clean))
    assert not (second_folder() / "run").exists()


def test_who_reads_the_journal_of_its_own_process_still_counts_as_having_it_open(small: Bench, tmp_path: Path) -> None:
    """A page of a held run is read in the engine's process; who opens the file after that to look removes no log."""
    logs = []

    def look(run: UnattendedRun) -> None:
        with JournalReader.open(run.run_dir):
            pass
        subprocess.run([sys.executable, "-c", OPEN_AND_CLOSE, str(run.run_dir / JOURNAL_FILE)], check=True)
        logs.append((run.run_dir / LOG).exists())

    run = UnattendedRun(tmp_path / "run", after={AT: look})
    assert run_unattended(small, run).state is State.FINISHED
    assert logs == [True]


def _until_committed(runs: Path, dwells: int, process: subprocess.Popen[str]) -> Path:
    """Return the folder of the run, as soon as its journal holds so many."""
    clock = SystemClock()
    while process.poll() is None:
        for journal in runs.glob(f"*/{JOURNAL_FILE}"):
            if (CommittedCount(journal).read() or (0, 0))[1] >= dwells:
                return journal.parent
        clock.sleep(0.02)
    raise AssertionError("the run ended before")


def test_fault_93_a_journal_is_removed_under_a_real_process(tmp_path: Path) -> None:
    """With the ports, the alert, the exit status and the last lines of a night."""
    procedure, rig = job(tmp_path)
    told, ports = tmp_path / "told.txt", tmp_path / "ports.toml"
    alerts = tmp_path / "alerts.toml"
    alerts.write_text(f"command = {json.dumps([sys.executable, '-c', WRITES, str(told)])}\n", encoding="utf-8")
    words = ["run", procedure, "--rig", str(ports), "--out", str(tmp_path / "runs"), "--alerts", str(alerts)]
    surroundings = {**os.environ, "XDG_STATE_HOME": str(tmp_path / "home")}
    with simulated(rig, ports, "--time-factor", "60"), subprocess.Popen(
        [sys.executable, "-m", "procedures.cli.main", *words], env=surroundings, stderr=subprocess.PIPE, text=True
    ) as run:  # fmt: skip
        assert run.stderr is not None
        run_dir = _until_committed(tmp_path / "runs", 9, run)
        for path in run_dir.glob(f"{JOURNAL_FILE}*"):
            path.unlink()
        said = run.stderr.read()
    copy = tmp_path / "home" / "calrig" / "emergency" / run_dir.name
    assert run.returncode == ExitStatus.FAILED, said
    assert f"{JOURNAL_FILE}: is not there any more" in told.read_text(encoding="utf-8")
    assert f"page{run_dir / 'why.html'}next" in "".join(said.split())
    assert "cannot be read" not in said
    assert len(dwells_of(copy)) >= 9


def test_its_alarm_is_acknowledged_by_the_name_of_the_run(
    small: Bench, clean: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _run_while(small, tmp_path / "run", clean, _remove(""))
    assert not is_acknowledged_elsewhere("run")
    said = call(capsys, "ack", tmp_path / "run", "I have it", "--out", tmp_path / "none")
    assert said.status == 0, said.err
    assert is_acknowledged_elsewhere("run")


LOOKS = [["status"], ["resume", "--operator", "anna", "--reason", "on"], ["solve"], ["handover"], ["attach"], ["data"],
         ["close", "--operator", "anna", "--reason", "over"]]  # fmt: skip


@pytest.mark.parametrize("how", ["all removed", "overwritten by another run's", "the folder removed"])
def test_whoever_looks_at_the_run_is_told_of_its_page_and_its_copy(
    small: Bench, clean: Path, tmp_path: Path, how: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where what stands there now is a whole journal: it is another run's."""
    run_dir = tmp_path / "runs" / "run"
    run_dir.parent.mkdir()
    outcome, _ = _run_while(small, run_dir, clean, TAKEN[how][0])
    (page,) = [*run_dir.rglob("why.html"), *second_folder().rglob("why.html")]
    for words in LOOKS:
        said = call(capsys, words[0], run_dir, *words[1:])
        assert said.status == ExitStatus.WRONG_REQUEST, words
        told = "".join(said.err.split())
        for path in (run_dir, outcome.copy, page):
            assert str(path) in told, words
        assert "".join(TAKEN[how][1].split()) in told, words
    if run_dir.exists():
        listed = call(capsys, "status", "--all", "--out", run_dir.parent)
        assert (listed.status, f"calrig resume {outcome.copy}" in listed.out) == (ExitStatus.WRONG_REQUEST, True)
        assert str(page) in listed.out
    assert status(outcome.copy or run_dir).state is State.INTERRUPTED, "the copy is read as it stands"


def test_the_console_names_page_and_copy_of_a_run_whose_journal_is_gone(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    visited = Visited(tmp_path)
    run_dir = tmp_path / "runs" / "run"
    outcome, _ = _run_while(small, run_dir, clean, _remove("", "-wal", "-shm"))
    browser = visited.enter()
    shown = browser.get("/run/run"), browser.get("/"), browser.get("/night")
    for page in shown:
        assert f"calrig resume {outcome.copy}" in page.text, page.url
        assert str(run_dir / "why.html") in page.text, page.url
    assert shown[0].status_code == 500


def test_who_wants_what_stands_there_all_the_same_removes_the_word_that_was_left(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    """As after a journal was put back by hand; a copy that takes the place of the folder needs nothing."""
    outcome, _ = _run_while(small, tmp_path / "run", clean, _remove("", "-wal", "-shm"))
    assert outcome.copy is not None
    with pytest.raises(JournalTakenAway, match=r"remove .*taken-away\.json"):
        status(tmp_path / "run")
    shutil.copyfile(outcome.copy / JOURNAL_FILE, tmp_path / "run" / JOURNAL_FILE)
    (tmp_path / "run" / "taken-away.json").unlink()
    assert status(tmp_path / "run").state is State.INTERRUPTED
    outcome.copy.rename(tmp_path / "elsewhere")
    assert status(tmp_path / "elsewhere").state is State.INTERRUPTED


def test_a_folder_that_was_moved_and_is_put_back_is_read(small: Bench, clean: Path, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    outcome, _ = _run_while(small, run_dir, clean, lambda journal, _: journal.parent.rename(tmp_path / "away"))
    assert (outcome.cause, outcome.copy) == ("moved", None)
    with pytest.raises(JournalTakenAway, match="name that folder"):
        status(run_dir)
    (tmp_path / "away").rename(run_dir)
    assert status(run_dir).state is State.INTERRUPTED


def test_a_journal_of_another_run_than_was_committed_there_is_refused(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    """Where the run ended otherwise before it noticed: its count tells whose the folder is."""
    shutil.copytree(clean, tmp_path / "run")
    small.run(tmp_path / "other")
    shutil.copyfile(tmp_path / "other" / JOURNAL_FILE, tmp_path / "run" / JOURNAL_FILE)
    with pytest.raises(JournalError, match=r"is the journal of run .*committed in this folder was of run"):
        status(tmp_path / "run")
