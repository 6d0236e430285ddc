"""What is asked of one sensor takes no longer in a larger archive, by SQLite's own count of the steps that it makes."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from archive_kinds import Archive
from archived_runs import a_run, a_sensor
from sqlalchemy import Engine, Row, event, insert, select

from ams.archive.connection import reading, writing
from ams.archive.histories import history, population_of
from ams.archive.run_search import _by_key
from ams.archive.runs import adjustment_of, publish_run
from ams.archive.sets import show
from ams.archive.synthetic import Story, synthetic_archive
from ams.archive.tables import QUARANTINES, SETS, SIGNATURES
from ams.archive.taken_back import latest_sets_before
from ams.errors import ArchiveUnknown
from ams.surveillance.between_runs import pooled_scatter
from bench.archive import fill

SMALL, LARGE = 24, 96
SENSORS_OF_A_RUN = 6


def steps_of(work: Callable[[], object]) -> int:
    """Return how many instructions SQLite's machine executes while something is done with an archive."""
    steps = 0

    def count() -> int:
        nonlocal steps
        steps += 1
        return 0

    def watch(connection: object, *_: object) -> None:
        connection.connection.dbapi_connection.set_progress_handler(count, 1)  # type: ignore[attr-defined]

    event.listen(Engine, "before_cursor_execute", watch)
    try:
        work()
    finally:
        event.remove(Engine, "before_cursor_execute", watch)
    return steps


def signatures_of(row: "Row[tuple[str, object]]", at: int) -> list[dict[str, object]]:
    roles = [
        "prepared",
        "reviewed",
        "approved",
        *([] if at % 9 else ["withdrawn"]),
        *([] if at % 9 - 4 else ["released"]),
    ]
    return [
        {"sha256": row.sha256, "role": role, "name": "A. Ray", "signed_utc": row.created_utc, "comment": ""}
        for role in roles
    ]


def grown(url: str, sensors: int) -> str:
    """Fill an archive with sensors that are calibrated six at a time, signed, withdrawn, held and released."""
    story = Story(sensors=sensors, years=4, drift_arcsec_per_year=0.0, drop_arcsec=0.0)
    made = synthetic_archive(np.random.default_rng(4), story)
    names = sorted({label.sensor for label in made.population.labels})
    labels = [
        replace(label, run_id=f"{label.run_id}-{names.index(label.sensor) // SENSORS_OF_A_RUN}")
        for label in made.population.labels
    ]
    sensor = made.sound[2]
    fill(url, replace(made.population, labels=labels), sensor, document="")
    with writing(url, 10.0) as connection:
        others = select(SETS.c.sha256, SETS.c.created_utc).where(SETS.c.sensor != sensor).order_by(SETS.c.sha256)
        rows = connection.execute(others).all()
        signed = [entry for at, row in enumerate(rows) for entry in signatures_of(row, at)]
        connection.execute(insert(SIGNATURES), [{**entry, "sequence": at} for at, entry in enumerate(signed)])
        held = [
            {"sha256": row.sha256, "reason": "", "quarantined_utc": row.created_utc}
            for at, row in enumerate(rows)
            if at % 9 in (4, 5)
        ]
        connection.execute(insert(QUARANTINES), held)
    for day in (0, 200):
        publish_run(url, a_run(day), [a_sensor(day, f"AA{at}") for at in (1, 2)], a_run(day).ended_utc)
    return sensor


