"""How a session ends whose screen, or whose console, is gone and hangs in its own clean-up."""

import os
from threading import Event

from procedures.errors import ExitStatus
from procedures.jog_screen.worker import Bench

LEAVE_S = 30.0
"""After this long, with every axis stopped, we go."""


def leave_anyway(bench: Bench, ended: Event) -> None:
    """End this process so long after its operator was lost, where it does not end itself."""
    while not ended.wait(0.5):
        if bench.guard.lost:
            if not ended.wait(LEAVE_S):
                os._exit(ExitStatus.ABORTED)
            return
