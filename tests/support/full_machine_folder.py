"""A machine folder whose disk is full: a small one that is really mounted, or one that only says so."""

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from small_disk import small_disk

from rig.machine_folder import OVERRIDE

SIZE = "64k"
MOUNTED, SAID = "mounted", "said"
WAYS = (MOUNTED, SAID)


@dataclass
class MachineFolder:
    """``fill`` and ``free`` it."""

    path: Path
    fill: Callable[[], None]
    free: Callable[[], None]

    def marks(self) -> dict[str, str]:
        """Return the marks of uses, by file."""
        return {path.name: path.read_text(encoding="utf-8") for path in self.path.rglob("*.used")}

    def left_over(self) -> list[Path]:
        """Return what a write that failed has left behind."""
        return [path for path in self.path.rglob("*") if ".used." in path.name or path.suffix == ".partial"]

    def fill_with_names(self) -> None:
        """Let somebody else make empty files until no more can be."""
        with suppress(OSError):
            for number in range(1000):
                (self.path / f"somebody-else-{number}").touch()


@contextmanager
def machine_folder_that_fills(
    folder: Path, monkeypatch: pytest.MonkeyPatch, way: str = MOUNTED, size: str = SIZE
) -> Iterator[MachineFolder]:
    """Have this process and its children share one. Where it is to be mounted and may not be, the test is skipped."""
    if way == MOUNTED:
        with small_disk(folder / "disk", size) as disk:
            monkeypatch.setenv(OVERRIDE, str(disk.path / "calrig"))
            yield MachineFolder(disk.path / "calrig", disk.fill, disk.free)
        return
    path = folder / "calrig"
    monkeypatch.setenv(OVERRIDE, str(path))
    plain_open, is_full = os.open, False

    def opened(name: Any, flags: int, *arguments: Any, **named: Any) -> int:
        if is_full and flags & (os.O_WRONLY | os.O_RDWR) and str(name).startswith(str(path)):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), name)
        return plain_open(name, flags, *arguments, **named)

    def become(full: bool) -> None:
        nonlocal is_full
        is_full = full

    monkeypatch.setattr(os, "open", opened)
    yield MachineFolder(path, lambda: become(True), lambda: become(False))
