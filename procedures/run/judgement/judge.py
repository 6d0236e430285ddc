"""Is a dwell good: by its own readings, by those before it, by position and temperature. Pure: values in, reasons out.

A dwell without a reason is accepted. A reason rejects it: it stays in the journal and is measured again; when the
retries are used up the run holds, because nothing suspect is ever accepted silently.

* overload: one reading suffices.
* noise: scatter above ``max_noise_factor`` × the reference, the running median of accepted dwells' scatter, corrected
  for the median of χ² so that it estimates σ at any number of samples; judged from the fifth dwell on. The limit is
  never below what chance gives a channel once in a hundred thousand dwells: the scatter of few readings scatters
  itself, and so does a reference learnt from few dwells (F).
* stuck: scatter so far below the reference that chance gives it once in ten million readings of a channel (for 3
  samples a tenth of the variance would be a false alarm in 9.5 % of dwells, so the limit follows from their number).
* slope: a line over time through the samples, at 1e-5, from four samples on; where the reference is known, the line
  must rise out of that noise as well. A drift through three samples shows as noise.
* position: read back before and after, within the arrival tolerance, at rest, seated, homed, no fault.
* temperature: finite, and within the band where the plan has one.

What is recorded along a motion, in a field or by streams is judged likewise, but for what there is no measure of:

* samples: as many as were asked for, none missing, none twice, none in doubt, each finite; one gap voids the dwell.
* scatter: a sensor that scattered in the dwells before and now reads one number over and over is stuck. One that always
  reads one number may be too coarse for its noise: nothing can be said.
* position: what was reached is what a reference told, where there is one, within its tolerance and three of its
  standard uncertainties.

The rate itself is watched while the axis turns (:mod:`procedures.run.dwell.turning`): out of its band it is a fault
of the machine, not of a dwell.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np

from ams.frames import wrap_deg
from procedures.plan.steps import Dwell, Follow, Turn
from procedures.records.dwells import ChannelReading, Look, Measurement, NoiseReference, StreamTiming
from procedures.statistics import has_slope, small_variance_ratio, t_limit
from rig.description.rig_file import AttitudeReference

SLOPE_FALSE_ALARM = 1e-5
NOISE_FALSE_ALARM = 1e-5
STUCK_FALSE_ALARM = 1e-7
EPSILON = float(np.finfo(float).eps)
LARGEST_RATE_ERROR = 0.01
"""Of a stream: quartz keeps its rate a hundred times better."""
SETTLED_DEGREES = 30
"""Of the reference, for the least that a line must rise: beside the line's own test it needs no better."""
FEWEST_SAMPLES_STUCK = 5
"""Of a stream, before equal samples mean that it is stuck."""
_SIGMAS = 3.0


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


def judge_dwell(
    dwell: Dwell, measured: Measurement, limits: Limits, noise: NoiseReference, reference: AttitudeReference | None
) -> tuple[str, ...]:
    """Return every reason to reject the dwell, of whatever kind it is; empty where it is good."""
    if measured.motion is None:
        return judge(measured, limits, noise)
    return (
        *_settling(measured),
        *(reason for timing in measured.motion.streams for reason in _stream(timing)),
        *(reason for reading in measured.readings.values() for reason in _recorded(reading, noise)),
        *_position(dwell, measured, limits, reference),
        *temperature(measured.before, limits, "before"),
        *temperature(measured.after, limits, "after"),
    )


def judge(measured: Measurement, limits: Limits, noise: NoiseReference) -> tuple[str, ...]:
    """Return every reason to reject a dwell that rests and is read by readouts; empty where it is good."""
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
    reference_v, least_rise_v = noise.standard_deviation(reading.channel), 0.0
    if reference_v is not None and reading.samples.size > 1:
        by_chance_v = noise.largest_by_chance(reading.channel, reading.samples.size - 1, NOISE_FALSE_ALARM) or 0.0
        yield from _scatter(reading, reference_v, limits.max_noise_factor, by_chance_v)
        least_rise_v = reference_v * t_limit(SETTLED_DEGREES, SLOPE_FALSE_ALARM)
    times_s = reading.started_s + reading.interval_s * np.arange(reading.samples.size, dtype=np.float64)
    if has_slope(times_s, reading.samples, SLOPE_FALSE_ALARM, least_rise_v):
        yield f"{reading.channel}: the readings drift within the dwell"


