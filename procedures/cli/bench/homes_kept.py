"""Homes of a rig that is used by hand: taken over from the use before, and kept for the next."""

from collections.abc import Iterator
from contextlib import contextmanager

from ams.whole_file import replace_file
from procedures.cli.output import note
from rig.assembly.open_rig import Rig
from rig.errors import RigError
from rig.motion.home_memory import HomeMemory


@contextmanager
def homes_kept(opened: Rig) -> Iterator[None]:
    """Take over homes that the machines prove to have kept since the last jog; keep those of this one for the next."""
    memory = HomeMemory(opened.description, opened.clock, replace_file)
    for why in memory.take_over(opened.axes).values():
        note(why)
    yield
    try:
        memory.keep(opened.axes)
    except (RigError, OSError) as error:
        note(f"homes are not kept for the next jog: {error}")
