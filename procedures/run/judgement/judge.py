"""Is a dwell good: by its own readings, by those before it, by position and temperature. Pure: values in, reasons out.

A dwell without a reason is accepted. A reason rejects it: it stays in the journal and is measured again; when the
retries are used up the run holds, because nothing suspect is ever accepted silently.

* overload: one reading suffices.
* noise: scatter above ``max_noise_factor`` × the reference, the running median of accepted dwells' scatter, corrected
  for the median of χ² so that it estimates σ at any number of samples; judged from the fifth dwell on.
* stuck: scatter so far below the reference that chance gives it once in ten million readings of a channel (for 3
  samples a tenth of the variance would be a false alarm in 9.5 % of dwells, so the limit follows from their number).
* slope: a line over time through the samples, at 1e-5.
* position: read back before and after, within the arrival tolerance, at rest, seated, homed, no fault.
* temperature: finite, and within the band where the plan has one.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np

from procedures.records.dwells import ChannelReading, Look, Measurement, NoiseReference
from procedures.statistics import has_slope, small_variance_ratio

SLOPE_FALSE_ALARM = 1e-5
STUCK_FALSE_ALARM = 1e-7
EPSILON = float(np.finfo(float).eps)
"""So many accepted dwells make a reference."""


@dataclass(frozen=True, slots=True)
class Band:
    """Where a temperature has to be."""

    setpoint_degc: float
    band_degc: float


@dataclass(frozen=True, slots=True)
class Limits:
    """What a dwell is judged against."""

    targets_deg: Mapping[str, float]
    tolerance_deg: Mapping[str, float]
    max_noise_factor: float
    bands: Mapping[str, Band]


def judge(measured: Measurement, limits: Limits, noise: NoiseReference) -> tuple[str, ...]:
    """Every reason to reject the dwell; empty where it is good."""
    return (
        *_settling(measured),
        *(reason for reading in measured.readings.values() for reason in _reading(reading, limits, noise)),
        *at_rest(measured.before, limits, "before", limits.targets_deg),
        *at_rest(measured.after, limits, "after", limits.targets_deg),
        *temperature(measured.before, limits, "before"),
        *temperature(measured.after, limits, "after"),
    )


def _settling(measured: Measurement) -> Iterable[str]:
    if not measured.is_settled:
        yield f"not settled after {measured.settle_s:.3g} s"


def _reading(reading: ChannelReading, limits: Limits, noise: NoiseReference) -> Iterable[str]:
    overloads = int(np.count_nonzero(~np.isfinite(reading.samples)))
    if overloads:
        yield f"{reading.channel}: {overloads} of {reading.samples.size} readings overloaded"
        return
    reference_v = noise.standard_deviation(reading.channel)
    if reference_v is not None and reading.samples.size > 1:
        yield from _scatter(reading, reference_v, limits.max_noise_factor)
    times_s = reading.started_s + reading.interval_s * np.arange(reading.samples.size, dtype=np.float64)
    if has_slope(times_s, reading.samples, SLOPE_FALSE_ALARM):
        yield f"{reading.channel}: the readings drift within the dwell"


def _scatter(reading: ChannelReading, reference_v: float, max_noise_factor: float) -> Iterable[str]:
    scatter_v, rounding_v = reading.standard_deviation, 4.0 * EPSILON * float(np.abs(reading.samples).max())
    reference_v = max(reference_v, rounding_v)
    least_v = reference_v * sqrt(small_variance_ratio(reading.samples.size - 1, STUCK_FALSE_ALARM))
    if scatter_v > max_noise_factor * reference_v:
        yield (
            f"{reading.channel}: noise: standard deviation {scatter_v:.3g} V, allowed "
            f"{max_noise_factor * reference_v:.3g} V ({max_noise_factor:g} × that of the dwells before)"
        )
    elif scatter_v < least_v and reference_v > rounding_v:
        yield f"{reading.channel}: stuck: standard deviation {scatter_v:.3g} V, expected about {reference_v:.3g} V"


def at_rest(look: Look, limits: Limits, when: str, expected_deg: Mapping[str, float]) -> Iterable[str]:
    """Every axis at rest and trusted, and where it is expected, if it is."""
    for axis in limits.targets_deg:
        state, target_deg = look.axes[axis], expected_deg.get(axis)
        if target_deg is not None and abs(state.position_deg - target_deg) > limits.tolerance_deg[axis]:
            yield (
                f"{axis}: at {state.position_deg:g} deg {when} the readings, allowed within "
                f"{limits.tolerance_deg[axis]:g} deg of {target_deg:g} deg"
            )
        for is_wrong, what in (
            (state.is_moving, "moving"),
            (not state.is_seated, "not seated"),
            (not state.is_homed, "not homed"),
            (bool(state.fault), f"at fault ({state.fault})"),
        ):
            if is_wrong:
                yield f"{axis}: {what} {when} the readings"


def temperature(look: Look, limits: Limits, when: str) -> Iterable[str]:
    """Finite, and inside its band where the plan has one."""
    for name, degc in look.temperature_degc.items():
        band = limits.bands.get(name)
        if not isfinite(degc):
            yield f"{name}: no temperature {when} the readings"
        elif band is not None and abs(degc - band.setpoint_degc) > band.band_degc:
            yield (
                f"{name}: {degc:.2f} degC {when} the readings, allowed {band.setpoint_degc:g} ± {band.band_degc:g} degC"
            )
