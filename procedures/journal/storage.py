"""The journal's file: its layout, how it is opened, and what SQLite's errors mean to a person.

A journal is in WAL mode with ``synchronous=FULL`` from its first byte to its last: in SQLite's rollback mode a kill
leaves a hot journal that no read-only reader can open. Closed cleanly, all of it is in the one file; a reader may
leave an empty ``-wal`` and a ``-shm`` beside it, which mean nothing. Beside
it a line of fixed length tells how much was committed, so that a journal that lost its ``-wal`` file is noticed.
"""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import apsw

from ams.whole_file import sync_folder
from procedures.errors import JournalError, StorageFailed

JOURNAL_FILE = "journal.sqlite"
APPLICATION_ID = 0x63616C72
SCHEMA_VERSION = 1
BUSY_MS = 5000
_MAGIC = b"SQLite format 3\0"
_COUNT_LENGTH = 128
_AS_IT_IS: int = getattr(os, "O_BINARY", 0)
"""Windows turns the ends of lines into two bytes otherwise."""
_AT_ONCE: int = getattr(os, "O_NONBLOCK", 0)
"""A pipe in the place of a file is not waited for."""

SCHEMA = f"""
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
CREATE TABLE header (id INTEGER PRIMARY KEY CHECK (id = 1), document TEXT NOT NULL, sha256 TEXT NOT NULL);
CREATE TABLE events (
  sequence INTEGER PRIMARY KEY, utc TEXT NOT NULL, monotonic_s REAL NOT NULL, kind TEXT NOT NULL,
  detail TEXT NOT NULL, sha256 TEXT NOT NULL);
CREATE INDEX events_by_kind ON events (kind, sequence);
CREATE TABLE dwells (
  number INTEGER PRIMARY KEY, step INTEGER NOT NULL, attempt INTEGER NOT NULL, epoch INTEGER NOT NULL,
  accepted INTEGER NOT NULL, record TEXT NOT NULL, samples BLOB NOT NULL, sha256 TEXT NOT NULL,
  UNIQUE (step, attempt, epoch));
"""
"""Version 1. ``number`` counts dwells from 1 in the order of commitment."""


def open_for_writing(path: Path) -> apsw.Connection:
    """Open the engine's only connection to an existing journal. Raises: JournalError, StorageFailed."""
    with storage_errors_of(path):
        connection = apsw.Connection(str(path), flags=apsw.SQLITE_OPEN_READWRITE)
        connection.set_busy_timeout(BUSY_MS)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        return connection


def header_row(path: Path, connection: apsw.Connection) -> tuple[str, str]:
    """Return the header's document and its SHA-256. Raises: JournalError, StorageFailed."""
    with storage_errors_of(path):
        ((document, digest),) = connection.execute("SELECT document, sha256 FROM header")
        return document, digest


def make_file(path: Path) -> apsw.Connection:
    """Make a new file, to be put in place when it is whole. Raises: StorageFailed."""
    with storage_errors_of(path):
        apsw.Connection(str(path), flags=apsw.SQLITE_OPEN_READWRITE | apsw.SQLITE_OPEN_CREATE).close()
    return open_for_writing(path)


def fold(path: Path, connection: apsw.Connection) -> None:
    """Bring the write-ahead log into a file that is to be renamed, and close it. Raises: StorageFailed."""
    with storage_errors_of(path):
        checkpoint_and_close(connection)


def checkpoint_and_close(connection: apsw.Connection) -> None:
    """Write the log back and close: closing alone would keep silent about a failure. Raises: apsw.Error."""
    try:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    finally:
        connection.close()


def put_under_name(new_file: Path, path: Path) -> None:
    """Rename and sync the folder: the name appears with the whole content. Raises: StorageFailed."""
    try:
        os.rename(new_file, path)
        # The name stands in the folder: a power cut may take it back from one that was not synced.
        sync_folder(path.parent)
    except OSError as error:
        raise StorageFailed(f"{path}: cannot be made: {error.strerror}; nothing moved; check the folder") from error


def open_for_reading(path: Path) -> apsw.Connection:
    """Open a journal read-only that may be written to meanwhile. Raises: JournalError."""
    require_journal_file(path)
    with storage_errors_of(path):
        connection = apsw.Connection(_reading_uri(path), flags=apsw.SQLITE_OPEN_READONLY | apsw.SQLITE_OPEN_URI)
        connection.set_busy_timeout(BUSY_MS)
        require_our_schema(path, connection)
        return connection


def _reading_uri(path: Path) -> str:
    """Return the URI to read a journal by; one at rest in a folder that may not be written is read as it lies."""
    # In WAL mode SQLite makes a -shm even to read. Where it may not, it opens a file only if told that nobody writes to
    # it, and would then read past a -wal file.
    at_rest = not path.with_name(path.name + "-wal").exists() and not os.access(path.parent, os.W_OK)
    return path.resolve().as_uri() + ("?immutable=1" if at_rest else "?mode=ro")


