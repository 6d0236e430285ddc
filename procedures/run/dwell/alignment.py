"""When a streamed sample was taken, in rig time: a straight line through the stamps of least delay.

A poll's time is never before the sample that it brings, but may be long behind it. So the record is cut into pieces
and of each piece only the stamp of least delay is kept; the line through those gives offset and drift of the device's
clock against the rig's, and their scatter says how well they are known. A delay that every sample has (the time of a
line on the wire) looks like an offset and is part of its uncertainty.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from ams.arrays import FloatArray, IntArray
from procedures.records.dwells import StreamTiming
from procedures.run.dwell.stream_recorder import Recording

PIECES, FEWEST_PIECES = 24, 4
POLLS_A_PIECE = 8
KNOWN_DRIFT = 2e-3
"""A drift of the device's clock counts where its standard uncertainty is no larger."""


@dataclass(frozen=True)
class Alignment:
    """rig time = device time + offset + drift · (device time − middle)."""

    offset_s: float
    offset_uncertainty_s: float
    """Standard."""
    drift: float
    drift_uncertainty: float
    middle_s: float

    def rig_s(self, device_s: FloatArray) -> FloatArray:
        return np.asarray(device_s + self.offset_s + self.drift * (device_s - self.middle_s))


def align(recording: Recording, latency_s: float = 0.0) -> Alignment:
    """Fit the line for one recording.

    ``latency_s``: at most so long is a sample under way before it can be polled.
    """
    device_s = recording.device_s[recording.last_of_poll]
    middle_s = float(recording.device_s.mean()) if recording.samples else 0.0
    delays_s = recording.polled_s - device_s
    if delays_s.size == 0:
        return Alignment(0.0, float("inf"), 0.0, float("inf"), middle_s)
    least = _least(device_s, delays_s)
    times_s, least_s = device_s[least] - middle_s, delays_s[least]
    if least.size < FEWEST_PIECES:
        spread_s = float(np.ptp(delays_s)) + latency_s + 1.0 / recording.rate_hz
        return Alignment(float(least_s.min()), spread_s / sqrt(3.0), 0.0, float("inf"), middle_s)
    centred_s = times_s - times_s.mean()
    spread = float(centred_s @ centred_s)
    drift = float(centred_s @ least_s) / spread
    rest_s = least_s - least_s.mean() - drift * centred_s
    scatter_s = sqrt(float(rest_s @ rest_s) / (least.size - 2))
    excess_s = _excess_s(delays_s - drift * (device_s - middle_s), least.size)
    offset_s = float(least_s.mean()) - drift * float(times_s.mean()) - excess_s
    drawn_s = sqrt(scatter_s**2 / least.size + excess_s**2)
    return Alignment(
        offset_s=offset_s - 0.5 * latency_s,
        offset_uncertainty_s=sqrt(drawn_s**2 + latency_s**2 / 12.0),
        drift=drift,
        drift_uncertainty=scatter_s / sqrt(spread),
        middle_s=middle_s,
    )


def timing(recording: Recording, alignment: Alignment) -> StreamTiming:
    """Return what the journal keeps of a recording's timing."""
    gaps = recording.gaps
    first = next(iter(gaps), None)
    return StreamTiming(
        stream=recording.stream,
        samples=recording.samples,
        offset_s=alignment.offset_s,
        offset_uncertainty_s=_finite(alignment.offset_uncertainty_s),
        drift=alignment.drift,
        drift_uncertainty=_finite(alignment.drift_uncertainty),
        missing=sum(gap.missing or 0 for gap in gaps),
        doubled=sum(gap.missing == 0 for gap in gaps),
        doubtful=sum(gap.missing is None for gap in gaps),
        first_gap="" if first is None else f"before sample {first.at}: {first.why}",
        rate_error=_rate_error(recording, alignment),
    )


def _rate_error(recording: Recording, alignment: Alignment) -> float:
    """Return how far samples come faster than the rig file states, by rig time, as a part of it.

    Where the poll times do not tell the drift of the device's clock, that clock is believed.
    """
    if recording.samples < FEWEST_PIECES:
        return 0.0
    intervals = recording.samples - 1 + sum(gap.missing or 0 for gap in recording.gaps)
    drift = alignment.drift if alignment.drift_uncertainty <= KNOWN_DRIFT else 0.0
    took_s = float(recording.device_s[-1] - recording.device_s[0]) * (1.0 + drift)
    return intervals / took_s / recording.rate_hz - 1.0 if took_s > 0.0 else 0.0


def _least(device_s: FloatArray, delays_s: FloatArray) -> IntArray:
    """Index of the least delay in each piece of the record."""
    pieces = min(PIECES, delays_s.size // POLLS_A_PIECE) or 1
    edges = np.linspace(device_s[0], device_s[-1], pieces + 1)[1:-1]
    groups = np.split(np.arange(delays_s.size), np.searchsorted(device_s, edges))
    return np.array([group[np.argmin(delays_s[group])] for group in groups if group.size], dtype=np.int64)


def _excess_s(delays_s: FloatArray, pieces: int) -> float:
    """Estimate how far a least delay of evenly spread ones lies above the true least.

    The spread over their number and one.
    """
    return float(np.ptp(delays_s)) / (delays_s.size / pieces + 1.0)


def _finite(value: float) -> float:
    """JSON has no infinity: an uncertainty that nothing tells is said as a year."""
    return min(value, 3.15e7)
