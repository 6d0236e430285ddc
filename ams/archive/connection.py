"""Connections to an archive: its URL, its transactions, its schema version, and its refusals in sentences.

A SQLite archive keeps the rollback journal (its default): Python 3.11's own SQLite has a write-ahead log that two
writers can corrupt. A writer takes the write lock when its transaction begins, so two writers queue up instead of
meeting a lock half-way; in PostgreSQL an advisory lock does the same. Before an older SQLite archive is migrated, a
copy of it is written beside it.
"""

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import URL, Connection, Engine, create_engine, event, inspect, make_url, text
from sqlalchemy.exc import ArgumentError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from ams.archive.ledger import verify_chain
from ams.archive.refusals import NOTHING, RESTORE, cause_of, damaged, is_busy, refusal, without_password
from ams.archive.tables import REVISIONS
from ams.errors import AmsError, ArchiveAbsent, ArchiveDamaged, ArchiveError, ArchiveUnknown
from ams.whole_file import write_whole

if TYPE_CHECKING:
    from alembic.config import Config

MIGRATIONS = Path(__file__).with_name("migrations")
POSTGRES = "postgresql"
EMPTIED = "has 0 bytes, which no archive has: it was cut, or never begun"
EMPTIED_REMEDY = "restore a copy; where there was none, remove the file"
_WRITERS = 0x63616C726967
"""The advisory lock of writers: "calrig" as a number."""


@contextmanager
def reading(archive_url: str, busy_timeout_s: float) -> Iterator[Connection]:
    """Open a read transaction on an archive of the current schema. Raises: ArchiveError."""
    url = _parsed(archive_url)
    _require_begun(url, busy_timeout_s)
    with _transaction(url, "BEGIN", busy_timeout_s) as connection:
        if url.get_backend_name() == POSTGRES:
            connection.exec_driver_sql("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ, READ ONLY")
        shown = _shown(url)
        revision = _revision(connection)
        if revision is None:
            raise ArchiveUnknown(f"{shown}: is a database but no archive: it has no schema version; give another URL")
        _check_not_newer(revision, shown)
        if revision != REVISIONS[-1]:
            raise ArchiveError(
                f"{shown}: has the older schema {revision}, this calrig reads {REVISIONS[-1]}; calrig archive migrate "
                "brings it up to date, as publishing does"
            )
        yield connection


@contextmanager
def writing(archive_url: str, busy_timeout_s: float, *, only_existing: bool = False) -> Iterator[Connection]:
    """Open a write transaction, the archive made or migrated where needed; all of it is committed or nothing.

    ``only_existing``: what is to be changed must be there already, so no archive is made.

    Raises: ArchiveError.
    """
    url = _parsed(archive_url)
    if only_existing:
        _require_begun(url, busy_timeout_s)
    with _transaction(url, "BEGIN IMMEDIATE", busy_timeout_s) as connection:
        if url.get_backend_name() == POSTGRES:
            connection.exec_driver_sql(f"SET LOCAL lock_timeout = {int(busy_timeout_s * 1000)}")
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_WRITERS})")
        _migrate(connection, url)
        yield connection


def migrate(archive_url: str, busy_timeout_s: float = 10.0) -> tuple[str | None, str | None]:
    """Bring an archive that is there to this version's schema; the schema before and after. Raises: ArchiveError."""
    url = _parsed(archive_url)
    _require_begun(url, busy_timeout_s)
    with _transaction(url, "BEGIN", busy_timeout_s) as connection:
        before = _revision(connection)
    if before is None:
        raise ArchiveUnknown(f"{_shown(url)}: is no archive: it has no schema version; {NOTHING}; give another URL")
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        return before, _revision(connection)


def _require_begun(url: URL, busy_timeout_s: float) -> None:
    """Refuse a SQLite file that is not there, since to look at it would make it, or that has 0 bytes.

    Raises: ArchiveAbsent; ArchiveUnknown; ArchiveError where somebody who makes it takes too long.
    """
    path = _sqlite_path(url)
    if path is None:
        return
    if not os.path.exists(path):
        raise ArchiveAbsent(
            f"{path}: there is no archive: no such file; {NOTHING}; publish a set to it first, or give another URL"
        )
    if _is_emptied(url, path, busy_timeout_s):
        raise ArchiveUnknown(f"{path}: the archive {EMPTIED}; {NOTHING}; {EMPTIED_REMEDY}")


def is_emptied(archive_url: str, busy_timeout_s: float = 10.0) -> bool:
    """Return whether a SQLite archive's file is there and has 0 bytes: one in use was cut, or a first one not begun.

    SQLite takes it for a new database, and whoever writes to it begins a new archive. One that somebody is making at
    this moment is waited for. Raises: ArchiveUnknown; ArchiveError where that takes longer.
    """
    url = _parsed(archive_url)
    path = _sqlite_path(url)
    return path is not None and path.is_file() and _is_emptied(url, path, busy_timeout_s)


def _is_emptied(url: URL, path: Path, busy_timeout_s: float) -> bool:
    if os.path.getsize(path):
        return False
    try:
        # Who makes an archive has the turn of writers from the first byte to the last, and commits all of it at once.
        with _plain_transaction(url, "BEGIN IMMEDIATE", busy_timeout_s) as connection:
            connection.exec_driver_sql("ROLLBACK")  # a commit of nothing makes a database
    except SQLAlchemyError as error:
        if is_busy(error):
            raise refusal(_shown(url), error, busy_timeout_s) from error
    return not os.path.getsize(path)


