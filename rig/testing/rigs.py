"""A rig of twins on a line of one kind: in memory in virtual time, over TCP or over pseudo-terminals in scaled time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile

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
    with (
        serve_rig(read_rig(path), ScaledClock(factor), pty=line == "pty") as served,
        NamedTemporaryFile(dir=path.parent, prefix=f".{path.stem}-", suffix=".toml") as beside,
    ):  # beside it: what the file names is looked for from its folder
        written = write_rig(path, served.addresses, factor, Path(beside.name))
        with open_rig(written) as rig:
            yield rig
