"""Whether the machine folder takes files: where its disk is full nobody sees who has a rig, nor finds its stop guard.

It lies in a small file system that every account may fill.
"""

import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path

from rig.errors import RigBusy
from rig.machine_folder import OVERRIDE

_PAGE = bytes(4096)
"""What the smallest file takes."""
WHAT_TO_DO = (
    f"make room there (df, df -i), or set {OVERRIDE} to another folder, the same for every account, writable by all and"
    " sticky"
)


def write_whole(path: Path, text: str, mode: int) -> None:
    """Put a file in place of the one before, which stays as it was where that fails. Raises: OSError."""
    descriptor, partial = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(partial, mode)
        os.replace(partial, path)
    except OSError:
        with suppress(OSError):
            os.unlink(partial)
        raise


def require_room(folder: Path) -> None:
    """See that this account can leave a file there now. Raises: RigBusy."""
    try:
        with tempfile.TemporaryFile(dir=folder, buffering=0) as probe:
            probe.write(_PAGE)
    except OSError as error:
        raise RigBusy(f"{no_room_sentence(error, folder)}; {WHAT_TO_DO}") from error


def no_room_sentence(error: OSError, folder: Path) -> str:
    """Say which folder takes no file, why, and what it has left."""
    return f"{folder}: takes no file: {error.strerror or error}{_left(folder)}"


def _left(folder: Path) -> str:
    try:
        free_bytes = shutil.disk_usage(folder).free
    except OSError:
        return ""
    files = f" and {os.statvfs(folder).f_favail} files" if hasattr(os, "statvfs") else ""
    return f" ({free_bytes} bytes{files} free)"
