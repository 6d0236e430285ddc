"""Have this process woken before others that want a processor, as far as the system lets it: it works but moments."""

import ctypes
import os
import struct
import sys
from contextlib import suppress

SCHED_SETATTR = {"x86_64": 314, "aarch64": 274, "riscv64": 274, "armv7l": 380, "i686": 351}
"""Number of the call by machine: few C libraries have a function for it."""
SCHED_ATTR = struct.Struct("=IIQiIQQQ")
"""size, policy, flags, nice, priority, runtime, deadline, period: ``struct sched_attr`` in its first version."""
SLICE_NS = 100_000


def go_first() -> None:
    """Take a real-time priority; where that is not permitted, ask for short slices, which is open to everybody.

    Root may have the first, and whoever has a limit for it (``LimitRTPRIO=`` of a unit, ``rtprio`` of limits.conf).
    """
    if sys.platform.startswith("linux"):
        try:
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(os.sched_get_priority_min(os.SCHED_RR)))
        except OSError:
            with suppress(OSError, AttributeError):
                ask_for_short_slices()


def step_back() -> None:
    """Be as every other process again: what is started by one that goes first goes first, too."""
    if sys.platform.startswith("linux"):
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def ask_for_short_slices() -> None:
    """Since Linux 6.12 who asks for short slices is put before who runs for long; before, it changes nothing."""
    if sys.platform.startswith("linux") and (number := SCHED_SETATTR.get(os.uname().machine)) is not None:
        nice = os.getpriority(os.PRIO_PROCESS, 0)
        attributes = SCHED_ATTR.pack(SCHED_ATTR.size, os.SCHED_OTHER, 0, nice, 0, SLICE_NS, 0, 0)
        ctypes.CDLL(None).syscall(number, 0, attributes, 0)
