"""The stop that needs next to nothing of this process: a few bytes to the stop guard, which is a process of its own.

Out of memory, a driver may not be able to say what stops its axis: the question is an allocation, and so is the answer.
So on the way out of a defect the guard is asked first, and the stops that this process sends follow.
"""

import sys
from collections.abc import Mapping

BY_GUARD = "; the stop guard was asked first to stop every axis"


def stop_by_guard(axes: Mapping[str, object]) -> bool:
    """Have the stop guard of these axes stop every axis of its rig; False where there is none. Raises nothing."""
    try:
        for axis in axes.values():
            stop = getattr(axis, "stop_by_guard", None)
            if stop is not None:
                return bool(stop())
    except Exception:  # noqa: BLE001, S110  the last resort: what comes behind it must still be tried
        pass
    return False


def stop_past_a_defect(axes: Mapping[str, object]) -> bool:
    """Do the same where an error of Python's own is being handled: what calrig foresees has classes of its own."""
    error = sys.exception()
    return isinstance(error, Exception) and type(error).__module__ == "builtins" and stop_by_guard(axes)
