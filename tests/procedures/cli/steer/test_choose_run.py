"""Laws of a command that is given no RUN: it takes the run there is no doubt about, says which, and guesses nothing."""

from contextlib import ExitStack
from datetime import timedelta
from pathlib import Path

import pytest
from command import call
from run_folders import STARTED_UTC, make_run

from procedures.journal.sidecar.owner import owning
from procedures.journal.status.status import status
from procedures.records.states import RESUMABLE, State

STEERING = ("pause", "continue", "stop", "abort")
LOOKING = (("status",), ("handover",))
ANY_RUN = (*LOOKING, *((name,) for name in STEERING), ("note", "words"), ("ack",), ("solve",))
"""Commands that take the run that is alive, else the latest."""
CHANGING = (
    ("resume", "--operator", "anna", "--reason", "x"),
    ("void", "--from", 20, "--reason", "x", "--operator", "anna"),
    ("redo", "--replication", 1, "--reason", "x", "--operator", "anna"),
)
"""Commands that take only the one run that they can be done to."""


def night(runs: Path, *states: State) -> list[Path]:
    """Runs named a, b, c…, started a day apart, the last one latest."""
    days = enumerate(zip("abcdef", states, strict=False))
    return [make_run(runs / name, state, started_utc=STARTED_UTC + timedelta(days=day)) for day, (name, state) in days]


def content(runs: Path) -> dict[str, bytes]:
    """Every journal and every request of a folder of runs."""
    kept = [path for path in runs.rglob("*") if path.name == "journal.sqlite" or path.parent.name == "requests"]
    return {str(path): path.read_bytes() for path in kept}


