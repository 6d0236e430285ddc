"""A disk that loses power: every write and sync of a journal is recorded, and images are made of what such a moment may
leave. What was synced is there; of what was not, any subset, in any order, with sectors torn out of the middle.

SQLite's files are seen through a VFS shim, the file beside the journal and the rename through the module ``os``.
Source of the method: SQLite's crash VFS (sqlite.org/testing.html, section 3.4).
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import apsw
import numpy as np

SECTOR = 512
_VFS = "recording"


@dataclass(frozen=True)
class Write:
    file: str
    offset: int
    data: bytes


@dataclass(frozen=True)
class Truncate:
    file: str
    size: int


@dataclass(frozen=True)
class Sync:
    """Everything that was written to the file before is on the disk, and the file's name with it."""

    file: str


@dataclass(frozen=True)
class Delete:
    file: str


@dataclass(frozen=True)
class Rename:
    source: str
    target: str


@dataclass(frozen=True)
class SyncFolder:
    pass


@dataclass(frozen=True)
class Acknowledged:
    """So many dwells were told to be stored."""

    dwells: int


Operation = Write | Truncate | Sync | Delete | Rename | SyncFolder | Acknowledged


@dataclass
class Recorder:
    """What happens in one folder."""

    folder: Path
    operations: list[Operation] = field(default_factory=list)

    def acknowledge(self, dwells: int) -> None:
        self.operations.append(Acknowledged(dwells))

    def name_of(self, path: object) -> str | None:
        found = Path(os.fspath(path))  # type: ignore[call-overload]
        return found.name if found.parent == self.folder else None


class _Vfs(apsw.VFS):
    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._below = apsw.vfs_names()[0]
        super().__init__(_VFS, self._below, makedefault=True)

    def xOpen(self, name: Any, flags: list[int]) -> Any:
        path = name.filename() if isinstance(name, apsw.URIFilename) else name
        return _File(self._recorder, self._below, name, path, flags)

    def xDelete(self, name: str, syncdir: bool) -> None:
        super().xDelete(name, syncdir)
        if (file := self._recorder.name_of(name)) is not None:
            self._recorder.operations.append(Delete(file))
            if syncdir:
                self._recorder.operations.append(SyncFolder())


class _File(apsw.VFSFile):
    def __init__(self, recorder: Recorder, below: str, name: Any, path: str | None, flags: list[int]) -> None:
        self._operations = recorder.operations
        self._file = recorder.name_of(path) if path else None
        super().__init__(below, name, flags)

    def xLock(self, level: int) -> None:
        """SQLite tries an exclusive lock when a read-only connection closes, and shrugs when it has none."""
        try:
            super().xLock(level)
        except apsw.IOError as error:
            raise apsw.BusyError("no exclusive lock on a file that is open for reading only") from error

    def xWrite(self, data: bytes, offset: int) -> None:
        super().xWrite(data, offset)
        if self._file is not None:
            self._operations.append(Write(self._file, offset, bytes(data)))

    def xTruncate(self, size: int) -> None:
        super().xTruncate(size)
        if self._file is not None:
            self._operations.append(Truncate(self._file, size))

    def xSync(self, flags: int) -> None:
        super().xSync(flags)
        if self._file is not None:
            self._operations.append(Sync(self._file))


@contextmanager
def recorded(folder: Path, checkpoint_pages: int) -> Iterator[Recorder]:
    """Record what happens in ``folder``; a checkpoint every so many pages, so that short journals have some."""
    recorder, hooks, pwrite, rename, fsync = Recorder(folder), apsw.connection_hooks, os.pwrite, os.rename, os.fsync
    open_files = _open_files(recorder)

    def seen_pwrite(handle: int, data: bytes, offset: int) -> int:
        if (file := open_files(handle)) is not None:
            if os.fstat(handle).st_size == 0:
                recorder.operations.append(Write(file, 0, b""))  # made, and empty until the content arrives
            recorder.operations.append(Write(file, offset, bytes(data)))
        return pwrite(handle, data, offset)

    def seen_rename(source: Any, target: Any) -> None:
        rename(source, target)
        recorder.operations.append(Rename(Path(source).name, Path(target).name))

    def seen_fsync(handle: int) -> None:
        fsync(handle)
        if os.readlink(f"/proc/self/fd/{handle}") == str(folder):
            recorder.operations.append(SyncFolder())

    def often(connection: apsw.Connection) -> None:
        if not connection.readonly("main"):
            connection.wal_autocheckpoint(checkpoint_pages)

    vfs = _Vfs(recorder)
    hooks.append(often)
    os.pwrite, os.rename, os.fsync = seen_pwrite, seen_rename, seen_fsync
    try:
        yield recorder
    finally:
        os.pwrite, os.rename, os.fsync = pwrite, rename, fsync
        hooks.remove(often)
        vfs.unregister()


def _open_files(recorder: Recorder) -> Callable[[int], str | None]:
    return lambda handle: recorder.name_of(os.readlink(f"/proc/self/fd/{handle}"))


@dataclass(frozen=True)
class Image:
    """What the disk holds after the power came back."""

    files: Mapping[str, bytes]
    acknowledged: int

    def write_to(self, folder: Path) -> None:
        folder.mkdir()
        for name, content in self.files.items():
            (folder / name).write_bytes(content)


def image_at(operations: Sequence[Operation], moment: int, chance: np.random.Generator | None = None) -> Image:
    """The disk after ``operations[:moment]``. Without ``chance`` all of them arrived, with it only what was synced
    and a random part of the rest."""
    done = operations[:moment]
    files: dict[str, bytearray] = {}
    for index, operation in enumerate(done):
        if chance is None or _is_durable(done, index):
            _apply(files, operation)
        elif chance.uniform() < 0.5:
            _apply(files, _torn(operation, chance))
    acknowledged = max((entry.dwells for entry in done if isinstance(entry, Acknowledged)), default=0)
    return Image({name: bytes(content) for name, content in files.items()}, acknowledged)


def _is_durable(done: Sequence[Operation], index: int) -> bool:
    """Content is durable once its file was synced, under whatever name; a name once its folder was."""
    operation = done[index]
    if isinstance(operation, Rename | Delete):
        return any(isinstance(later, SyncFolder) for later in done[index + 1 :])
    if not isinstance(operation, Write | Truncate):
        return True
    return any(isinstance(later, Sync) and later.file == operation.file for later in done[index + 1 :])


def _torn(operation: Operation, chance: np.random.Generator) -> Operation:
    """One time in two a write of several sectors arrives only as far as one of them."""
    if not isinstance(operation, Write) or len(operation.data) <= SECTOR or chance.uniform() < 0.5:
        return operation
    sectors = int(chance.integers(0, len(operation.data) // SECTOR))
    return Write(operation.file, operation.offset, operation.data[: sectors * SECTOR])


def _apply(files: dict[str, bytearray], operation: Operation) -> None:
    match operation:
        case Write(file, offset, data):
            content = files.setdefault(file, bytearray())
            content.extend(bytes(max(0, offset + len(data) - len(content))))
            content[offset : offset + len(data)] = data
        case Truncate(file, size):
            content = files.setdefault(file, bytearray())
            content.extend(bytes(max(0, size - len(content))))
            del content[size:]
        case Delete(file):
            files.pop(file, None)
        case Rename(source, target) if source in files:
            files[target] = files.pop(source)
