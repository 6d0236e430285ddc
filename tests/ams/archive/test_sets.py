"""The archive: nothing twice, nothing half, nothing lost, every refusal a sentence; SQLite and PostgreSQL alike."""

import sqlite3
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import pytest
from changed_sets import changed
from postgres_server import Server
from solved import provenance, solved_package
from sqlalchemy import create_engine, inspect
from sqlalchemy.pool import NullPool

from ams.archive.connection import migrate
from ams.archive.refusals import without_password
from ams.archive.sets import Publication, list_sets, publish, show
from ams.archive.signatures import verify_archive
from ams.errors import ArchiveError, ArchiveUnknown, SetError, VectorsDisagree
from ams.sets.coefficients import CoefficientSet, build_set, from_document

PUBLISHED = datetime(2026, 3, 2, 8, 0, tzinfo=UTC)


def a_set(sensor: str = "SN1047", day: int = 1) -> CoefficientSet:
    created = datetime(2026, 3, day, 6, 20, tzinfo=UTC)
    return build_set(solved_package("xyz"), provenance(sensor=sensor, created_utc=created))


@pytest.fixture
def url(archive: Any) -> str:
    return str(archive.url)


@pytest.fixture
def sqlite_url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'archive.sqlite'}"


def rows(url: str, query: str) -> list[tuple[object, ...]]:
    engine = create_engine(url, poolclass=NullPool)
    with engine.begin() as connection:
        return [tuple(row) for row in connection.exec_driver_sql(query)]


def execute(url: str, *statements: str) -> None:
    engine = create_engine(url, poolclass=NullPool)
    with engine.begin() as connection:
        for statement in statements:
            connection.exec_driver_sql(statement)


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
    assert [(entry.sensor, entry.created_utc.day) for entry in listed] == [("SN1", 2), ("SN1", 4), ("SN2", 3)]
    assert [coefficients.created_utc.day for coefficients in list_sets(url, "SN1")] == [2, 4]
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


FULL_SQLITE = (
    "CREATE TRIGGER full_disk BEFORE INSERT ON coefficients WHEN NEW.axis = 'z' AND (SELECT count(*) FROM sets) > 2 "
    "BEGIN SELECT RAISE(ABORT, 'database or disk is full'); END",
)
FULL_POSTGRES = (
    """CREATE FUNCTION full_disk() RETURNS trigger AS $$ BEGIN
    IF NEW.axis = 'z' AND (SELECT count(*) FROM sets) > 2 THEN
        RAISE EXCEPTION 'could not extend file: No space left on device' USING ERRCODE = '53100';
    END IF; RETURN NEW; END $$ LANGUAGE plpgsql""",
    "CREATE TRIGGER full_disk BEFORE INSERT ON coefficients FOR EACH ROW EXECUTE FUNCTION full_disk()",
)


def test_all_sets_of_a_publication_are_in_or_none_when_the_disk_is_full(archive: Any, url: str) -> None:
    publish(url, [a_set("SN0")], PUBLISHED)
    execute(url, *(FULL_SQLITE if archive.is_sqlite else FULL_POSTGRES))
    with pytest.raises(ArchiveError, match=r"the disk of the archive is full or fails: .*; nothing was changed; free"):
        publish(url, [a_set("SN1"), a_set("SN2")], PUBLISHED)
    assert [coefficients.sensor for coefficients in list_sets(url)] == ["SN0"]
    assert rows(url, "SELECT DISTINCT sha256 FROM coefficients") == rows(url, "SELECT sha256 FROM sets")
    assert rows(url, "SELECT count(*) FROM records") == [(1,)]


PUBLISH_ON_A_FULL_DISK = """
import os, resource, signal, sys
from datetime import UTC, datetime
sys.path.insert(0, sys.argv[2])
from archived_runs import a_run, a_sensor
from ams.errors import ArchiveError
from ams.archive.runs import publish_run
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
size = os.path.getsize(sys.argv[1].removeprefix("sqlite:///")) + 8192
resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
try:
    publish_run(sys.argv[1], a_run(1), [a_sensor(1), a_sensor(1, "SN2")], datetime(2026, 6, 1, tzinfo=UTC))
except ArchiveError as error:
    print(error)
"""


def test_a_file_that_cannot_grow_leaves_nothing_half(sqlite_url: str) -> None:
    """The system itself refuses the pages that a transaction needs, in the middle of it."""
    publish(sqlite_url, [a_set("SN0")], PUBLISHED)
    support = str(Path(__file__).parents[2] / "support")
    command = [sys.executable, "-c", PUBLISH_ON_A_FULL_DISK, sqlite_url, support]
    done = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "the disk of the archive is full or fails: " in done
    assert "nothing was changed" in done
    assert [coefficients.sensor for coefficients in list_sets(sqlite_url)] == ["SN0"]
    assert verify_archive(sqlite_url).faults == ()
    publish(sqlite_url, [a_set("SN1")], PUBLISHED)


