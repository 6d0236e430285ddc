"""``calrig status`` of a run with dwells that are damaged: each by name, and what becomes of the run."""

import sqlite3
from pathlib import Path

import pytest
from command import call
from finished_job import FinishedJob

DAMAGES = {
    "samples": "UPDATE dwells SET samples = zeroblob(length(samples)) WHERE step = 7",
    "a number": "UPDATE dwells SET record = replace(record, '\"attempt\":1', '\"attempt\":3') WHERE step = 7",
    "half a text": "UPDATE dwells SET record = substr(record, 1, 50) WHERE step = 7",
    "no text": "UPDATE dwells SET record = CAST(x'7bff' AS TEXT) WHERE step = 7",
    "no object": "UPDATE dwells SET record = 12, samples = 'abc' WHERE step = 7",
    "its sum": "UPDATE dwells SET sha256 = CAST(x'ff' AS TEXT) WHERE step = 7",
    "whether it counts": "UPDATE dwells SET accepted = 1 - accepted WHERE step = 7",
    "gone": "DELETE FROM dwells WHERE step = 7",
}
NAME = "step 7, attempt 1, epoch 1"


def _damaged(run: Path, statement: str) -> Path:
    with sqlite3.connect(run / "journal.sqlite") as journal:
        assert journal.execute(statement).rowcount == 1
    journal.close()
    (run / "journal.count").unlink(missing_ok=True)  # what is copied without it says no less
    return run


@pytest.mark.parametrize("damage", DAMAGES)
def test_status_names_a_damaged_dwell_and_what_becomes_of_the_run(
    damage: str, finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = finished_job.copied_to(tmp_path)
    assert "\ndamaged: " not in call(capsys, "status", run).out
    assert "damaged" not in call(capsys, "status", run, "--json").document
    _damaged(run, DAMAGES[damage])
    looked = call(capsys, "status", run)
    (line,) = [line for line in looked.out.splitlines() if line.startswith("damaged: ")]
    assert (looked.status, f"{run}/journal.sqlite: the dwell of {NAME} is not as it was written" in line) == (2, True)
    assert "dwells, by a journal that is damaged\n" in looked.out
    assert f"calrig salvage {run} takes the rest" in line
    assert call(capsys, "status", run, "--json").document["damaged"] == [NAME]
    refused = call(capsys, "solve", run)
    assert (refused.status, refused.out) == (2, "")
    assert NAME in refused.err or "dwells were committed" in refused.err


def test_the_list_of_runs_and_the_metrics_say_by_which_journal_they_count(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = finished_job.copied_to(tmp_path)
    assert "damaged" not in call(capsys, "status", "--all", "--out", run.parent).out
    figure = f'calrig_run_damaged{{run="{run.name}"}}'
    assert f"{figure} 0\n" in call(capsys, "status", "--metrics", "--out", run.parent).out
    _damaged(run, DAMAGES["its sum"])
    listed = call(capsys, "status", "--all", "--out", run.parent)
    assert f"by a journal that is damaged: {NAME} not as written; calrig status {run} names what is" in listed.out
    assert f"{figure} 1\n" in call(capsys, "status", "--metrics", "--out", run.parent).out
    (entry,) = call(capsys, "status", "--all", "--json", "--out", run.parent).document["runs"]
    assert entry["damaged"] == [NAME]


@pytest.mark.parametrize("of_json", [(), ("--json",)])
def test_the_list_of_runs_ends_with_the_highest_status_of_any_of_them(
    of_json: tuple[str, ...], finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """DESIGN 5: a file that is wrong or corrupt 2, status of a readable run 0."""
    whole = finished_job.copied_to(tmp_path / "whole")
    everywhere = ("status", "--all", *of_json, "--out")
    assert call(capsys, *everywhere, whole.parent).status == 0
    damaged = _damaged(finished_job.copied_to(tmp_path / "damaged"), DAMAGES["its sum"])
    no_journal = finished_job.copied_to(tmp_path / "no-journal")
    (no_journal / "journal.sqlite").write_bytes(b"no journal")
    for run in (damaged, no_journal):
        beside = run.rename(whole.parent / run.parent.name)
        assert call(capsys, *everywhere, whole.parent).status == call(capsys, "status", beside).status == 2
        beside.rename(run)
    assert call(capsys, *everywhere, whole.parent).status == 0


@pytest.mark.parametrize("damage", ["half a text", "no text", "no object", "its sum"])
def test_handover_and_salvage_say_which_dwell(
    damage: str, finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = _damaged(finished_job.copied_to(tmp_path), DAMAGES[damage])
    page = call(capsys, "handover", run)
    assert NAME in page.out + page.err
    assert f"damaged, to be measured again: {NAME}" in call(capsys, "salvage", run).out


def test_a_salvaged_run_names_nothing_as_damaged(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = _damaged(finished_job.copied_to(tmp_path), DAMAGES["samples"])
    assert call(capsys, "salvage", run, "--to", tmp_path / "new").status == 0
    assert "damaged" not in call(capsys, "status", tmp_path / "new", "--json").document


EVENTS = {
    "detail = detail || ' '": "event 20 (",
    "detail = replace(detail, '}', ' }')": "event 20 (",
    "sha256 = 'f' || sha256": "event 20 (",
    "kind = 'lost'": "event 20 (lost)",
    "monotonic_s = monotonic_s + 1": "event 20 (",
}


@pytest.mark.parametrize("change", EVENTS)
def test_status_and_handover_name_a_damaged_event_and_what_becomes_of_the_run(
    change: str, finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = _damaged(finished_job.copied_to(tmp_path), f"UPDATE events SET {change} WHERE sequence = 20")
    looked, handed = call(capsys, "status", run), call(capsys, "handover", run)
    lines = [line for line in looked.out.splitlines() if line.startswith("damaged: ")]
    assert f"damaged: {run}/journal.sqlite: {EVENTS[change]}" in lines[0]
    assert f"calrig salvage {run} takes the rest" in lines[0]
    assert (looked.status, handed.status) == (2, 2)
    assert "dwells, by a journal that is damaged\n" in looked.out
    assert f"damaged    {EVENTS[change]}" in handed.out
    assert f"next       calrig solve and calrig resume refuse the run; calrig salvage {run}" in handed.out
    told = call(capsys, "status", run, "--json")
    assert (told.status, told.document["damaged"][0].startswith(EVENTS[change])) == (2, True)
    assert call(capsys, "solve", run).status == 2


def test_status_names_an_event_that_is_gone(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    statement = "DELETE FROM events WHERE sequence = (SELECT max(sequence) FROM events WHERE kind = 'intent')"
    looked = call(capsys, "status", _damaged(finished_job.copied_to(tmp_path), statement))
    assert looked.status == 2
    assert "(missing) is not as it was written" in looked.out
