"""How a session ends: by the last stop of every axis, also where its screen, or its console, is gone and hangs."""

import os
from collections.abc import Callable
from threading import Event

from procedures.jog_screen.worker import Bench
from rig.motion.out_of_reach import BACK_S

LEAVE_S = 30.0
"""After this long, with every axis stopped, we go."""
LAST_STOP_S = 120.0
"""Longer than a last stop that waits for a line: twice the deadline of a stop, and :data:`BACK_S`."""
_SOON_S = 5.0


def close(bench: Bench, note: Callable[[str], None]) -> None:
    """Close the bench; ``note`` hears where its last stop takes long, which nobody should cut short."""
    bench.leave()
    try:
        if not bench.has_ended(_SOON_S):
            note(
                f"not every axis is seen to stand yet; the line of one that turns is waited for, up to {BACK_S:g} s:"
                " leave this running, or use the stop button at the machine"
            )
    finally:
        bench.close()


def leave_anyway(bench: Bench, ended: Event) -> None:
    """End this process so long after its operator was lost and the axes were stopped, where it does not end itself."""
    while not ended.wait(0.5):
        if bench.guard.lost:
            bench.has_ended(LAST_STOP_S)
            if not ended.wait(LEAVE_S):
                os._exit(bench.last_stop.exit_status(bench.guard.lost))
            return
