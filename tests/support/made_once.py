"""What is dear and never changed, made once in a session, however many workers run it."""

import fcntl
from collections.abc import Callable
from pathlib import Path

import pytest


def made_once(
    name: str, make: Callable[[Path], object], folders: pytest.TempPathFactory, config: pytest.Config
) -> Path:
    """Return a folder that ``make`` has filled; the other workers wait for the first that asks, and find it made."""
    base = folders.getbasetemp()
    shared = base.parent if hasattr(config, "workerinput") else base
    folder, made = shared / name, shared / f"{name}.made"
    with (shared / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.exists():
            folder.mkdir()
            make(folder)
            made.touch()
    return folder
