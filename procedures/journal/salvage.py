"""Take out of a damaged journal whatever is provably as it was written, into a new file; the old one stays untouched.

The header must be whole. Events are taken as long as their chain holds; a dwell is taken where its SHA-256 is that
which a kept event tells. Dwells that are told of but damaged are named in an event, ``quarantined``, and a finished
run that lost some is stopped: a resume on the new file measures them again.
"""

import json
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import apsw

from procedures.errors import JournalError
from procedures.journal.encoding import compact_json, hash_dwell, hash_event
from procedures.journal.header import sha256
from procedures.journal.storage import (
    JOURNAL_FILE,
    SCHEMA,
    CommittedCount,
    fold,
    make_file,
    put_under_name,
    require_journal_file,
    require_our_schema,
    storage_errors_of,
)
from procedures.journal.voids import QUARANTINED, Key
from procedures.records.states import State
from rig.clock import Clock, SystemClock

if TYPE_CHECKING:
    import apsw

_DWELL = (
    "SELECT number, step, attempt, epoch, accepted, record, CAST(samples AS BLOB), sha256 FROM dwells WHERE number = ?"
)
_FURTHEST_MISS = 1000
"""Rows that are missing one after the other before a table counts as ended."""


@dataclass(frozen=True)
class Salvaged:
    """What was taken over."""

    path: Path
    events: int
    dwells: int
    quarantined: tuple[str, ...]
    """Dwells that were committed and are damaged, by name."""
    events_promised: int
    """How many the count beside the journal tells of; 0 where there is none."""


def salvage(source: Path, target: Path, clock: Clock | None = None) -> Salvaged:
    """``source``: a journal or the folder of a run. ``target``: a folder that holds no journal yet, or is made.

    Raises: JournalError where not even the header can be read or a journal is at the target, StorageFailed.
    """
    source = source / JOURNAL_FILE if source.is_dir() else source
    path = target / JOURNAL_FILE
    if path.exists():
        raise JournalError(f"{path}: exists already; nothing was written; give a folder without a journal")
    require_journal_file(source)
    with TemporaryDirectory(prefix="calrig-salvage-") as scratch:
        copy = _copied(source, Path(scratch))
        with _opened(copy, source) as rows:
            return _written(rows, source, path, clock or SystemClock())


def _copied(source: Path, scratch: Path) -> Path:
    """Copy the journal with its write-ahead log: opening the copy changes nothing of the original."""
    copy = scratch / JOURNAL_FILE
    shutil.copyfile(source, copy)
    log = source.with_name(source.name + "-wal")
    if log.exists():
        shutil.copyfile(log, copy.with_name(copy.name + "-wal"))
    _fill_up(copy)
    return copy


def _fill_up(copy: Path) -> None:
    """SQLite opens nothing of a file that is shorter than it says; with empty pages at its end it reads the rest."""
    with open(copy, "r+b") as file:
        start = file.read(32)
        page = int.from_bytes(start[16:18], "big")
        size = (65536 if page == 1 else page) * int.from_bytes(start[28:32], "big")
        if file.seek(0, 2) < size:
            file.truncate(size)


class _Rows:
    """Row by row, because one damaged page must not hide the others."""

    def __init__(self, connection: apsw.Connection, source: Path) -> None:
        self._connection = connection
        self._source = source
        header = self._row("SELECT document, sha256 FROM header WHERE id = ?", 1)
        if header is None or sha256(header[0]) != header[1]:
            raise JournalError(
                f"{source}: the header is lost, so nothing can be salvaged; restore the file from a copy"
            )
        self.header: tuple[str, str] = (header[0], header[1])

    def __enter__(self) -> "_Rows":
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()

    def events(self) -> Iterator[tuple[Any, ...]]:
        """Yield the events as long as the chain holds."""
        previous = self.header[1]
        sequence = 1
        while (row := self._row("SELECT * FROM events WHERE sequence = ?", sequence)) is not None:
            if hash_event(previous, *row[:5]) != row[5]:
                return
            yield row
            previous, sequence = row[5], sequence + 1

    def dwells(self) -> Iterator[tuple[Any, ...]]:
        """Yield every row that can be read, whatever lies between."""
        number, missed = 1, 0
        while missed < _FURTHEST_MISS:
            row = self._row(_DWELL, number)
            missed = 0 if row is not None else missed + 1
            if row is not None:
                yield row
            number += 1

    def _row(self, query: str, key: int) -> tuple[Any, ...] | None:
        try:
            row: tuple[Any, ...] | None = self._connection.execute(query, (key,)).fetchone()
        except (apsw.CorruptError, apsw.IOError, apsw.SQLError, apsw.FormatError, UnicodeDecodeError):
            return None
        return row