def test_what_is_asked_of_one_sensor_takes_no_longer_in_an_archive_four_times_as_large(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every look went through all signatures, and a history through the names of all sets."""
    monkeypatch.setattr("ams.archive.histories.LEARNED_FROM", 30)
    monkeypatch.setattr("ams.surveillance.between_runs.LEARNED_FROM", 30)
    monkeypatch.setattr("ams.archive.histories.stored_document", lambda *_: {"provenance": {"acceptance": None}})
    taken: dict[str, list[int]] = {}
    for sensors in (SMALL, LARGE):
        url = f"sqlite:///{tmp_path / f'{sensors}.sqlite'}"
        sensor = grown(url, sensors)
        begins = show(url, "AA1").sha256[:8]
        third = [a_sensor(400, f"AA{at}") for at in (1, 2)]
        works: dict[str, Callable[[], object]] = {
            "population": lambda url=url, sensor=sensor: population_of(url, sensor, only_needed=True),
            "history": lambda url=url: history(url, "AA1"),
            "show": lambda url=url: show(url, "AA1"),
            "show of a checksum": lambda url=url, begins=begins: show(url, begins),
            "adjustment": lambda url=url: adjustment_of(url, "AA1"),
            "sets before": lambda url=url: latest_sets_before(url, ["AA1", "AA2"], "another", is_simulated=False),
            "publish": lambda url=url, third=third: publish_run(url, a_run(400), third, a_run(400).ended_utc),
        }
        for name, work in works.items():
            taken.setdefault(name, []).append(steps_of(work))
    assert all(small > 50 for small, _ in taken.values())
    assert {name: large - small for name, (small, large) in taken.items() if large > 1.1 * small} == {}


def test_a_checksum_that_is_begun_is_looked_up_in_the_index(archive: Archive) -> None:
    """As the database plans it: the whole table was scanned, each document behind it read."""
    sensor = grown(archive.url, SMALL)
    begins = show(archive.url, sensor).sha256[:8]
    asked: list[tuple[str, Any]] = []

    def watch(_connection: object, _cursor: object, statement: str, parameters: Any, *_: object) -> None:
        asked.append((statement, parameters))

    event.listen(Engine, "before_cursor_execute", watch)
    try:
        show(archive.url, begins.upper())
    finally:
        event.remove(Engine, "before_cursor_execute", watch)
    ((statement, parameters),) = [entry for entry in asked if "sets.sha256 <" in entry[0] or "COLLATE" in entry[0]]
    if archive.url.startswith("sqlite"):
        with reading(archive.url, 10.0) as connection:
            plan = connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters).all()
        assert any("SEARCH sets USING" in row[-1] and "sha256>?" in row[-1] for row in plan), plan
        assert not any("SCAN" in row[-1] for row in plan), plan


def test_sensors_of_one_run_are_gathered_without_comparing_each_with_each() -> None:
    compared = 0

    class Counting(str):
        __slots__ = ()

        def __eq__(self, other: object) -> bool:
            nonlocal compared
            compared += 1
            return str.__eq__(self, str(other))

        __hash__ = str.__hash__

    rows = [("run-1", Counting(f"SN{at}")) for at in (*range(300), *range(300))]
    assert _by_key(iter(rows)) == {"run-1": tuple(f"SN{at}" for at in range(300))}
    assert compared <= 3 * len(rows)


@pytest.mark.parametrize("key", ["zzzzzz", "%%%%%%", "______", "abcdefg"])
def test_what_is_no_beginning_of_a_checksum_fits_none(archive: Archive, key: str) -> None:
    grown(archive.url, SMALL)
    with pytest.raises(ArchiveUnknown, match="found nothing"):
        show(archive.url, key)


def test_either_kind_of_archive_reads_the_sensors_that_follow_by_code_points(
    archive: Archive, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ams.archive.histories.LEARNED_FROM", 30)
    monkeypatch.setattr("ams.surveillance.between_runs.LEARNED_FROM", 30)
    sensor = grown(archive.url, SMALL)
    needed, whole = population_of(archive.url, sensor, only_needed=True), population_of(archive.url, sensor)
    assert len(needed.labels) < len(whole.labels) / 2
    assert pooled_scatter(needed, sensor).variance.tolist() == pooled_scatter(whole, sensor).variance.tolist()
    of_its_runs = {label.run_id for label in needed.labels if label.sensor == sensor}
    beside = {label.sensor for label in whole.labels if label.run_id in of_its_runs}
    assert beside <= {label.sensor for label in needed.labels}
