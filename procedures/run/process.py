"""The process' own figures: what grows over a night shows here first. Linux only; elsewhere what can be told."""

import os
import threading
from pathlib import Path

PROCESS_EVERY = 100
"""Judged dwells between two looks."""
_STATM, _FDS = Path("/proc/self/statm"), Path("/proc/self/fd")


def process_figures() -> dict[str, object]:
    """Resident memory in MB, open files, threads."""
    figures: dict[str, object] = {"threads": threading.active_count()}
    if _STATM.exists():
        pages = int(_STATM.read_text(encoding="ascii").split()[1])
        figures["resident_mb"] = round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 2)
        figures["open_files"] = len(os.listdir(_FDS))
    return figures
