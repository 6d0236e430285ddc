"""The files of an open journal: whether they still stand under their names, as they were written last.

A file that is removed or replaced stays open in the process that has it: SQLite writes on to it, syncs it, says
nothing, and all of it is gone when the process ends. So the names are looked up before and behind every commit.
"""

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from procedures.errors import JournalReplaced, StorageFailed
from procedures.journal.location import NETWORK, file_system

_HANDLES = Path("/dev/fd")
"""Where systems that let an open file be removed list what a process has open."""


class _FileState(NamedTuple):
    """Which file stands under a name, and what tells that its content was changed."""

    identity: tuple[int, int]
    """Device and inode."""
    stamp: tuple[int, int]
    """Size in bytes, and when it was written last in ns."""


class HeldFiles:
    """What stood under the names of a journal, of its write-ahead log and of its index when they were opened."""

    def __init__(self, journal: Path) -> None:
        """Look at the files of a journal that has just been opened. Raises: StorageFailed."""
        self._journal, self._log, self._index = (journal.with_name(journal.name + e) for e in ("", "-wal", "-shm"))
        self._has_numbers = file_system(journal.parent.resolve()) not in NETWORK
        """A network file system may number the same file anew: there another number alone proves nothing."""
        self._opened = self._written = self._look()

    def is_as_written(self) -> bool:
        """Return whether nobody else has written to the files since :meth:`remember`.

        Raises: JournalReplaced where another file or none stands under a name, StorageFailed.
        """
        found = self._look()
        is_changed = {path: found[path].stamp != self._written[path].stamp for path in found.keys() & self._written}
        self._require_opened(found, lambda path: self._has_numbers or is_changed.get(path, False))
        return not any(is_changed.get(path, False) for path in (self._journal, self._log))

    def remember(self) -> None:
        """Take the content as it stands for what was written. Raises: as :meth:`is_as_written`."""
        found = self._look()
        self._require_opened(found, lambda _: self._has_numbers)
        self._written = found
        self._opened = found if not self._has_numbers else found | self._opened

    def are_removed(self) -> bool:
        """Return whether the journal has no name any more by which it outlives the process, as it has in a folder that
        was only moved. True where the system does not tell.
        """
        with suppress(OSError):
            for handle in os.listdir(_HANDLES):
                with suppress(OSError):
                    found = os.fstat(int(handle))
                    if (found.st_dev, found.st_ino) == self._opened[self._journal].identity:
                        return found.st_nlink == 0
        return True

    def _require_opened(self, found: Mapping[Path, _FileState], is_proof: Callable[[Path], bool]) -> None:
        """``is_proof``: whether another number under a name is another file."""
        for path, opened in self._opened.items():
            if path not in found:
                raise JournalReplaced(f"{path}: is not there any more: it was removed or renamed while it was written")
            if found[path].identity != opened.identity and is_proof(path):
                raise JournalReplaced(
                    f"{path}: is another file than the one that was opened: it was replaced while it was written"
                )

    def _look(self) -> dict[Path, _FileState]:
        states = {}
        for path in (self._journal, self._log, self._index):
            try:
                found = os.stat(path)
            except (FileNotFoundError, NotADirectoryError):
                continue
            except OSError as error:
                raise StorageFailed(
                    f"{path}: cannot be looked at: {error.strerror}; repair the disk or its rights, then resume the run"
                ) from error
            states[path] = _FileState((found.st_dev, found.st_ino), (found.st_size, found.st_mtime_ns))
        return states
