"""Who runs a run: a kernel lock on a file in the run's folder, which ends with its process however that ends."""

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

from procedures.errors import RequestError
from rig.clock import Clock, SystemClock

OWNER_FILE = "owner.lock"
_LOOKS, _BETWEEN_S = 10, 0.02
"""Somebody who only asks holds the lock for an instant; a refusal must outlast that."""


@contextmanager
def owning(run_dir: Path, clock: Clock | None = None) -> Iterator[None]:
    """Own the run while inside. Raises: RequestError naming the process that owns it."""
    clock = clock or SystemClock()
    with open(run_dir / OWNER_FILE, "a+", encoding="utf-8") as file:
        if not _locked(file.fileno(), clock):
            raise RequestError(
                f"{run_dir}: the run belongs to process {_told(run_dir)}; nothing was changed; steer it with "
                "calrig status, pause, continue, stop or abort"
            )
        file.truncate(0)
        file.write(json.dumps({"pid": os.getpid(), "since_utc": clock.now_utc().isoformat()}))
        file.flush()
        yield


def is_owned(run_dir: Path) -> bool:
    """True while a living process runs the run."""
    try:
        with open(run_dir / OWNER_FILE, encoding="utf-8") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                return True
            return False
    except FileNotFoundError:
        return False


def owned_since(run_dir: Path) -> datetime | None:
    """When the present or last owner took the run; None where nobody ever did."""
    try:
        return datetime.fromisoformat(json.loads((run_dir / OWNER_FILE).read_text(encoding="utf-8"))["since_utc"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _locked(handle: int, clock: Clock) -> bool:
    for look in range(_LOOKS):
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if look + 1 < _LOOKS:
                clock.sleep(_BETWEEN_S)
            continue
        return True
    return False


def _told(run_dir: Path) -> str:
    try:
        document = json.loads((run_dir / OWNER_FILE).read_text(encoding="utf-8"))
        return f"{document['pid']} since {document['since_utc']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "unknown"
