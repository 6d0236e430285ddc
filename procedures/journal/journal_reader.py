"""The journal as everybody but the engine sees it: read-only, in short transactions, verified on demand."""

import hashlib
import json
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from procedures.errors import JournalError
from procedures.journal.damage import Damage, DamageSearch, is_whole, key_in, name_of, promise
from procedures.journal.encoding import decode_dwell, decode_event, hash_dwell, is_event_whole
from procedures.journal.header import RunHeader, sha256
from procedures.journal.lost_events import LOST, first_unanswered
from procedures.journal.storage import JOURNAL_FILE, Committed, CommittedCount, open_for_reading, storage_errors_of
from procedures.journal.taken_away import require_not_taken_away
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import QUARANTINED, Key, keys_in, voided_in
from procedures.records.dwells import DwellRecord, Event
from procedures.records.states import State
from rig.description.read import rig_from_json
from rig.description.rig_file import RigDescription
from rig.errors import DescriptionError

if TYPE_CHECKING:
    import apsw

_CHUNK = 256
_EVENTS = "SELECT * FROM events WHERE sequence > ? ORDER BY sequence LIMIT ?"
_EVENTS_OF = "SELECT * FROM events WHERE sequence > ? AND kind = ? ORDER BY sequence LIMIT ?"
_LAST_EVENT = "SELECT * FROM events WHERE ? IS NULL OR kind = ? ORDER BY sequence DESC LIMIT 1"
_DWELLS_WITHOUT_SAMPLES = (
    "SELECT number, CAST(step AS INTEGER), CAST(attempt AS INTEGER), CAST(epoch AS INTEGER), accepted, "
    "CAST(record AS BLOB), NULL, CAST(sha256 AS BLOB) FROM dwells WHERE number > ? ORDER BY number LIMIT ?"
)
"""As bytes: a text that is no text any more hides no other dwell, and is told by the name of its own."""
_DWELLS = _DWELLS_WITHOUT_SAMPLES.replace("NULL", "CAST(samples AS BLOB)")
_EVENT_DIGESTS = (
    "SELECT sequence, kind, CASE kind WHEN 'state' THEN detail END, sha256 FROM events "
    "WHERE sequence > ? ORDER BY sequence LIMIT ?"
)
_DWELL_DIGESTS = "SELECT number, sha256 FROM dwells WHERE number > ? ORDER BY number LIMIT ?"
_LEFT = "it was left as it is"
_SALVAGE = "calrig salvage takes the rest into a new folder, where a resume measures it again"

AFTERTHOUGHTS = ("note", "ack")
"""What people write when the run has ended."""