def _scatter(reading: ChannelReading, reference_v: float, max_noise_factor: float, by_chance_v: float) -> Iterable[str]:
    scatter_v, rounding_v = reading.standard_deviation, 4.0 * EPSILON * float(np.abs(reading.samples).max())
    reference_v = max(reference_v, rounding_v)
    allowed_v = max(max_noise_factor * reference_v, by_chance_v)
    least_v = reference_v * sqrt(small_variance_ratio(reading.samples.size - 1, STUCK_FALSE_ALARM))
    if scatter_v > allowed_v:
        yield (
            f"{reading.channel}: noise: standard deviation {scatter_v:.3g} V, allowed "
            f"{allowed_v:.3g} V ({allowed_v / reference_v:.3g} × that of the dwells before)"
        )
    elif scatter_v < least_v and reference_v > rounding_v:
        yield f"{reading.channel}: stuck: standard deviation {scatter_v:.3g} V, expected about {reference_v:.3g} V"


def at_rest(look: Look, limits: Limits, when: str, expected_deg: Mapping[str, float]) -> Iterable[str]:
    """Yield every axis that is not at rest, not trusted, or not where it is expected, if it is."""
    for axis in limits.targets_deg:
        state, target_deg = look.axes[axis], expected_deg.get(axis)
        if target_deg is not None and abs(state.position_deg - target_deg) > limits.tolerance_deg[axis]:
            yield (
                f"{axis}: at {state.position_deg:g}° {when} the readings, allowed within "
                f"{limits.tolerance_deg[axis]:g}° of {target_deg:g}°"
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
    """Yield what is wrong with a temperature: not finite, or outside its band where the plan has one."""
    for name, degc in look.temperature_degc.items():
        band = limits.bands.get(name)
        if not isfinite(degc):
            yield f"{name}: no temperature {when} the readings"
        elif band is not None and abs(degc - band.setpoint_degc) > band.band_degc:
            yield (f"{name}: {degc:.2f} °C {when} the readings, allowed {band.setpoint_degc:g} ± {band.band_degc:g} °C")


def _stream(timing: StreamTiming) -> Iterable[str]:
    lost = {"missing": timing.missing, "sent twice": timing.doubled, "in doubt": timing.doubtful}
    losses = ", ".join(f"{count} {what}" for what, count in lost.items() if count)
    if losses:
        yield f"{timing.stream}: of {timing.samples} samples {losses} ({timing.first_gap}), allowed none"
    elif abs(timing.rate_error) > LARGEST_RATE_ERROR + 2.0 / timing.samples:
        yield (
            f"{timing.stream}: samples come {1.0 + timing.rate_error:.4g} times as fast as the rig file states, "
            f"allowed within {LARGEST_RATE_ERROR:.0%}; correct streams.{timing.stream}: rate_hz, or the device"
        )


def _recorded(reading: ChannelReading, noise: NoiseReference) -> Iterable[str]:
    bad = int(np.count_nonzero(~np.isfinite(reading.samples)))
    if bad:
        yield f"{reading.channel}: {bad} of {reading.samples.size} readings overloaded"
    elif _stands_still(reading) and noise.standard_deviation(reading.channel):
        yield f"{reading.channel}: stuck: {reading.samples.size} times {reading.samples[0]:g}"


def _stands_still(reading: ChannelReading) -> bool:
    """Return True for a sensor that stands still; an axis that takes no part in a motion stands where it is."""
    is_axis = reading.channel.startswith("axes.")
    return not is_axis and reading.samples.size >= FEWEST_SAMPLES_STUCK and float(np.ptp(reading.samples)) == 0.0


def _position(
    dwell: Dwell, measured: Measurement, limits: Limits, reference: AttitudeReference | None
) -> Iterable[str]:
    moved = _moved(dwell)
    reference_deg = measured.reference_deg or {}
    reached = {} if reference is None else reference_deg
    expected: Mapping[str, float] = {
        name: target for name, target in limits.targets_deg.items() if name not in moved and name not in reached
    }
    yield from at_rest(measured.before, limits, "before", expected)
    yield from at_rest(measured.after, limits, "after", expected)
    if reference is None or not reference.closes_loop:
        return
    allowed_deg = reference.tolerance_deg + _SIGMAS * reference.uncertainty_deg
    for name, angle_deg in reached.items():
        off_deg = wrap_deg(angle_deg - limits.targets_deg[name])
        if abs(off_deg) > allowed_deg:
            yield f"{name}: the reference tells {angle_deg:.4g}°, allowed within {allowed_deg:.3g}° of its target"


def _moved(dwell: Dwell) -> frozenset[str]:
    match dwell.motion:
        case Turn():
            return frozenset((dwell.motion.turned_axis,))
        case Follow():
            return frozenset(dwell.motion.span_deg)
    return frozenset()
