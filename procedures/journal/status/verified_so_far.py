"""A journal that is verified as it grows: a look costs what was committed since, not what the run is long.

What was verified is not verified again at once, but in a second search that begins at the start and goes on by a share
at each look: what changes on the disk under a run that goes on is found when that search comes to it, and the search
that has reached the end takes the place of the one before. Another file, another header or another end than the one
that was read is another journal: it is to be read anew.
"""

import os
from pathlib import Path

from procedures.errors import JournalError
from procedures.journal.damage import Damage
from procedures.journal.journal_reader import JournalReader
from procedures.journal.status.course import Course
from procedures.journal.status.standing import RunStatus

SHARE = 500
"""So many events, and so many dwells, are verified again at each look."""


class VerifiedSoFar:
    """Of one journal: what is not as it was written, and where the run stands by what was read."""

    def __init__(self, reader: JournalReader) -> None:
        """Before the first look. Raises: PlanError where the plan of the journal is of another version."""
        self._identity = _identity(reader.path)
        header = reader.header
        self.design_steps = frozenset(dwell.step for dwell in header.plan.design_dwells)
        self._course: Course | None = Course(reader.path.parent, header)
        """None where an event is so damaged that nobody can tell."""
        self._search, self._again = reader.new_search(), reader.new_search()

    def is_continued_by(self, reader: JournalReader) -> bool:
        """Return whether an opened journal is the one that was read, which may have grown since."""
        return _identity(reader.path) == self._identity and reader.holds_end_of(self._search)

    def look(self, reader: JournalReader) -> Damage:
        """Read what is new, and a share of the rest once more. Raises: JournalError."""
        is_first = not self._search.sequence
        reader.read_on(self._search)
        self._course = _read_on(self._course, reader)
        if is_first:
            return self._search.damage
        reader.read_on(self._again, at_most=SHARE)
        found, again = self._search.damage, self._again.changed
        if self._again.has_reached(self._search):
            self._search, self._again = self._again, reader.new_search()
            return self._search.damage
        return Damage(*(tuple(dict.fromkeys(names + more)) for names, more in zip(found, again, strict=True)))

    def status(self, *, is_alive: bool) -> RunStatus | None:
        """Return where the run stands, ``is_alive``: whether a living process runs it; None where nobody can tell."""
        return None if self._course is None else self._course.status(is_alive=is_alive)


def _read_on(course: Course | None, reader: JournalReader) -> Course | None:
    if course is None:
        return None
    try:
        for event in reader.events(after=course.sequence):
            course.take(event)
    except (JournalError, LookupError, TypeError, ValueError):
        return None  # the damage is named, and hides nothing else of the run
    return course


def _identity(journal: Path) -> tuple[int, int]:
    found = os.stat(journal)
    return found.st_dev, found.st_ino
