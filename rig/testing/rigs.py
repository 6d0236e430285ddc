"""A rig of twins on a line of one kind: in memory in virtual time, over TCP or over pseudo-terminals in scaled time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig

LINES = ("memory", "tcp", "pty")
FACTOR = 100.0


@contextmanager
def rig_on(line: str, path: Path, factor: float = FACTOR) -> Iterator[Rig]:
    """Open the twins of the rig file at ``path`` behind such lines; ``factor``: rig seconds in a second there."""
    if line == "memory":
        with open_rig(read_rig(path)) as rig:
            yield rig
        return
    with serve_rig(read_rig(path), ScaledClock(factor), pty=line == "pty") as served:
        written = write_rig(path, served.addresses, factor, path.with_name(f"{line}.toml"))
        with open_rig(written) as rig:
            yield rig
