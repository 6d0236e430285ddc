"""Take out of a damaged journal whatever is provably as it was written, into a new file; the old one stays untouched.

The header must be whole. An event is taken where the chain proves it, a dwell where its SHA-256 is that which a kept
event tells; an event that is lost is marked in its place. What is lost is named in an event, ``quarantined``. What a
damaged event took back, as far as it can be read, is taken back again, and a finished run that has dwells to measure
after that is stopped: a resume on the new file measures them again.
"""

import json
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import apsw

from procedures.errors import JournalError
from procedures.journal.encoding import compact_json, hash_dwell, hash_event
from procedures.journal.header import sha256
from procedures.journal.intact_events import DamagedEvent, RawEvent, StoredEvent, Trail, intact_events
from procedures.journal.lost_events import UNREADABLE, LostEvent
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
from procedures.journal.taken_away import require_not_taken_away
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import QUARANTINED, Key, void_detail
from procedures.records.states import State
from rig.clock import Clock, SystemClock

if TYPE_CHECKING:
    import apsw

_DWELL = "SELECT number, record, CAST(samples AS BLOB), sha256 FROM dwells WHERE number = ?"
_EVENT = (
    "SELECT sequence, CAST(utc AS BLOB), monotonic_s, CAST(kind AS BLOB), CAST(detail AS BLOB), CAST(sha256 AS BLOB) "
    "FROM events WHERE sequence = ?"
)
"""As bytes: what is no text any more still tells the SHA-256 that the event behind it is chained to."""
_MOST_NAMED = 8
_FURTHEST_MISS = 1000
"""Rows that are missing one after the other before a table counts as ended."""


@dataclass(frozen=True)
class Salvaged:
    """What was taken over."""

    path: Path
    events: int
    """That are as they were written."""
    dwells: int
    quarantined: tuple[str, ...]
    """Dwells that were committed and are damaged, or of which no event tells any more, by name."""
    events_promised: int
    """How many the count beside the journal tells of; 0 where there is none."""
    lost: tuple[LostEvent, ...] = ()
    behind: int = 0
    """Events that were committed behind the last one that can be read."""
    taken_back: tuple[str, ...] = ()
    """Dwells that damaged events name as taken back, and that stay out, by name."""


def salvage(source: Path, target: Path, clock: Clock | None = None) -> Salvaged:
    """``source``: a journal or the folder of a run. ``target``: a folder that holds no journal yet, or is made.

    Raises: JournalError where not even the header can be read or a journal is at the target, StorageFailed.
    """
    if not source.exists() or not (source.is_file() or (source / JOURNAL_FILE).exists()):
        require_not_taken_away(source.parent if source.name == JOURNAL_FILE else source)
    source = source / JOURNAL_FILE if source.is_dir() else source
    path = _free_name(target)
    require_journal_file(source)
    with TemporaryDirectory(prefix="calrig-salvage-") as scratch:
        copy = _copied(source, Path(scratch))
        with _opened(copy, source) as rows:
            return _written(rows, source, path, clock or SystemClock(), _promised(source))


def salvage_open(
    connections: Sequence[apsw.Connection],
    header: tuple[str, str],
    source: Path,
    target: Path,
    clock: Clock,
    promised: int,
) -> Salvaged:
    """Salvage what open connections still give of a journal, whatever became of ``source``; the first that has a row
    gives it.

    ``header``: document and SHA-256. ``promised``: events that were committed. Raises: as :func:`salvage`.
    """
    return _written(_Rows(connections, source, header), source, _free_name(target), clock, promised)


