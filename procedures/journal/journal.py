"""The journal's writer: the engine's, and nobody else's.

Everything is committed whole or not at all. A dwell and the event that tells of it are one transaction; a dwell that
is committed twice (the process died before it learned of the first) is stored once.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import apsw

from procedures.errors import JournalError, JournalReplaced, StorageFailed
from procedures.journal.encoding import compact_json, encode_dwell, hash_dwell, hash_event, with_sha256
from procedures.journal.header import RunHeader, sha256
from procedures.journal.held_files import HeldFiles
from procedures.journal.journal_reader import JournalReader
from procedures.journal.kept_rows import KeptRows, Row
from procedures.journal.salvage import Salvaged, salvage_open
from procedures.journal.storage import (
    SCHEMA,
    CommittedCount,
    checkpoint_and_close,
    fold,
    header_row,
    make_file,
    open_for_writing,
    put_under_name,
    require_journal_file,
    require_our_schema,
    storage_errors_of,
)
from procedures.journal.taken_away import require_not_taken_away
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from rig.clock import Clock
from rig.crash_points import CrashPoint, crash_point


class Journal:
    """An open journal that can be appended to. Made by :meth:`create` or :meth:`open_for_append`."""

    def __init__(
        self,
        path: Path,
        connection: apsw.Connection,
        run_id: str,
        chain: tuple[int, str],
        dwells: int,
        state_sequence: int,
        header: tuple[str, str],
        kept: KeptRows,
    ) -> None:
        """``header``: document and SHA-256. ``kept``: the rows of the journal as it was opened."""
        self.path = path
        self._connection = connection
        self._header_row = header
        self._kept = kept
        self._new_events: list[Row] = []
        self._new_dwells: list[Row] = []
        """Of the transaction that is open, or was committed last."""
        self._run_id = run_id
        self._last_sequence, self._last_sha256 = chain
        self._dwells = dwells
        self.state_sequence = state_sequence
        """Of the newest event of a state: what a request that was made in view of that state refers to."""
        self._count = CommittedCount(path)
        self._files = HeldFiles(path)
        self._is_written_by_others = False

    @staticmethod
    def create(path: Path, header: RunHeader, clock: Clock) -> "Journal":
        """Create a journal in state ``planned``, first under another name: where there is a journal, it is whole.

        Raises: JournalError where there is a file, StorageFailed.
        """
        if path.exists():
            raise JournalError(
                f"{path}: exists already; a run never writes into another's journal; nothing was written"
            )
        document = header.to_json()
        new_file = path.with_name(path.name + ".new")
        new_file.unlink(missing_ok=True)
        row = document, sha256(document)
        begun = Journal(new_file, make_file(new_file), header.run_id, (0, row[1]), 0, 0, row, KeptRows())
        with begun._transaction():
            begun._connection.execute(SCHEMA)
            begun._connection.execute("INSERT INTO header VALUES (1, ?, ?)", row)
            chain = begun._insert_event("state", {"to": State.PLANNED, "by": header.operator, "reason": ""}, clock)
        fold(new_file, begun._connection)
        put_under_name(new_file, path)
        begun._kept.close()
        connection = open_for_writing(path)
        kept = KeptRows.of(path, connection)
        journal = Journal(path, connection, header.run_id, chain, 0, chain[0], row, kept)
        journal._committed(chain, 0)
        return journal

    @staticmethod
    def open_for_append(path: Path) -> "Journal":
        """Open an existing journal, after all of it was verified. Raises: JournalError, StorageFailed."""
        require_not_taken_away(path.parent)
        require_journal_file(path)
        with JournalReader.open(path) as reader:
            reader.verify()
            header, last, state = reader.header, reader.last_event(), reader.last_event("state")
            dwells = reader.committed_dwells()
        connection = open_for_writing(path)
        require_our_schema(path, connection)
        row, kept = header_row(path, connection), KeptRows.of(path, connection)
        assert last is not None
        entered = 0 if state is None else state.sequence
        return Journal(path, connection, header.run_id, (last.sequence, last.sha256), dwells, entered, row, kept)

    def has_dwell(self, record: DwellRecord) -> bool:
        """Return whether a dwell stands under the (step, attempt, epoch) of this one. Raises: StorageFailed."""
        key = (record.step, record.attempt, record.epoch)
        return self._kept.has_dwell(key) or self._stored_sha256(key) is not None

    def salvage_into(self, target: Path, clock: Clock) -> Salvaged:
        """Take what was committed into a new journal in ``target``, whatever stands under the names of this one: out of
        the rows that were kept, and out of the open files.

        Raises: as :func:`procedures.journal.salvage.salvage`.
        """
        sources = *self._kept.connections, self._connection
        return salvage_open(sources, self._header_row, self.path, target, clock, self._last_sequence)

    def is_lost_with_process(self) -> bool:
        """Return whether the open files have no name any more: who ends this process ends what is in them."""
        return self._files.are_removed()

    def require_as_written(self) -> None:
        """Refuse to write behind another hand, unless the journal, read afresh, is whole and ends as it was left.

        Raises: JournalReplaced, StorageFailed.
        """
        if self._files.is_as_written():
            return
        if not self._reads_as_left():
            self._is_written_by_others = True
            raise JournalReplaced(
                f"{self.path}: another program wrote to it or to its log while it was written: as it stands now it "
                "is no whole journal that ends with what was written last"
            )
        self._files.remember()

    def append_event(self, kind: str, detail: Mapping[str, object], clock: Clock) -> None:
        """Append one line of the audit trail, on the disk when this returns. Raises: StorageFailed."""
        with self._transaction():
            chain = self._insert_event(kind, detail, clock)
        self._committed(chain, self._dwells)
        if kind == "state":
            self.state_sequence = chain[0]

    def commit_dwell(self, record: DwellRecord, clock: Clock) -> DwellRecord:
        """Store a judged dwell with its event; returns it with its SHA-256.

        Raises: JournalError where another dwell stands under the same (step, attempt, epoch), StorageFailed.
        """
        text, samples = encode_dwell(record)
        stored = with_sha256(record, hash_dwell(text, samples))
        key = (stored.step, stored.attempt, stored.epoch)
        found = self._stored_sha256(key)
        # A commit whose acknowledgement was lost is made again: the same content is no error, other content is.
        if found is not None and found != stored.sha256:
            raise JournalError(
                f"{self.path}: step {key[0]}, attempt {key[1]}, epoch {key[2]} is stored already, with other content; "
                "a stored dwell is never changed; nothing was written"
            )
        if found is not None:
            return stored
        row = (record.step, record.attempt, record.epoch, int(record.accepted), text, samples, stored.sha256)
        # One transaction: a dwell without its event, or the event without its dwell, would pass for a change by hand.
        with self._transaction():
            numbered = (self._dwells + 1, *row)
            self._connection.execute("INSERT INTO dwells VALUES (?, ?, ?, ?, ?, ?, ?, ?)", numbered)
            self._new_dwells.append(numbered)
            chain = self._insert_event("dwell", _dwell_detail(stored), clock)
        self._committed(chain, self._dwells + 1)
        return stored

    def close(self) -> None:
        """Fold the write-ahead log into the file, so that nothing stands beside it unless a reader is looking."""
        # A reader must not keep the end of the run: the log then stays beside the file and is read with it.
        self._kept.close()
        self._connection.set_busy_timeout(0)
        crash_point(CrashPoint.BEFORE_CHECKPOINT)
        if self._is_written_by_others:  # damaged files are left as they are
            self._connection.config(apsw.SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1)
            self._connection.close()
            return
        try:
            checkpoint_and_close(self._connection)
        except (apsw.IOError, apsw.FullError) as error:
            raise JournalError(f"{self.path}: cannot be closed: {error}; all that was committed is in it") from error

    def _stored_sha256(self, key: tuple[int, int, int]) -> str | None:
        with storage_errors_of(self.path):
            found = self._connection.execute(
                "SELECT sha256 FROM dwells WHERE step = ? AND attempt = ? AND epoch = ?", key
            ).fetchone()
        return None if found is None else str(found[0])

    def _insert_event(self, kind: str, detail: Mapping[str, object], clock: Clock) -> tuple[int, str]:
        sequence, text = self._last_sequence + 1, compact_json(dict(detail))
        utc, monotonic_s = clock.now_utc().isoformat(), clock.monotonic_s()
        digest = hash_event(self._last_sha256, sequence, utc, monotonic_s, kind, text)
        row = (sequence, utc, monotonic_s, kind, text, digest)
        self._connection.execute("INSERT INTO events VALUES (?, ?, ?, ?, ?, ?)", row)
        self._new_events.append(row)
        return sequence, digest

    def _committed(self, chain: tuple[int, str], dwells: int) -> None:
        self._last_sequence, self._last_sha256 = chain
        self._dwells = dwells
        self._kept.add(self._new_events, self._new_dwells)
        self._files.remember()
        self._count.write(self._run_id, self._last_sequence, self._dwells)

    def _reads_as_left(self) -> bool:
        try:
            with JournalReader.open(self.path) as reader:
                reader.verify()
                last = reader.last_event()
        except (JournalError, StorageFailed):
            return False
        return last is not None and (last.sequence, last.sha256) == (self._last_sequence, self._last_sha256)

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self.require_as_written()
        self._new_events, self._new_dwells = [], []
        with storage_errors_of(self.path):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
                crash_point(CrashPoint.BEFORE_COMMIT)
                self._connection.execute("COMMIT")
                crash_point(CrashPoint.AFTER_COMMIT)
            finally:
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")


def _dwell_detail(record: DwellRecord) -> dict[str, object]:
    return {
        "step": record.step,
        "attempt": record.attempt,
        "epoch": record.epoch,
        "accepted": record.accepted,
        "reasons": list(record.reasons),
        "sha256": record.sha256,
    }