def test_a_set_that_contradicts_itself_is_not_published(url: str) -> None:
    def nudge(document: dict[str, object]) -> None:
        document["axes"]["x"]["primary"]["values"]["offset_v"] = 0.006  # type: ignore[index]

    wrong = from_document(changed(a_set("SN2"), nudge), "wrong")
    with pytest.raises(VectorsDisagree, match="SN2: publish: axis x"):
        publish(url, [a_set("SN1"), wrong], PUBLISHED)
    with pytest.raises(
        ArchiveError, match=r"there is no archive: no such file|is a database but no archive|has 0 bytes"
    ):
        list_sets(url)


def test_two_writers_at_once_lose_nothing(url: str) -> None:
    sets = [a_set(f"SN{number}") for number in range(12)]
    with ThreadPoolExecutor(4) as pool:
        waiting = [pool.submit(publish, url, [coefficients], PUBLISHED, 60.0) for coefficients in [*sets, *sets]]
        published = [publication for future in waiting for publication in future.result()]
    assert sorted(coefficients.sha256 for coefficients in published if coefficients.is_new) == sorted(
        coefficients.sha256 for coefficients in sets
    )
    assert {coefficients.sha256 for coefficients in list_sets(url)} == {coefficients.sha256 for coefficients in sets}


PUBLISH_UNTIL_KILLED = """
import sys
from datetime import UTC, datetime
from pathlib import Path
from ams.archive.sets import publish
from ams.exports.formats import load_set
sets = [load_set(path) for path in sorted(Path(sys.argv[2]).glob("*.json"))]
print("ready", flush=True)
for one in sets:
    publish(sys.argv[1], [one], datetime.now(UTC))
    print(one.sha256, flush=True)
"""


