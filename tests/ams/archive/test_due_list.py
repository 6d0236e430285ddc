"""The desk: what is due by its own dates, runs by any word that is known of them."""

from datetime import UTC, date, datetime, timedelta
from typing import Any

import pytest
from archived_runs import a_run, a_sensor

from ams.archive.due_list import due_list, search_runs
from ams.archive.runs import Override, publish_run, standards_used

NOW = datetime(2026, 6, 1, tzinfo=UTC)


@pytest.fixture
def two_runs(archive: Any) -> str:
    for day in (0, 180):
        publish_run(archive.url, a_run(day), [a_sensor(day)], NOW, override=Override("anna", "known"))
    return str(archive.url)


def test_every_word_must_be_known_of_a_run_and_none_finds_all(two_runs: str) -> None:
    first = a_run(0)
    assert [search_run.run.run_id for search_run in search_runs(two_runs, [])] == ["run-180", "run-0"]
    assert [search_run.run.run_id for search_run in search_runs(two_runs, ["RUN-0"])] == ["run-0"]
    assert [
        search_run.run.run_id for search_run in search_runs(two_runs, ["sn1", first.run_id, first.operator.upper()])
    ] == ["run-0"]
    assert search_runs(two_runs, ["sn1", "nobody-wrote-this"]) == ()
    assert search_runs(two_runs, ["%"]) == search_runs(two_runs, ["_%_%_"]) == ()


def test_a_standard_finds_what_was_measured_with_it(two_runs: str) -> None:
    (use, _), *_ = standards_used(two_runs, a_run(0).journal_sha256)
    found = search_runs(two_runs, [use.serial])
    assert "run-0" in [entry.run.run_id for entry in found]
    assert all(use.serial in entry.standards and entry.sensors == ("SN1",) for entry in found)


def test_what_is_due_first_comes_first(two_runs: str) -> None:
    found = due_list(two_runs, sensor_every_days=30)
    dates = [entry.due for entry in found if entry.due is not None]
    assert dates == sorted(dates)
    sensor = next(entry for entry in found if entry.kind == "sensor")
    assert sensor.name == "SN1"
    assert sensor.due is not None
    assert sensor.days_left(sensor.due + timedelta(days=3)) == -3
    later = next(entry for entry in due_list(two_runs, sensor_every_days=40) if entry.kind == "sensor")
    assert later.due == sensor.due + timedelta(days=10)
    assert [
        entry for entry in found if entry.kind == "standard" and entry.due is not None and entry.due < date(2020, 1, 1)
    ] == []
