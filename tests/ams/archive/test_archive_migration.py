"""An archive of every past schema is still read: taken over whole, with a copy left beside it, or not touched."""

import shutil
import sqlite3
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest
from archived_runs import a_run, a_sensor
from not_usable import set_not_usable, set_usable
from sqlalchemy import delete, select, text

from ams.archive.connection import migrate, writing
from ams.archive.histories import history
from ams.archive.ledger import Written, tell
from ams.archive.runs import publish_run
from ams.archive.sets import list_sets, publish, show
from ams.archive.signatures import sign, verify_archive
from ams.archive.tables import COEFFICIENTS, POINTS, RECORDS, SETS
from ams.errors import ArchiveError, ArchiveUnknown, SetError
from ams.exports.json_text import from_json

SCHEMA_0001 = Path(__file__).parents[2] / "data" / "archive_0001.sqlite"
SCHEMA_0002 = SCHEMA_0001.with_name("runs_0_1_0") / "archive.sqlite"
SET_V1 = SCHEMA_0001.with_name("coefficient_set_v1.json")
NOW = datetime(2026, 6, 1, tzinfo=UTC)


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return Path(shutil.copy(SCHEMA_0001, tmp_path / "archive.sqlite"))


def test_an_older_archive_is_not_read_before_it_is_migrated_and_says_how(old: Path) -> None:
    before = old.read_bytes()
    with pytest.raises(ArchiveError, match="has the older schema 0001, this calrig reads 0009; calrig archive migrate"):
        list_sets(f"sqlite:///{old}")
    assert old.read_bytes() == before


def test_a_migrated_archive_has_every_set_a_history_a_chain_and_a_copy_beside_it(old: Path) -> None:
    url, before = f"sqlite:///{old}", old.read_bytes()
    assert migrate(url) == ("0001", "0009")
    assert [(coefficients.sensor, coefficients.created_utc.day) for coefficients in list_sets(url)] == [
        ("SN1047", 1),
        ("SN1047", 20),
        ("SN2", 3),
    ]
    assert list_sets(url)[0].rig == "accelerometer laboratory, dual-axis table"
    assert show(url, "SN2").sensor == "SN2"
    assert len(history(url, "SN1047").history.labels) == 1  # both sets are of one run
    assert verify_archive(url).faults == ()
    assert old.with_name("archive.sqlite.schema-0001").read_bytes() == before
    assert migrate(url) == ("0009", "0009")


def test_publishing_migrates_and_goes_on(old: Path) -> None:
    url = f"sqlite:///{old}"
    publish_run(url, a_run(0), [a_sensor(0)], NOW)
    assert len(list_sets(url)) == 4
    assert verify_archive(url).faults == ()


def test_a_migration_that_meets_a_damaged_set_changes_nothing(old: Path) -> None:
    with closing(sqlite3.connect(old)) as connection, connection:
        connection.execute("UPDATE sets SET document = replace(document, '2.47', '2.48') WHERE sensor = 'SN2'")
    before = old.read_bytes()
    with pytest.raises(SetError, match=r"archive: set [0-9a-f]{12}: checksum: does not fit"):
        migrate(f"sqlite:///{old}")
    assert old.read_bytes() == before


def as_schema_0005(path: Path) -> str:
    """Take away what 0006 brought, and tell the rows as 0005 told them; return the URL."""
    url = f"sqlite:///{path}"
    with writing(url, 10.0) as connection:
        parts = [
            Written(table, [dict(row) for row in connection.execute(select(table)).mappings()])
            for table in (SETS, COEFFICIENTS, POINTS)
        ]
        connection.execute(delete(RECORDS))
        tell(connection, NOW, "sets", parts, {})
        connection.execute(text("DROP TABLE verdicts"))
        connection.execute(text("DROP TABLE functions"))
        connection.execute(text("DROP INDEX ix_sets_run_sensor"))
        connection.execute(text("UPDATE alembic_version SET version_num = '0005'"))
    return url


def test_an_archive_of_0005_gets_the_verdict_that_each_of_its_sets_states(tmp_path: Path) -> None:
    path = tmp_path / "archive.sqlite"
    stated = [set_not_usable(), set_usable(), from_json(SET_V1.read_bytes(), "v1")]  # the last is of before the key
    publish(f"sqlite:///{path}", stated, NOW)
    url = as_schema_0005(path)
    assert migrate(url) == ("0005", "0009")
    expected = {entry.sha256: entry.document.get("verdict") for entry in stated}
    assert {row.sha256: row.verdict for row in list_sets(url)} == expected
    assert sorted(map(str, expected.values())) == ["None", "not usable", "sound"]
    assert verify_archive(url).faults == ()


def test_a_damaged_set_of_0005_is_taken_over_without_a_verdict_and_verify_names_it(tmp_path: Path) -> None:
    path = tmp_path / "archive.sqlite"
    publish(f"sqlite:///{path}", [set_not_usable()], NOW)
    url = as_schema_0005(path)
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("UPDATE sets SET document = substr(document, 1, 2000)")
    assert migrate(url) == ("0005", "0009")
    (row,) = list_sets(url)
    assert row.verdict is None
    assert [fault for fault in verify_archive(url).faults if row.sha256[:12] in fault]


def test_a_verdict_that_was_changed_behind_the_record_shows(tmp_path: Path) -> None:
    path = tmp_path / "archive.sqlite"
    publish(f"sqlite:///{path}", [set_not_usable()], NOW)
    assert verify_archive(f"sqlite:///{path}").faults == ()
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("UPDATE verdicts SET verdict = 'sound'")
    assert any(fault.startswith("verdicts ") for fault in verify_archive(f"sqlite:///{path}").faults)


def test_signatures_of_0006_stay_without_a_function_and_the_next_may_tell_one(tmp_path: Path) -> None:
    path = tmp_path / "archive.sqlite"
    url = f"sqlite:///{path}"
    publish(url, [set_usable()], NOW)
    (row,) = list_sets(url)
    sign(url, row.sha256, "prepared", "A. Ray", NOW)
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("DROP TABLE functions")
        connection.execute("DROP INDEX ix_sets_run_sensor")
        connection.execute("UPDATE alembic_version SET version_num = '0006'")
    assert migrate(url) == ("0006", "0009")
    signed = sign(url, row.sha256, "reviewed", "B. Lee", NOW, function="head of the laboratory")
    assert [signature.signatory for signature in signed.signatures] == ["A. Ray", "B. Lee, head of the laboratory"]
    assert verify_archive(url).faults == ()
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("UPDATE functions SET function = 'director'")
    assert any(fault.startswith("functions ") for fault in verify_archive(url).faults)


def test_what_is_no_archive_is_not_migrated(tmp_path: Path) -> None:
    with pytest.raises(ArchiveUnknown, match="there is no archive"):
        migrate(f"sqlite:///{tmp_path / 'none.sqlite'}")
    assert not (tmp_path / "none.sqlite").exists()


def test_an_archive_of_0002_keeps_its_chain_and_has_nothing_in_quarantine(tmp_path: Path) -> None:
    url = f"sqlite:///{shutil.copy(SCHEMA_0002, tmp_path / 'archive.sqlite')}"
    assert migrate(url) == ("0002", "0009")
    assert verify_archive(url).faults == ()
    assert {coefficients.quarantine for coefficients in list_sets(url)} == {None}
    publish_run(url, a_run(400), [a_sensor(400)], NOW)
    assert verify_archive(url).faults == ()
