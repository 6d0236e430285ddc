"""What the journal holds, as values: the vocabulary between engine, journal, report and solver."""

from array import array
from bisect import insort
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from math import isfinite, sqrt

import numpy as np

from ams.arrays import FloatArray
from ams.models.possible_temperature import impossible_temperatures
from procedures.statistics import degrees_of_median, large_deviation_ratio, median_variance_ratio
from rig.abilities.abilities import AxisState


@dataclass(frozen=True, slots=True)
class ChannelReading:
    """One channel over one dwell: the raw samples and what follows from them."""

    channel: str
    """Full name, ``readout.channel``."""
    samples: FloatArray
    """(n,) as read, in order, in ``unit``, NaN where overloaded."""
    started_s: float
    interval_s: float
    unit: str = "v"
    """As it is written in a key: ``v`` behind a meter, ``g``, ``dps``, ``ut`` or ``counts`` on a stream."""

    @property
    def mean(self) -> float:
        return float(np.add.reduce(self.samples) / self.samples.size)  # as numpy.mean does, without its ceremony

    @property
    def standard_deviation(self) -> float:
        return float(self.samples.std(ddof=1)) if self.samples.size > 1 else float("nan")


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
    rate_error: float = 0.0
    """Samples a second by rig time over those that the rig file states, less one; 0 where nothing tells."""


@dataclass(frozen=True, slots=True)
class MotionRecord:
    """What a dwell with motion, a field or a reference has beside its readings."""

    rates_dps: Mapping[str, float] = field(default_factory=dict)
    """Axis to its mean rate while it was read, from position and time."""
    rate_uncertainty_dps: Mapping[str, float] = field(default_factory=dict)
    """Standard."""
    turned_deg: float = 0.0
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


def without_readings(dwell: DwellRecord) -> DwellRecord:
    """Return what whoever keeps many dwells needs of one: its samples are many times the rest, and in the journal."""
    return replace(dwell, readings={})


def read_back_rad(dwells: Sequence[DwellRecord]) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Return the (K,) pitch, roll and yaw where dwells stood by their read-back; no yaw where none has that axis.

    An axis that is not there is at zero.
    """
    pitch, roll, yaw = (
        np.deg2rad([dwell.measured_deg.get(axis, 0.0) for dwell in dwells]) for axis in ("pitch", "roll", "yaw")
    )
    return pitch, roll, yaw if any("yaw" in dwell.measured_deg for dwell in dwells) else None


def measured_again(dwells: Sequence[DwellRecord]) -> list[bool]:
    """Return of each dwell whether its step was measured again later, whatever came of it."""
    last = {dwell.step: at for at, dwell in enumerate(dwells)}
    return [at < last[dwell.step] for at, dwell in enumerate(dwells)]


def measured_design(dwells: Iterable[DwellRecord]) -> list[tuple[int, int]]:
    """Return step and replication of every dwell of the design that counts, in the order of time."""
    design = [dwell for dwell in dwells if dwell.accepted and dwell.purpose == "design"]
    return [(dwell.step, dwell.replication) for dwell in sorted(design, key=lambda dwell: (dwell.epoch, dwell.ended_s))]


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


FEWEST_DWELLS = 5
RECENT_DEGREES = 60
"""Of freedom, from which the noise of the latest dwells is pooled: known to 9 %, and followed within a few dwells."""


@dataclass(frozen=True, slots=True)
class Look:
    """Position and temperature at one moment."""

    axes: Mapping[str, AxisState]
    temperature_degc: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Measurement:
    """One dwell as it was read, not yet judged."""

    before: Look
    after: Look
    readings: Mapping[str, ChannelReading]
    is_settled: bool
    settle_s: float
    motion: MotionRecord | None = None
    """Of a dwell with motion, a field or a reference."""
    reference_deg: Mapping[str, float] | None = None
    """The attitude that a reference sensor told, which is better than the axes' own read-back."""

    def mean_position_deg(self) -> dict[str, float]:
        """Return the mean position of before and after the readings; a reference's where there is one."""
        after = self.after.axes
        reference = self.reference_deg or {}
        positions_deg = {
            name: 0.5 * (state.position_deg + after[name].position_deg) for name, state in self.before.axes.items()
        }
        return {**positions_deg, **reference}

    def mean_temperature_degc(self) -> dict[str, float]:
        """Return the mean temperature of before and after; what is not finite is left out.

        One of the two that no sensor stands is the temperature: in a mean it might pass for one.
        """
        after = self.after.temperature_degc
        means = {name: _mean_degc(degc, after[name]) for name, degc in self.before.temperature_degc.items()}
        return {name: degc for name, degc in means.items() if isfinite(degc)}


