"""What is new in the journal of a run, read as it grows: the one way in which screens and status look at a run.

Everything that a state, a count or an end needs is kept from one look to the next, so that a look costs what has
happened since, not what the run is long. The bell is ``journal.count``, which is written after every commit: where its
time of modification has not changed, nothing is read.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procedures.errors import JournalError
from procedures.journal.encoding import FLOAT, channels_of, decode_dwell
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.status.course import Course
from procedures.journal.status.standing import RunStatus
from procedures.journal.storage import JOURNAL_FILE, CommittedCount
from procedures.journal.taken_away import require_not_taken_away
from procedures.journal.time_stamps import SETTLED_NS
from procedures.records.dwells import DwellRecord, Event
from rig.clock import Clock, SystemClock


@dataclass(frozen=True, slots=True)
class FollowedDwell:
    """A dwell with what its samples come to, and without them."""

    record: DwellRecord
    """Its readings are left out. Accepted as it was committed; a later event may take it back."""
    mean: Mapping[str, float]
    """Channel to the mean of its samples, in the channel's unit; not a number where one was overloaded."""
    standard_deviation: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class News:
    """What happened since the look before, and where the run stands now."""

    events: tuple[Event, ...]
    dwells: tuple[FollowedDwell, ...]
    status: RunStatus
    sequence: int
    """Of the newest event: what a request that was made after seeing it refers to."""
    is_alive: bool
    """A living process runs the run."""


class Follower:
    """Follows one run; :meth:`poll` is cheap where nothing happened."""

    def __init__(self, run_dir: Path, *, with_dwells: bool = True, clock: Clock | None = None) -> None:
        self._run_dir = run_dir
        self._with_dwells = with_dwells
        self._clock = clock or SystemClock()
        self._count = CommittedCount(run_dir / JOURNAL_FILE).path
        self._rung_ns = -1
        self._number = 0
        self._opened: tuple[JournalReader, Course] | None = None

    def poll(self) -> News:
        """Return what is new. Raises: JournalError."""
        require_not_taken_away(self._run_dir)
        is_alive = is_owned(self._run_dir)  # asked first: what a dying owner wrote last is then read below
        events: tuple[Event, ...] = ()
        dwells: tuple[FollowedDwell, ...] = ()
        is_first = self._opened is None
        reader, course = self._opened = self._opened or self._open()
        if self._has_rung() or is_first:
            events = tuple(reader.events(after=course.sequence))
            if self._with_dwells:
                dwells = tuple(self._followed(reader))
            for event in events:
                course.take(event)
        return News(events, dwells, course.status(is_alive=is_alive), course.sequence, is_alive)

    def close(self) -> None:
        if self._opened is not None:
            self._opened[0].close()

    def _open(self) -> tuple[JournalReader, Course]:
        reader = JournalReader.open(self._run_dir)
        try:
            return reader, Course(self._run_dir, reader.header)
        except BaseException:
            reader.close()
            raise

    def _has_rung(self) -> bool:
        try:
            now_ns = os.stat(self._count).st_mtime_ns
        except FileNotFoundError:
            return True  # a journal of which only the one file is left is read whole every time
        if now_ns == self._rung_ns:
            return False
        age_ns = self._clock.now_utc().timestamp() * 1e9 - now_ns
        self._rung_ns = now_ns if age_ns > SETTLED_NS else -1
        return True

    def _followed(self, reader: JournalReader) -> list[FollowedDwell]:
        found = []
        for number, text, samples, digest in reader.stored_dwells(after=self._number):
            try:
                record = decode_dwell(text, None, digest)
            except JournalError as error:
                raise JournalError(
                    f"{reader.path}: {error}; it was left as it is; calrig status names what is damaged"
                ) from None
            mean, deviation = _figures(channels_of(text), samples)
            found.append(FollowedDwell(record, mean, deviation))
            self._number = number
        return found


def _figures(channels: list[tuple[str, int]], samples: bytes) -> tuple[dict[str, float], dict[str, float]]:
    values_v, first = np.frombuffer(samples, dtype=FLOAT), 0
    mean, deviation = {}, {}
    for channel, count in channels:
        part = values_v[first : first + count]
        first += count
        mean[channel] = float(part.sum() / count) if count else float("nan")
        spread = part - mean[channel]
        deviation[channel] = float(np.sqrt(spread.dot(spread) / (count - 1))) if count > 1 else float("nan")
    return mean, deviation
