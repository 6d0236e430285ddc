"""Which stored events are provably as they were written, where some are not: found from the chain alone.

An event's SHA-256 covers the one that is stored of the event before it. So an event whose own agrees proves, beside
itself, what was stored before it; one damaged event takes no other with it. Where the row before is gone altogether,
nothing tells what an event was chained to, and it is lost as well.
"""

import re
from collections.abc import Mapping
from typing import NamedTuple

from procedures.journal.encoding import compact_json, hash_event
from procedures.journal.lost_events import LOST, UNREADABLE, LostEvent, lost_detail
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import Key

_KIND = re.compile(r"[a-z_]{3,24}")
_KEY = re.compile(r"\[(\d{1,9}),(\d{1,9}),(\d{1,9})\]")


class StoredEvent(NamedTuple):
    """A row of the audit trail, column by column, as text where it is one."""

    sequence: int
    utc: str
    monotonic_s: float
    kind: str
    detail: str
    sha256: str


class RawEvent(NamedTuple):
    """A row as its bytes; what is damaged need be no text any more."""

    sequence: int
    utc: bytes
    monotonic_s: object
    kind: bytes
    detail: bytes
    sha256: bytes


class DamagedEvent(NamedTuple):
    """A row that is not as it was written, as far as it can be read."""

    lost: LostEvent
    detail: str

    @property
    def took_back(self) -> tuple[Key, ...]:
        """The dwells that it names where it took some back, whichever byte of it was changed."""
        if self.lost.kind != VOIDED and '"remounted":' not in self.detail:
            return ()
        return tuple((int(step), int(attempt), int(epoch)) for step, attempt, epoch in _KEY.findall(self.detail))

    @property
    def is_remounted(self) -> bool:
        return bool(self.took_back) and '"remounted":true' in self.detail


class Trail(NamedTuple):
    """The audit trail with every lost event marked in its place."""

    rows: tuple[StoredEvent, ...]
    damaged: tuple[DamagedEvent, ...]

    @property
    def intact(self) -> tuple[StoredEvent, ...]:
        """The events that are as they were written; what an earlier salvage marked is none of them."""
        lost = {event.lost.sequence for event in self.damaged}
        return tuple(row for row in self.rows if row.sequence not in lost and row.kind != LOST)


def intact_events(raw: Mapping[int, RawEvent], header_sha256: str, began_utc: str) -> Trail:
    """Return the trail up to the last row that can be read. ``raw``: by sequence number, gaps where nothing is read.

    ``header_sha256``: what the first event is chained to. ``began_utc``: of a lost one before any other.
    """
    rows: list[StoredEvent] = []
    damaged: list[DamagedEvent] = []
    previous, utc, monotonic_s = header_sha256, began_utc, 0.0
    for sequence in range(1, max(raw, default=0) + 1):
        row = _proved(raw, sequence, previous)
        if row is None:
            event = _as_read(raw.get(sequence), sequence)
            row = StoredEvent(
                sequence, utc, monotonic_s, LOST, compact_json(lost_detail(event.lost)), _digest(raw.get(sequence))
            )
            damaged.append(event)
        rows.append(row)
        previous, utc, monotonic_s = row.sha256, row.utc, row.monotonic_s
    return Trail(tuple(rows), tuple(damaged))


def _proved(raw: Mapping[int, RawEvent], sequence: int, previous: str) -> StoredEvent | None:
    """Return an event that its own SHA-256 proves, or the one of the event behind it where its own was damaged."""
    found = _text(raw.get(sequence))
    if found is None:
        return None
    is_marked = found.kind == LOST and found.detail == compact_json(lost_detail(_named(found)))
    digest = found.sha256 if is_marked else _hash(previous, found)
    if digest == found.sha256:
        return found
    behind = _text(raw.get(sequence + 1))
    if digest is not None and behind is not None and _hash(digest, behind) == behind.sha256:
        return found._replace(sha256=digest)
    return None


def _named(marked: StoredEvent) -> LostEvent:
    """Return the event that a ``lost`` one of an earlier salvage stands for."""
    kind = re.match(r'\{"kind":"([a-z_]+)"', marked.detail)
    return LostEvent(marked.sequence, kind[1] if kind else UNREADABLE)


def _hash(previous: str, event: StoredEvent) -> str | None:
    try:
        return hash_event(previous, *event[:5])
    except (TypeError, ValueError):
        return None


def _text(row: RawEvent | None) -> StoredEvent | None:
    if row is None or not isinstance(row.monotonic_s, float | int):
        return None
    try:
        utc, kind, detail = (part.decode("utf-8") for part in (row.utc, row.kind, row.detail))
    except UnicodeDecodeError:
        return None
    return StoredEvent(row.sequence, utc, row.monotonic_s, kind, detail, _digest(row))


def _digest(row: RawEvent | None) -> str:
    return "" if row is None else row.sha256.decode("ascii", "replace")


def _as_read(row: RawEvent | None, sequence: int) -> DamagedEvent:
    if row is None:
        return DamagedEvent(LostEvent(sequence, UNREADABLE), "")
    kind = row.kind.decode("utf-8", "replace")
    return DamagedEvent(
        LostEvent(sequence, kind if _KIND.fullmatch(kind) else UNREADABLE), row.detail.decode("utf-8", "replace")
    )
