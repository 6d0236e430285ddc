"""What stands beside a journal for people, and is not as it was written any more: none of it is told as the run's."""

import json
from pathlib import Path

import pytest
from command import call
from finished_job import FinishedJob

from procedures.journal.plan_file import PLAN_FILE
from procedures.journal.sidecar.verdict_file import CHANGED, VERDICT_FILE, read_verdict
from procedures.records.states import State
from procedures.run.handover import handover

SENTENCE = "verdict.json is not as calrig wrote it: nothing of it is told; calrig solve writes it anew"
PLAN = "plan.json is not the plan of this run, which its journal holds; nothing is taken from it"


@pytest.fixture
def run(finished_job: FinishedJob, tmp_path: Path) -> Path:
    return finished_job.copied_to(tmp_path)


def test_a_verdict_that_somebody_changed_is_told_nowhere(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In status, on the page of the shift, for programs; who has written it anew is believed."""
    file = run / VERDICT_FILE
    written = json.loads(file.read_text(encoding="utf-8"))
    assert read_verdict(run, State.FINISHED) == written
    file.write_text(json.dumps({**written, "sentence": "All sensors are sound."}), encoding="utf-8")
    assert read_verdict(run, State.FINISHED) == CHANGED
    assert f"verdict: {SENTENCE}\n" in call(capsys, "status", run).out
    assert call(capsys, "status", run, "--json").document["verdict"] == SENTENCE
    page = handover(run)
    assert f"verdict    {SENTENCE}\n" in page
    assert "sound" not in page
    file.write_text(json.dumps(written), encoding="utf-8")  # the same in another layout
    assert read_verdict(run, State.FINISHED) == written


@pytest.mark.parametrize("key", ["trust", "grounds", "state", "sensors"])
def test_no_part_of_a_verdict_can_be_changed_unseen(run: Path, key: str) -> None:
    file = run / VERDICT_FILE
    written = json.loads(file.read_text(encoding="utf-8"))
    file.write_text(json.dumps({**written, key: "finished" if key == "sensors" else [key]}), encoding="utf-8")
    assert read_verdict(run, State.FINISHED) == CHANGED


@pytest.mark.parametrize("checksum", [None, "", {}, {"sha256": "0"}, {"sha256": None}])
def test_a_checksum_that_is_none_holds_for_nothing(run: Path, checksum: object) -> None:
    file = run / VERDICT_FILE
    written = json.loads(file.read_text(encoding="utf-8"))
    file.write_text(json.dumps({**written, "checksum": checksum}), encoding="utf-8")
    assert read_verdict(run, State.FINISHED) == CHANGED


def test_a_plan_that_somebody_changed_is_said_to_be_none_of_the_run(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = run / PLAN_FILE
    assert "plan.json" not in call(capsys, "status", run).out + handover(run)
    file.write_text(file.read_text(encoding="utf-8").replace("1", "2", 1), encoding="utf-8")
    assert f"\nplan: {PLAN}\n" in call(capsys, "status", run).out
    assert call(capsys, "status", run, "--json").document["plan"] == PLAN
    assert f"plan       {PLAN}\n" in handover(run)
    file.unlink()
    assert "plan.json" not in call(capsys, "status", run).out, "who took it away has seen that"
