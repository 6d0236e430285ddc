"""Dwells that were taken back: never edited, only superseded by a later line of the audit trail.

A ``voided`` event names dwells by (step, attempt, epoch) and says who took them back and why. From then on every
reader sees them as rejected, for that reason, and a resume measures their steps again. Where the package was moved,
the event also begins a new mounting: its azimuth and coning angle are its own.
"""

from collections.abc import Iterable

from procedures.records.dwells import DwellRecord, Event

KIND = "voided"
DROPPED = "dropped"
"""A sensor that is measured no more: the others went on without it."""
QUARANTINED = "quarantined"
"""Dwells that were damaged on the disk and left out when the journal was salvaged."""

Key = tuple[int, int, int]
"""(step, attempt, epoch)."""


def key_of(dwell: DwellRecord) -> Key:
    return dwell.step, dwell.attempt, dwell.epoch


def void_detail(
    dwells: Iterable[Key], by: str, reason: str, cause: str, *, is_remounted: bool = False
) -> dict[str, object]:
    """Return what the journal keeps of dwells taken back.

    ``cause``: ``void``, ``redo``, ``salvage`` or what in the run itself took them back.
    """
    return {
        "by": by, "reason": reason, "cause": cause, "remounted": is_remounted, "dwells": [list(key) for key in dwells],
    }  # fmt: skip


def voided_in(events: Iterable[Event]) -> dict[Key, str]:
    """Return every dwell that was taken back, with the sentence for its reasons; the first word stands."""
    found: dict[Key, str] = {}
    for event in events:
        sentence = f"voided{_by(event)}: {event.detail.get('reason', '')}"
        for key in keys_in(event):
            found.setdefault(key, sentence)
    return found


def keys_in(event: Event) -> list[Key]:
    """Return the dwells that a ``voided`` or ``quarantined`` event names."""
    rows = event.detail.get("dwells", [])
    assert isinstance(rows, list)
    return [(int(step), int(attempt), int(epoch)) for step, attempt, epoch in rows]


def _by(event: Event) -> str:
    by = event.detail.get("by")
    return f" by {by}" if by else ""
