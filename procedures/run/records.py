"""What the journal holds, as values: the vocabulary between engine, journal, report and solver."""

from collections.abc import Mapping
from dataclasses import dataclass
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
