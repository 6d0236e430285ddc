"""The archive: nothing twice, nothing half, nothing lost, every refusal a sentence."""

import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from sealed import changed
from solved import provenance, solved_package

from ams.errors import ArchiveError, SetError, VectorsDisagree
from ams.sets.archive import Publication, list_sets, publish, show
from ams.sets.coefficients import CoefficientSet, build_set, from_document

PUBLISHED = datetime(2026, 3, 2, 8, 0, tzinfo=UTC)


def a_set(sensor: str = "SN1047", day: int = 1) -> CoefficientSet:
    created = datetime(2026, 3, day, 6, 20, tzinfo=UTC)
    return build_set(solved_package("xyz"), provenance(sensor=sensor, created_utc=created))


@pytest.fixture
def url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'archive.sqlite'}"


def rows(url: str, query: str) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(url.removeprefix("sqlite:///"))) as connection:
        return connection.execute(query).fetchall()


def execute(url: str, statement: str) -> None:
    with closing(sqlite3.connect(url.removeprefix("sqlite:///"))) as connection, connection:
        connection.execute(statement)


def test_a_published_set_comes_back_equal(url: str) -> None:
    coefficients = a_set()
    assert publish(url, [coefficients], PUBLISHED) == (Publication(coefficients.sha256, "SN1047", True),)
    assert show(url, coefficients.sha256) == coefficients
    assert show(url, coefficients.sha256[:8].upper()) == coefficients


def test_publishing_twice_changes_nothing(url: str) -> None:
    coefficients = a_set()
    publish(url, [coefficients], PUBLISHED)
    before = rows(url, "SELECT * FROM sets"), rows(url, "SELECT * FROM coefficients")
    again = publish(url, [coefficients, coefficients], PUBLISHED + timedelta(days=9))
    assert [publication.is_new for publication in again] == [False, False]
    assert (rows(url, "SELECT * FROM sets"), rows(url, "SELECT * FROM coefficients")) == before


def test_sets_are_listed_by_sensor_then_age_in_plain_values(url: str) -> None:
    publish(url, [a_set("SN2", 3), a_set("SN1", 4), a_set("SN1", 2)], PUBLISHED)
    listed = list_sets(url)
    assert [(one.sensor, one.created_utc.day) for one in listed] == [("SN1", 2), ("SN1", 4), ("SN2", 3)]
    assert [one.created_utc.day for one in list_sets(url, "SN1")] == [2, 4]
    assert listed[0].model == "pitch-roll"
    assert (listed[0].status, listed[0].simulated) == ("engineering", False)


def test_a_sensor_shows_its_latest_set(url: str) -> None:
    latest = a_set("SN1", 4)
    publish(url, [latest, a_set("SN1", 2)], PUBLISHED)
    assert show(url, "SN1") == latest


def test_times_are_utc_wherever_they_were_taken(url: str) -> None:
    publish(url, [a_set()], datetime(2026, 3, 2, 10, 0, tzinfo=timezone(timedelta(hours=2))))
    (listed,) = list_sets(url)
    assert (listed.published_utc, listed.published_utc.utcoffset()) == (PUBLISHED, timedelta(0))


def test_a_time_without_a_zone_is_refused(url: str) -> None:
    with pytest.raises(ArchiveError, match="published_utc has no time zone"):
        publish(url, [a_set()], PUBLISHED.replace(tzinfo=None))


def test_coefficients_are_kept_as_numbers_for_histories(url: str) -> None:
    publish(url, [a_set()], PUBLISHED)
    found = rows(url, "SELECT value, unit FROM coefficients WHERE axis = 'x' AND name = 'sensitivity_v_per_g'")
    assert found == [(2.5, "V/g")]


def test_all_sets_of_a_publication_are_in_or_none(url: str) -> None:
    publish(url, [a_set("SN0")], PUBLISHED)
    third = "NEW.axis = 'z' AND (SELECT count(*) FROM sets) > 2"
    full = "SELECT RAISE(ABORT, 'database or disk is full')"
    execute(url, f"CREATE TRIGGER full BEFORE INSERT ON coefficients WHEN {third} BEGIN {full}; END")
    with pytest.raises(ArchiveError, match="the archive refused: database or disk is full; nothing was changed"):
        publish(url, [a_set("SN1"), a_set("SN2")], PUBLISHED)
    assert [one.sensor for one in list_sets(url)] == ["SN0"]
    assert rows(url, "SELECT DISTINCT sha256 FROM coefficients") == rows(url, "SELECT sha256 FROM sets")


def test_a_set_that_contradicts_itself_is_not_published(url: str) -> None:
    def nudge(document: dict[str, object]) -> None:
        document["axes"]["x"]["primary"]["values"]["offset_v"] = 0.006  # type: ignore[index]

    wrong = from_document(changed(a_set("SN2"), nudge), "wrong")
    with pytest.raises(VectorsDisagree, match="SN2: publish: axis x"):
        publish(url, [a_set("SN1"), wrong], PUBLISHED)
    with pytest.raises(ArchiveError, match="there is no archive: no such file"):
        list_sets(url)


def test_two_writers_at_once_lose_nothing(url: str) -> None:
    sets = [a_set(f"SN{number}") for number in range(12)]
    with ThreadPoolExecutor(4) as pool:
        waiting = [pool.submit(publish, url, [one], PUBLISHED, 60.0) for one in [*sets, *sets]]
        published = [publication for future in waiting for publication in future.result()]
    assert sorted(one.sha256 for one in published if one.is_new) == sorted(one.sha256 for one in sets)
    assert {one.sha256 for one in list_sets(url)} == {one.sha256 for one in sets}


