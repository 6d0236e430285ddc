"""Laws of the messages that left when the journal was closed: what became of them is known, and journalled later."""

from pathlib import Path

import pytest
from small_run import bench
from unattended_run import UnattendedRun, asks, events, run_unattended

from procedures.journal.sidecar.alert_record import FILE, keep_outcomes, outcome_sentence, read_outcomes
from procedures.run.resume import resume
from procedures.run.services import RunServices

RANG: dict[str, object] = {"what": "calrig: night: tripped", "failed": ""}
DEAF: dict[str, object] = {"what": "calrig: night: still tripped", "failed": "ring: exit status 1"}


@pytest.mark.parametrize("is_full", [False, True], ids=["beside it", "at the second place"])
def test_what_became_of_the_last_alerts_is_kept_and_added_to(tmp_path: Path, is_full: bool) -> None:
    run, second = tmp_path / "run", tmp_path / "second"
    if is_full:
        run.write_text("no folder: nothing can be written into it")
    else:
        run.mkdir()
    keep_outcomes(run, second, [])
    assert read_outcomes(run, second) == ()
    keep_outcomes(run, second, [RANG])
    keep_outcomes(run, second, [DEAF])
    assert read_outcomes(run, second) == (RANG, DEAF)
    assert outcome_sentence(DEAF) == "calrig: night: still tripped: not delivered: ring: exit status 1"
    assert ((second / "run" if is_full else run) / FILE).is_file()


def test_a_resume_journals_what_became_of_them(tmp_path: Path) -> None:
    small, run_dir, second = bench(tmp_path), tmp_path / "run", tmp_path / "second"
    run_unattended(small, UnattendedRun(run_dir, after={3: asks("stop")}))
    keep_outcomes(run_dir, second, [RANG, DEAF])
    resume(run_dir, "tester", services=RunServices(second_folder=second))
    assert [event.detail for event in events(run_dir, "alert")] == [RANG, DEAF]
    assert read_outcomes(run_dir, second) == ()
