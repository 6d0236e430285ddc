"""An archive of every past schema is still read: taken over whole, with a copy left beside it, or not touched."""

import shutil
import sqlite3
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest
from archived_runs import a_run, a_sensor

from ams.archive.connection import migrate
from ams.archive.histories import history
from ams.archive.runs import publish_run
from ams.archive.sets import list_sets, show
from ams.archive.signatures import verify_archive
from ams.errors import ArchiveError, ArchiveUnknown, SetError

SCHEMA_0001 = Path(__file__).parents[2] / "data" / "archive_0001.sqlite"
SCHEMA_0002 = SCHEMA_0001.with_name("runs_0_1_0") / "archive.sqlite"
NOW = datetime(2026, 6, 1, tzinfo=UTC)


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return Path(shutil.copy(SCHEMA_0001, tmp_path / "archive.sqlite"))


def test_an_older_archive_is_not_read_before_it_is_migrated_and_says_how(old: Path) -> None:
    before = old.read_bytes()
    with pytest.raises(ArchiveError, match="has the older schema 0001, this calrig reads 0005; calrig archive migrate"):
        list_sets(f"sqlite:///{old}")
    assert old.read_bytes() == before


def test_a_migrated_archive_has_every_set_a_history_a_chain_and_a_copy_beside_it(old: Path) -> None:
    url, before = f"sqlite:///{old}", old.read_bytes()
    assert migrate(url) == ("0001", "0005")
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
    assert migrate(url) == ("0005", "0005")


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


def test_what_is_no_archive_is_not_migrated(tmp_path: Path) -> None:
    with pytest.raises(ArchiveUnknown, match="there is no archive"):
        migrate(f"sqlite:///{tmp_path / 'none.sqlite'}")
    assert not (tmp_path / "none.sqlite").exists()


def test_an_archive_of_0002_keeps_its_chain_and_has_nothing_in_quarantine(tmp_path: Path) -> None:
    url = f"sqlite:///{shutil.copy(SCHEMA_0002, tmp_path / 'archive.sqlite')}"
    assert migrate(url) == ("0002", "0005")
    assert verify_archive(url).faults == ()
    assert {coefficients.quarantine for coefficients in list_sets(url)} == {None}
    publish_run(url, a_run(400), [a_sensor(400)], NOW)
    assert verify_archive(url).faults == ()
