"""The process' own figures: what grows over a night shows here first. Linux only; elsewhere what can be told.

A process that has grown far beyond its start ends its run gracefully, before the machine ends it in mid-dwell: the run
can be resumed at once, by a fresh one.
"""

import os
import threading
from collections.abc import Mapping
from pathlib import Path

PROCESS_EVERY = 100
"""Judged dwells between two looks."""
MOST_GROWTH = {"resident_mb": 1000.0, "open_files": 500.0, "threads": 100.0}
_STATM, _FDS = Path("/proc/self/statm"), Path("/proc/self/fd")


def process_figures() -> dict[str, float]:
    """Resident memory in MB, open files, threads."""
    figures: dict[str, float] = {"threads": threading.active_count()}
    if _STATM.exists():
        pages = int(_STATM.read_text(encoding="ascii").split()[1])
        figures["resident_mb"] = round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 2)
        figures["open_files"] = len(os.listdir(_FDS))
    return figures


def growth(first: Mapping[str, float], now: Mapping[str, float]) -> str:
    """Describe what has grown too far; empty where nothing has."""
    grown = (
        f"{name} from {first[name]:g} to {now[name]:g}, allowed {most:g} more"
        for name, most in MOST_GROWTH.items()
        if name in first and name in now and now[name] - first[name] > most
    )
    return "; ".join(grown)
