"""The process' own figures: what grows over a night shows here first.

A process that has grown far beyond its start ends its run gracefully, before the machine ends it in mid-dwell: the run
can be resumed at once, by a fresh one.
"""

import os
from collections.abc import Mapping

from psutil import Process

from rig.threads import thread_count

PROCESS_EVERY = 100
"""Judged dwells between two looks."""
MOST_GROWTH = {"resident_mb": 1000.0, "open_files": 500.0, "threads": 100.0}


def process_figures() -> dict[str, float]:
    """Return resident memory in MB, open files (Windows: handles), threads."""
    process = Process()
    return {
        "threads": thread_count(),
        "resident_mb": round(process.memory_info().rss / 1e6, 2),
        "open_files": getattr(process, "num_handles" if os.name == "nt" else "num_fds")(),
    }


def growth(first: Mapping[str, float], now: Mapping[str, float]) -> str:
    """Describe what has grown too far; empty where nothing has."""
    grown = (
        f"{name} from {first[name]:g} to {now[name]:g}, allowed {most:g} more"
        for name, most in MOST_GROWTH.items()
        if name in first and name in now and now[name] - first[name] > most
    )
    return "; ".join(grown)
