"""Who makes the results of a run now: a kernel lock beside the journal, which ends with its process however that ends.

A run is finished before its results are there: eight packages take a minute. Until then nobody is to solve it again.
"""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from procedures.errors import RequestError
from rig import file_lock
from rig.clock import Clock, SystemClock
from rig.local_time import text_at_both

DELIVERY_FILE = "delivery.lock"
_ATTEMPTS = 10


@contextmanager
def delivering(run_dir: Path, clock: Clock | None = None) -> Iterator[None]:
    """Deliver the run while inside; where its folder takes no lock, as on a full disk, without one.

    Raises: RequestError naming the process that delivers it already.
    """
    clock = clock or SystemClock()
    try:
        file = (run_dir / DELIVERY_FILE).open("a+", encoding="utf-8")
    except OSError:
        yield
        return
    with file:
        if not file_lock.take(file, clock, _ATTEMPTS):
            raise RequestError(
                f"{run_dir}: its results are being delivered by {delivered_by(run_dir)}; nothing was changed; wait "
                "until calrig handover shows the verdict"
            )
        with suppress(OSError):
            file_lock.say(file, json.dumps({"pid": os.getpid(), "since_utc": clock.now_utc().isoformat()}))
        yield


def delivered_by(run_dir: Path) -> str:
    """Return the living process that delivers the run, and since when; empty where none does."""
    path = run_dir / DELIVERY_FILE
    try:
        with path.open(encoding="utf-8") as file:
            if not file_lock.is_held(file):
                return ""
    except OSError:
        return ""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return f"process {document['pid']} since {text_at_both(str(document['since_utc']))}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
