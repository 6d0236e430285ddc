"""Whose defect an unexpected exception is: calrig's, or that of an installed part of another distribution.

Parts of others (``calrig.drivers``, ``calrig.exports`` and so on) run inside calrig. Where an exception passed through
the module of one, its author must read it first: also where calrig's own line raised it, for what it was handed.
"""

from collections.abc import Collection, Iterator
from importlib.metadata import distributions
from traceback import walk_tb

OURS = "calrig"


def whose(error: BaseException) -> str:
    """Return ``calrig``, or such as ``the driver 'oven' of oven-driver 1.0``. Raises nothing."""
    passed = {str(frame.f_globals.get("__name__", "")).partition(".")[0] for frame, _ in walk_tb(error.__traceback__)}
    try:
        return next(_parts_of_others(passed), OURS)
    except Exception:  # noqa: BLE001  it is asked while an axis is being stopped: an installation that is broken is ours
        return OURS


def _parts_of_others(modules: Collection[str]) -> Iterator[str]:
    for distribution in distributions():
        for entry in distribution.entry_points if distribution.name.lower() != OURS else ():
            if entry.group.startswith("calrig.") and entry.module.partition(".")[0] in modules:
                what = entry.group.removeprefix("calrig.").removesuffix("s")
                yield f"the {what} {entry.name!r} of {distribution.name} {distribution.version}"
