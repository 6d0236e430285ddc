"""Did the interruption make a step: the check set after a restart against the one from the start.

One t-test a channel and attitude, at 1e-6 two-sided. Its scatter is the larger of two: that of a mean of samples
within a dwell, and that between visits to the same attitude (reseating, drift) where at least six degrees of freedom
show it. So a rig that drifts or reseats loosely is not called broken for it, and one that does neither is judged
finely.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from procedures.records.dwells import DwellRecord
from procedures.statistics import t_limit

FALSE_ALARM = 1e-6
FEWEST_DEGREES = 6


@dataclass(frozen=True, slots=True)
class RestartComparison:
    """One channel at one check attitude, before and after."""

    step: int
    channel: str
    change_v: float
    standard_error_v: float
    t: float
    t_limit: float

    @property
    def is_step(self) -> bool:
        return abs(self.t) > self.t_limit

    @property
    def departure(self) -> float:
        """How far beyond its limit: t over the limit, 0 where nothing judges it."""
        return 0.0 if self.t_limit == inf else abs(self.t) / self.t_limit


@dataclass(frozen=True, slots=True)
class Scatter:
    """Variance of a dwell's mean and how well it is known."""

    variance_v2: float
    degrees_of_freedom: int


def compare(
    before: Mapping[int, DwellRecord], after: Mapping[int, DwellRecord], visits: Iterable[DwellRecord]
) -> tuple[RestartComparison, ...]:
    """Compare every channel at every check attitude.

    ``visits``: accepted dwells before the restart, for the scatter between.
    """
    between = _between_visits(visits)
    pairs = [(step, before[step], dwell) for step, dwell in after.items() if step in before]
    channels = list(pairs[0][2].readings) if pairs else []
    found = []
    for channel in channels:
        scatter = _scatter(channel, pairs, between)
        for step, old, new in pairs:
            change_v = new.readings[channel].mean - old.readings[channel].mean
            found.append(_comparison(step, channel, change_v, scatter))
    return tuple(found)


def strongest(found: Iterable[RestartComparison]) -> RestartComparison:
    """Return the one that is told of all: what departs most from its limit, not what changed by most volts.

    Sensors of one run may differ a hundredfold in sensitivity and noise.
    """
    return max(found, key=lambda comparison: comparison.departure)


def _comparison(step: int, channel: str, change_v: float, scatter: Scatter) -> RestartComparison:
    error_v = sqrt(2.0 * scatter.variance_v2)
    limit = t_limit(scatter.degrees_of_freedom, FALSE_ALARM) if scatter.degrees_of_freedom > 0 else inf
    t = change_v / error_v if error_v > 0.0 else 0.0 if change_v == 0.0 else inf
    return RestartComparison(step, channel, change_v, error_v, t, limit)


def _scatter(
    channel: str, pairs: list[tuple[int, DwellRecord, DwellRecord]], between: Mapping[str, Scatter]
) -> Scatter:
    readings = [dwell.readings[channel] for _, old, new in pairs for dwell in (old, new)]
    degrees = sum(reading.samples.size - 1 for reading in readings)
    squares = sum(float(((reading.samples - reading.mean) ** 2).sum()) for reading in readings)
    samples = min(reading.samples.size for reading in readings)
    within = Scatter(squares / degrees / samples if degrees else 0.0, degrees)
    other = between.get(channel, Scatter(0.0, 0))
    is_known = other.degrees_of_freedom >= FEWEST_DEGREES and other.variance_v2 > within.variance_v2
    return other if is_known else within


def _between_visits(visits: Iterable[DwellRecord]) -> dict[str, Scatter]:
    """Return channel to the pooled variance of dwell means at the same attitude."""
    means: dict[str, dict[tuple[tuple[str, float], ...], list[float]]] = defaultdict(lambda: defaultdict(list))
    for dwell in visits:
        attitude = tuple(dwell.targets_deg.items())
        for channel, reading in dwell.readings.items():
            means[channel][attitude].append(reading.mean)
    return {channel: _pooled([np.array(group) for group in groups.values()]) for channel, groups in means.items()}


def _pooled(groups: list[np.ndarray[tuple[int], np.dtype[np.float64]]]) -> Scatter:
    degrees = sum(group.size - 1 for group in groups)
    squares = sum(float(((group - group.mean()) ** 2).sum()) for group in groups)
    return Scatter(squares / degrees if degrees else 0.0, degrees)
