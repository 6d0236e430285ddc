"""What is measured is delivered, whatever the archive can tell of the years before."""

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from command import call
from finished_job import FinishedJob
from job_files import job

from ams.errors import ArchiveError, WriteFailed
from procedures.delivery.deliver import deliver, sets_of, solve_run
from procedures.report.write import draw_report, view_of


@pytest.mark.thorough
def test_a_look_at_the_past_that_fails_is_told_and_costs_no_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def locked(*_: object, **__: object) -> None:
        raise ArchiveError("archive: is locked by another program")

    for location in ("past", "publish"):
        monkeypatch.setattr(f"procedures.delivery.{location}.history", locked)
    procedure, rig = job(tmp_path)
    ran = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "runs")
    assert ran.status == 0
    assert "is locked by another program" in ran.out + ran.err
    (run,) = (tmp_path / "runs").glob("*/journal.sqlite")
    assert (run.parent / "report.html").exists()
    assert list((run.parent / "exports").iterdir())


MAKERS = {
    "set": "_written_sets",
    "archive": "publish_solved",
    "lessons": "teach",
    "exports": "_exported",
    "html": "write_screen",
    "pdf": "write_paper",
}


ERRORS = (WriteFailed("there: no space left"), OSError(28, "No space left"), KeyError("ours"))


def test_a_part_that_cannot_be_delivered_costs_no_other_and_solve_makes_it(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    run = finished_job.copied_to(tmp_path)
    solved, url = solve_run(run), f"sqlite:///{tmp_path / 'other.sqlite'}"
    drawn = draw_report(view_of(solved.record, solved.sensors))
    monkeypatch.setattr("procedures.delivery.deliver.draw_report", lambda *_: drawn)
    for (part, maker), error in zip(MAKERS.items(), cycle(ERRORS)):
        with monkeypatch.context() as broken:
            broken.setattr(f"procedures.delivery.deliver.{maker}", _raises(error))
            delivered = deliver(solved, url)
        assert set(delivered.failures) == {part}
        assert str(error.args[-1]) in delivered.failures[part]
    with monkeypatch.context() as broken:
        broken.setattr("procedures.delivery.deliver.write_paper", _raises(ERRORS[0]))
        outcome = call(capsys, "solve", run)
    assert (outcome.status, f"calrig solve {run} makes what is missing" in outcome.err) == (1, True)
    assert call(capsys, "solve", run).status == 0


def _raises(error: Exception) -> Callable[..., object]:
    def make(*_: object, **__: object) -> object:
        raise error

    return make


@pytest.mark.parametrize("is_recorded", [True, False])
def test_the_set_of_a_run_says_whether_a_temperature_was_recorded(finished_job: FinishedJob, is_recorded: bool) -> None:
    run = solve_run(finished_job.run)
    (solved,) = run.sensors.values()
    degc = np.full(solved.observations.rows, 21.0) if is_recorded else None
    measured = replace(solved, observations=replace(solved.observations, temperature_degc=degc))
    (made,) = sets_of(replace(run, sensors={solved.name: measured})).values()
    assert made.document["temperature_recorded"] is is_recorded