@pytest.mark.parametrize("command", ANY_RUN, ids=lambda command: command[0])
def test_of_two_that_are_alive_none_is_guessed(
    command: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = night(tmp_path, State.RUNNING, State.RUNNING, State.FINISHED)
    before = content(tmp_path)
    with owning(runs[0]), owning(runs[1]):
        refused = call(capsys, *command, "--out", tmp_path)
    assert (refused.status, refused.out) == (2, "")
    assert f"{tmp_path}: 2 runs are alive (a, b); nothing was done; name one of them" in refused.err
    assert content(tmp_path) == before


@pytest.mark.parametrize("kind", STEERING)
def test_the_run_that_is_alive_is_steered_though_others_began_later(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = night(tmp_path, State.RUNNING, State.STOPPED, State.FINISHED)
    with owning(runs[0]):
        outcome = call(capsys, kind, "--out", tmp_path)
    assert (outcome.status, outcome.err) == (0, f"{runs[0]}: the run that is alive\n")
    assert [path.name.split("-")[-1] for path in (runs[0] / "requests").iterdir()] == [f"{kind}.json"]
    assert not any((run / "requests").exists() for run in runs[1:])


@pytest.mark.parametrize("kind", STEERING)
def test_what_nobody_runs_is_not_steered_and_the_latest_is_named(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = night(tmp_path, State.STOPPED, State.FINISHED)
    refused = call(capsys, kind, "--out", tmp_path)
    assert refused.status == 2
    assert f"{runs[1]}: cannot {kind}: no process runs this run: it is finished; nothing was asked" in refused.err


def test_the_latest_is_looked_at_where_none_is_alive_and_the_choice_is_told_beside_the_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = night(tmp_path, State.FINISHED, State.STOPPED)
    outcome = call(capsys, "status", "--out", tmp_path, "--json")
    assert outcome.document["run"] == str(runs[1])
    assert outcome.err == f"{runs[1]}: the latest run; none is alive\n"
    assert str(runs[1]) in call(capsys, "handover", "--out", tmp_path).out


def test_a_damaged_journal_is_left_out_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = night(tmp_path, State.FINISHED, State.STOPPED)
    (runs[1] / "journal.sqlite").write_bytes(b"")
    outcome = call(capsys, "status", "--out", tmp_path, "--json")
    assert outcome.document["run"] == str(runs[0])
    assert f"{runs[1]}: left out: {runs[1] / 'journal.sqlite'}: has zero length" in outcome.err


@pytest.mark.parametrize("command", [*ANY_RUN, *CHANGING], ids=lambda command: command[0])
def test_a_folder_without_runs_is_a_sentence(
    command: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    refused = call(capsys, *command, "--out", tmp_path / "nowhere")
    assert (refused.status, refused.out) == (2, "")
    assert "nowhere: holds no run" in refused.err


def test_a_note_goes_to_the_latest_run_and_its_name_alone_is_no_note(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = night(tmp_path, State.FINISHED, State.STOPPED)
    assert call(capsys, "note", "the door was open", "--operator", "anna", "--out", tmp_path).status == 0
    assert "anna: the door was open" in call(capsys, "handover", runs[1]).out
    for name in ("b", str(runs[0])):
        refused = call(capsys, "note", name, "--out", tmp_path)
        assert (refused.status, "needed is what to write down" in refused.err) == (2, True)
    assert call(capsys, "note", "a", "in the first one", "--out", tmp_path).status == 0
    assert "in the first one" in call(capsys, "handover", runs[0]).out


@pytest.mark.parametrize("command", CHANGING, ids=lambda command: command[0])
@pytest.mark.parametrize("state", RESUMABLE)
def test_of_two_that_it_can_be_done_to_none_is_guessed(
    command: tuple[str, ...], state: State, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    night(tmp_path, state, State.RUNNING, State.FAILED)  # nobody runs the second, so it is interrupted
    before = content(tmp_path)
    refused = call(capsys, *command, "--out", tmp_path)
    assert (refused.status, refused.out) == (2, "")
    assert "2 runs can be " in refused.err
    assert "(b, a); nothing was done; name one of them" in refused.err
    assert content(tmp_path) == before


def test_the_only_one_is_taken_though_others_are_alive_or_have_ended(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = night(tmp_path, State.STOPPED, State.RUNNING, State.FAILED, State.FAILED)
    with ExitStack() as kept:
        kept.enter_context(owning(runs[1]))
        outcome = call(
            capsys, "redo", "--replication", 1, "--reason", "bumped", "--operator", "anna", "--out", tmp_path
        )
        assert outcome.status == 0
        assert f"{runs[0]}: stopped, the only run that can be taken back from" in outcome.err
    assert status(runs[0]).dwells_done == 0
    assert status(runs[1]).dwells_done > 0


def test_out_takes_the_place_of_runs_for_a_name_as_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = night(tmp_path / "elsewhere", State.FINISHED, State.STOPPED)
    assert call(capsys, "status", "a", "--out", tmp_path / "elsewhere", "--json").document["run"] == str(runs[0])
    monkeypatch.chdir(tmp_path)
    night(tmp_path / "runs", State.HELD)
    assert call(capsys, "status", "--json").document["run"] == "runs/a"
    assert call(capsys, "status", "a", "--json").document["state"] == "interrupted"


def test_all_runs_are_listed_with_state_and_count_the_latest_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = night(tmp_path, State.RUNNING, State.FINISHED, State.STOPPED)
    (runs[2] / "journal.sqlite").write_bytes(b"")
    with owning(runs[0]):
        listed = call(capsys, "status", "--all", "--out", tmp_path, "--json").document["runs"]
        text = call(capsys, "status", "--all", "--out", tmp_path).out.splitlines()
        entry = call(capsys, "status", runs[0], "--json").document
    assert [entry["run"] for entry in listed] == [str(runs[1]), str(runs[0]), str(runs[2])]
    assert [entry["state"] for entry in listed] == ["finished", "running", None]
    assert [entry["alive"] for entry in listed] == [False, True, False]
    assert {key: listed[1][key] for key in ("run", "state", "dwells_done", "dwells_planned")} == {
        key: entry[key] for key in ("run", "state", "dwells_done", "dwells_planned")
    }
    assert listed[0]["trouble"] is None
    assert "has zero length" in listed[2]["trouble"]
    assert [line.split()[0] for line in text] == ["3", "finished", "running", "unreadable"]
    assert call(capsys, "status", "a", "--all", "--out", tmp_path).status == 2


@pytest.mark.parametrize("state", [State.RUNNING, State.STOPPED])
def test_the_verdict_of_before_is_none_of_a_run_that_is_not_finished(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], state: State
) -> None:
    """Dwells were taken back since, or it goes on."""
    (run,) = night(tmp_path, state)
    (run / "verdict.json").write_text('{"sentence": "Sound."}', encoding="utf-8")
    assert "verdict" not in call(capsys, "status", run, "--json").document
    assert "Sound." not in call(capsys, "status", run).out


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("a", "--metrics"), "--metrics prints every run: got 'a' as well; give one of the two"),
        (("--metrics", "--all"), "--metrics prints every run as Prometheus text: got --all as well; leave one out"),
        (("--metrics", "--json"), "--metrics prints every run as Prometheus text: got --json as well; leave one out"),
        (("--all", "--follow"), "--follow belongs to the lines of one run, not to --all; leave one out"),
        (("--metrics", "--follow"), "--follow belongs to the lines of one run, not to --metrics; leave one out"),
        (("a", "--json", "--follow"), "--follow belongs to the lines of one run, not to --json; leave one out"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_two_forms_of_a_status_are_refused_and_none_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], sentence: str
) -> None:
    make_run(tmp_path / "a", State.FINISHED)
    asked = call(capsys, "status", *options, "--out", tmp_path)
    assert (asked.status, asked.out) == (2, "")
    assert f"status: {sentence}" in asked.err
    assert 'run="a"' in call(capsys, "status", "--metrics", "--out", tmp_path).out
