"""Whether somebody reads what this process says: at a terminal, or by who started it and passes it on."""

import os
import sys
from collections.abc import Mapping

READ_BY = "CALRIG_READ_BY"
"""The variable that holds the number of the process that reads what the process that it started says."""


def is_read() -> bool:
    """Return whether a person sees standard error, now: where who passed it on is gone, nobody does."""
    return sys.stderr.isatty() or os.environ.get(READ_BY) == str(os.getppid())


def read_by_us() -> Mapping[str, str]:
    """Return the variables of a process whose words this one reads and passes on."""
    return {**os.environ, READ_BY: str(os.getpid())}
