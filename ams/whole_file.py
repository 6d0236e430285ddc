"""Files written whole: the final name holds the complete bytes or what it held before, also after a power cut."""

import os
import secrets
from pathlib import Path

from ams.errors import SetError, WriteFailed


def write_whole(path: Path, content: bytes) -> None:
    """Write beside the target, sync, rename into place, sync the folder.

    Raises: WriteFailed where the file system refuses; the target is then as it was and nothing is left beside it.
    """
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        try:
            _write_synced(partial, content)
            os.replace(partial, path)
        finally:
            partial.unlink(missing_ok=True)
        _sync_folder(path.parent)
    except OSError as error:
        raise WriteFailed(
            f"{path}: cannot be written: {error.strerror or error}; nothing was changed there; "
            "check the folder, the rights and the free space"
        ) from error


def _write_synced(path: Path, content: bytes) -> None:
    with open(path, "xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def read_whole(path: Path) -> bytes:
    """The file's bytes. Raises: SetError where it is missing or cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise SetError(
            f"{path}: cannot be read: {error.strerror or error}; give the path of a coefficient set or an export of one"
        ) from error
