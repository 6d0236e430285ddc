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
class Turn:
    """Turn one axis at a constant rate while reading: whole revolutions, or sweeps between two angles."""

    turned_axis: str
    rate_dps: float
    """Signed; what is measured counts, not this."""
    seconds: float
    """Of reading, all sweeps together."""
    revolutions: int
    """Whole ones; 0 where the axis sweeps."""
    sweep_deg: tuple[float, float] | None
    """From and to, in the sense of the rate; the axis returns between sweeps."""
    sweeps: int
    tolerance: float
    """How far the measured rate may be from the rate, as part of it; beyond, the axis is at fault."""


@dataclass(frozen=True, slots=True)
class Follow:
    """Lead several axes along a motion over time while streams are recorded."""

    shape: Literal["ramp", "harmonic"]
    seconds: float
    span_deg: Mapping[str, float]
    """Axis to its amplitude (harmonic), or to where it goes from its start (ramp)."""
    frequency_hz: Mapping[str, float]
    """Of harmonic motion, by axis."""
    update_s: float
    """Between two commands to an axis."""
    bin_s: float
    """One row of the solution: the mean rate and the mean reading over so long."""


@dataclass(frozen=True, slots=True)
class Rest:
    """Record at rest for so long."""

    rest_seconds: float


@dataclass(frozen=True, slots=True)
class Applied:
    """A magnetic field that stands during the dwell."""

    coil: str
    field_ut: float
    """Along the coil's direction."""


Motion = Turn | Follow | Rest


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
    motion: Motion | None = None
    """What is done at that attitude while reading; None: it rests and ``[dwell]`` says how it is read."""
    applied: Applied | None = None


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
