"""A run that is solved again elsewhere keeps the set that is there, and the signatures on it."""

import sqlite3
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from finished_job import FinishedJob

from ams.archive.sets import list_sets, publish, show
from ams.archive.signatures import sign
from procedures.delivery.deliver import SolvedRun, deliver, set_of, solve_run
from procedures.delivery.kept_sets import kept_sets

MOMENT = datetime(2026, 3, 2, 9, tzinfo=UTC)


def _moved(run: SolvedRun, by: float) -> SolvedRun:
    """Return the run as another processor solves it: every number a little larger."""
    sensors = {}
    for name, solved in run.sensors.items():
        assert solved.calibration is not None
        axes = {
            label: replace(axis, primary=np.nextafter(axis.primary * (1.0 + by), np.inf))
            for label, axis in solved.calibration.axes.items()
        }
        sensors[name] = replace(solved, calibration=replace(solved.calibration, axes=axes))
    return replace(run, sensors=sensors)


def test_last_digits_of_another_processor_make_no_second_set(finished_job: FinishedJob, tmp_path: Path) -> None:
    solved, url = solve_run(finished_job.copied_to(tmp_path)), f"sqlite:///{tmp_path / 'other.sqlite'}"
    sensor, *_ = solved.sensors
    first = set_of(solved, sensor)
    publish(url, [first], MOMENT)
    elsewhere = set_of(_moved(solved, 0.0), sensor)
    assert elsewhere.sha256 != first.sha256
    assert kept_sets(url, {sensor: elsewhere})[sensor].document == first.document
    assert kept_sets(url, {sensor: set_of(_moved(solved, 1e-9), sensor)}) == {}
    sign(url, sensor, "withdrawn", "A. Operator", MOMENT, "the sensor was dropped")
    kept = kept_sets(url, {sensor: elsewhere})[sensor]
    assert (kept.sha256, kept.status) == (first.sha256, "withdrawn"), "it does not stand again under other digits"


def test_an_archive_that_is_not_there_keeps_nothing(finished_job: FinishedJob, tmp_path: Path) -> None:
    solved = solve_run(finished_job.copied_to(tmp_path))
    sensor, *_ = solved.sensors
    assert kept_sets(f"sqlite:///{tmp_path / 'none.sqlite'}", {sensor: set_of(solved, sensor)}) == {}


@pytest.mark.thorough
def test_the_signed_set_stays_what_counts_and_its_file_the_same(finished_job: FinishedJob, tmp_path: Path) -> None:
    run, url = finished_job.copied_to(tmp_path), f"sqlite:///{tmp_path / 'other.sqlite'}"
    solved = solve_run(run)
    first = deliver(solved, url)
    (sensor, path), *_ = first.sets.items()
    written = path.read_bytes()
    sign(url, sensor, "prepared", "A. Operator", MOMENT)
    again = deliver(_moved(solved, 0.0), url)
    assert set(again.parts.values()) == {"done"}
    assert [entry.sha256 for entry in list_sets(url, sensor)] == [show(url, sensor).sha256]
    assert path.read_bytes() == written
    deliver(_moved(solved, 1e-9), url)
    assert len(list_sets(url, sensor)) == 2, "another result is another set"


@pytest.mark.parametrize("damage", ["UPDATE sets SET created_utc = 'x'", "DROP TABLE verdicts"])
def test_a_damaged_archive_takes_no_set_no_export_no_page_and_no_paper(
    damage: str, finished_job: FinishedJob, tmp_path: Path
) -> None:
    path = tmp_path / "other.sqlite"
    solved, url = solve_run(finished_job.copied_to(tmp_path)), f"sqlite:///{path}"
    deliver(solved, url)
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute(damage)
    before = path.read_bytes()
    again = deliver(solved, url)
    assert again.parts["archive"].startswith(f"{path}: the archive is damaged (")
    others = {part: word for part, word in again.parts.items() if part not in ("archive", "lessons")}
    assert others == dict.fromkeys(("set", "exports", "html", "pdf"), "done")
    assert again.parts["lessons"] == "not due: the run is not archived"
    assert not again.defects
    assert path.read_bytes() == before