def _free_name(target: Path) -> Path:
    path = target / JOURNAL_FILE
    if path.exists():
        raise JournalError(f"{path}: exists already; nothing was written; give a folder without a journal")
    return path


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

    def __init__(
        self, connections: Sequence[apsw.Connection], source: Path, header: tuple[str, str] | None = None
    ) -> None:
        """``header``: document and SHA-256, where they are known."""
        self._connections = connections
        self._source = source
        header = header or self._row("SELECT document, sha256 FROM header WHERE id = ?", 1)
        if header is None or sha256(header[0]) != header[1]:
            raise JournalError(
                f"{source}: the header is lost, so nothing can be salvaged; restore the file from a copy"
            )
        self.header: tuple[str, str] = (header[0], header[1])

    def __enter__(self) -> "_Rows":
        return self

    def __exit__(self, *_: object) -> None:
        for connection in self._connections:
            connection.close()

    def events(self) -> dict[int, RawEvent]:
        """Return every event that can be read, by its number, whatever lies between."""
        return {row[0]: RawEvent(*row) for row in self._every(_EVENT)}

    def dwells(self) -> Iterator[tuple[Any, ...]]:
        """Yield number, record, samples and SHA-256 of every dwell that can be read."""
        yield from self._every(_DWELL)

    def _every(self, query: str) -> Iterator[tuple[Any, ...]]:
        number, missed = 1, 0
        while missed < _FURTHEST_MISS:
            row = self._row(query, number)
            missed = 0 if row is not None else missed + 1
            if row is not None:
                yield row
            number += 1

    def _row(self, query: str, key: int) -> tuple[Any, ...] | None:
        for connection in self._connections:
            with suppress(apsw.CorruptError, apsw.IOError, apsw.SQLError, apsw.FormatError, UnicodeDecodeError):
                row: tuple[Any, ...] | None = connection.execute(query, (key,)).fetchone()
                if row is not None:
                    return row
        return None


def _opened(copy: Path, source: Path) -> _Rows:
    with storage_errors_of(source):
        connection = apsw.Connection(str(copy), flags=apsw.SQLITE_OPEN_READWRITE)
        try:
            require_our_schema(source, connection)
            return _Rows([connection], source)
        except BaseException:
            connection.close()
            raise


def _written(rows: _Rows, source: Path, path: Path, clock: Clock, promised: int) -> Salvaged:
    document = json.loads(rows.header[0])
    trail = intact_events(rows.events(), rows.header[1], str(document["created_utc"]))
    digests = _kept_digests(trail.intact)
    whole, untold = _sorted_dwells(rows.dwells(), digests)
    lost = sorted((digests.keys() - whole.keys()) | untold)
    events = _Appended(trail.rows, rows.header[1], clock)
    events.add(QUARANTINED, _quarantined_detail(lost, trail, source, promised))
    taken_back = _taken_back_again(trail, whole, events)
    may_lack_dwells = lost or _is_void_last(events.rows) or any(map(_may_be_of_a_dwell, trail.damaged))
    if may_lack_dwells and _state(events.rows) is State.FINISHED:
        reason = "salvage left dwells to measure"
        events.add("state", {"from": State.FINISHED, "to": State.STOPPED, "by": "", "reason": reason})
    path.parent.mkdir(parents=True, exist_ok=True)
    new_file = path.with_name(path.name + ".new")
    new_file.unlink(missing_ok=True)
    connection = make_file(new_file)
    with storage_errors_of(new_file):
        connection.execute("BEGIN IMMEDIATE")
        connection.execute(SCHEMA)
        connection.execute("INSERT INTO header VALUES (1, ?, ?)", rows.header)
        connection.executemany("INSERT INTO events VALUES (?, ?, ?, ?, ?, ?)", events.rows)
        connection.executemany("INSERT INTO dwells VALUES (?, ?, ?, ?, ?, ?, ?, ?)", _numbered(whole))
        connection.execute("COMMIT")
    fold(new_file, connection)
    put_under_name(new_file, path)
    CommittedCount(path).write(str(document["run_id"]), len(events.rows), len(whole))
    return Salvaged(
        path,
        len(trail.intact),
        len(whole),
        _names(lost),
        promised,
        tuple(event.lost for event in trail.damaged),
        max(0, promised - len(trail.rows)),
        _names(taken_back),
    )


class _Appended:
    """The audit trail of the new journal, with what the salvage itself says behind it."""

    def __init__(self, rows: Iterable[StoredEvent], header_sha256: str, clock: Clock) -> None:
        self.rows = list(rows)
        self._header_sha256 = header_sha256
        self._clock = clock

    def add(self, kind: str, detail: Mapping[str, object]) -> None:
        previous = self.rows[-1].sha256 if self.rows else self._header_sha256
        utc, monotonic_s, text = self._clock.now_utc().isoformat(), self._clock.monotonic_s(), compact_json(detail)
        sequence = len(self.rows) + 1
        digest = hash_event(previous, sequence, utc, monotonic_s, kind, text)
        self.rows.append(StoredEvent(sequence, utc, monotonic_s, kind, text, digest))


