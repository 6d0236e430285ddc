"""Every row of an open journal once more, where no other hand can empty it or write over it.

Events are few, and kept in memory. Dwells are in a file without a name: SQLite makes it in the folder of temporary
files, takes its name away at once, and it ends with the process. What the connection of the journal keeps in memory is
no such store: samples longer than a page are read past it, out of the file.
"""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import apsw

from procedures.journal.storage import SCHEMA, storage_errors_of

_OF_KEY = "SELECT 1 FROM dwells WHERE step = ? AND attempt = ? AND epoch = ?"
Row = Sequence[Any]


class KeptRows:
    """The rows of a journal, as its tables have them."""

    def __init__(self) -> None:
        self._events = apsw.Connection(":memory:")
        self._events.execute(SCHEMA)
        self._dwells = apsw.Connection("")
        self._takes_dwells = False
        with suppress(apsw.Error):
            self._dwells.execute("PRAGMA journal_mode = MEMORY")
            self._dwells.execute("PRAGMA synchronous = OFF")
            self._dwells.execute(SCHEMA)
            self._takes_dwells = True

    @property
    def connections(self) -> tuple[apsw.Connection, ...]:
        """To read them by: an event or a dwell is in one of these."""
        return self._events, self._dwells

    @staticmethod
    def of(path: Path, connection: apsw.Connection) -> "KeptRows":
        """Keep what was written before the journal was opened. Raises: JournalError, StorageFailed."""
        kept = KeptRows()
        with storage_errors_of(path):
            kept.add(connection.execute("SELECT * FROM events"), connection.execute("SELECT * FROM dwells"))
        return kept

    def add(self, events: Iterable[Row], dwells: Iterable[Row]) -> None:
        """Keep rows that are committed. A disk that takes no more dwells hinders no run: what was kept stays.

        Raises: as the iterables.
        """
        for row in events:
            self._events.execute("INSERT INTO events VALUES (?, ?, ?, ?, ?, ?)", row)
        for row in dwells:
            self._add_dwell(row)

    def has_dwell(self, key: tuple[int, int, int]) -> bool:
        """Return whether a dwell of this (step, attempt, epoch) is kept."""
        with suppress(apsw.Error):
            return self._dwells.execute(_OF_KEY, key).fetchone() is not None
        return False

    def close(self) -> None:
        for connection in self.connections:
            connection.close()

    def _add_dwell(self, row: Row) -> None:
        if self._takes_dwells:
            try:
                self._dwells.execute("INSERT INTO dwells VALUES (?, ?, ?, ?, ?, ?, ?, ?)", row)
            except apsw.Error:
                self._takes_dwells = False