def test_a_killed_writer_leaves_whole_sets_and_everything_it_acknowledged(url: str, tmp_path: Path) -> None:
    from ams.exports.formats import export_set

    (tmp_path / "sets").mkdir()
    for number in range(40):
        export_set(a_set(f"SN{number}"), "json", tmp_path / "sets" / f"{number:02}.json")
    command = [sys.executable, "-c", PUBLISH_UNTIL_KILLED, url, str(tmp_path / "sets")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        acknowledged = [writer.stdout.readline().strip() for _ in range(12)][1:]
        writer.kill()
    stored = {coefficients.sha256 for coefficients in list_sets(url)}
    assert set(acknowledged) <= stored
    assert all(show(url, sha256).sha256 == sha256 for sha256 in stored)
    assert {row[0] for row in rows(url, "SELECT sha256 FROM coefficients")} == stored


def test_a_locked_archive_is_a_sentence_and_unlocked_it_goes_on(sqlite_url: str, tmp_path: Path) -> None:
    publish(sqlite_url, [a_set("SN1")], PUBLISHED)
    with closing(sqlite3.connect(tmp_path / "archive.sqlite", isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(
            ArchiveError, match=r"the archive is locked by another program for over 0\.05 s; nothing was"
        ):
            publish(sqlite_url, [a_set("SN2")], PUBLISHED, busy_timeout_s=0.05)
        with pytest.raises(ArchiveError, match="is locked by another program"):
            list_sets(sqlite_url, busy_timeout_s=0.05)
    publish(sqlite_url, [a_set("SN2")], PUBLISHED)
    assert len(list_sets(sqlite_url)) == 2


def test_a_writer_that_holds_the_server_is_a_sentence_and_readers_go_on(postgres: Server) -> None:
    from ams.archive.connection import writing

    url = postgres.new_database()
    publish(url, [a_set("SN1")], PUBLISHED)
    with (
        writing(url, 5.0),
        pytest.raises(ArchiveError, match=r"the archive is locked by another program for over 0\.05 s; nothing was"),
    ):
        publish(url, [a_set("SN2")], PUBLISHED, busy_timeout_s=0.05)
    with writing(url, 5.0):
        assert len(list_sets(url)) == 1
    publish(url, [a_set("SN2")], PUBLISHED)
    assert len(list_sets(url)) == 2


def test_a_newer_schema_is_left_alone(url: str) -> None:
    publish(url, [a_set()], PUBLISHED)
    execute(url, "UPDATE alembic_version SET version_num = '0999'")
    for attempt in (lambda: publish(url, [a_set("SN2")], PUBLISHED), lambda: list_sets(url)):
        with pytest.raises(
            ArchiveError, match="was written by a newer calrig: got schema 0999, this one knows up to 0009"
        ):
            attempt()
    assert rows(url, "SELECT count(*) FROM sets") == [(1,)]


def test_a_database_of_something_else_is_left_alone(url: str) -> None:
    execute(url, "CREATE TABLE invoices (number INTEGER)")
    with pytest.raises(ArchiveError, match="is a database of something else"):
        publish(url, [a_set()], PUBLISHED)
    with pytest.raises(ArchiveError, match="is a database but no archive"):
        list_sets(url)
    assert inspect(create_engine(url, poolclass=NullPool)).get_table_names() == ["invoices"]


@pytest.mark.parametrize("look", [list_sets, migrate, verify_archive])
def test_an_archive_that_was_cut_to_nothing_is_no_new_one(tmp_path: Path, look: Callable[[str], object]) -> None:
    """SQLite takes a file of 0 bytes for a new database."""
    path = tmp_path / "archive.sqlite"
    publish(f"sqlite:///{path}", [a_set()], PUBLISHED)
    path.write_bytes(b"")
    with pytest.raises(
        ArchiveError, match=r"has 0 bytes, which no archive has: .* nothing was changed; restore a copy"
    ):
        look(f"sqlite:///{path}")
    assert path.read_bytes() == b""


def test_a_file_that_is_no_database_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no database at all, but long enough to have a header of a hundred bytes, " * 3)
    before = path.read_bytes()
    with pytest.raises(ArchiveError, match=r"notes\.txt: is no archive, or a damaged one: file is not a database"):
        publish(f"sqlite:///{path}", [a_set()], PUBLISHED)
    assert path.read_bytes() == before


def test_an_archive_without_write_rights_is_a_sentence(sqlite_url: str, tmp_path: Path) -> None:
    publish(sqlite_url, [a_set()], PUBLISHED)
    read_only = f"sqlite:///file:{tmp_path / 'archive.sqlite'}?mode=ro&uri=true"
    with pytest.raises(ArchiveError, match="the archive cannot be written: attempt to write a readonly database"):
        publish(read_only, [a_set("SN2")], PUBLISHED)
    assert len(list_sets(read_only)) == 1


def test_a_user_without_the_rights_of_a_writer_is_a_sentence(postgres: Server) -> None:
    url = postgres.new_database()
    publish(url, [a_set()], PUBLISHED)
    database = url.rpartition("/")[2]
    postgres.execute(database, f"CREATE ROLE reader_{database} LOGIN PASSWORD 'opensesame'")
    postgres.execute(database, f"GRANT SELECT ON ALL TABLES IN SCHEMA public TO reader_{database}")
    reader = postgres.url(database, f"reader_{database}")
    assert len(list_sets(reader)) == 1
    with pytest.raises(ArchiveError, match="the rights are missing: permission denied for table sets; nothing was"):
        publish(reader, [a_set("SN2")], PUBLISHED)
    assert len(list_sets(url)) == 1


def test_a_server_that_refuses_or_is_not_there_is_a_sentence(postgres: Server) -> None:
    url = postgres.new_database()
    with pytest.raises(ArchiveError, match=r"does not let you in: FATAL: .*password authentication failed"):
        list_sets(url.replace("opensesame", "wrong"))
    with pytest.raises(ArchiveUnknown, match=r'no such database or server: FATAL: .*"nowhere" does not exist'):
        list_sets(url.rpartition("/")[0] + "/nowhere")
    with pytest.raises(ArchiveError, match="the server of the archive does not answer: Connection refused"):
        list_sets(url.replace(f":{postgres.port}/", ":1/"))


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ("archive.sqlite", "archive URL: cannot be used: got 'archive.sqlite'"),
        ("nonsense://host/db", "archive URL: cannot be used: got 'nonsense://host/db'"),
        ("sqlite://", "archive URL: names no file"),
        ("sqlite:///:memory:", "archive URL: names no file"),
        ("sqlite:////nowhere/archive.sqlite", "/nowhere/archive.sqlite: the archive cannot be opened"),
        ("mysql+pymysql://me:secret@host/db", "no driver for this kind of database"),
        ("postgresql+psycopg://me:secret@nowhere.invalid/db", "there is no such database or server"),
    ],
)
def test_a_wrong_url_is_a_sentence_without_its_password(wrong: str, sentence: str) -> None:
    with pytest.raises(ArchiveError) as caught:
        publish(wrong, [a_set()], PUBLISHED)
    assert sentence in str(caught.value)
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        ("postgresql+psycopg://me:s:e@c/ret@host:5432/db", "postgresql+psycopg://me:***@host:5432/db"),
        (
            "postgresql+psycopg://host/db?user=me&password=secret&x=1",
            "postgresql+psycopg://host/db?user=me&password=***&x=1",
        ),
        ("postgresql+psycopg://me@host/db", "postgresql+psycopg://me@host/db"),
        ("sqlite:////a/b@c:d/archive.sqlite", "sqlite:////a/b@c:d/archive.sqlite"),
    ],
)
def test_no_url_is_shown_with_its_password(url: str, shown: str) -> None:
    assert without_password(url) == shown


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
    from ams.archive.tables import COMING_AND_GOING, METADATA

    publish(url, [a_set()], PUBLISHED)
    made = inspect(create_engine(url, poolclass=NullPool))
    tables = {**METADATA.tables, **COMING_AND_GOING.tables}
    assert set(made.get_table_names()) == {*tables, "alembic_version"}
    for name, declared in tables.items():
        columns = {column["name"]: column["nullable"] for column in made.get_columns(name)}
        assert columns == {column.name: column.nullable for column in declared.columns}


def test_the_revisions_that_are_known_are_those_of_the_migrations() -> None:
    from alembic.script import ScriptDirectory

    from ams.archive.connection import MIGRATIONS
    from ams.archive.tables import REVISIONS

    scripts = ScriptDirectory(str(MIGRATIONS)).walk_revisions()
    assert tuple(script.revision for script in scripts) == REVISIONS[::-1]
