"""Standard input, output and error of the program: there from the start, and never the reason that a run failed.

Cron, a supervisor and ``2>&-`` may begin a program without them. Python then has None where a stream is asked whether
it is a terminal, and the first file that is opened gets the number at which every library writes its errors.
Source: Python's documentation of ``sys.__stderr__``; POSIX ``exec``, which permits closed standard streams.
"""

import os
import sys
from typing import TextIO

_MODES = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))
"""By the numbers 0, 1 and 2."""


def open_closed_streams() -> None:
    """Give every standard stream that is closed the null device, under its number; children inherit it."""
    for name, mode in _MODES:
        if getattr(sys, name) is None:
            handle = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: that of the stream
            os.set_inheritable(handle, True)
            setattr(sys, name, os.fdopen(handle, mode, encoding="utf-8", closefd=False))


def let_go_of(stream: TextIO) -> None:
    """Send what a stream holds and all that follows to the null device: its reader is gone, or its disk is full."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream.fileno())
    os.close(null)
