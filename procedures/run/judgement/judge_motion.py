"""Is a dwell with motion, a field or a stream good. Pure: values in, reasons out.

* samples: as many as were asked for, none missing, none twice, none in doubt, each finite; one gap voids the dwell.
* scatter: a sensor that scattered in the dwells before and now reads one number over and over is stuck. One that always
  reads one number may be too coarse for its noise: nothing can be said.
* position: at rest before and after, seated, homed, no fault; what was reached is what a reference told, where there is
  one, within its tolerance and three of its standard uncertainties.
* temperature as everywhere.

The rate itself is watched while the axis turns (:mod:`procedures.run.dwell.turning`): out of its band it is a fault
of the machine, not of a dwell.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from procedures.plan.steps import Dwell, Follow, Turn
from procedures.records.dwells import ChannelReading, Measurement, NoiseReference, StreamTiming
from procedures.run.judgement.judge import Limits, at_rest, judge, temperature
from rig.description.rig_file import AttitudeReference

FEWEST_SAMPLES_STUCK = 5
_SIGMAS = 3.0


def judge_dwell(
    dwell: Dwell, measured: Measurement, limits: Limits, noise: NoiseReference, reference: AttitudeReference | None
) -> tuple[str, ...]:
    """Every reason to reject the dwell, of whatever kind it is; empty where it is good."""
    if measured.motion is None:
        return judge(measured, limits, noise)
    return (
        *([] if measured.is_settled else [f"not settled after {measured.settle_s:.3g} s"]),
        *(reason for timing in measured.motion.streams for reason in _stream(timing)),
        *(reason for reading in measured.readings.values() for reason in _reading(reading, noise)),
        *_position(dwell, measured, limits, reference),
        *temperature(measured.before, limits, "before"),
        *temperature(measured.after, limits, "after"),
    )


def _stream(timing: StreamTiming) -> Iterator[str]:
    lost = {"missing": timing.missing, "sent twice": timing.doubled, "in doubt": timing.doubtful}
    told = ", ".join(f"{count} {what}" for what, count in lost.items() if count)
    if told:
        yield f"{timing.stream}: of {timing.samples} samples {told} ({timing.first_gap}), allowed none"


def _reading(reading: ChannelReading, noise: NoiseReference) -> Iterator[str]:
    bad = int(np.count_nonzero(~np.isfinite(reading.samples)))
    if bad:
        yield f"{reading.channel}: {bad} of {reading.samples.size} readings overloaded"
    elif _stands_still(reading) and noise.standard_deviation(reading.channel):
        yield f"{reading.channel}: stuck: {reading.samples.size} times {reading.samples[0]:g}"


def _stands_still(reading: ChannelReading) -> bool:
    """Of a sensor; an axis that takes no part in a motion stands where it is."""
    is_axis = reading.channel.startswith("axes.")
    return not is_axis and reading.samples.size >= FEWEST_SAMPLES_STUCK and float(np.ptp(reading.samples)) == 0.0


def _position(
    dwell: Dwell, measured: Measurement, limits: Limits, reference: AttitudeReference | None
) -> Iterator[str]:
    moved = _moved(dwell)
    told = measured.told_deg or {}
    reached = {} if reference is None else told
    expected: Mapping[str, float] = {
        name: target for name, target in limits.targets_deg.items() if name not in moved and name not in reached
    }
    yield from at_rest(measured.before, limits, "before", expected)
    yield from at_rest(measured.after, limits, "after", expected)
    if reference is None or not reference.closes_loop:
        return
    allowed_deg = reference.tolerance_deg + _SIGMAS * reference.uncertainty_deg
    for name, angle_deg in reached.items():
        off_deg = (angle_deg - limits.targets_deg[name] + 180.0) % 360.0 - 180.0
        if abs(off_deg) > allowed_deg:
            yield f"{name}: the reference tells {angle_deg:.4g} deg, allowed within {allowed_deg:.3g} deg of its target"


def _moved(dwell: Dwell) -> frozenset[str]:
    match dwell.motion:
        case Turn():
            return frozenset((dwell.motion.turned_axis,))
        case Follow():
            return frozenset(dwell.motion.span_deg)
    return frozenset()
