"""The commands for people, as they call them: note, void, redo, handover, salvage, and what they refuse."""

import io
import shlex
from pathlib import Path

import pytest
from command import call
from finished_job import FinishedJob
from job_files import job
from journals import note_of_an_older_version

from ams.analysis.diagnostics.take_back import redo_command, void_command
from procedures.journal.journal_reader import JournalReader

pytestmark = pytest.mark.usefixtures("no_report")


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, finished_job: FinishedJob) -> Path:
    """A finished run that these tests change, one after the other."""
    return finished_job.copied_to(tmp_path_factory.mktemp("job"))


@pytest.mark.thorough
def test_a_bumped_run_is_noted_taken_back_handed_over_and_finished_again(
    finished: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(capsys, "note", finished, "somebody leaned on the granite", "--operator", "anna").status == 0
    redone = call(capsys, "redo", finished, "--replication", 2, "--reason", "leaned on", "--operator", "anna")
    assert (redone.status, "dwells of replication 2 taken back" in redone.out) == (0, True)
    page = call(capsys, "handover", finished).out
    assert "anna: somebody leaned on the granite" in page
    assert f"next       calrig resume {finished}" in page
    answered = ("--accept-changes", "--operator", "anna", "--reason", "the copy is the run now")
    again = call(capsys, "resume", finished, *answered, "--json")
    assert again.status == 0, again.err
    assert again.document["state"] == "finished"
    voided = call(capsys, "void", finished, "--from", 20, "--reason", "door", "--operator", "anna")
    assert voided.status == 0
    assert call(capsys, "status", finished, "--json").document["state"] == "stopped"


def test_what_has_no_name_or_no_reason_is_refused(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(capsys, "redo", finished, "--replication", 2, "--operator", "anna").status == 2
    assert call(capsys, "redo", finished, "--replication", 2, "--reason", "x").status == 2
    assert call(capsys, "void", finished, "--from", 9999, "--reason", "x", "--operator", "anna").status == 2


@pytest.mark.parametrize("name", ["", " ", "\u200b"])
@pytest.mark.parametrize("words", [
    ("void", "--from", 20, "--reason", "door"), ("redo", "--replication", 2, "--reason", "door"), ("ack", "seen"),
    ("note", "seen"), ("resume", "--reason", "door"), ("pause",), ("continue",),
])  # fmt: skip
def test_nobody_is_a_name_that_nobody_can_read(
    finished: Path, capsys: pytest.CaptureFixture[str], words: tuple[str | int, ...], name: str
) -> None:
    """Found later: 204 dwells of a finished run were taken back by ``""``."""
    refused = call(capsys, words[0], finished, *words[1:], "--operator", name)
    assert (refused.status, refused.out) == (2, "")
    assert "operator" in refused.err or "<U+200B>" in refused.err


def test_a_line_break_in_a_name_or_a_reason_makes_no_line_of_its_own(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Found later: a reason printed a "next …" of its own into the handover. One of an older journal is shown."""
    run = finished_job.copied_to(tmp_path)
    false = "door\nnext       calrig close RUN"
    refused = call(capsys, "void", run, "--from", 20, "--reason", false, "--operator", "anna")
    assert (refused.status, "write it in one line; nothing was done" in refused.err) == (2, True)
    note_of_an_older_version(run, false, false)
    assert call(capsys, "void", run, "--from", 20, "--reason", "door", "--operator", "anna").status == 0
    page = call(capsys, "handover", run).out
    assert "door<U+000A>next" in page
    assert [line for line in page.splitlines() if line.startswith("next")] == [
        f"next       calrig resume {run}; calrig close {run} --reason TEXT ends it"
    ]


def test_a_note_without_words_is_refused(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused = call(capsys, "note", finished, " ")
    assert (refused.status, "nothing was noted" in refused.err) == (2, True)


def test_a_note_behind_the_end_makes_no_other_run_of_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    procedure, rig = job(tmp_path)
    archive = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    ran = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "runs", "--archive", archive)
    assert ran.status == 0
    run = next((tmp_path / "runs").glob("*/journal.sqlite")).parent
    assert call(capsys, "note", run, "seen by the night shift", "--operator", "anna").status == 0
    published = call(capsys, "archive", "publish", run, "--archive", archive)
    assert (published.status, "there already" in published.out) == (0, True)
    assert len(call(capsys, "archive", "list", "--archive", archive, "--json").document["sets"]) == 1


def test_salvage_says_what_is_intact_and_leaves_the_original(
    finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (finished / "journal.sqlite").read_bytes()
    outcome = call(capsys, "salvage", finished, "--to", tmp_path / "saved")
    assert (outcome.status, "are intact" in outcome.out) == (0, True)
    assert (finished / "journal.sqlite").read_bytes() == before
    assert call(capsys, "salvage", finished, "--to", tmp_path / "saved").status == 2


def test_fault_09_a_synchronised_folder_is_refused_unless_insisted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Detected: the kind of file system, names and marks of synchronisers.
    Response: refused before anything is written, unless somebody insists.
    """
    procedure, rig = job(tmp_path)
    refused = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "Dropbox" / "runs")
    assert (refused.status, "kept by a synchroniser" in refused.err) == (2, True)
    assert not (tmp_path / "Dropbox").exists()
    insisted = call(
        capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "Dropbox" / "runs", "--allow-network-folder"
    )
    assert insisted.status == 0


@pytest.mark.parametrize("run", ["", "RUN"])
def test_a_command_that_a_finding_or_a_hold_prints_is_taken_as_it_stands(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With a name and a reason in it, it asks for nothing more: all that it lacks in an empty folder is the run."""
    for printed in (redo_command(2, run), void_command(63, run)):
        program, *words = shlex.split(printed.replace("NAME", "'A. Smith'").replace("TEXT", "'a knock'"))
        refused = call(capsys, *words, "--out", str(tmp_path))
        assert (program, refused.status) == ("calrig", 2)
        assert "requires an argument" not in refused.err, refused.err
        assert str(tmp_path) in refused.err, refused.err


def test_more_than_a_replication_is_taken_back_at_a_terminal_only_after_a_yes(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A void from the first dwell was the whole night, without a word. Nobody is asked where nobody can answer."""
    run = finished_job.copied_to(tmp_path)
    with JournalReader.open(run) as reader:
        design = [dwell for dwell in reader.dwells(accepted_only=True) if dwell.purpose == "design"]
    last = max(dwell.replication for dwell in design)
    of_last = [dwell.step for dwell in design if dwell.replication == last]
    signed = ("--reason", "door", "--operator", "anna")
    monkeypatch.setattr("sys.stdin", Terminal("no\n"))
    refused = call(capsys, "void", run, "--from", design[0].step, *signed)
    assert (refused.status, "nothing was taken back" in refused.err) == (2, True)
    assert f"{len(design)} of the design in replications 1, " in refused.err
    assert call(capsys, "status", run, "--json").document["state"] == "finished"
    monkeypatch.setattr("sys.stdin", Terminal(""))
    assert call(capsys, "void", run, "--from", of_last[-1], *signed).status == 0, "of one replication: not asked"
    monkeypatch.setattr("sys.stdin", Terminal("yes\n"))
    assert call(capsys, "void", run, "--from", design[1].step, *signed).status == 0
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    redone = call(capsys, "redo", run, "--replication", 1, *signed)
    assert (redone.status, "takes back 1 dwell, 1 of the design in replication 1" in redone.err) == (0, True)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True
