"""What the journal holds, as values: the vocabulary between engine, journal, report and solver."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class ChannelReading:
    """One channel over one dwell: the raw samples and what follows from them."""

    channel: str
    """Full name, ``readout.channel``."""
    samples_v: NDArray[np.float64]
    """(n,) as read, in order, NaN where overloaded."""
    started_s: float
    interval_s: float

    @property
    def mean_v(self) -> float:
        return float(self.samples_v.mean())

    @property
    def standard_deviation_v(self) -> float:
        return float(self.samples_v.std(ddof=1)) if self.samples_v.size > 1 else float("nan")


@dataclass(frozen=True, slots=True)
class StreamTiming:
    """How the samples of one stream lie in rig time, and what is missing among them."""

    stream: str
    samples: int
    offset_s: float
    """Rig time less device time at the middle of the dwell, by the stamps of least delay."""
    offset_uncertainty_s: float
    drift: float
    """How much faster rig time runs than the device's, as part of it."""
    drift_uncertainty: float
    missing: int
    doubled: int
    doubtful: int
    """Gaps of unknown length, and lines that were no sample."""
    first_gap: str
    """Where and why; empty where there is none."""


@dataclass(frozen=True, slots=True)
class MotionRecord:
    """What a dwell with motion, a field or a reference has beside its readings."""

    rates_dps: Mapping[str, float] = field(default_factory=dict)
    """Axis to its mean rate while it was read, from position and time."""
    rate_uncertainty_dps: Mapping[str, float] = field(default_factory=dict)
    """Standard."""
    turned_deg: float = 0.0
    attitude_uncertainty_deg: Mapping[str, float] = field(default_factory=dict)
    """Standard, of a measured attitude that a reference sensor told."""
    commanded_deg: Mapping[str, float] = field(default_factory=dict)
    """Where the axes stood by their own read-back when a reference told where they are."""
    field_ut: Mapping[str, float] = field(default_factory=dict)
    """Coil to the field that stood."""
    streams: tuple[StreamTiming, ...] = ()


@dataclass(frozen=True, slots=True)
class DwellRecord:
    """One judged dwell, accepted or rejected with its reasons."""

    step: int
    purpose: str
    replication: int
    point: int
    attempt: int
    """1-based judged attempt of this step."""
    epoch: int
    """1-based; each restart of the run opens a new one."""
    accepted: bool
    reasons: tuple[str, ...]
    """Why it was rejected, or what is remarkable about an accepted one."""
    targets_deg: Mapping[str, float]
    measured_deg: Mapping[str, float]
    """Read back, mean of before and after the readings."""
    temperature_degc: Mapping[str, float]
    """Environment name to the mean of before and after; empty where none is declared."""
    readings: Mapping[str, ChannelReading]
    started_utc: datetime
    ended_utc: datetime
    started_s: float
    """Rig seconds (monotonic) since the run's clock started; comparable within one epoch."""
    ended_s: float
    settle_s: float
    sha256: str
    """Over everything but itself, as stored; empty before it is stored."""
    mounting: int = 1
    """1-based; a package that was moved begins a new one, with a coning angle and azimuth of its own."""
    motion: MotionRecord | None = None


@dataclass(frozen=True, slots=True)
class Event:
    """One line of the audit trail, hash-chained to the line before."""

    sequence: int
    utc: datetime
    monotonic_s: float
    kind: str
    """Such as ``state``, ``intent``, ``request``, ``note``, ``trip``, ``opened``."""
    detail: Mapping[str, object]
    sha256: str
