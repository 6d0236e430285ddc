"""The last lines of a run that did not finish: what a terminal of 24 rows still shows in the morning."""

import sys
from pathlib import Path

import pytest
from command import call
from job_files import job
from terminal_window import TerminalWindow

REVERSED = {"sensitivity_v_per_g = 2.48": "sensitivity_v_per_g = -2.48"}


@pytest.mark.usefixtures("no_report")
def test_a_run_that_did_not_finish_ends_with_state_cause_page_and_next_step(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    procedure, rig = job(tmp_path, rig_changes=REVERSED)
    begun = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "runs", "--json")
    run_folder = begun.document["run"]
    resumed = call(capsys, "resume", run_folder, "--operator", "anna", "--reason", "it is so")
    page = call(capsys, "handover", run_folder).out.splitlines()
    for outcome in (begun, resumed):
        assert outcome.status == 3
        state, why, to_do = outcome.err.splitlines()[-3:]
        assert state.startswith("state      tripped since "), "and the cause"
        assert "polarity reversed" in state
        assert why == f"page       {Path(run_folder) / 'why.html'}"
        assert to_do.startswith("next       ")
        assert f"calrig resume {run_folder} --operator NAME --reason TEXT" in to_do
    assert {state, to_do} < set(page), "in handover's own words"


@pytest.mark.thorough
def test_the_last_screen_of_a_trip_says_why_where_and_what_to_do(tmp_path: Path) -> None:
    procedure, rig = job(tmp_path, rig_changes=REVERSED)
    command = [sys.executable, "-m", "procedures.cli.main", "run", procedure, "--rig", rig, "--out", tmp_path / "r"]
    with TerminalWindow(command, columns=80, lines=24) as window:
        window.wait_for("next       ", within_s=60.0)
        assert window.process.wait(60) == 3
        shown = " ".join(window.wait_for("--reason TEXT").split())
    for words in ("state tripped since", "polarity reversed", "why.html", "calrig resume"):
        assert words in shown