@contextmanager
def _transaction(url: URL, begin: str, busy_timeout_s: float) -> Iterator[Connection]:
    try:
        with _plain_transaction(url, begin, busy_timeout_s) as connection:
            yield connection
    except SQLAlchemyError as error:
        raise refusal(_shown(url), error, busy_timeout_s) from error
    except (AmsError, OSError):
        raise
    except Exception as error:
        # A cell that is none, or a driver that cannot read the file, raises what a defect of ours does: the record
        # tells which of the two it was.
        if (damage := _damage(url, busy_timeout_s)) is not None:
            raise damage from error
        raise


@contextmanager
def _plain_transaction(url: URL, begin: str, busy_timeout_s: float) -> Iterator[Connection]:
    engine = _engine(url, begin, busy_timeout_s)
    try:
        with engine.begin() as connection:
            yield connection
    finally:
        engine.dispose()


def _damage(url: URL, busy_timeout_s: float) -> ArchiveDamaged | None:
    """Return what to say of the first thing in an archive that is not as it was written; None where all of it is."""
    try:
        with _plain_transaction(url, "BEGIN", busy_timeout_s) as connection:
            fault = next(iter(verify_chain(connection).faults), None)
            return None if fault is None else damaged(_shown(url), fault)
    except Exception as error:  # noqa: BLE001  not even the record can be read
        return damaged(_shown(url), cause_of(error), RESTORE)


def _engine(url: URL, begin: str, busy_timeout_s: float) -> Engine:
    is_sqlite = url.get_backend_name() == "sqlite"
    waits = {"timeout": busy_timeout_s} if is_sqlite else {"connect_timeout": max(2, math.ceil(busy_timeout_s))}
    try:
        engine = create_engine(url, poolclass=NullPool, connect_args=waits)
    except ImportError as error:
        raise ArchiveError(
            f"{_shown(url)}: no driver for this kind of database: {error}; {NOTHING}; "
            "install its driver (pip install 'calrig[postgres]' for PostgreSQL), or use sqlite:///PATH"
        ) from error
    if is_sqlite:
        event.listen(engine, "connect", _begin_transactions_here)
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql(begin))
    return engine


def _begin_transactions_here(connection: object, record: object) -> None:  # noqa: ARG001 (the event's signature)
    """Keep Python's driver from beginning transactions of its own; make foreign keys and every sync count."""
    connection.isolation_level = None  # type: ignore[attr-defined]  # a DBAPI connection of sqlite3
    connection.execute("PRAGMA foreign_keys = ON")  # type: ignore[attr-defined]
    connection.execute("PRAGMA synchronous = FULL")  # type: ignore[attr-defined]


def _parsed(archive_url: str) -> URL:
    try:
        url = make_url(archive_url)
        url.get_dialect()
    except (ArgumentError, ImportError, ValueError) as error:
        raise ArchiveUnknown(
            f"archive URL: cannot be used: got {without_password(archive_url)!r} ({error.__class__.__name__}), "
            f"allowed are sqlite:///relative/path, sqlite:////absolute/path and postgresql+psycopg://…; {NOTHING}"
        ) from error
    if url.get_backend_name() == "sqlite" and url.database in (None, "", ":memory:"):
        raise ArchiveUnknown(
            f"archive URL: names no file: got {archive_url!r}, needed is sqlite:///path; {NOTHING}; "
            "an archive in memory would be lost"
        )
    return url


def _shown(url: URL) -> str:
    path = _sqlite_path(url)
    return without_password(url.render_as_string(hide_password=True)) if path is None else str(path)


def _sqlite_path(url: URL) -> Path | None:
    """Return the archive's file; None where the URL is no plain file name."""
    if url.get_backend_name() != "sqlite" or url.database is None or url.database.startswith("file:"):
        return None
    return Path(url.database)


def _config(connection: Connection) -> "Config":
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def _revision(connection: Connection) -> str | None:
    if not inspect(connection).has_table("alembic_version"):
        return None
    found = connection.execute(text("SELECT version_num FROM alembic_version")).scalar()
    return None if found is None else str(found)


def _check_not_newer(revision: str, shown: str) -> None:
    if revision not in REVISIONS:
        raise ArchiveError(
            f"{shown}: was written by a newer calrig: got schema {revision}, this one knows up to {REVISIONS[-1]}; "
            f"{NOTHING}; install that calrig"
        )


def _migrate(connection: Connection, url: URL) -> None:
    revision, shown = _revision(connection), _shown(url)
    if revision == REVISIONS[-1]:
        return
    if revision is not None:
        _check_not_newer(revision, shown)
        # The file as it is, under the write lock and before the first change; a server has backups of its own.
        path = _sqlite_path(url)
        if path is not None:
            write_whole(path.with_name(f"{path.name}.schema-{revision}"), path.read_bytes())
    elif inspect(connection).get_table_names():
        raise ArchiveUnknown(
            f"{shown}: is a database of something else: it has tables and no schema version of calrig; "
            f"{NOTHING}; give the archive a file or database of its own"
        )
    from alembic import command

    command.upgrade(_config(connection), "head")
