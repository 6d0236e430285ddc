"""A disk of its own that can be full: a small file system in memory, mounted where the tests may do that."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

PIECE = bytes(4096)


class SmallDisk:
    """``path`` is where it is mounted."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._filler = path / "somebody-else"

    def fill(self, left_bytes: int = 0) -> None:
        """Let somebody else write until nothing more goes, but for ``left_bytes``."""
        with self._filler.open("ab", buffering=0) as file:
            with suppress(OSError):
                while True:
                    file.write(PIECE)
            os.truncate(file.fileno(), max(os.fstat(file.fileno()).st_size - left_bytes, 0))
        if left_bytes == 0:
            with pytest.raises(OSError, match="No space left"):
                (self.path / "one more").write_bytes(PIECE)

    def free(self) -> None:
        """Somebody else tidies up."""
        self._filler.unlink(missing_ok=True)
        (self.path / "one more").unlink(missing_ok=True)


@contextmanager
def small_disk(path: Path, size: str) -> Iterator[SmallDisk]:
    """Mount one of ``size``, or skip the test where this account may not."""
    path.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(path)], capture_output=True, text=True, check=False
    )
    if mounted.returncode != 0:
        pytest.skip(f"a disk of its own needs an account that may mount one: {mounted.stderr.strip()}")
    try:
        yield SmallDisk(path)
    finally:
        subprocess.run(["umount", "--lazy", str(path)], check=True)
