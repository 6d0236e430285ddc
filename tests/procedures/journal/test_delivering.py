"""A run that is finished while its results are still being made: nobody makes them a second time meanwhile."""

import os
from pathlib import Path

import pytest
from command import call
from small_run import PROCEDURE, RIG

from procedures.cli.run import run as command
from procedures.delivery.deliver import Delivery, deliver
from procedures.journal.delivering import delivered_by, delivering


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
