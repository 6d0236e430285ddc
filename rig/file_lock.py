"""A file as a lock: the kernel's, which ends with its process however that ends, so a stale file blocks nobody.

Everywhere but on Windows it is flock, and whoever only looks shares it. Windows knows no look: there a byte far behind
the text is taken and given back at once, so two that look at the same instant may both find it held.

The library filelock is not used: it opens a lock's file for writing, which one of another account does not allow, and
empties it, and what the file says is what a refusal tells.

What the file says is for people; the lock itself is the truth. Who holds it and what a refusal says is the caller's:
the rig's locks are in :mod:`rig.lines.lock`, a run's owner in the journal.
"""

import os
from typing import IO

from rig.clock import Clock
from rig.errors import RigBusy
from rig.system_parts import module_here

_BETWEEN_S = 0.02
_FLOCK = module_here("fcntl")
_WINDOWS = module_here("msvcrt")
_BEHIND_ALL_TEXT = 1 << 30


def take(file: IO[str], clock: Clock, attempts: int) -> bool:
    """Hold the file until it is closed; False where another holds it.

    Somebody who only looks holds it for an instant: ``attempts``, a fiftieth of a second apart, must outlast that.
    """
    for attempt in range(1, attempts + 1):
        if _is_taken(file):
            return True
        if attempt < attempts:
            clock.sleep(_BETWEEN_S)
    return False


def is_held(file: IO[str]) -> bool:
    """Return whether another holds the file now; until ``file`` is closed, looking holds it as well."""
    if _FLOCK:
        return not _is_flocked(file, _FLOCK.LOCK_SH)
    is_free = _is_byte_taken(file)
    if is_free:
        offset = os.lseek(file.fileno(), 0, os.SEEK_CUR)
        os.lseek(file.fileno(), _BEHIND_ALL_TEXT, os.SEEK_SET)
        _WINDOWS.locking(file.fileno(), _WINDOWS.LK_UNLCK, 1)
        os.lseek(file.fileno(), offset, os.SEEK_SET)
    return not is_free


def say(file: IO[str], text: str) -> None:
    """Let the file that is held, opened to append, say ``text`` and nothing else.

    Raises: OSError naming it; then nothing waits to be written when it is closed, which would raise once more.
    """
    try:
        file.truncate(0)
        os.write(file.fileno(), text.encode("utf-8"))
    except OSError as error:
        raise OSError(error.errno, error.strerror, file.name) from error


def _is_taken(file: IO[str]) -> bool:
    return _is_flocked(file, _FLOCK.LOCK_EX) if _FLOCK else _is_byte_taken(file)


def _is_flocked(file: IO[str], kind: int) -> bool:
    try:
        _FLOCK.flock(file, kind | _FLOCK.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_byte_taken(file: IO[str]) -> bool:
    if _WINDOWS is None:
        raise RigBusy(
            f"{file.name}: this system has no way to lock a file (neither fcntl nor msvcrt), so nobody could be kept"
            " away; nothing was opened; use a Python that has one of them"
        )
    offset = os.lseek(file.fileno(), 0, os.SEEK_CUR)
    os.lseek(file.fileno(), _BEHIND_ALL_TEXT, os.SEEK_SET)
    try:
        _WINDOWS.locking(file.fileno(), _WINDOWS.LK_NBLCK, 1)
    except OSError:
        return False
    finally:
        os.lseek(file.fileno(), offset, os.SEEK_SET)
    return True
