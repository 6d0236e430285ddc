"""A history of a large archive reads what it needs, and says what it would say had it read everything."""

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import Engine, event

from ams.archive.histories import history, population_of
from ams.archive.synthetic import Story, synthetic_archive
from ams.surveillance.between_runs import names_behind, pooled_scatter
from ams.surveillance.control_chart import history_of
from bench.archive import fill


def test_a_history_reads_a_thousand_others_at_most_and_tells_the_same_as_all_of_them(tmp_path: Path) -> None:
    made = synthetic_archive(np.random.default_rng(4), Story(sensors=80, years=10))
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    fill(url, made.population, made.sound[7], document="")
    sensor = made.sound[7]
    needed, whole = population_of(url, sensor, only_needed=True), population_of(url, sensor)
    assert len(whole.labels) == 81 * 20
    assert len(needed.labels) <= 20 + 1000 + 20  # its own, the others, and a check sensor among them
    for name in ("variance", "dof", "prior_dof"):
        assert (
            getattr(pooled_scatter(needed, sensor), name).tolist()
            == getattr(pooled_scatter(whole, sensor), name).tolist()
        )
    few, all_of_them = history_of(needed, sensor), history_of(whole, sensor)
    for chart, other in zip(few.charts, all_of_them.charts, strict=True):
        np.testing.assert_array_equal(chart.prediction_high, other.prediction_high)
    assert few.findings == all_of_them.findings == ()


def test_a_history_goes_through_no_table_of_sets_row_by_row(tmp_path: Path) -> None:
    """What it takes grows with the sets that it reads, as SQLite's own plan of every query tells."""
    made = synthetic_archive(np.random.default_rng(4), Story(sensors=8, years=4))
    path, sensor = tmp_path / "archive.sqlite", made.sound[-1]
    fill(f"sqlite:///{path}", made.population, sensor, document="")
    asked: list[tuple[str, object]] = []

    def note(*call: object) -> None:
        _, _, statement, values, *_ = call
        asked.append((str(statement), values))

    event.listen(Engine, "before_cursor_execute", note)
    try:
        history(f"sqlite:///{path}", sensor)
    finally:
        event.remove(Engine, "before_cursor_execute", note)
    with closing(sqlite3.connect(path)) as connection:
        plans = [
            step
            for statement, values in asked
            if statement.lstrip().startswith("SELECT")
            for *_, step in connection.execute(f"EXPLAIN QUERY PLAN {statement}", values)  # type: ignore[arg-type]
        ]
    assert any(step.startswith("SEARCH sets USING INDEX") for step in plans)
    tables = ("sets", "points", "signatures", "quarantines")
    assert [step for step in plans if step.startswith(tuple(f"SCAN {table}" for table in tables))] == []


def test_whose_characteristics_these_are_is_looked_for_among_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = synthetic_archive(np.random.default_rng(5), Story(sensors=80, years=10))
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    fill(url, made.population, made.sound[7], document="")
    monkeypatch.setattr("ams.archive.histories.stored_document", lambda *_: {"provenance": {"acceptance": None}})
    monkeypatch.setattr("ams.surveillance.between_runs.LEARNED_FROM", 20)
    monkeypatch.setattr("ams.archive.histories.LEARNED_FROM", 20)
    monkeypatch.setattr("ams.archive.histories._NAMES_AT_ONCE", 1)
    sensor, partner = made.mixed_up
    assert partner not in {label.sensor for label in population_of(url, sensor, only_needed=True).labels}
    assert partner in {finding.partner for finding in history(url, sensor).history.findings}


def test_the_names_behind_go_round() -> None:
    assert names_behind(["c", "a", "b", "d"], "b") == ["c", "d", "a"]
    assert names_behind(["c", "a"], None) == ["a", "c"]
