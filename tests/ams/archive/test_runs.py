"""A published run: all of it or nothing, once; found against what was there before; expired standards answered for."""

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from archived_runs import EXPIRED, TURNED, a_run, a_sensor, turned

from ams.archive.histories import history, population_of
from ams.archive.runs import (
    Override,
    adjustment_of,
    list_runs,
    publish_run,
    run_primaries,
    standards_used,
)
from ams.archive.sets import Search, list_sets, show
from ams.archive.signatures import verify_archive
from ams.errors import ArchiveError
from ams.findings import Finding

NOW = datetime(2026, 6, 1, tzinfo=UTC)
LATER = NOW + timedelta(days=365)
"""When nothing that these tests publish is dated ahead."""
TABLES = ("sets", "coefficients", "points", "runs", "standards", "uses", "adjustments", "records")


def counts(archive: Any) -> dict[str, int]:
    return {table: int(archive.execute(f"SELECT count(*) FROM {table}")[0][0]) for table in TABLES}


def test_a_run_is_published_with_its_sets_standards_and_what_was_found(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    published = publish_run(archive.url, a_run(180), [a_sensor(180, gain=1.001)], NOW, usage_pitch_deg=(-30.0, 30.0))
    found = published.adjustments["SN1"]
    assert found.as_found is not None
    assert (found.as_found.verdict, found.as_left.verdict) == ("fail", "pass")
    assert found.as_found.largest_error_deg == pytest.approx(0.0248, abs=0.001)  # degrees(0.001·sin 30·cos 30)
    stored = adjustment_of(archive.url, "SN1")
    assert stored is not None
    assert stored.as_found is not None
    assert stored.as_found.judgements == found.as_found.judgements
    assert [run.run_id for run in list_runs(archive.url)] == ["run-0", "run-180"]
    assert [(coefficients.as_found, coefficients.as_left) for coefficients in list_sets(archive.url)] == [
        (None, "pass"),
        ("fail", "pass"),
    ]
    (use, word) = standards_used(archive.url, a_run(0).journal_sha256)[0]
    assert (use.certificate, use.uncertainty["uncertainty_arcsec"], word) == ("26-0117", 1.0, None)
    assert verify_archive(archive.url).faults == ()


def test_publishing_a_run_again_changes_nothing_and_tells_the_same(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    first = publish_run(archive.url, a_run(180), [a_sensor(180, gain=1.001)], NOW)
    before = {table: sorted(map(repr, archive.execute(f"SELECT * FROM {table}"))) for table in TABLES}
    again = publish_run(archive.url, a_run(180), [a_sensor(180, gain=1.001)], datetime(2027, 1, 1, tzinfo=UTC))
    assert {table: sorted(map(repr, archive.execute(f"SELECT * FROM {table}"))) for table in TABLES} == before
    assert [publication.is_new for publication in again.publications] == [False]
    assert again.adjustments["SN1"].as_found is not None
    assert again.adjustments["SN1"].as_found.judgements == first.adjustments["SN1"].as_found.judgements  # type: ignore[union-attr]


def test_a_newer_solution_of_a_run_is_found_against_the_run_before_and_counts_in_history(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    publish_run(archive.url, a_run(180), [a_sensor(180)], NOW)
    newer = a_sensor(180, version="0.2.0", gain=1.0 + 1e-9)
    published = publish_run(archive.url, a_run(180), [newer], datetime(2026, 7, 1, tzinfo=UTC))
    assert published.adjustments["SN1"].as_found is not None
    assert published.adjustments["SN1"].as_found.set_sha256 == a_sensor(0).coefficients.sha256
    labels = population_of(archive.url, "SN1").labels
    assert [label.run_id for label in labels] == ["run-0", "run-180"]
    assert labels[-1].sha256 == newer.coefficients.sha256
    primary = json.loads(run_primaries(archive.url)["run-180"]["SN1"])["axes"]["x"]["primary"]
    assert primary["values"] == dict(newer.coefficients.axes["x"].primary)


def test_an_expired_standard_is_refused_unless_somebody_answers_for_it(archive: Any) -> None:
    late = a_sensor(0, due=EXPIRED)
    day = a_run(0).ended_utc.astimezone().date()
    with pytest.raises(ArchiveError, match=rf"standards expired before the run ended on {day}: table \(26-0117, due"):
        publish_run(archive.url, a_run(0), [late], NOW)
    for word in (Override("", "why not"), Override("B. Boss", "  ")):
        with pytest.raises(ArchiveError, match="an override needs a name and a reason"):
            publish_run(archive.url, a_run(0), [late], NOW, override=word)
    word = Override("B. Boss", "certificate is in the post")
    publish_run(archive.url, a_run(0), [late], NOW, override=word)
    ((_, found),) = standards_used(archive.url, a_run(0).journal_sha256)
    assert found == word
    (detail,) = archive.execute("SELECT detail FROM records WHERE kind = 'run'")[0]
    assert "certificate is in the post" in detail
    assert verify_archive(archive.url).faults == ()


def test_nothing_of_a_simulated_run_expires_and_it_never_stands_before_a_measured_one(archive: Any) -> None:
    publish_run(archive.url, a_run(0, simulated=True), [a_sensor(0, due=EXPIRED, simulated=True)], NOW)
    published = publish_run(archive.url, a_run(1), [a_sensor(1)], NOW)
    assert published.adjustments["SN1"].no_as_found == "first calibration in this archive"
    assert [label.run_id for label in population_of(archive.url, "SN1").labels] == ["run-1"]


def test_a_run_is_whole_or_not_there(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    before = counts(archive)
    trap = (
        "CREATE TRIGGER trap BEFORE INSERT ON adjustments BEGIN SELECT RAISE(ABORT, 'database or disk is full'); END"
        if archive.is_sqlite
        else "CREATE RULE trap AS ON INSERT TO adjustments DO INSTEAD SELECT 1 / (count(*) - count(*)) FROM adjustments"
    )
    archive.execute(trap)
    with pytest.raises(ArchiveError, match="nothing was changed"):
        publish_run(archive.url, a_run(1), [a_sensor(1), a_sensor(1, "SN2")], NOW)
    assert counts(archive) == before


def test_two_publishers_at_once_lose_nothing_and_find_each_other(archive: Any) -> None:
    runs = [(a_run(day), [a_sensor(day, gain=1.0 + 1e-6 * day)]) for day in range(8)]
    with ThreadPoolExecutor(4) as pool:
        waiting = [
            pool.submit(publish_run, archive.url, run, sensors, NOW, busy_timeout_s=60.0) for run, sensors in runs
        ]
        done = [future.result() for future in waiting]
    assert len(list_sets(archive.url)) == len(list_runs(archive.url)) == len(done) == 8
    assert sum(entry.adjustments["SN1"].as_found is None for entry in done) <= 8
    assert verify_archive(archive.url).faults == ()


PUBLISH_UNTIL_KILLED = """
import sys
from datetime import UTC, datetime, timedelta
sys.path.insert(0, sys.argv[2])
from archived_runs import a_run, a_sensor
from ams.archive.runs import publish_run
runs = [(a_run(day), [a_sensor(day), a_sensor(day, "SN2")]) for day in range(9)]
print("ready", flush=True)
for run, sensors in runs:
    publish_run(sys.argv[1], run, sensors, datetime(2026, 6, 1, tzinfo=UTC))
    print(run.run_id, flush=True)
"""


def test_a_killed_publisher_leaves_whole_runs_and_everything_it_acknowledged(archive: Any) -> None:
    support = str(Path(__file__).parents[2] / "support")
    command = [sys.executable, "-c", PUBLISH_UNTIL_KILLED, archive.url, support]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        acknowledged = [writer.stdout.readline().strip() for _ in range(4)][1:]
        writer.kill()
    stored = [run.run_id for run in list_runs(archive.url)]
    assert set(acknowledged) <= set(stored)
    for run_id in stored:
        assert len(list_sets(archive.url, search=Search(run_id=run_id))) == 2
    assert counts(archive)["adjustments"] == 2 * len(stored)
    assert verify_archive(archive.url).faults == ()


def test_sets_are_found_by_serial_rig_run_and_day(archive: Any) -> None:
    for day in (0, 180):
        publish_run(archive.url, a_run(day), [a_sensor(day), a_sensor(day, "SN2")], NOW)
    url = archive.url

    def found(**wanted: Any) -> list[tuple[str, str | None]]:
        return [(coefficients.sensor, coefficients.run_id) for coefficients in list_sets(url, search=Search(**wanted))]

    assert found(serial="2") == [("SN2", "run-0"), ("SN2", "run-180")]
    assert found(run_id="run-0") == [("SN1", "run-0"), ("SN2", "run-0")]
    assert found(rig="bench", sensor="SN1") == [("SN1", "run-0"), ("SN1", "run-180")]
    assert found(rig="elsewhere") == []
    assert found(since_utc=datetime(2026, 3, 1, tzinfo=UTC)) == [("SN1", "run-180"), ("SN2", "run-180")]
    assert found(until_utc=datetime(2026, 3, 1, tzinfo=UTC)) == [("SN1", "run-0"), ("SN2", "run-0")]


@pytest.mark.thorough
def test_both_databases_tell_the_same_history(archive: Any) -> None:
    for day in range(0, 480, 80):
        sensors = [a_sensor(day, gain=1.0 + 2e-5 * day / 80), a_sensor(day, "CHECK", is_check=True)]
        publish_run(archive.url, a_run(day), sensors, NOW)
    found = history(archive.url, "SN1")
    assert len(found.history.labels) == 6
    assert found.limit_deg == 0.02
    assert history(archive.url, "CHECK").check is not None
    chart = next(chart for chart in found.history.charts if chart.name == "sensitivity_v_per_g.x")
    assert chart.value[-1] / chart.value[0] == pytest.approx(1.0 + 1e-4, abs=1e-6)


def test_two_packages_that_were_exchanged_are_told_with_their_second_publication_and_kept_apart(archive: Any) -> None:
    from procedures.delivery.publish import history_findings

    first = [a_sensor(0), a_sensor(0, "SN2", gain=1.01)]
    publish_run(archive.url, a_run(0), first, NOW)
    mixed = [a_sensor(50, "SN1", gain=1.01), a_sensor(50, "SN2")]
    published = publish_run(archive.url, a_run(50), mixed, NOW)
    (said,) = history_findings(archive.url, published.publications, LATER)
    assert said.startswith("SN1 and SN2 look exchanged: SN1's output fits SN2's set of 2026-01-11, and not its own")
    new = {entry.coefficients.sha256: entry.coefficients.sensor for entry in mixed}
    held = {entry.sha256: entry.quarantine for entry in list_sets(archive.url) if entry.quarantine}
    assert set(held) == set(new)
    assert all(adjusted.as_found is None for adjusted in published.adjustments.values())
    assert history(archive.url, "SN1").history.labels[-1].sha256 == first[0].coefficients.sha256
    again = publish_run(archive.url, a_run(50), mixed, NOW)
    assert not list(history_findings(archive.url, again.publications, LATER)), "told once"


def test_a_run_after_sets_that_were_exchanged_and_count_is_no_exchange(archive: Any) -> None:
    """Each in a night of its own, so that nothing compared them; the right run after them went into quarantine."""
    from procedures.delivery.publish import history_findings

    publish_run(archive.url, a_run(0), [a_sensor(0), a_sensor(0, "SN2", gain=1.01)], NOW)
    publish_run(archive.url, a_run(50), [a_sensor(50, gain=1.01)], NOW)
    publish_run(archive.url, a_run(51), [a_sensor(51, "SN2")], NOW)
    right = publish_run(archive.url, a_run(100), [a_sensor(100), a_sensor(100, "SN2", gain=1.01)], NOW)
    sentences = list(history_findings(archive.url, right.publications, LATER))
    assert sum(sentence.startswith("SN1 and SN2 look exchanged in their sets before") for sentence in sentences) == 1
    assert [entry.sensor for entry in list_sets(archive.url) if entry.quarantine] == []
    assert {found.as_found is None for found in right.adjustments.values()} == {False}


def test_a_package_under_another_ones_name_is_noticed_when_it_is_published(archive: Any) -> None:
    """The mix-up is told with the publication, not years later; the other one is not in this run."""
    from procedures.delivery.publish import history_findings

    for day in range(0, 250, 50):
        sensors = [a_sensor(day), a_sensor(day, "SN2", gain=1.01)]
        assert not list(
            history_findings(archive.url, publish_run(archive.url, a_run(day), sensors, NOW).publications, LATER)
        )
    mixed = [a_sensor(250, "SN1", gain=1.01)]
    found = list(history_findings(archive.url, publish_run(archive.url, a_run(250), mixed, NOW).publications, LATER))
    assert len(found) == 1
    assert "SN1: what was calibrated as it at 2026-09-18 has the characteristics of SN2" in found[0]


def test_of_a_set_in_quarantine_no_history_is_missed(archive: Any) -> None:
    from procedures.delivery.publish import history_findings

    alone = publish_run(archive.url, a_run(0), [turned(a_sensor(0, "SN9"))], NOW)
    assert list(history_findings(archive.url, alone.publications, NOW)) == []


def test_a_set_whose_table_turned_is_kept_in_quarantine_and_is_nobodys_previous(archive: Any) -> None:
    from procedures.cli.archive.text import history_lines

    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    publish_run(archive.url, a_run(10), [turned(a_sensor(10, gain=1.01))], NOW)
    published = publish_run(archive.url, a_run(20), [a_sensor(20)], NOW)
    first, second, third = list_sets(archive.url)
    assert [bool(entry.quarantine) for entry in (first, second, third)] == [False, True, False]
    found = published.adjustments["SN1"].as_found
    assert found is not None
    assert (found.set_sha256, found.verdict) == (first.sha256, "pass")
    assert show(archive.url, second.sha256).sensor == "SN1"
    past = history(archive.url, "SN1")
    assert [label.sha256 for label in past.history.labels] == [first.sha256, third.sha256]
    assert [(held.sha256, held.reason) for held in past.in_quarantine] == [(second.sha256, second.quarantine)]
    (said,) = [line for line in history_lines(past) if line.startswith("left out: the calibration of")]
    assert f"is in quarantine: {second.quarantine}" in said
    assert history(archive.url, "SN1", until_utc=first.created_utc).in_quarantine == ()
    assert verify_archive(archive.url).faults == ()


def test_a_run_whose_table_turned_does_not_say_how_a_sensor_was_found(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    published = publish_run(archive.url, a_run(10), [turned(a_sensor(10, gain=1.01))], NOW)
    adjustment = published.adjustments["SN1"]
    assert adjustment.as_found is None
    assert adjustment.no_as_found == f"not judged, this run does not tell: {TURNED.text}"
    assert show(archive.url, "SN1").sha256 == list_sets(archive.url)[0].sha256, "the latest that is trusted"
    sha256 = published.publications[0].sha256
    (held,) = [entry for entry in list_sets(archive.url) if entry.sha256 == sha256]
    for told in (adjustment, adjustment_of(archive.url, sha256)):
        assert told is not None
        assert (told.as_left.verdict, told.as_left.judgements) == (None, ())
        assert told.not_judged == "the set was put in quarantine"
        assert told.as_left.largest_error_deg is not None, "the errors stand, only their judgement does not"
    assert (held.as_left, bool(held.quarantine)) == (None, True)
    again = publish_run(archive.url, a_run(10), [turned(a_sensor(10, gain=1.01))], NOW)
    assert not again.publications[0].is_new
    assert verify_archive(archive.url).faults == ()


@pytest.mark.parametrize(
    "other",
    [
        replace(TURNED, is_significant=False),
        replace(TURNED, kind="meter-gain"),
        replace(TURNED, details={"turned_arcsec": 2.0}),
        replace(TURNED, details={"turned_arcsec": 72.0, "confounded_with": "sensor-change"}),
    ],
    ids=["not significant", "another kind", "small", "or the sensor itself"],
)
def test_only_a_table_that_certainly_turned_takes_a_set_away(tmp_path: Path, other: Finding) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish_run(url, a_run(0), [turned(a_sensor(0), other)], NOW)
    assert list_sets(url)[0].quarantine is None
