"""What the console does and says of sets whose dwells were taken back, and of those that were measured after."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from archived_runs import a_run, a_sensor
from finished_job import FinishedJob

from ams.archive.runs import publish_run
from ams.archive.sets import list_sets
from ams.archive.signatures import sign
from procedures.console.acts import Action, perform
from procedures.console.withdrawn_sets import withdrawn_sentence
from procedures.journal.journal_reader import JournalReader
from rig.clock import SystemClock

NOW = datetime(2026, 3, 5, tzinfo=UTC)


def test_dwells_taken_back_on_a_page_withdraw_the_set_in_the_archive_of_the_run(
    finished_job: FinishedJob, tmp_path: Path
) -> None:
    """The console looks at another archive; the run's is the one beside it, as it is simulated."""
    run = finished_job.copied_to(tmp_path)
    with JournalReader.open(run) as reader:
        entered = reader.last_event("state")
    assert entered is not None
    action = Action("redo", "Anna", "127.0.0.1", "k1", entered.sequence, "fixture was loose", 1, False, {})
    answer = perform(run, action, SystemClock(), f"sqlite:///{tmp_path / 'laboratory.sqlite'}")
    assert answer.status == 202
    assert "superseded-1: holds the sets, exports and report of before" in answer.message
    assert "withdrawn in the archive" in answer.message
    (entry,) = list_sets(f"sqlite:///{run.parent / 'archive.sqlite'}")
    assert (entry.status, entry.withdrawal and entry.withdrawal.name) == ("withdrawn", "Anna")
    assert not (tmp_path / "laboratory.sqlite").exists()


def test_a_run_whose_set_was_measured_again_is_not_said_to_be_withdrawn(tmp_path: Path) -> None:
    url, before, after = f"sqlite:///{tmp_path / 'archive.sqlite'}", a_sensor(0), a_sensor(1)
    publish_run(url, a_run(0), [before], NOW)
    sign(url, "SN1", "withdrawn", "Anna", NOW, "bumped")
    assert "the set of SN1 is withdrawn by Anna" in withdrawn_sentence(url, "run-0")
    provenance = {**after.coefficients.provenance, "run_id": "run-0"}
    document = {**after.coefficients.document, "provenance": provenance}
    again = replace(after, coefficients=replace(after.coefficients, document=document))
    publish_run(url, replace(a_run(1), run_id="run-0"), [again], NOW, lineage=[a_run(0).journal_sha256])
    assert [entry.status for entry in list_sets(url)] == ["withdrawn", "engineering"]
    assert withdrawn_sentence(url, "run-0") == ""
