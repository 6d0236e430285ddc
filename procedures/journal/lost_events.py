"""Events that a damaged journal lost: each keeps its place in the audit trail, marked, and the chain goes on over it.

A salvage puts a ``lost`` event where the damaged one stood, with the SHA-256 that was stored of it: what stands behind
was chained to that. The ``quarantined`` event, which the salvage adds and which is chained itself, names every one, so
that no damage passes for a gap that somebody has answered for.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from procedures.journal.voids import QUARANTINED, Key, keys_in
from procedures.records.dwells import Event

LOST = "lost"
"""Kind of the event that stands where a damaged one stood."""
UNREADABLE = "unreadable"
"""In the place of a kind that nobody can tell any more."""


@dataclass(frozen=True, order=True)
class LostEvent:
    """An event that was committed and is not as it was written."""

    sequence: int
    kind: str
    """As far as it can be read; :data:`UNREADABLE` otherwise."""

    def __str__(self) -> str:
        return f"{self.sequence} ({self.kind})"


@dataclass(frozen=True)
class Losses:
    """What salvages left out of a journal, all told."""

    events: tuple[LostEvent, ...]
    behind: int
    """Events that were committed behind the last one that can be read."""
    dwells: tuple[Key, ...]

    @property
    def has_events(self) -> bool:
        return bool(self.events) or self.behind > 0


def losses_in(events: Iterable[Event]) -> Losses:
    """Return what the salvages of a journal left out, as its events tell."""
    lost: list[LostEvent] = []
    dwells: list[Key] = []
    behind = 0
    for event in events:
        if event.kind != QUARANTINED:
            continue
        named = named_in(event)
        lost += named
        dwells += keys_in(event)
        # Journals that were salvaged by an earlier version name no events: everything behind the first was left out.
        promised, kept = (int(str(event.detail.get(key, 0))) for key in ("events_promised", "events_kept"))
        behind += max(0, promised - kept - len(named))
    return Losses(tuple(lost), behind, tuple(dwells))


def named_in(event: Event) -> list[LostEvent]:
    """Return the events that a ``quarantined`` one names."""
    rows = event.detail.get("events_lost", [])
    assert isinstance(rows, list)
    return [LostEvent(int(sequence), str(kind)) for sequence, kind in rows]


def lost_detail(lost: LostEvent) -> dict[str, object]:
    """Return what the event says that stands in the place of a lost one."""
    return {"kind": lost.kind, "text": f"event {lost} was damaged and left out when the journal was salvaged"}


def first_unanswered(events: Sequence[Event]) -> Event | None:
    """Return the first ``lost`` event that no salvage names as it stands; None where each is named."""
    named = {lost for event in events if event.kind == QUARANTINED for lost in named_in(event)}
    for event in events:
        if event.kind == LOST and LostEvent(event.sequence, str(event.detail.get("kind"))) not in named:
            return event
    return None
