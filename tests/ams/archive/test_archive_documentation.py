"""The page about the archive is run, and names every command and every verdict."""

import doctest
import os
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, get_args

import pytest
from archived_runs import a_run, a_sensor, turned
from sqlalchemy import create_engine, inspect, text
from sqlalchemy.pool import NullPool

from ams.archive.runs import publish_run, standards_used
from ams.archive.sets import list_sets, show
from ams.archive.sign_offs import Role
from ams.archive.signatures import sign
from ams.archive.tables import METADATA, REVISIONS
from ams.surveillance.adjustment import RULES, Verdict

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "archive.md"


def test_the_examples_of_the_page_give_what_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    results = doctest.testfile(os.fspath(PAGE), module_relative=False, encoding="utf-8")
    assert (results.failed, results.attempted) == (0, 15)


def test_the_page_names_every_command_role_rule_and_verdict() -> None:
    from procedures.cli.archive.archive import app

    page = PAGE.read_text("utf-8")
    commands = [f"calrig archive {name}" for name in app if not name.startswith("-")]
    assert len(commands) >= 9
    wanted = [*commands, "calrig resolve", *get_args(Role), *(f"`{rule}`" for rule in RULES), *get_args(Verdict)]
    assert [name for name in wanted if name not in page] == []


def test_the_views_of_the_page_tell_what_calrig_tells(archive: Any) -> None:
    day = datetime(2026, 6, 1, tzinfo=UTC)
    publish_run(archive.url, a_run(0), [a_sensor(0)], day)
    publish_run(archive.url, a_run(180), [a_sensor(180, gain=1.001)], day)
    sign(archive.url, "SN1", "withdrawn", "A. Ray", day, "dropped")
    publish_run(archive.url, a_run(270), [turned(a_sensor(270))], day)
    page = PAGE.read_text("utf-8")
    (block,) = re.findall(r"```sql\n(.*?)```", page, flags=re.DOTALL)
    (question,) = re.findall(r"^`(SELECT .*)`\.$", page, flags=re.MULTILINE)
    engine = create_engine(archive.url, poolclass=NullPool)
    with engine.connect() as connection:
        for statement in filter(str.strip, block.split(";")):
            connection.execute(text(statement))
        rows = connection.execute(text("SELECT * FROM calibration_view ORDER BY created_utc")).mappings().all()
        values = connection.execute(
            text("SELECT axis, name, value FROM coefficient_view WHERE sha256 = :sha256"), {"sha256": rows[1]["sha256"]}
        )
        listed = list_sets(archive.url)
        assert [(row["sha256"], row["as_found"], row["as_left"]) for row in rows] == [
            (entry.sha256, entry.as_found, entry.as_left) for entry in listed
        ]
        assert [(row["run_id"], row["operator"], row["rig"]) for row in rows] == [
            (f"run-{number}", "J. Doe", "bench") for number in (0, 180, 270)
        ]
        assert [bool(row["in_quarantine"]) for row in rows] == [False, False, True]
        assert [bool(row["withdrawn"]) for row in rows] == [False, True, False]
        assert [(row["withdrawn_by"], row["withdrawn_because"]) for row in rows] == [
            (None, None), ("A. Ray", "dropped"), (None, None)
        ]  # fmt: skip
        assert [row["verdict"] for row in rows] == [entry.verdict for entry in listed]
        axes = show(archive.url, rows[1]["sha256"]).axes
        assert {(axis, name): value for axis, name, value in values} == {
            (label, name): value for label, axis in axes.items() for name, value in axis.parameters.items()
        }
        behind = connection.execute(text("SELECT name, certificate FROM standard_view WHERE run_id = 'run-180'"))
        assert [tuple(entry) for entry in behind] == [
            (use.name, use.certificate) for use, _ in standards_used(archive.url, a_run(180).journal_sha256)
        ]
        assert connection.execute(text(question)).all() == []  # the only failure is withdrawn
        stored = connection.execute(text("SELECT as_found FROM adjustments WHERE as_found = 'fail'"))
        assert len(stored.all()) == 1
        assert connection.scalar(text("SELECT version_num FROM alembic_version")) == REVISIONS[-1]
        assert set(METADATA.tables) <= set(inspect(connection).get_table_names())
    engine.dispose()
    assert f"(`{REVISIONS[-1]}`)" in page