class JournalReader:
    """A journal open for reading. A context manager; made by :meth:`open`."""

    def __init__(self, path: Path, connection: "apsw.Connection") -> None:
        self.path = path
        self._connection = connection
        row = self._single_row("SELECT document, sha256 FROM header")
        if row is None:
            raise JournalError(f"{self.path}: holds no header; {_LEFT}")
        if sha256(row[0]) != row[1]:
            raise JournalError(f"{self.path}: the header is not as it was written (SHA-256 differs); {_LEFT}")
        self.header = RunHeader.from_json(row[0])

    @staticmethod
    def open(path: Path) -> "JournalReader":
        """Open a journal or the folder of a run. Raises: JournalError naming what is wrong with the file."""
        require_not_taken_away(path.parent if path.name == JOURNAL_FILE else path)
        path = path / JOURNAL_FILE if path.is_dir() else path
        promised = CommittedCount(path).read()
        connection = open_for_reading(path)
        try:
            reader = JournalReader(path, connection)
            reader._require_committed(promised)
        except BaseException:
            connection.close()
            raise
        return reader

    def __enter__(self) -> "JournalReader":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        self._connection.close()

    def events(self, kind: str | None = None, after: int = 0) -> Iterator[Event]:
        """Yield the events in their order, all or those of one kind, ``after`` a sequence number."""
        for row in self._rows(_EVENTS if kind is None else _EVENTS_OF, () if kind is None else (kind,), after):
            yield self._event(row)

    def last_event(self, kind: str | None = None) -> Event | None:
        """Return the newest event, of one kind if given; None where there is none."""
        row = self._single_row(_LAST_EVENT, (kind, kind))
        return None if row is None else self._event(row)

    def _event(self, row: Sequence[Any]) -> Event:
        """Return a stored event. Raises: JournalError where its moment or its text is none."""
        try:
            return decode_event(*row)
        except (ValueError, TypeError):
            sequence, _, _, kind, *_ = row
            raise self._changed_event(sequence, kind) from None

    def _changed_event(self, sequence: int, kind: str) -> JournalError:
        return JournalError(
            f"{self.path}: event {sequence} ({kind}) is not as it was written; {_LEFT}; calrig salvage leaves it out, "
            "by name, and takes the rest into a new folder"
        )

    @cached_property
    def rig(self) -> RigDescription:
        """The rig as it was stored. Raises: DescriptionError where it is of another version."""
        return rig_from_json(self.header.rig_json)

    @cached_property
    def _channel_units(self) -> Mapping[str, str]:
        """Return the units of the channels of the stored rig; of streams only, since a meter's are volts."""
        try:
            return self.rig.channel_units()
        except DescriptionError:
            return {}

    def _units(self) -> Mapping[str, str]:
        return self._channel_units

    def dwells(self, accepted_only: bool = False, with_samples: bool = True) -> Iterator[DwellRecord]:
        """Yield the dwells in the order of commitment, rejected ones too unless ``accepted_only``.

        A dwell that was taken back counts as rejected, and so does one that is not as it was written (noticed only
        ``with_samples``): each says so in its reasons. :meth:`damage` names the damaged ones.
        """
        for _, dwell in self.numbered_dwells(with_samples=with_samples):
            if dwell.accepted or not accepted_only:
                yield dwell

    def numbered_dwells(self, *, with_samples: bool = True) -> Iterator[tuple[int, DwellRecord]]:
        """Yield every dwell as :meth:`dwells` gives it, behind its number: what no other dwell of the journal has."""
        voided = voided_in(self.events(VOIDED))
        for row in self._dwell_rows(with_samples=with_samples):
            dwell = self._as_it_stands(row, voided, with_samples)
            if dwell is not None:
                yield int(row[0]), dwell

    def stored_dwells(self, after: int = 0) -> Iterator[tuple[int, bytes, bytes, str]]:
        """Yield the dwells ``after`` a number, as they are stored: number, text, samples, SHA-256."""
        for number, *_, text, samples, digest in self._dwell_rows(after):
            yield number, text, samples, digest

    def damage(self) -> Damage:
        """Return which events and dwells are not as they were written, or are not there any more; none is fine."""
        search = self.new_search()
        self.read_on(search)
        return search.damage

    def new_search(self) -> DamageSearch:
        """Return a search for damage that has read nothing yet."""
        return DamageSearch(self._single_row("SELECT sha256 FROM header")[0])  # type: ignore[index]

    def read_on(self, search: DamageSearch, at_most: int | None = None) -> None:
        """Take what stands behind what was taken, to the end or so many events and as many dwells.

        Raises: JournalError where a whole event cannot be read.
        """
        # Events first: a run that goes on commits others meanwhile, and every dwell that an event tells of is there.
        for row in islice(self._rows(_EVENTS, (), search.sequence), at_most):
            try:
                search.take_event(row)
            except (ValueError, TypeError):
                raise self._changed_event(int(row[0]), str(row[3])) from None
        for row in islice(self._dwell_rows(search.number), at_most):
            search.take_dwell(row)

    def holds_end_of(self, search: DamageSearch) -> bool:
        """Return whether this is the journal that was searched, as far as header and newest rows tell."""
        event = self._single_row("SELECT sha256 FROM events WHERE sequence = ?", (search.sequence,))
        dwell = self._single_row("SELECT CAST(sha256 AS BLOB) FROM dwells WHERE number = ?", (search.number,))
        return event == (search.event_sha256,) and (
            dwell == (search.dwell_sha256.encode(),) if search.number else dwell is None
        )

    def quarantined(self) -> tuple[str, ...]:
        """Dwells that were left out when the journal was salvaged, by name."""
        return tuple(name_of(key) for event in self.events(QUARANTINED) for key in keys_in(event))

    def state(self) -> State:
        """Return the state as last written.

        Whether its owner still lives is :func:`procedures.journal.status.status.status`'s to say.
        """
        event = self.last_event("state")
        if event is None:
            raise JournalError(f"{self.path}: holds no state; {_LEFT}")
        return State(str(event.detail["to"]))

    def committed_dwells(self) -> int:
        return int(self._single_row("SELECT count(*) FROM dwells")[0])  # type: ignore[index]

    def accepted_steps(self) -> set[int]:
        """Return the steps with an accepted dwell that was not taken back."""
        voided = voided_in(self.events(VOIDED))
        with storage_errors_of(self.path):
            rows = self._connection.execute("SELECT step, attempt, epoch FROM dwells WHERE accepted = 1").fetchall()
        return {key[0] for row in rows if (key := key_in(row)) not in voided}

    def verify(self) -> None:
        """Check the file, the chain of events and the SHA-256 of every dwell. Raises: JournalError naming the first
        dwell or event that is not as it was written.
        """
        deque(self.verified()[1], maxlen=0)

    def verified(self) -> tuple[list[Event], Iterator[DwellRecord]]:
        """Verify the journal as :meth:`verify` does; return its events, and every dwell as :meth:`dwells` gives it.

        What the iterator yields is proven when the last is. Raises: JournalError.
        """
        with storage_errors_of(self.path):
            problems = [row[0] for row in self._connection.execute("PRAGMA quick_check(1)")]
        if problems != ["ok"]:
            raise JournalError(f"{self.path}: is damaged ({problems[0]}); {_LEFT}; restore it from a copy")
        events = self._verify_chain()
        voided = voided_in(event for event in events if event.kind == VOIDED)
        return events, self._verify_dwells(_promised(events), voided)

    def sha256_of_content(self) -> str:
        """Return the SHA-256 of header, events and dwells as they were written, whatever the file around them.

        Notes and acknowledgements behind the last other event change nothing of what was measured.
        """
        return self.contents()[0]

    def contents(self) -> tuple[str, ...]:
        """Return :meth:`sha256_of_content`, and behind it what it was at each end that it grew out of."""
        rows, dwells = list(self._rows(_EVENT_DIGESTS)), [row[-1] for row in self._rows(_DWELL_DIGESTS)]
        ends = [index for index, (_, kind, detail, _) in enumerate(rows) if kind == "state" and _is_finish(detail)]
        if not any(row[1] == VOIDED for row in rows[max(ends, default=0) :]):
            ends = ends[:-1]
        last = len(rows)
        while last and rows[last - 1][1] in AFTERTHOUGHTS:
            last -= 1
        return self._digest([row[-1] for row in rows[:last]], dwells), *(
            self._digest([row[-1] for row in rows[: end + 1]], dwells[: sum(row[1] == "dwell" for row in rows[:end])])
            for end in ends
        )

    def _digest(self, events: Sequence[str], dwells: Sequence[str]) -> str:
        digest = hashlib.sha256(self._single_row("SELECT sha256 FROM header")[0].encode())  # type: ignore[index]
        for event in (*events, *dwells):
            digest.update(event.encode())
        return digest.hexdigest()

    def _require_committed(self, promised: Committed | None) -> None:
        if promised is None:
            return
        if promised.run_id != self.header.run_id:
            raise JournalError(
                f"{self.path}: is the journal of run {self.header.run_id}, and what was committed in this folder was "
                f"of run {promised.run_id}: it was replaced, or journal.count was; put back what belongs together"
            )
        events = int(self._single_row("SELECT count(*) FROM events")[0])  # type: ignore[index]
        held = (events, self.committed_dwells())
        if held[0] < promised.events or held[1] < promised.dwells:
            raise JournalError(
                f"{self.path}: holds {held[1]} dwells and {held[0]} events, but {promised.dwells} and "
                f"{promised.events} were committed; its file {self.path.name}-wal is missing or of another day; put it "
                "back beside the journal"
            )

    def _verify_chain(self) -> list[Event]:
        """Verify the chain of events and return them."""
        previous, events = self._single_row("SELECT sha256 FROM header")[0], []  # type: ignore[index]
        expected = 1
        for row in self._rows(_EVENTS):
            sequence, *_, kind, _, digest = row
            if sequence != expected:
                raise JournalError(f"{self.path}: event {expected} is missing from the audit trail; {_LEFT}")
            if kind != LOST and not is_event_whole(previous, *row):
                raise self._changed_event(sequence, kind)
            events.append(self._event(row))
            previous, expected = digest, expected + 1
        if (gap := first_unanswered(events)) is not None:
            raise self._changed_event(gap.sequence, LOST)
        return events

    def _verify_dwells(self, digests: Mapping[Key, str], voided: Mapping[Key, str]) -> Iterator[DwellRecord]:
        found = 0
        for _, step, attempt, epoch, accepted, text, samples, digest in self._dwell_rows():
            name = f"{self.path}: the dwell of {name_of((step, attempt, epoch))}"
            if hash_dwell(text, samples) != digest or digests.get((step, attempt, epoch)) != digest:
                raise JournalError(f"{name} is not as it was written (SHA-256 differs); {_LEFT}; {_SALVAGE}")
            record = decode_dwell(text, samples, digest, self._units)
            if (record.step, record.attempt, record.epoch, record.accepted) != (step, attempt, epoch, bool(accepted)):
                raise JournalError(f"{name} is filed under another key than its own; {_LEFT}; {_SALVAGE}")
            found += 1
            yield _as_corrected(record, voided.get((step, attempt, epoch)))
        if found != len(digests):
            raise JournalError(f"{self.path}: {len(digests)} dwells were committed, {found} are there; {_LEFT}")

    def _as_it_stands(self, row: tuple[Any, ...], voided: Mapping[Key, str], with_samples: bool) -> DwellRecord | None:
        """Return the dwell of a row; None where it is too damaged to be shown.

        Raises: JournalError where it cannot be read, and its samples are not asked for.
        """
        *_, text, samples, digest = row
        taken_back = voided.get(key_in(row[1:4]))
        if with_samples and not is_whole(row):
            taken_back = "quarantined: it is not as it was written (SHA-256 differs)"
        try:
            dwell = decode_dwell(text, samples, digest, self._units)
        except JournalError as error:
            if with_samples:
                return None
            name = f"{self.path}: the dwell of {name_of(key_in(row[1:4]))}"
            raise JournalError(f"{name} is not as it was written: {error}; {_LEFT}; {_SALVAGE}") from None
        return _as_corrected(dwell, taken_back)

    def _dwell_rows(self, after: int = 0, *, with_samples: bool = True) -> Iterator[tuple[Any, ...]]:
        """Yield number, step, attempt, epoch, accepted, text, samples or None, and SHA-256 of every dwell."""
        for *row, digest in self._rows(_DWELLS if with_samples else _DWELLS_WITHOUT_SAMPLES, (), after):
            yield (*row, digest.decode("ascii", "replace"))

    def _rows(self, query: str, bindings: tuple[object, ...] = (), last: int = 0) -> Iterator[tuple[Any, ...]]:
        """All rows of a query that ends in ``> ? … LIMIT ?`` over its first column, a short transaction a chunk."""
        while True:
            with storage_errors_of(self.path):
                rows = self._connection.execute(query, (last, *bindings, _CHUNK)).fetchall()
            yield from rows
            if len(rows) < _CHUNK:
                return
            last = int(rows[-1][0])  # type: ignore[arg-type]

    def _single_row(self, query: str, bindings: tuple[object, ...] = ()) -> tuple[Any, ...] | None:
        with storage_errors_of(self.path):
            row: tuple[Any, ...] | None = self._connection.execute(query, bindings).fetchone()
            return row


def _promised(events: Iterable[Event]) -> dict[Key, str]:
    """Return the SHA-256 of every dwell that was committed, but for those that a salvage left out."""
    digests: dict[Key, str] = {}
    for event in events:
        promise(digests, event)
    return digests


def _is_finish(detail: str) -> bool:
    return bool(json.loads(detail).get("to") == State.FINISHED)


def _as_corrected(dwell: DwellRecord, taken_back: str | None) -> DwellRecord:
    """Return the dwell, not accepted where it was taken back or is damaged: the sentence that says why."""
    return dwell if taken_back is None else replace(dwell, accepted=False, reasons=(*dwell.reasons, taken_back))
