"""Connections to an archive: its URL, its transactions, its schema version, and its refusals in sentences.

A SQLite archive keeps the rollback journal (its default): Python 3.11's own SQLite has a write-ahead log that two
writers can corrupt. A writer takes the write lock when its transaction begins, so two writers queue up instead of
meeting a lock half-way.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ams.errors import ArchiveError, ArchiveUnknown

if TYPE_CHECKING:
    from alembic.config import Config
    from sqlalchemy import URL, Connection, Engine

MIGRATIONS = Path(__file__).with_name("migrations")
NOTHING = "nothing was changed"


@contextmanager
def reading(archive_url: str, busy_timeout_s: float) -> "Iterator[Connection]":
    """A read transaction on an archive of the current schema. Raises: ArchiveError."""
    url = _parsed(archive_url)
    path = _sqlite_path(url)
    if path is not None and not os.path.exists(path):
        raise ArchiveUnknown(
            f"{path}: there is no archive: no such file; publish a set to it first, or give another URL"
        )
    with _transaction(url, "BEGIN", busy_timeout_s) as connection:
        _check_schema(connection, _shown(url))
        yield connection


@contextmanager
def writing(archive_url: str, busy_timeout_s: float) -> "Iterator[Connection]":
    """A write transaction, the archive made or migrated where needed; all of it is committed or nothing.

    Raises: ArchiveError.
    """
    url = _parsed(archive_url)
    with _transaction(url, "BEGIN IMMEDIATE", busy_timeout_s) as connection:
        _migrate(connection, _shown(url))
        yield connection


@contextmanager
def _transaction(url: "URL", begin: str, busy_timeout_s: float) -> "Iterator[Connection]":
    from sqlalchemy.exc import SQLAlchemyError

    try:
        engine = _engine(url, begin, busy_timeout_s)
        try:
            with engine.begin() as connection:
                yield connection
        finally:
            engine.dispose()
    except SQLAlchemyError as error:
        raise ArchiveError(_sentence(url, error, busy_timeout_s)) from error


def _engine(url: "URL", begin: str, busy_timeout_s: float) -> "Engine":
    from sqlalchemy import create_engine, event
    from sqlalchemy.pool import NullPool

    is_sqlite = url.get_backend_name() == "sqlite"
    try:
        engine = create_engine(url, poolclass=NullPool, connect_args={"timeout": busy_timeout_s} if is_sqlite else {})
    except ImportError as error:
        raise ArchiveError(
            f"{_shown(url)}: no driver for this kind of database: {error}; {NOTHING}; "
            "install its driver (psycopg for PostgreSQL), or use sqlite:///PATH"
        ) from error
    if is_sqlite:
        event.listen(engine, "connect", _own_the_transactions)
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql(begin))
    return engine


def _own_the_transactions(connection: object, record: object) -> None:  # noqa: ARG001 (the event's signature)
    """Keep Python's driver from beginning transactions of its own; make foreign keys and every sync count."""
    connection.isolation_level = None  # type: ignore[attr-defined]  # a DBAPI connection of sqlite3
    connection.execute("PRAGMA foreign_keys = ON")  # type: ignore[attr-defined]
    connection.execute("PRAGMA synchronous = FULL")  # type: ignore[attr-defined]


def _parsed(archive_url: str) -> "URL":
    from sqlalchemy import make_url
    from sqlalchemy.exc import ArgumentError

    try:
        url = make_url(archive_url)
        url.get_dialect()
    except (ArgumentError, ImportError, ValueError) as error:
        raise ArchiveUnknown(
            f"archive URL: cannot be used: got {_without_password(archive_url)!r} ({error.__class__.__name__}), "
            f"allowed are sqlite:///relative/path, sqlite:////absolute/path and postgresql+psycopg://…; {NOTHING}"
        ) from error
    if url.get_backend_name() == "sqlite" and url.database in (None, "", ":memory:"):
        raise ArchiveUnknown(
            f"archive URL: names no file: got {archive_url!r}, needed is sqlite:///path; {NOTHING}; "
            "an archive in memory would be lost"
        )
    return url


def _without_password(text: str) -> str:
    head, _, tail = text.rpartition("@")
    return f"…@{tail}" if head else text


def _shown(url: "URL") -> str:
    path = _sqlite_path(url)
    return url.render_as_string(hide_password=True) if path is None else str(path)


def _sqlite_path(url: "URL") -> Path | None:
    """The archive's file; None where the URL is no plain file name."""
    if url.get_backend_name() != "sqlite" or url.database is None or url.database.startswith("file:"):
        return None
    return Path(url.database)


def _config(connection: "Connection | None") -> "Config":
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def _revision(connection: "Connection") -> str | None:
    from alembic.runtime.migration import MigrationContext

    return MigrationContext.configure(connection).get_current_revision()


def _known_revisions() -> tuple[str, ...]:
    """Newest first."""
    from alembic.script import ScriptDirectory

    return tuple(script.revision for script in ScriptDirectory.from_config(_config(None)).walk_revisions())


def _check_schema(connection: "Connection", shown: str) -> None:
    revision, known = _revision(connection), _known_revisions()
    if revision is None:
        raise ArchiveUnknown(f"{shown}: is a database but no archive: it has no schema version; give another URL")
    _check_not_newer(revision, known, shown)
    if revision != known[0]:
        raise ArchiveError(
            f"{shown}: has the older schema {revision}, this calrig reads {known[0]}; publish a set to migrate it"
        )


def _check_not_newer(revision: str, known: tuple[str, ...], shown: str) -> None:
    if revision not in known:
        raise ArchiveError(
            f"{shown}: was written by a newer calrig: got schema {revision}, this one knows up to {known[0]}; "
            f"{NOTHING}; install that calrig"
        )


def _migrate(connection: "Connection", shown: str) -> None:
    from alembic import command
    from sqlalchemy import inspect

    revision, known = _revision(connection), _known_revisions()
    if revision == known[0]:
        return
    if revision is not None:
        _check_not_newer(revision, known, shown)
    elif inspect(connection).get_table_names():
        raise ArchiveUnknown(
            f"{shown}: is a database of something else: it has tables and no schema version of calrig; "
            f"{NOTHING}; give the archive a file or database of its own"
        )
    command.upgrade(_config(connection), "head")


def _sentence(url: "URL", error: Exception, busy_timeout_s: float) -> str:
    cause = str(getattr(error, "orig", None) or error).splitlines()[0]
    shown = _shown(url)
    if "locked" in cause or "busy" in cause:
        held = f"is locked by another program for over {busy_timeout_s:g} s"
        return f"{shown}: the archive {held}; {NOTHING}; try again later"
    if "unable to open" in cause:
        return f"{shown}: the archive cannot be opened: {cause}; {NOTHING}; check that the folder exists and its rights"
    if "readonly" in cause or "read-only" in cause:
        return (
            f"{shown}: the archive cannot be written: {cause}; {NOTHING}; check the rights of the file and its folder"
        )
    if "not a database" in cause or "malformed" in cause:
        return f"{shown}: is no archive, or a damaged one: {cause}; {NOTHING}; restore a copy, or give another URL"
    return f"{shown}: the archive refused: {cause}; {NOTHING}; check the URL, the rights and the free space"
