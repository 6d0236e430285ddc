"""Named places at which a test may kill this process, as a power cut would.

They are between an intent and its move, before a commit and after it, inside a checkpoint.

Off unless ``CALRIG_CRASH_POINT`` is set, to ``NAME:N`` or ``any:N``: the N-th passage, counted down in the variable
itself, ends in SIGKILL. Only a rig whose every device is a twin in this process may be opened with it.
"""

import os
import signal
from collections.abc import Sequence
from enum import StrEnum

from rig.errors import RequestRefused

VARIABLE = "CALRIG_CRASH_POINT"
ANY = "any"


class CrashPoint(StrEnum):
    """Where a kill tells something of its own."""

    RUN_CREATED = "run-created"
    EPOCH_OPENED = "epoch-opened"
    INTENT_COMMITTED = "intent-committed"
    MOVE_SENT = "move-sent"
    IN_POSITION = "in-position"
    ACQUIRING = "acquiring"
    BEFORE_COMMIT = "before-commit"
    AFTER_COMMIT = "after-commit"
    BEFORE_CHECKPOINT = "before-checkpoint"
    PAUSED = "paused"
    HELD = "held"
    ENDING = "ending"
    MADE_SAFE = "made-safe"
    SOLVED = "solved"
    SETS_WRITTEN = "sets-written"
    PUBLISHED = "published"
    REPORTED = "reported"


def crash_point(point: CrashPoint) -> None:
    """Die here where a test asked for it; otherwise one look at the environment."""
    wanted = os.environ.get(VARIABLE)
    if wanted is not None:
        _count_down(point, wanted)


def refuse_crash_points(real_ports: Sequence[str]) -> None:
    """Raise RequestRefused where the variable is set and a port that is not a twin's would be opened."""
    if VARIABLE in os.environ and real_ports:
        raise RequestRefused(
            f"{real_ports[0]}: {VARIABLE} is set to {os.environ[VARIABLE]!r}: it kills the program in the middle of its"
            " work, and is allowed only where every device is a twin; nothing was opened; unset it"
        )


def _count_down(point: CrashPoint, wanted: str) -> None:
    name, _, left = wanted.partition(":")
    if name not in (ANY, point):
        return
    if int(left) <= 1:
        os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))  # of Windows: ends it as hard
    os.environ[VARIABLE] = f"{name}:{int(left) - 1}"
