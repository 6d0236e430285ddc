"""Files that fail at the n-th call: what SQLite writes and syncs (through a VFS shim) and what the module ``os`` does
in a run's folder share one count. Source of the method: SQLite's tests of I/O errors (sqlite.org/testing.html, 3.2)."""

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import apsw

_VFS = "failing"


@dataclass
class FailingFiles:
    """``error`` is an errno; ``stuck``: every call from the n-th on fails, not that one alone."""

    folder: Path
    call: int
    error: int
    stuck: bool = False
    calls: int = 0

    @property
    def has_failed(self) -> bool:
        return self.calls >= self.call

    def _fails(self) -> bool:
        self.calls += 1
        return self.calls >= self.call if self.stuck else self.calls == self.call

    def of_sqlite(self) -> None:
        if self._fails():
            found = os.strerror(self.error)
            raise apsw.FullError(found) if self.error == errno.ENOSPC else apsw.IOError(found)

    def of_system(self, path: object) -> None:
        if str(path).startswith(str(self.folder)) and self._fails():
            raise OSError(self.error, os.strerror(self.error), str(path))


class _Vfs(apsw.VFS):
    def __init__(self, failing: FailingFiles) -> None:
        self._failing, self._below = failing, apsw.vfs_names()[0]
        super().__init__(_VFS, self._below, makedefault=True)

    def xOpen(self, name: Any, flags: list[int]) -> Any:
        return _File(self._failing, self._below, name, flags)


class _File(apsw.VFSFile):
    def __init__(self, failing: FailingFiles, below: str, name: Any, flags: list[int]) -> None:
        self._failing = failing
        super().__init__(below, name, flags)

    def xLock(self, level: int) -> None:
        """SQLite tries an exclusive lock when a read-only connection closes, and shrugs when it has none."""
        try:
            super().xLock(level)
        except apsw.IOError as error:
            raise apsw.BusyError("no exclusive lock on a file that is open for reading only") from error

    def xWrite(self, data: bytes, offset: int) -> None:
        self._failing.of_sqlite()
        super().xWrite(data, offset)

    def xSync(self, flags: int) -> None:
        self._failing.of_sqlite()
        super().xSync(flags)

    def xTruncate(self, size: int) -> None:
        self._failing.of_sqlite()
        super().xTruncate(size)


@contextmanager
def failing_files(folder: Path, call: int, error: int, *, stuck: bool = False) -> Iterator[FailingFiles]:
    """While inside, the ``call``-th file call in ``folder`` fails."""
    failing, kept = FailingFiles(folder, call, error, stuck), {}
    for name, path_of in _PATHS.items():
        kept[name] = getattr(os, name)
        setattr(os, name, _checked(failing, kept[name], path_of))
    vfs = _Vfs(failing)
    try:
        yield failing
    finally:
        vfs.unregister()
        for name, function in kept.items():
            setattr(os, name, function)


def _checked(
    failing: FailingFiles, function: Callable[..., Any], path_of: Callable[[Any], object]
) -> Callable[..., Any]:
    def checked(first: Any, *arguments: Any, **named: Any) -> Any:
        failing.of_system(path_of(first))
        return function(first, *arguments, **named)

    return checked


def _of_handle(handle: Any) -> object:
    return os.readlink(f"/proc/self/fd/{handle}")


_PATHS: dict[str, Callable[[Any], object]] = {
    "open": str,
    "pwrite": _of_handle,
    "fsync": _of_handle,
    "rename": str,
    "replace": str,
}
"""Functions of ``os`` to what tells the path from their first argument."""
