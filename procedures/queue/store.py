"""The queue's file: events in SQLite, each with the hash of the one before; whoever changes it sees what it changes.

A change is one transaction that reads everything, decides and writes, so that two who change it at once do it one
after the other, and a kill at any moment leaves all of a change or nothing. ``synchronous=FULL``: what was answered is
on the disk.
"""

import hashlib
import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

import apsw

from procedures.errors import JournalError, StorageFailed
from procedures.queue.state import Detail, Event, Queue, folded
from rig.clock import Clock

FILE = "queue.sqlite"
VERSION = 1
_BUSY_MS = 10_000
_TABLE = """CREATE TABLE IF NOT EXISTS events (
  sequence INTEGER PRIMARY KEY, utc TEXT NOT NULL, kind TEXT NOT NULL, detail TEXT NOT NULL,
  previous TEXT NOT NULL, sha256 TEXT NOT NULL) STRICT"""
FIRST = "0" * 64

Change = tuple[str, Detail]
"""The kind of an event, and what it says."""


class QueueStore:
    """The queue of one rig, in a folder of its own."""

    def __init__(self, folder: Path, clock: Clock) -> None:
        self.folder = folder
        self._clock = clock

    def read(self) -> Queue:
        """Return the queue as it stands; an empty one where there is none yet. Raises: JournalError."""
        if not (self.folder / FILE).exists():
            return Queue()
        with self._open() as connection:
            return folded(self._events(connection))

    def change(self, decide: Callable[[Queue], Change | None]) -> Queue:
        """Add the event that ``decide`` makes of the queue as it is now; None adds nothing.

        Raises: what ``decide`` raises, JournalError, StorageFailed; nothing is changed then.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as error:
            raise StorageFailed(f"{self.folder}: cannot be made: {error.strerror}; nothing was changed") from error
        with self._open() as connection:
            connection.execute("BEGIN IMMEDIATE")
            try:
                before = folded(self._events(connection))
                change = decide(before)
                after = before if change is None else folded([self._append(connection, before, *change)], before)
            except BaseException:
                connection.execute("ROLLBACK")
                raise
            connection.execute("COMMIT")
            return after

    def hold(self, act: Callable[[Queue], None]) -> None:
        """Do something in view of the queue while nobody can change it; whoever wants to waits until it is done.

        Raises: what ``act`` raises, JournalError.
        """
        with self._open() as connection:
            connection.execute("BEGIN IMMEDIATE")
            try:
                act(folded(self._events(connection)))
            finally:
                connection.execute("ROLLBACK")

    def _append(self, connection: apsw.Connection, queue: Queue, kind: str, detail: Detail) -> Event:
        last = connection.execute("SELECT sha256 FROM events ORDER BY sequence DESC LIMIT 1").fetchone()
        previous = str(last[0]) if last else FIRST
        utc = self._clock.now_utc()
        row = (queue.sequence + 1, utc.isoformat(), kind, json.dumps(detail, ensure_ascii=False, sort_keys=True))
        connection.execute("INSERT INTO events VALUES (?, ?, ?, ?, ?, ?)", (*row, previous, _hash(previous, row)))
        return Event(row[0], utc, kind, json.loads(row[3]))

    def _events(self, connection: apsw.Connection) -> Iterator[Event]:
        """Yield the events, each against the one before. Raises: JournalError where one was changed."""
        previous, expected = FIRST, 1
        for sequence, utc, kind, detail, before, digest in connection.execute("SELECT * FROM events ORDER BY sequence"):
            row = (sequence, utc, kind, detail)
            if sequence != expected or before != previous or digest != _hash(previous, row):
                raise JournalError(
                    f"{self.folder / FILE}: event {sequence} is not what was written; nothing is started from this "
                    "queue; keep the file, and begin a new queue"
                )
            yield Event(sequence, datetime.fromisoformat(utc), kind, json.loads(detail))
            previous, expected = digest, expected + 1

    @contextmanager
    def _open(self) -> Iterator[apsw.Connection]:
        path = self.folder / FILE
        try:
            connection = apsw.Connection(str(path))
        except apsw.Error as error:
            raise JournalError(f"{path}: cannot be opened: {error}") from error
        try:
            connection.set_busy_timeout(_BUSY_MS)
            connection.execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL")
            found = connection.pragma("user_version")
            if found == 0:
                connection.execute(f"{_TABLE}; PRAGMA user_version={VERSION}")
            elif found != VERSION:
                raise JournalError(f"{path}: version {found}, known is {VERSION}; nothing was changed")
            yield connection
        except (apsw.CorruptError, apsw.NotADBError, UnicodeDecodeError) as error:
            raise JournalError(
                f"{path}: is damaged ({error}); nothing was changed; keep the file, and begin a new queue"
            ) from error
        except apsw.Error as error:
            raise JournalError(f"{path}: cannot be used: {error}; nothing was changed") from error
        finally:
            connection.close()


def folder_of_rig(queues: Path, rig_name: str) -> Path:
    """Return where the queue of a rig is kept: by the rig's name, whatever its file is called."""
    slug = re.sub(r"[^a-z0-9]+", "-", rig_name.lower()).strip("-")[:40] or "rig"
    return queues / f"{slug}-{hashlib.sha256(rig_name.encode()).hexdigest()[:8]}"


def _hash(previous: str, row: tuple[int, str, str, str]) -> str:
    return hashlib.sha256(json.dumps([previous, *row], ensure_ascii=False).encode()).hexdigest()
