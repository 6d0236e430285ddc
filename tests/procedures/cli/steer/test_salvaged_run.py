"""A run that was salvaged with a line of its record lost: no page and no file tells its results as usable."""

import json
import sqlite3
from pathlib import Path

import pytest
from command import call
from finished_job import FinishedJob

TAKING_BACK = ("--replication", 2, "--operator", "Anna", "--reason", "a bump")
LOSSES = {
    "a line that takes nothing away": "UPDATE events SET detail = detail || ' ' WHERE sequence = "
    "(SELECT max(sequence) FROM events WHERE kind = 'intent')",
    "the line that took dwells back, gone": "DELETE FROM events WHERE kind = 'voided'",
    "the end": "DELETE FROM events WHERE sequence >= (SELECT max(sequence) FROM events WHERE kind = 'voided')",
}


def _changed(run: Path, statement: str) -> None:
    connection = sqlite3.connect(run / "journal.sqlite")
    assert connection.execute(statement).rowcount >= 1
    connection.commit()
    connection.close()


@pytest.mark.parametrize("loss", LOSSES)
def test_no_result_of_a_run_is_usable_whose_record_lost_a_line(
    loss: str, finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, new = finished_job.copied_to(tmp_path), tmp_path / "new"
    assert call(capsys, "redo", run, *TAKING_BACK).status == 0
    _changed(run, LOSSES[loss])
    said = call(capsys, "salvage", run, "--to", new).out
    assert "\nlost: " in said
    assert "\nnot usable: what is lost may have taken back dwells" in said
    solved = call(capsys, "solve", new)
    assert "lines of the run's record are lost" in " ".join(solved.out.split())
    verdict = json.loads((new / "verdict.json").read_text(encoding="utf-8"))
    assert verdict["trust"] == "unusable"
    assert {row["verdict"] for row in verdict["sensors"]} == {"not usable"}
    assert "the journal was damaged and salvaged" in (new / "report.html").read_text(encoding="utf-8")
    assert "salvaged" in call(capsys, "handover", new).out


def test_dwells_that_were_taken_back_stay_out_of_the_salvaged_run(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, new = finished_job.copied_to(tmp_path), tmp_path / "new"
    assert call(capsys, "redo", run, *TAKING_BACK).status == 0
    before = call(capsys, "status", run, "--json").document
    _changed(run, "UPDATE events SET detail = replace(detail, 'a bump', 'a bomp') WHERE kind = 'voided'")
    assert call(capsys, "solve", run).status == 2
    assert "stays taken back" in call(capsys, "salvage", run, "--to", new).out
    after = call(capsys, "status", new, "--json").document
    assert (after["state"], after["dwells_done"]) == ("stopped", before["dwells_done"])


def test_the_sets_of_a_finished_run_say_so_and_go_into_quarantine(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = finished_job.copied_to(tmp_path)
    new = run.with_name("salvaged")
    _changed(run, LOSSES["a line that takes nothing away"])
    assert "damaged, to be measured again" not in call(capsys, "salvage", run, "--to", new).out
    assert "the archive has it with another journal" in " ".join(call(capsys, "solve", new).err.split())
    archive = ("--archive", f"sqlite:///{tmp_path}/new.sqlite")
    assert call(capsys, "archive", "publish", new, *archive).status == 0
    paths = list((new / "coefficients").glob("*.json"))
    assert paths
    for path in paths:
        document = json.loads(path.read_text(encoding="utf-8"))
        assert document["verdict"] == "not usable"
        assert any("salvaged" in str(text) for text in document["warnings"])
        shown = call(capsys, "archive", "show", document["sensor"]["name"], *archive)
        assert "quarantine" in shown.out + shown.err
