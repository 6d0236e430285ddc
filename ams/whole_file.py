"""Files written whole: the final name holds the complete bytes or what it held before, also after a power cut.

The one writer of calrig, but for the stop guard: that process runs without what is installed and writes its own two
files (:mod:`rig.guard.process`). The rig, which knows nothing of this package, is handed :func:`replace_file` by who
opens it.
"""

import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from ams.errors import SetError, WriteFailed

_kernel: Any  # its locks; Windows has none
try:
    import fcntl as _kernel
except ImportError:
    _kernel = None


class FolderNotSynced(OSError):
    """The file has its new content, and a power cut now may still take it back."""


def write_whole(path: Path, content: bytes) -> None:
    """Write a file as :func:`replace_file` does, or say in a sentence what is true of it then. Raises: WriteFailed."""
    with whole_file(path) as file:
        file.write(content)


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Yield a file that takes the place of ``path``, synced, when all is written; of an error nothing is left.

    What a writer of ``path`` left beside it that was killed is taken away.

    Raises: WriteFailed.
    """
    try:
        _remove_abandoned(path)
        with _replacing(path) as file:
            yield file
    except FolderNotSynced as error:
        raise WriteFailed(
            f"{path}: was written, but its folder could not be synced: {error.strerror or error}; a power cut may "
            "bring back what was there before; check the disk and write it again"
        ) from error
    except OSError as error:
        raise WriteFailed(
            f"{path}: cannot be written: {error.strerror or error}; nothing was changed there; "
            "check the folder, the rights and the free space"
        ) from error


def replace_file(path: Path, content: bytes, *, is_synced: bool = True) -> None:
    """Write beside the target, sync, rename into place, sync the folder.

    Not ``is_synced``: as whole for whoever reads it meanwhile, and nothing waits for the disk. For what is told anew
    every second and says nothing after a power cut.

    Raises: FolderNotSynced where only the last failed; OSError where the file system refuses the file: the target is
    then as it was and nothing is left beside it.
    """
    with _replacing(path, is_synced=is_synced) as file:
        file.write(content)


@contextmanager
def _replacing(path: Path, *, is_synced: bool = True) -> Iterator[IO[bytes]]:
    partial, opened = _opened_beside(path)
    try:
        with opened as file:
            yield file
            file.flush()
            if is_synced:
                os.fsync(file.fileno())
        os.replace(partial, path)
    except OSError as error:
        if error.errno is not None and not error.filename:
            error.filename = str(path)  # what an open file refuses has no name
        raise
    finally:
        partial.unlink(missing_ok=True)
    if is_synced:
        sync_folder(path.parent)


def _remove_abandoned(path: Path) -> None:
    """Remove what writers of a file left that were killed: nobody holds it, since the kernel lets go for the dead.

    Where there are no such locks, or the file system has none, it stays.
    """
    is_partial = re.compile(rf"\.{re.escape(path.name)}\.[0-9a-f]{{8}}\.partial").fullmatch
    if _kernel is None or not path.parent.is_dir():
        return
    with suppress(OSError):  # what cannot be taken away hinders nobody
        for name in filter(is_partial, os.listdir(path.parent)):
            with suppress(OSError), open(path.with_name(name), "rb") as file:
                _kernel.flock(file, _kernel.LOCK_EX | _kernel.LOCK_NB)
                path.with_name(name).unlink()


def _opened_beside(path: Path) -> tuple[Path, IO[bytes]]:
    """Return a new file beside ``path`` that is held until it is closed, with its path."""
    while True:
        partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
        file = open(partial, "xb")  # noqa: SIM115  closed by who writes it
        if _is_held(file):
            return partial, file
        file.close()


def _is_held(file: IO[bytes]) -> bool:
    """Hold a file until it is closed; False where another writer took it for one of the dead before it was held."""
    if _kernel is not None:
        with suppress(OSError):  # a file system without locks
            _kernel.flock(file, _kernel.LOCK_EX)
    return os.fstat(file.fileno()).st_nlink > 0


def sync_folder(folder: Path) -> None:
    """Let the names in a folder outlive a power cut, where the system can. Raises: FolderNotSynced."""
    if not hasattr(os, "O_DIRECTORY"):  # Windows opens no folder
        return
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError as error:
        raise FolderNotSynced(error.errno, error.strerror, str(folder)) from error


def read_whole(path: Path) -> bytes:
    """Return the file's bytes. Raises: SetError where it is missing or cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise SetError(
            f"{path}: cannot be read: {error.strerror or error}; give the path of a coefficient set or an export of one"
        ) from error
