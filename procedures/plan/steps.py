"""Steps: the plan as data. A list that can be printed, hashed, estimated, rehearsed and stored.

Steps name devices; they hold none.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Purpose = Literal["design", "reference", "check"]
"""``design``: enters the solution. ``reference``: the repeated reference attitude. ``check``: the six-attitude check
set, measured at the start and again after every restart."""


@dataclass(frozen=True, slots=True)
class Dwell:
    """Go to an attitude, let it settle, read every channel, judge."""

    step: int
    """0-based place in the plan; the twin's chance is drawn by it and the journal refers to it."""
    purpose: Purpose
    replication: int
    """1-based; 0 for the check set."""
    point: int
    """1-based label of the design point; 0 where it is no design point."""
    targets_deg: Mapping[str, float]
    """Axis name to attitude, in the order in which the axes move."""


@dataclass(frozen=True, slots=True)
class Soak:
    """Bring an environment to a plateau and hold it there before going on."""

    step: int
    plateau: int
    environment: str
    setpoint_degc: float
    band_degc: float
    soak_s: float


Step = Dwell | Soak
