"""Whose defect an unexpected exception is: calrig's, or that of an installed part of another distribution.

Parts of others (``calrig.drivers``, ``calrig.exports`` and so on) run inside calrig. Where an exception passed through
the module of one, its author must read it first: also where calrig's own line raised it, for what it was handed.
"""

from importlib.metadata import entry_points
from traceback import walk_tb

OURS = "calrig"


def whose(error: BaseException) -> str:
    """Return ``calrig``, or such as ``the driver 'oven' of oven-driver 1.0``."""
    passed = {str(frame.f_globals.get("__name__", "")).partition(".")[0] for frame, _ in walk_tb(error.__traceback__)}
    for entry in entry_points():
        is_theirs = entry.group.startswith("calrig.") and entry.dist is not None and entry.dist.name.lower() != OURS
        if is_theirs and entry.module.partition(".")[0] in passed:
            what = entry.group.removeprefix("calrig.").removesuffix("s")
            return f"the {what} {entry.name!r} of {entry.dist.name} {entry.dist.version}"  # type: ignore[union-attr]
    return OURS
