"""A file as a lock: the kernel's (flock), which ends with its process however that ends, so a stale file blocks nobody.

What the file says is for people; the lock itself is the truth. Who holds it and what a refusal says is the caller's:
the rig's locks are in :mod:`rig.lines.lock`, a run's owner in the journal.
"""

import fcntl
from typing import IO

from rig.clock import Clock

_BETWEEN_S = 0.02


def take(file: IO[str], clock: Clock, attempts: int) -> bool:
    """Hold the file until it is closed; False where another holds it.

    Somebody who only looks holds it for an instant: ``attempts``, a fiftieth of a second apart, must outlast that.
    """
    for attempt in range(1, attempts + 1):
        if _try(file, fcntl.LOCK_EX):
            return True
        if attempt < attempts:
            clock.sleep(_BETWEEN_S)
    return False


def is_held(file: IO[str]) -> bool:
    """Return whether another holds the file now; until ``file`` is closed, looking holds it as well."""
    return not _try(file, fcntl.LOCK_SH)


def say(file: IO[str], text: str) -> None:
    """Let the file that is held say ``text`` and nothing else."""
    file.truncate(0)
    file.write(text)
    file.flush()


def _try(file: IO[str], kind: int) -> bool:
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