def require_journal_file(path: Path) -> None:
    """Check what can be told from the first bytes of a journal. Raises: JournalError."""
    if path.exists() and not path.is_file() and not path.is_dir():
        raise JournalError(f"{path}: is no plain file, as a journal is; it was left as it is; give the folder of a run")
    try:
        start = _first_bytes(path)
    except OSError as error:
        raise JournalError(f"{path}: cannot be read: {error.strerror}; give the folder of a run") from None
    if not start:
        raise JournalError(f"{path}: has zero length; its content is lost; restore it with its -wal file from a copy")
    if not _MAGIC.startswith(start[: len(_MAGIC)]):
        raise JournalError(f"{path}: is not a journal: it does not begin as an SQLite file does; it was left as it is")
    if len(start) < len(_MAGIC):
        raise JournalError(f"{path}: is truncated after {len(start)} bytes; restore it from a copy")


def _first_bytes(path: Path) -> bytes:
    """Read them through SQLite. Raises: OSError.

    A process that closes a file itself loses its every lock on it (POSIX): the engine, which looks at its journal for a
    page, would be taken for gone, and the next program that opens the journal would remove its write-ahead log.
    """
    try:
        file = apsw.VFSFile("", str(path.absolute()), [apsw.SQLITE_OPEN_MAIN_DB | apsw.SQLITE_OPEN_READONLY, 0])
        try:
            size = min(len(_MAGIC), file.xFileSize())
            return file.xRead(size, 0) if size else b""
        finally:
            file.xClose()
    except apsw.Error:
        with open(path, "rb") as plain:  # for the system's word why not
            return plain.read(len(_MAGIC))


def require_our_schema(path: Path, connection: apsw.Connection) -> None:
    """Check whose file it is. Raises: JournalError for another program's and for a version of another calrig."""
    application, version = connection.pragma("application_id"), connection.pragma("user_version")
    if application != APPLICATION_ID:
        raise JournalError(f"{path}: is an SQLite file but not a journal of calrig; it was left as it is")
    if version != SCHEMA_VERSION:
        raise JournalError(
            f"{path}: journal version: got {version}, this calrig reads {SCHEMA_VERSION}; it was left as it is; "
            "use the calrig that wrote it"
        )


@contextmanager
def storage_errors_of(path: Path) -> Iterator[None]:
    """SQLite's errors as ours: a damaged file is the journal's, everything about space and rights the disk's."""
    try:
        yield
    except (apsw.NotADBError, apsw.CorruptError, apsw.FormatError) as error:
        raise JournalError(
            f"{path}: is truncated or damaged ({error}); it was left as it is; restore it and its -wal from a copy"
        ) from None
    except (apsw.FullError, apsw.IOError, apsw.CantOpenError, apsw.ReadOnlyError, apsw.PermissionsError) as error:
        raise StorageFailed(
            f"{path}: cannot be written: {error}; everything committed before is intact, the dwell in progress is not "
            "recorded; free space or repair the disk, then resume the run"
        ) from error
    except (apsw.BusyError, apsw.LockedError) as error:
        raise StorageFailed(f"{path}: another program holds the journal ({error}); close it, then try again") from error
    except (apsw.SQLError, UnicodeDecodeError) as error:
        raise JournalError(f"{path}: is not a whole journal ({error}); it was left as it is") from None


class Committed(NamedTuple):
    """What was committed at least, and to the journal of which run."""

    events: int
    dwells: int
    run_id: str


class CommittedCount:
    """``journal.count``: run, events and dwells committed so far, overwritten in place after each commit."""

    def __init__(self, journal: Path) -> None:
        self.path = journal.with_name("journal.count")

    def write(self, run_id: str, events: int, dwells: int) -> None:
        """Write the counts in one go.

        They survive the death of the process; a power cut may leave them a commit behind.
        """
        line = json.dumps({"run": run_id, "events": events, "dwells": dwells})
        try:
            handle = os.open(self.path, os.O_WRONLY | os.O_CREAT | _AS_IT_IS | _AT_ONCE, 0o644)
            try:
                # In one go where the system can. Without a second fsync a dwell: the rows are on the disk by their own,
                # and a count that lags behind them accuses no journal.
                content = line.ljust(_COUNT_LENGTH - 1).encode() + b"\n"
                if hasattr(os, "pwrite"):
                    os.pwrite(handle, content, 0)
                else:
                    os.write(handle, content)
            finally:
                os.close(handle)
        except OSError as error:
            raise StorageFailed(
                f"{self.path}: cannot be written: {error.strerror}; free space or repair the disk, then resume the run"
            ) from error

    def read(self) -> Committed | None:
        """Return what was committed; None where there is no such file, or a power cut left it without its
        content. Raises: JournalError.
        """
        if self.path.exists() and not self.path.is_file():
            raise JournalError(f"{self.path}: is no plain file; remove it to read the journal without it")
        try:
            text = self.path.read_text(encoding="utf-8").strip("\0")
            document = json.loads(text) if text else None
            if document is None:
                return None
            return Committed(int(document["events"]), int(document["dwells"]), str(document["run"]))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise JournalError(
                f"{self.path}: cannot be read: {error}; remove it to read the journal without it"
            ) from None
