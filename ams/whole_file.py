"""Files written whole: the final name holds the complete bytes or what it held before, also after a power cut.

The one writer of calrig, but for the stop guard: that process runs without what is installed and writes its own two
files (:mod:`rig.guard.process`). The rig, which knows nothing of this package, is handed :func:`replace_file` by who
opens it.
"""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from ams.errors import SetError, WriteFailed


class FolderNotSynced(OSError):
    """The file has its new content, and a power cut now may still take it back."""


def write_whole(path: Path, content: bytes) -> None:
    """Write a file as :func:`replace_file` does, or say in a sentence what is true of it then. Raises: WriteFailed."""
    with whole_file(path) as file:
        file.write(content)


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Yield a file that takes the place of ``path``, synced, when all is written; of an error nothing is left.

    Raises: WriteFailed.
    """
    try:
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
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        with open(partial, "xb") as file:
            yield file
            file.flush()
            if is_synced:
                os.fsync(file.fileno())
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
    if is_synced:
        sync_folder(path.parent)


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
        raise FolderNotSynced(error.errno, error.strerror) from error


def read_whole(path: Path) -> bytes:
    """Return the file's bytes. Raises: SetError where it is missing or cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise SetError(
            f"{path}: cannot be read: {error.strerror or error}; give the path of a coefficient set or an export of one"
        ) from error