def _mean_degc(before_degc: float, after_degc: float) -> float:
    wild = impossible_temperatures(np.array([before_degc, after_degc]))
    return after_degc if wild[1] else before_degc if wild[0] else 0.5 * (before_degc + after_degc)


class NoiseReference:
    """The scatter that each channel is known to have, from the dwells accepted so far."""

    def __init__(self) -> None:
        self._variances_v2: dict[str, array[float]] = {}
        """Of every dwell, sorted."""
        self._degrees: dict[str, float] = {}
        self._pooled: dict[str, tuple[float, int]] = {}
        """Sum of squares and degrees of freedom, of all readings."""
        self._recent: dict[str, deque[tuple[float, int]]] = {}
        """The same, dwell by dwell, the latest last."""

    def learn(self, readings: Mapping[str, ChannelReading]) -> None:
        """Take an accepted dwell in."""
        for channel, reading in readings.items():
            degrees = reading.samples.size - 1
            if degrees >= 1:
                variance_v2 = reading.standard_deviation**2 / median_variance_ratio(degrees)
                insort(self._variances_v2.setdefault(channel, array("d")), variance_v2)
                self._degrees[channel] = self._degrees.get(channel, 0.0) + degrees_of_median(degrees)
                squares_v2, pooled = self._pooled.get(channel, (0.0, 0))
                of_dwell_v2 = degrees * reading.standard_deviation**2
                self._pooled[channel] = squares_v2 + of_dwell_v2, pooled + degrees
                recent = self._recent.setdefault(channel, deque(maxlen=RECENT_DEGREES))
                recent.append((of_dwell_v2, degrees))

    def standard_deviation(self, channel: str) -> float | None:
        """Return the standard deviation; None until enough dwells were accepted."""
        known = self._variances_v2.get(channel, array("d"))
        if len(known) < FEWEST_DWELLS:
            return None
        middle = len(known) // 2
        return sqrt(known[middle] if len(known) % 2 else (known[middle - 1] + known[middle]) / 2.0)

    def recent(self, channel: str) -> float | None:
        """Return the scatter that the latest dwells show together, a changed noise among them; None until enough.

        Squares and degrees of freedom are summed: the scatter of a single dwell would be known too poorly to act on.
        """
        squares_v2, degrees = 0.0, 0
        dwells = self._recent.get(channel, deque[tuple[float, int]]())
        for count, (of_dwell_v2, degrees_of_dwell) in enumerate(reversed(dwells), start=1):
            squares_v2, degrees = squares_v2 + of_dwell_v2, degrees + degrees_of_dwell
            if count >= FEWEST_DWELLS and degrees >= RECENT_DEGREES:
                break
        return sqrt(squares_v2 / degrees) if len(dwells) >= FEWEST_DWELLS else None

    def largest_by_chance(self, channel: str, degrees: int, false_alarm: float) -> float | None:
        """Return the scatter that a dwell as noisy as those before exceeds with probability ``false_alarm``.

        By the median, or by all readings where these tell it closer: a loud dwell among the first moves the latter only
        up, so that the former holds then.
        """
        by_median = self.standard_deviation(channel)
        if by_median is None:
            return None
        squares_v2, pooled = self._pooled[channel]
        return min(
            by_median * large_deviation_ratio(degrees, self._degrees[channel], false_alarm),
            sqrt(squares_v2 / pooled) * large_deviation_ratio(degrees, float(pooled), false_alarm),
        )


ANGLE, LOOKED, TAKEN = "angle_deg", "looked_s", "taken_s"
