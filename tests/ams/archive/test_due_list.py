"""The desk: what is due by its own dates, runs by any word that is known of them."""

import json
import re
from dataclasses import replace
from datetime import UTC, date, datetime, timedelta
from typing import Any

import pytest
from archived_runs import a_run, a_sensor, turned

from ams.archive.due_list import Due, due_list
from ams.archive.run_search import search_runs
from ams.archive.runs import Override, publish_run, standards_used
from ams.archive.signatures import sign
from ams.errors import ArchiveUnknown

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


def test_a_recall_names_every_run_of_that_standard_and_no_other(archive: Any) -> None:
    """The number of one standard begins that of another, and stands in the title of a third run."""
    for day, serial in ((0, "AA-2216"), (1, "AA-2216-B"), (2, "QL-9"), (3, "AA-2216")):
        run = replace(a_run(day), title=f"instead of {serial[:7]}" if day != 2 else "instead of AA-2216")
        publish_run(archive.url, run, [a_sensor(day, standard=serial)], NOW)

    def recalled(serial: str, *words: str) -> list[str]:
        return [entry.run.run_id for entry in search_runs(archive.url, words, serial)]

    assert recalled("AA-2216") == ["run-3", "run-0"]
    assert recalled("AA-2216-B") == ["run-1"]
    assert recalled("AA-2216", "RUN-3") == ["run-3"]
    assert len(search_runs(archive.url, ["AA-2216"])) == 4
    with pytest.raises(
        ArchiveUnknown, match=r"'AA-22', which stands behind no run of the archive; .*AA-2216, AA-2216-B"
    ):
        search_runs(archive.url, [], "AA-22")


def test_a_word_is_found_where_somebody_wrote_it_and_not_in_a_key_or_a_digit(archive: Any) -> None:
    for day, customer in ((0, "MÜLLER Windkanal"), (1, 'Smith & "Sons"')):
        publish_run(archive.url, a_run(day), [a_sensor(day, customer=customer)], NOW)
    assert [entry.run.run_id for entry in search_runs(archive.url, ["müller"])] == ["run-0"]
    assert [entry.run.run_id for entry in search_runs(archive.url, ["WINDKANAL", "Müller"])] == ["run-0"]
    assert [entry.run.run_id for entry in search_runs(archive.url, ['"sons"'])] == ["run-1"]
    assert search_runs(archive.url, ["customer"]) == ()
    digits = re.findall(r"\d\.\d{6}", json.dumps(a_sensor(0).coefficients.document["axes"]))
    assert len(digits) > 10
    assert search_runs(archive.url, digits[:1]) == ()
    assert [entry.run.run_id for entry in search_runs(archive.url, ["2026-01-11"])] == ["run-1", "run-0"]


def test_a_sensor_whose_newest_set_fell_is_due_by_the_one_that_stands(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    publish_run(archive.url, a_run(100), [turned(a_sensor(100))], NOW)
    assert _sensors_due(archive.url) == {"SN1": ("calibrated 2026-01-11", date(2027, 1, 11))}
    sign(archive.url, "SN1", "withdrawn", "A. Ray", NOW, "dropped")
    ((because, due),) = _sensors_due(archive.url).values()
    assert because.startswith("no set stands: that of 2026-04-21 is in quarantine")
    assert due == date(2026, 4, 21)


def _sensors_due(url: str) -> dict[str, tuple[str, date | None]]:
    return {item.name: (item.because, item.due) for item in due_list(url) if item.kind == "sensor"}


@pytest.mark.parametrize(
    ("due", "words"),
    [
        (None, "no date"), (date(2026, 6, 1), "today"), (date(2026, 6, 2), "in 1 day"),
        (date(2026, 6, 11), "in 10 days"), (date(2026, 5, 31), "1 day over"), (date(2025, 6, 1), "365 days over"),
    ],
)  # fmt: skip
def test_days_are_told_as_people_say_them(due: date | None, words: str) -> None:
    assert Due("standard", "table", "AA-2216", "certificate 1", due).when(date(2026, 6, 1)) == words
