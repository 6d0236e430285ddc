"""A run that is finished while its results are still being made: nobody makes them a second time meanwhile."""

import os
from dataclasses import replace
from pathlib import Path

import pytest
from command import call
from small_disk import small_disk
from small_run import PROCEDURE, RIG, bench

from procedures.cli.run import run as command
from procedures.cli.run.last_word import last_word
from procedures.delivery.deliver import Delivery, deliver, solve_run
from procedures.journal.sidecar.delivering import delivered_by, delivering
from procedures.journal.sidecar.owner import owning
from procedures.records.states import State
from procedures.run.handover import handover


def test_whoever_looks_while_results_are_made_is_told_to_wait_and_no_second_solve_begins(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rig.toml").write_text(RIG, encoding="utf-8")
    (tmp_path / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    said: dict[str, str] = {}

    def looked_at(solved: object, *more: object) -> Delivery:
        (run_dir,) = (tmp_path / "runs").glob("2*")
        for word in ("handover", "status", "solve"):
            outcome = call(capsys, word, run_dir)
            said[word] = outcome.out + outcome.err
        said["refused"] = str(outcome.status)
        return deliver(solved, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(command, "deliver", looked_at)
    words = ["run", tmp_path / "procedure.toml", "--rig", tmp_path / "rig.toml", "--out", tmp_path / "runs"]
    assert call(capsys, *words).status == 0
    process = f"being delivered by process {os.getpid()} since "
    assert f"next       wait: its results are {process}" in said["handover"]
    assert "calrig solve" not in said["handover"]
    assert f"results: {process}" in said["status"]
    assert f"its results are {process}" in said["solve"]
    assert said["refused"] == "2"
    (run_dir,) = (tmp_path / "runs").glob("2*")
    assert delivered_by(run_dir) == ""
    assert "being delivered" not in call(capsys, "handover", run_dir).out


def test_a_folder_that_takes_no_lock_hinders_no_delivery(tmp_path: Path) -> None:
    with delivering(tmp_path / "away"):
        assert delivered_by(tmp_path / "away") == ""


def test_a_disk_that_takes_no_word_of_who_delivers_hinders_no_delivery(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk", "64k") as disk:
        disk.fill()
        with delivering(disk.path):
            pass


def test_a_file_that_takes_no_word_of_who_runs_is_named(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk", "64k") as disk:
        disk.fill()
        with pytest.raises(OSError, match=r"No space left on device: .*owner"), owning(disk.path):
            pass


def test_results_that_could_not_be_written_are_named_by_status_handover_and_alert(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The alert leads to no report that is not there."""
    small = bench(tmp_path)
    run_dir = tmp_path / "run"
    assert small.run(run_dir).state is State.FINISHED
    for page in (call(capsys, "status", run_dir).out, handover(run_dir)):
        assert "no verdict, no coefficient file of this end is written; calrig solve" in page
    delivery = deliver(solve_run(run_dir), None)
    assert "file://" in last_word(delivery)[1]
    unreported = replace(delivery, parts={**delivery.parts, "html": "report.html: cannot be written"})
    text = last_word(unreported)[1]
    assert f"There is no report yet: calrig solve {run_dir} makes it." in text
    assert "file://" not in text
    assert "in the report" not in text
    for page in (call(capsys, "status", run_dir).out, handover(run_dir)):
        assert "no coefficient file" not in page