def _quarantined_detail(lost: Sequence[Key], trail: Trail, source: Path, promised: int) -> dict[str, object]:
    """Return what the new journal keeps of what was lost; ``promised``: by the count beside the old one."""
    return {
        "dwells": [list(key) for key in lost],
        "events_lost": [[event.lost.sequence, event.lost.kind] for event in trail.damaged],
        "from": str(source),
        "events_kept": len(trail.rows) - len(trail.damaged),
        "events_promised": promised,
        "reason": _what_is_lost(trail, len(lost), max(0, promised - len(trail.rows))),
    }


def _what_is_lost(trail: Trail, dwells: int, behind: int) -> str:
    """Return what a reader of the audit trail is told; empty of a journal that was whole."""
    named = ", ".join(str(event.lost) for event in trail.damaged[:_MOST_NAMED])
    more = len(trail.damaged) - _MOST_NAMED
    parts = [
        *([f"event {named}{f' and {more} more' if more > 0 else ''}"] if named else []),
        *([f"{behind} events behind the last that can be read"] if behind else []),
        *([f"{dwells} {'dwell' if dwells == 1 else 'dwells'}"] if dwells else []),
    ]
    return f"salvaged from a damaged journal, without {'; '.join(parts)}" if parts else ""


def _taken_back_again(trail: Trail, whole: Mapping[Key, tuple[Any, ...]], events: _Appended) -> list[Key]:
    """Take back what damaged events name: whatever byte of such a line was changed, its dwells were taken back."""
    found: list[Key] = []
    for event in trail.damaged:
        keys = [key for key in event.took_back if key in whole]
        if not keys:
            continue
        reason = f"event {event.lost} is damaged, and names them as taken back as far as it can be read"
        detail = void_detail(keys, "calrig salvage", reason, "salvage", is_remounted=event.is_remounted)
        events.add(VOIDED, detail)
        found += keys
    return found


def _kept_digests(events: Iterable[StoredEvent]) -> dict[Key, str]:
    """Return the SHA-256 of every dwell that the kept events tell of, but for those quarantined before."""
    digests: dict[Key, str] = {}
    for event in events:
        if event.kind not in ("dwell", QUARANTINED):
            continue
        detail = json.loads(event.detail)
        if event.kind == "dwell":
            digests[(detail["step"], detail["attempt"], detail["epoch"])] = detail["sha256"]
            continue
        for key in detail["dwells"]:
            digests.pop((key[0], key[1], key[2]), None)
    return digests


def _sorted_dwells(
    rows: Iterable[tuple[Any, ...]], digests: Mapping[Key, str]
) -> tuple[dict[Key, tuple[Any, ...]], set[Key]]:
    """Return the dwells that the events prove, as rows without their number, and the keys of those without an event.

    Key and acceptance are those of the record, which its SHA-256 covers; the columns beside it can be damaged alone.
    """
    whole: dict[Key, tuple[Any, ...]] = {}
    untold: set[Key] = set()
    for _, text, samples, stored in rows:
        digest = hash_dwell(text, samples) if isinstance(text, str | bytes) else ""
        if digest != stored and digest not in digests.values():
            continue
        document = json.loads(text)
        key = document["step"], document["attempt"], document["epoch"]
        if digests.get(key) == digest:
            whole[key] = (*key, int(document["accepted"]), text, samples, digest)
        elif key not in digests:
            untold.add(key)
    return whole, untold


def _numbered(whole: Mapping[Key, tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
    for number, row in enumerate(whole.values(), start=1):
        yield (number, *row)


def _names(keys: Iterable[Key]) -> tuple[str, ...]:
    return tuple(f"step {step}, attempt {attempt}, epoch {epoch}" for step, attempt, epoch in keys)


def _may_be_of_a_dwell(event: DamagedEvent) -> bool:
    """Return whether a dwell can be lost with an event that nobody can name."""
    return event.lost.kind in ("dwell", UNREADABLE)


def _is_void_last(events: Sequence[StoredEvent]) -> bool:
    """Return whether dwells were taken back behind the last state: what stopped the run for it is lost."""
    last = next((event.kind for event in reversed(events) if event.kind in ("state", VOIDED)), "")
    return last == VOIDED


def _state(events: Sequence[StoredEvent]) -> State | None:
    last = next((event.detail for event in reversed(events) if event.kind == "state"), None)
    return None if last is None else State(json.loads(last)["to"])


def _promised(source: Path) -> int:
    try:
        count = CommittedCount(source).read()
    except JournalError:
        return 0
    return 0 if count is None else count.events
