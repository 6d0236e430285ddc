"""This machine's own time zone as a test wants it: what is told and due goes by the clock on the wall."""

import os
import time  # noqa: TID251 tzset is nowhere else
from collections.abc import Iterator
from contextlib import contextmanager

FARTHEST = ("Pacific/Kiritimati", "Etc/GMT+12")
"""26 h apart: at any moment the calendar of one of them, or both, shows another day than that of UTC."""


@contextmanager
def hung_in(zone: str) -> Iterator[None]:
    """Have the clock of this process hang on a wall in ``zone``."""
    before = os.environ.get("TZ")
    os.environ["TZ"] = zone
    time.tzset()
    try:
        yield
    finally:
        if before is None:
            del os.environ["TZ"]
        else:
            os.environ["TZ"] = before
        time.tzset()