PUBLISH_UNTIL_KILLED = """
import sys
from datetime import UTC, datetime
from pathlib import Path
from ams.sets.archive import publish
from ams.sets.export.formats import load_set
sets = [load_set(path) for path in sorted(Path(sys.argv[2]).glob("*.json"))]
print("ready", flush=True)
for one in sets:
    publish(sys.argv[1], [one], datetime.now(UTC))
    print(one.sha256, flush=True)
"""


def test_a_killed_writer_leaves_whole_sets_and_everything_it_acknowledged(url: str, tmp_path: Path) -> None:
    from ams.sets.export.formats import export_set

    (tmp_path / "sets").mkdir()
    for number in range(40):
        export_set(a_set(f"SN{number}"), "json", tmp_path / "sets" / f"{number:02}.json")
    command = [sys.executable, "-c", PUBLISH_UNTIL_KILLED, url, str(tmp_path / "sets")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        acknowledged = [writer.stdout.readline().strip() for _ in range(12)][1:]
        writer.kill()
    stored = {one.sha256 for one in list_sets(url)}
    assert set(acknowledged) <= stored
    assert all(show(url, sha256).sha256 == sha256 for sha256 in stored)
    assert {row[0] for row in rows(url, "SELECT sha256 FROM coefficients")} == stored


def test_a_locked_archive_is_a_sentence_and_unlocked_it_goes_on(url: str, tmp_path: Path) -> None:
    publish(url, [a_set("SN1")], PUBLISHED)
    with closing(sqlite3.connect(tmp_path / "archive.sqlite", isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(
            ArchiveError, match=r"the archive is locked by another program for over 0\.05 s; nothing was"
        ):
            publish(url, [a_set("SN2")], PUBLISHED, busy_timeout_s=0.05)
        with pytest.raises(ArchiveError, match="is locked by another program"):
            list_sets(url, busy_timeout_s=0.05)
    publish(url, [a_set("SN2")], PUBLISHED)
    assert len(list_sets(url)) == 2


def test_a_newer_schema_is_left_alone(url: str) -> None:
    publish(url, [a_set()], PUBLISHED)
    execute(url, "UPDATE alembic_version SET version_num = '0999'")
    for attempt in (lambda: publish(url, [a_set("SN2")], PUBLISHED), lambda: list_sets(url)):
        with pytest.raises(
            ArchiveError, match="was written by a newer calrig: got schema 0999, this one knows up to 0001"
        ):
            attempt()
    assert rows(url, "SELECT count(*) FROM sets") == [(1,)]


def test_a_database_of_something_else_is_left_alone(url: str) -> None:
    execute(url, "CREATE TABLE invoices (number INTEGER)")
    with pytest.raises(ArchiveError, match="is a database of something else"):
        publish(url, [a_set()], PUBLISHED)
    with pytest.raises(ArchiveError, match="is a database but no archive"):
        list_sets(url)
    assert rows(url, "SELECT name FROM sqlite_master") == [("invoices",)]


def test_a_file_that_is_no_database_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no database at all, but long enough to have a header of a hundred bytes, " * 3)
    before = path.read_bytes()
    with pytest.raises(ArchiveError, match=r"notes\.txt: is no archive, or a damaged one: file is not a database"):
        publish(f"sqlite:///{path}", [a_set()], PUBLISHED)
    assert path.read_bytes() == before


def test_an_archive_without_write_rights_is_a_sentence(url: str, tmp_path: Path) -> None:
    publish(url, [a_set()], PUBLISHED)
    read_only = f"sqlite:///file:{tmp_path / 'archive.sqlite'}?mode=ro&uri=true"
    with pytest.raises(ArchiveError, match="the archive cannot be written: attempt to write a readonly database"):
        publish(read_only, [a_set("SN2")], PUBLISHED)
    assert len(list_sets(read_only)) == 1


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ("archive.sqlite", "archive URL: cannot be used: got 'archive.sqlite'"),
        ("nonsense://host/db", "archive URL: cannot be used: got 'nonsense://host/db'"),
        ("sqlite://", "archive URL: names no file"),
        ("sqlite:///:memory:", "archive URL: names no file"),
        ("sqlite:////nowhere/archive.sqlite", "/nowhere/archive.sqlite: the archive cannot be opened"),
        ("postgresql+psycopg://me:secret@host/db", "no driver for this kind of database"),
    ],
)
def test_a_wrong_url_is_a_sentence_without_its_password(wrong: str, sentence: str) -> None:
    with pytest.raises(ArchiveError) as caught:
        publish(wrong, [a_set()], PUBLISHED)
    assert sentence in str(caught.value)
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize("key", ["SN9", "abc", "0" * 64, "%", "______"])
def test_a_key_that_fits_nothing_is_refused(key: str, url: str) -> None:
    publish(url, [a_set()], PUBLISHED)
    with pytest.raises(ArchiveError, match=r"no single set for .*: found nothing"):
        show(url, key)


def test_a_set_damaged_inside_the_archive_is_not_handed_out(url: str) -> None:
    coefficients = a_set()
    publish(url, [coefficients], PUBLISHED)
    execute(url, "UPDATE sets SET document = replace(document, '2.47', '2.48')")
    with pytest.raises(SetError, match=f"archive: set {coefficients.sha256[:12]}: checksum: does not fit"):
        show(url, "SN1047")


def test_the_migrations_make_the_tables_that_the_code_uses(url: str) -> None:
    from ams.sets.archive_tables import METADATA

    publish(url, [a_set()], PUBLISHED)
    for name, declared in METADATA.tables.items():
        made = {str(row[1]): bool(row[3]) for row in rows(url, f"PRAGMA table_info({name})")}
        assert made == {column.name: not column.nullable for column in declared.columns}
