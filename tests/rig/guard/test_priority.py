"""What a process that asks for short slices gets, as the system tells it (``sched_getattr`` of Linux)."""

import ctypes
import os
import subprocess
import sys

import pytest

ASKS = """
import ctypes, os, struct
from rig.guard.priority import SCHED_ATTR, SCHED_SETATTR, ask_for_short_slices
os.nice(3)
ask_for_short_slices()
told = ctypes.create_string_buffer(SCHED_ATTR.size)
failed = ctypes.CDLL(None).syscall(SCHED_SETATTR[os.uname().machine] + 1, 0, told, SCHED_ATTR.size, 0)
print(failed, *SCHED_ATTR.unpack(told.raw))
"""
TELLS_SLICES = (6, 12)


@pytest.mark.skipif(os.uname().machine not in ("x86_64", "aarch64"), reason="the number of the call is another's")
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of Linux")
def test_short_slices_are_asked_for_and_nothing_else_is_changed() -> None:
    assert ctypes.sizeof(ctypes.c_void_p) == 8
    done = subprocess.run([sys.executable, "-c", ASKS], capture_output=True, text=True, check=True).stdout
    failed, size, policy, _, nice, priority, runtime_ns, *_ = (int(word) for word in done.split())
    assert (failed, size, policy, priority) == (0, 48, os.SCHED_OTHER, 0)
    assert nice == os.getpriority(os.PRIO_PROCESS, 0) + 3
    kernel = tuple(int(part) for part in os.uname().release.split(".")[:2])
    assert kernel < TELLS_SLICES or runtime_ns == 100_000
