"""A rig of twins on a line of one kind: in memory in virtual time, over TCP or over pseudo-terminals in scaled time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import at_addresses, serve_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig

LINES = ("memory", "tcp", "pty")
FACTOR = 100.0


@contextmanager
def rig_on(line: str, path: Path, factor: float = FACTOR) -> Iterator[Rig]:
    """Open the twins of the rig file at ``path`` behind such lines; ``factor``: rig seconds in a second there.

    Nothing is written beside the file.
    """
    description = read_rig(path)
    if line == "memory":
        with open_rig(description) as rig:
            yield rig
        return
    with (
        serve_rig(description, ScaledClock(factor), pty=line == "pty") as served,
        open_rig(at_addresses(description, served.addresses, factor)) as rig,
    ):
        yield rig
