"""What of a journal is not as it was written: found row by row, so that what grows is read on from where it was left.

The chain of events and the SHA-256 of every dwell are walked to their end, over what is damaged. Whoever keeps the
search keeps what was found, and reads later only what was committed since.
"""

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

from procedures.journal.encoding import decode_event, hash_dwell, is_event_whole
from procedures.journal.lost_events import LOST, first_unanswered
from procedures.journal.voids import QUARANTINED, Key, keys_in
from procedures.records.dwells import Event

_TELLING = ("dwell", QUARANTINED, LOST)
"""Kinds of events by which dwells or events are to be there, or not to be."""


class Damage(NamedTuple):
    """What of a journal is not as it was written, by name."""

    events: tuple[str, ...]
    dwells: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return (*self.events, *self.dwells)

    @property
    def in_words(self) -> tuple[str, ...]:
        """Each as a phrase that a sentence goes on with."""
        return (*self.events, *(f"the dwell of {name}" for name in self.dwells))


class DamageSearch:
    """What was found of a journal so far, and where to read on."""

    def __init__(self, header_sha256: str) -> None:
        self.sequence = 0
        """Of the newest event that was taken."""
        self.number = 0
        """Of the newest dwell that was taken."""
        self.event_sha256 = header_sha256
        """As it is stored of the newest event: what the next is chained to."""
        self.dwell_sha256 = ""
        """As it is stored of the newest dwell."""
        self._changed: list[str] = []
        self._salvages: list[Event] = []
        self._promised: dict[Key, str] = {}
        self._found: dict[Key, str | None] = {}
        """The SHA-256 of every dwell that is there; None where it is not as it was written."""

    def take_event(self, row: Sequence[Any]) -> None:
        """Take the next event as it is stored. Raises: ValueError, TypeError where one that is whole is no event."""
        sequence, *_, kind, _, digest = row
        expected = self.sequence + 1
        self._changed += [f"event {missing} (missing)" for missing in range(expected, sequence)]
        if sequence == expected and kind != LOST and not is_event_whole(self.event_sha256, *row):
            self._changed.append(f"event {sequence} ({kind})")
        elif kind in _TELLING:
            event = decode_event(*row)
            promise(self._promised, event)
            if kind != "dwell":
                self._salvages.append(event)
        self.sequence, self.event_sha256 = sequence, digest

    def take_dwell(self, row: Sequence[Any]) -> None:
        """Take the next dwell: number, step, attempt, epoch, accepted, text, samples and SHA-256 as they are stored."""
        self.number, self.dwell_sha256 = int(row[0]), row[-1]
        self._found[key_in(row[1:4])] = row[-1] if _is_as_filed(row) else None

    def has_reached(self, other: "DamageSearch") -> bool:
        """Return whether this one has read as far as another."""
        return self.sequence >= other.sequence and self.number >= other.number

    @property
    def damage(self) -> Damage:
        """Of a journal that was read to its end: what is missing, too."""
        events, dwells = self.changed
        unanswered = first_unanswered(self._salvages)
        lost = () if unanswered is None else (f"event {unanswered.sequence} ({LOST})",)
        gone = sorted(self._promised.keys() - self._found.keys())
        return Damage((*events, *lost), (*dwells, *map(name_of, gone)))

    @property
    def changed(self) -> Damage:
        """Of what was read, however far: what is missed may come yet, and so may what answers for a lost event."""
        promised = self._promised
        dwells = (key for key, digest in self._found.items() if digest is None or digest != promised.get(key, digest))
        return Damage(tuple(self._changed), tuple(map(name_of, dwells)))


def promise(digests: dict[Key, str], event: Event) -> None:
    """Take from an event the SHA-256 of the dwell that it tells of, or leave out what a salvage left out."""
    if event.kind == "dwell":
        dwell = event.detail
        digests[key_in((dwell["step"], dwell["attempt"], dwell["epoch"]))] = str(dwell["sha256"])
    for key in keys_in(event) if event.kind == QUARANTINED else ():
        digests.pop(key, None)


def key_in(parts: Sequence[object]) -> Key:
    """Return (step, attempt, epoch) as they are stored. Raises: ValueError where one is no number."""
    step, attempt, epoch = (int(str(part)) for part in parts)
    return step, attempt, epoch


def name_of(key: Key) -> str:
    """Return how a dwell is named to people."""
    step, attempt, epoch = key
    return f"step {step}, attempt {attempt}, epoch {epoch}"


def is_whole(row: Sequence[Any]) -> bool:
    """Return whether text and samples of a stored dwell are those that its SHA-256 was taken of."""
    *_, text, samples, digest = row
    return bool(hash_dwell(text, samples) == digest)


def _is_as_filed(row: Sequence[Any]) -> bool:
    """Return whether a dwell is whole and stands under its key and acceptance: its SHA-256 covers neither column."""
    _, step, attempt, epoch, accepted, text, *_ = row
    if not is_whole(row):
        return False
    record = json.loads(text)
    filed = (record["step"], record["attempt"], record["epoch"], record["accepted"])
    return bool(filed == (step, attempt, epoch, bool(accepted)))
