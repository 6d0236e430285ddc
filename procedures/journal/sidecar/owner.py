"""Who runs a run: a kernel lock on a file in the run's folder, which ends with its process however that ends.

Whoever writes into a journal holds it: an engine, which runs the run, or a correction, which writes a line and is gone.
The file says which. It is written once the lock is held, so for an instant it speaks of the holder before.
"""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from psutil import pid_exists

from procedures.errors import ProcedureError, RequestError, StorageFailed
from rig import file_lock
from rig.clock import Clock, SystemClock
from rig.local_time import text_at_both

OWNER_FILE = "owner.lock"
_ATTEMPTS = 10
_LOOKS, _BETWEEN_LOOKS_S = 3, 0.02
"""At what the file says, where that may be of the holder before: nothing but a write lies between."""
_PIDS = 1 << 31
Role = Literal["engine", "correction"]


@contextmanager
def owning(run_dir: Path, clock: Clock | None = None, role: Role = "engine") -> Iterator[None]:
    """Own the run while inside. Raises: RequestError naming the process that owns it; StorageFailed."""
    clock = clock or SystemClock()
    # Opened without emptying it: a refusal reads out of it who owns the run. Never removed: a lock on a removed file is
    # one that nobody else meets.
    with open(run_dir / OWNER_FILE, "a+", encoding="utf-8", opener=_opened_itself) as file:
        if not file_lock.take(file, clock, _ATTEMPTS):
            raise RequestError(f"{run_dir}: {_refusal(run_dir)}")
        said = {"pid": os.getpid(), "since_utc": clock.now_utc().isoformat(), "role": role}
        file_lock.say(file, json.dumps(said))
        yield


def is_owned(run_dir: Path) -> bool:
    """Return True while a living process runs the run; one that corrects its journal does not.

    Raises: RequestError, StorageFailed where nothing can tell.
    """
    for look in range(_LOOKS):
        try:
            with open(run_dir / OWNER_FILE, encoding="utf-8", opener=_opened_itself) as file:
                if not file_lock.is_held(file):
                    return False
        except FileNotFoundError:
            return False
        holder = _holder(run_dir)
        if holder.get("role") == "correction":
            return False
        if isinstance(pid := holder.get("pid"), int) and 0 < pid < _PIDS and pid_exists(pid):
            return True
        if look + 1 < _LOOKS:
            SystemClock().sleep(_BETWEEN_LOOKS_S)
    return True  # of another namespace of processes, or by a calrig that says nothing that is understood


def _refusal(run_dir: Path) -> str:
    if _holder(run_dir).get("role") == "correction":
        return (
            f"a correction by process {_owner_in_words(run_dir)} is being written; nothing was changed; try again when"
            " it is done"
        )
    return (
        f"the run belongs to process {_owner_in_words(run_dir)}; nothing was changed; steer it with calrig status, "
        "pause, continue, stop or abort"
    )


def _holder(run_dir: Path) -> dict[str, Any]:
    """Return what the file says; nothing where it says nothing that is understood."""
    try:
        said = _said(run_dir)
    except (ProcedureError, OSError, ValueError):
        return {}
    return said if isinstance(said, dict) else {}


def owned_since(run_dir: Path) -> datetime | None:
    """Return when the present or last owner took the run; None where nobody ever did."""
    try:
        return datetime.fromisoformat(_said(run_dir)["since_utc"])
    except (ProcedureError, OSError, ValueError, KeyError, TypeError):
        return None


def _said(run_dir: Path) -> Any:
    with open(run_dir / OWNER_FILE, encoding="utf-8", opener=_opened_itself) as file:
        return json.load(file)


def _opened_itself(path: str, flags: int) -> int:
    """Open the lock, and no file that a link leads to: that would be emptied. A pipe has no end to wait for.

    Raises: RequestError where it is no plain file; FileNotFoundError, PermissionError; StorageFailed of a bad disk.
    """
    if os.path.lexists(path) and (os.path.islink(path) or not os.path.isfile(path)):
        raise RequestError(
            f"{path}: is no plain file, which the lock of a run is; nothing was changed; find out who put it there, "
            "then remove it"
        )
    try:
        return os.open(path, flags | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0), 0o666)
    except (FileNotFoundError, PermissionError):  # of a run that is not there, or is another account's
        raise
    except OSError as error:
        raise StorageFailed(
            f"{path}: cannot be opened: {error.strerror}; nothing was changed; free space or repair the disk, then try "
            "again"
        ) from error


def _owner_in_words(run_dir: Path) -> str:
    try:
        document = _said(run_dir)
        return f"{document['pid']} since {text_at_both(str(document['since_utc']))}"
    except (ProcedureError, OSError, ValueError, KeyError, TypeError):
        return "unknown"