def _opened(copy: Path, source: Path) -> _Rows:
    with storage_errors_of(source):
        connection = apsw.Connection(str(copy), flags=apsw.SQLITE_OPEN_READWRITE)
        try:
            require_our_schema(source, connection)
            return _Rows(connection, source)
        except BaseException:
            connection.close()
            raise


def _written(rows: _Rows, source: Path, path: Path, clock: Clock) -> Salvaged:
    kept = list(rows.events())
    digests = _kept_digests(kept)
    whole = [
        row for row in rows.dwells() if hash_dwell(row[5], row[6]) == row[7] == digests.get((row[1], row[2], row[3]))
    ]
    lost = sorted(digests.keys() - {(row[1], row[2], row[3]) for row in whole})
    promised = _promised(source)
    keys = [list(key) for key in lost]
    detail = {"dwells": keys, "from": str(source), "events_kept": len(kept), "events_promised": promised}
    events = [*kept, _next_event(kept, rows.header[1], QUARANTINED, detail, clock)]
    if lost and _state(kept) is State.FINISHED:
        stopped = {"from": State.FINISHED, "to": State.STOPPED, "by": "", "reason": "salvage left dwells to measure"}
        events.append(_next_event(events, rows.header[1], "state", stopped, clock))
    path.parent.mkdir(parents=True, exist_ok=True)
    new_file = path.with_name(path.name + ".new")
    new_file.unlink(missing_ok=True)
    connection = make_file(new_file)
    with storage_errors_of(new_file):
        connection.execute("BEGIN IMMEDIATE")
        connection.execute(SCHEMA)
        connection.execute("INSERT INTO header VALUES (1, ?, ?)", rows.header)
        connection.executemany("INSERT INTO events VALUES (?, ?, ?, ?, ?, ?)", events)
        connection.executemany("INSERT INTO dwells VALUES (?, ?, ?, ?, ?, ?, ?, ?)", _renumbered(whole))
        connection.execute("COMMIT")
    fold(new_file, connection)
    put_under_name(new_file, path)
    CommittedCount(path).write(str(json.loads(rows.header[0])["run_id"]), len(events), len(whole))
    names = tuple(f"step {step}, attempt {attempt}, epoch {epoch}" for step, attempt, epoch in lost)
    return Salvaged(path, len(kept), len(whole), names, promised)


def _kept_digests(events: list[tuple[Any, ...]]) -> dict[Key, str]:
    """Return the SHA-256 of every dwell that the kept events tell of, but for those quarantined before."""
    digests: dict[Key, str] = {}
    for *_, kind, text, _ in events:
        detail = json.loads(text)
        if kind == "dwell":
            digests[(detail["step"], detail["attempt"], detail["epoch"])] = detail["sha256"]
        elif kind == QUARANTINED:
            for key in detail["dwells"]:
                digests.pop((key[0], key[1], key[2]), None)
    return digests


def _renumbered(rows: list[tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
    for number, row in enumerate(rows, start=1):
        yield (number, *row[1:])


def _next_event(
    events: list[tuple[Any, ...]], header_sha256: str, kind: str, detail: Mapping[str, object], clock: Clock
) -> tuple[Any, ...]:
    previous, sequence = (events[-1][5], len(events) + 1) if events else (header_sha256, 1)
    utc, monotonic_s, text = clock.now_utc().isoformat(), clock.monotonic_s(), compact_json(dict(detail))
    digest = hash_event(previous, sequence, utc, monotonic_s, kind, text)
    return sequence, utc, monotonic_s, kind, text, digest


def _state(events: list[tuple[Any, ...]]) -> State | None:
    states = [json.loads(text)["to"] for *_, kind, text, _ in events if kind == "state"]
    return State(states[-1]) if states else None


def _promised(source: Path) -> int:
    try:
        count = CommittedCount(source).read()
    except JournalError:
        return 0
    return 0 if count is None else count[0]
