"""Constant rates: turn, be at speed, read over whole revolutions or sweeps, come to rest again.

The rate that counts is the angle between two looks over their time, never the set value; it is watched all the time,
and an axis that is too fast, too slow or turns farther than it should is decelerated and at fault. Nothing is read
before the rate is inside its band.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import floor, hypot, inf, sqrt
from typing import cast

import numpy as np

from procedures.plan.plan import Plan
from procedures.plan.step_times import SWEEP_MARGIN
from procedures.plan.steps import Dwell, Turn
from procedures.records.dwells import ChannelReading, Measurement, MotionRecord, StreamTiming
from procedures.run.dwell.alignment import align, timing
from procedures.run.dwell.measure import Announcement, OpenRig, look, move, read_channel
from procedures.run.dwell.stream_recorder import Recorder, Recording, recording
from rig.abilities.abilities import RateAxis, Stream, SweepAxis, TurnLook, Wait
from rig.abilities.rates import measured_rate
from rig.cables.cable import CableGuard
from rig.errors import DeviceFault
from rig.motion.move import stop_all

LOOK_S = 0.5
"""Between two looks at a turning axis."""
SPEED_LIMIT_S = 60.0
"""To be at speed, at the latest."""
STEADY, STEADY_LOOKS = 0.25, 3
"""An axis whose rate changes by less than this part of its band, so many looks in a row, gathers speed no more."""
OVERSPEED, SLOWEST_BAND_DPS = 1.25, 0.02
SPARE_TURNS = 0.25
"""Beyond the revolutions that were asked for, ramps included; after that the axis runs away."""


@dataclass
class RateWatch:
    """Every look at one turning axis, judged as it comes."""

    axis: str
    turn: Turn
    step_deg: float
    """No read-back is finer."""
    taken: list[TurnLook] = field(default_factory=list)
    is_at_speed: bool = False
    _last_dps: float = inf
    _steady: int = 0

    def take(self, look: TurnLook) -> None:
        """Keep a look and check the rate since the one before. Raises: DeviceFault where the rate left its band."""
        before = self._before(look)
        self.taken.append(look)
        if before is None:
            return
        rate = measured_rate(before, look)
        limit_dps = max(OVERSPEED * abs(self.turn.rate_dps), abs(self.turn.rate_dps) + SLOWEST_BAND_DPS)
        slack_dps = rate.uncertainty_dps
        if abs(rate.rate_dps) > limit_dps + slack_dps:
            raise self.fault(f"turns at {rate.rate_dps:.4g} °/s, over its limit of {limit_dps:.4g} °/s")
        if self.is_at_speed and abs(rate.rate_dps - self.turn.rate_dps) > self.band_dps + slack_dps:
            raise self.fault(f"turns at {rate.rate_dps:.5g} °/s, {self._rate_in_words}")

    def reaches_speed(self, look: TurnLook) -> bool:
        """Return whether this look shows the axis at its rate; from the next one on the band counts."""
        before = self._before(look)
        self.take(look)
        if before is not None:
            rate = measured_rate(before, look)
            self.is_at_speed = abs(rate.rate_dps - self.turn.rate_dps) <= self.band_dps + rate.uncertainty_dps
            is_steady = abs(rate.rate_dps - self._last_dps) <= STEADY * self.band_dps
            self._steady = self._steady + 1 if is_steady else 0
            self._last_dps = rate.rate_dps
            if self._steady >= STEADY_LOOKS and not self.is_at_speed:
                raise self.fault(f"turns steadily at {rate.rate_dps:.5g} °/s, {self._rate_in_words}")
        return self.is_at_speed

    @property
    def _rate_in_words(self) -> str:
        return (
            f"asked for {self.turn.rate_dps:.5g} °/s, allowed within {self.band_dps:.3g} °/s (procedure file: "
            "rates.tolerance)"
        )

    @property
    def band_dps(self) -> float:
        """With what the resolution of the read-back alone may pretend between two looks."""
        return self.turn.tolerance * abs(self.turn.rate_dps) + 4.0 * self.step_deg / LOOK_S

    def measured(self, first: int) -> "Measured":
        """Mean rate from a look to the last one; its uncertainty from times and from the scatter about the line."""
        looks = self.taken[first:]
        rate = measured_rate(looks[0], looks[-1])
        times_s = np.array([look.taken_s for look in looks]) - looks[0].taken_s
        angles_deg = np.array([look.angle_deg for look in looks])
        rest_deg = angles_deg - np.polyval(np.polyfit(times_s, angles_deg, 1), times_s)
        scatter_deg = sqrt(float(rest_deg @ rest_deg) / max(len(looks) - 2, 1))
        reading_deg = max(scatter_deg, self.step_deg / sqrt(12.0))
        uncertainty_dps = hypot(rate.uncertainty_dps / sqrt(3.0), sqrt(2.0) * reading_deg / float(times_s[-1]))
        return Measured(rate.rate_dps, uncertainty_dps, rate.turned_deg)

    def _before(self, look: TurnLook) -> TurnLook | None:
        """Return the newest look that is long enough ago to tell a rate."""
        return next(
            (earlier for earlier in reversed(self.taken) if look.taken_s - earlier.taken_s >= 0.5 * LOOK_S), None
        )

    def fault(self, what: str) -> DeviceFault:
        return DeviceFault(
            f"{self.axis}: {what}; the axis was told to decelerate to rest; look at drive, load and settings, then home"
            " it"
        )


@dataclass(frozen=True)
class Measured:
    """A rate and what it rests on."""

    rate_dps: float
    uncertainty_dps: float
    turned_deg: float


def turn(rig: OpenRig, plan: Plan, dwell: Dwell, motion: Turn, announcement: Announcement, wait: Wait) -> Measurement:
    """Measure one dwell at a constant rate. The axis is at rest when this returns or raises.

    Raises: RequestRefused (before anything turned), DeviceFault (the axis, which was stopped), WaitEnded, RigError.
    """
    before = look(rig, dwell.targets_deg)
    with recording(streams_of(rig, plan), rig.clock, wait) as recorder:
        if motion.sweep_deg is None:
            done = _revolve(rig, plan, motion, announcement, recorder)
        else:
            done = _sweep(rig, plan, dwell, motion, announcement, recorder, wait)
    rates, uncertainties = dict.fromkeys(dwell.targets_deg, 0.0), dict.fromkeys(dwell.targets_deg, 0.0)
    rates[motion.turned_axis] = done.measured.rate_dps
    uncertainties[motion.turned_axis] = done.measured.uncertainty_dps
    record = MotionRecord(rates, uncertainties, done.measured.turned_deg, streams=done.streams)
    return Measurement(before, look(rig, dwell.targets_deg), done.readings, True, done.ramp_s, record)


@dataclass(frozen=True)
class _Done:
    measured: Measured
    readings: Mapping[str, ChannelReading]
    streams: tuple[StreamTiming, ...]
    ramp_s: float


def _revolve(rig: OpenRig, plan: Plan, motion: Turn, announcement: Announcement, recorder: Recorder) -> _Done:
    axis = cast("RateAxis", rig.axes[motion.turned_axis])
    axis.check_rate(motion.rate_dps)
    if isinstance(axis, CableGuard):
        axis.require_room(360.0 * (motion.revolutions + SPARE_TURNS) * (1.0 if motion.rate_dps > 0.0 else -1.0))
    watch = RateWatch(axis.name, motion, rig.axes[axis.name].arrival_tolerance_deg)
    began_s = rig.clock.monotonic_s()
    try:
        axis.start_rate(motion.rate_dps)
        ramp_s = _come_to_speed(rig, axis, watch, recorder)
        recorder.start()
        announcement.read(rig.chance)
        first = len(watch.taken)
        watch.take(axis.turn_look(rig.clock))
        readings = _read_voltages(rig, plan, axis, watch, recorder)
        _until_turned(rig, plan, axis, motion, watch, first, recorder)
        recordings = recorder.stop()
    finally:
        stop_and_see(rig, axis.name)
    wanted = {name: floor(motion.seconds * recording.rate_hz + 1e-6) for name, recording in recordings.items()}
    parts = {name: recording.part(0, wanted[name]) for name, recording in recordings.items()}
    aligned = tuple(timing(part, align(part)) for part in parts.values())
    return _Done(watch.measured(first), {**readings, **as_readings(parts, plan, began_s)}, aligned, ramp_s)


def _come_to_speed(rig: OpenRig, axis: RateAxis, watch: RateWatch, recorder: Recorder) -> float:
    began_s = rig.clock.monotonic_s()
    while not watch.reaches_speed(axis.turn_look(rig.clock)):
        if rig.clock.monotonic_s() - began_s > SPEED_LIMIT_S:
            raise DeviceFault(
                f"{axis.name}: not at {watch.turn.rate_dps:g} °/s after {SPEED_LIMIT_S:g} s; the axis was told to "
                "decelerate to rest; look at drive, load and settings"
            )
        recorder.wait(LOOK_S)
    return rig.clock.monotonic_s() - began_s


def _until_turned(
    rig: OpenRig, plan: Plan, axis: RateAxis, motion: Turn, watch: RateWatch, first: int, recorder: Recorder
) -> None:
    """Until the revolutions are whole and every stream has sent its samples."""
    whole_deg = 360.0 * motion.revolutions
    at_most_deg = whole_deg + 360.0 * SPARE_TURNS + 10.0 * abs(motion.rate_dps) * LOOK_S
    at_most_s = 2.0 * motion.seconds + SPEED_LIMIT_S
    began = watch.taken[first]
    while True:
        here = watch.taken[-1]
        turned_deg = abs(here.angle_deg - began.angle_deg)
        wanting = [
            name for name, stream in streams_of(rig, plan).items()
            if recorder.samples(name) < floor(motion.seconds * stream.rate_hz + 1e-6)
        ]  # fmt: skip
        if turned_deg >= whole_deg and not wanting:
            return
        if turned_deg > at_most_deg:
            waited = f"; {', '.join(wanting)} had not sent its samples: look at its rate_hz" if wanting else ""
            raise watch.fault(f"turned by {turned_deg:.1f}°, {whole_deg:g}° were asked for{waited}")
        if here.taken_s - began.taken_s > at_most_s:
            raise watch.fault(f"after {at_most_s:g} s turned by {turned_deg:.1f}° of {whole_deg:g}°")
        left_s = (whole_deg - turned_deg) / abs(motion.rate_dps)
        recorder.wait(min(max(left_s, 0.5 * LOOK_S), LOOK_S))
        watch.take(axis.turn_look(rig.clock))


def _read_voltages(
    rig: OpenRig, plan: Plan, axis: RateAxis, watch: RateWatch, recorder: Recorder
) -> dict[str, ChannelReading]:
    """Read every channel of a readout, one after the other, with a look behind each."""
    readings = {}
    for channel in plan.channels:
        if channel.partition(".")[0] in rig.readouts:
            readings[channel] = read_channel(rig, channel, plan.dwell.samples, recorder.wait, plan.dwell.nplc)
            watch.take(axis.turn_look(rig.clock))
    return readings


def _sweep(
    rig: OpenRig,
    plan: Plan,
    dwell: Dwell,
    motion: Turn,
    announcement: Announcement,
    recorder: Recorder,
    wait: Wait,
) -> _Done:
    """Measure as many sweeps in the one sense as the reading takes; the way back is not read."""
    assert motion.sweep_deg is not None
    axis = cast("SweepAxis", rig.axes[motion.turned_axis])
    axis.check_rate(motion.rate_dps)
    start_deg, end_deg = motion.sweep_deg
    parts: list[dict[str, Recording]] = []
    rates: list[Measured] = []
    began_s = rig.clock.monotonic_s()
    for number in range(motion.sweeps):
        move(rig, replace(dwell, targets_deg={**dwell.targets_deg, axis.name: start_deg}), wait)
        try:
            axis.start_sweep(end_deg, abs(motion.rate_dps))
            rate, recorded = _single_sweep(rig, plan, axis, motion, announcement.of_sweep(number), recorder)
        finally:
            stop_and_see(rig, axis.name)
        rates.append(rate)
        parts.append(recorded)
    joined = {name: [part[name] for part in parts] for name in parts[0]}
    readings = {
        name: reading for name, ones in joined.items() for name, reading in _joined(ones, plan, began_s).items()
    }
    aligned = tuple(_worst(ones) for ones in joined.values())
    return _Done(mean_of_sweeps(rates), readings, aligned, 0.0)


def mean_of_sweeps(rates: Sequence[Measured]) -> Measured:
    """Return the mean rate of sweeps that were measured one by one, and all that was turned."""
    count = len(rates)
    return Measured(
        sum(rate.rate_dps for rate in rates) / count,
        sqrt(sum(rate.uncertainty_dps**2 for rate in rates)) / count,
        sum(rate.turned_deg for rate in rates),
    )


def _single_sweep(
    rig: OpenRig, plan: Plan, axis: SweepAxis, motion: Turn, announcement: Announcement, recorder: Recorder
) -> tuple[Measured, dict[str, Recording]]:
    assert motion.sweep_deg is not None
    start_deg, end_deg = motion.sweep_deg
    margin_deg = SWEEP_MARGIN * abs(end_deg - start_deg)
    watch = RateWatch(axis.name, motion, rig.axes[axis.name].arrival_tolerance_deg)
    while not _is_inside(watch, axis.turn_look(rig.clock), start_deg, margin_deg):
        recorder.wait(LOOK_S)
    recorder.start()
    announcement.read(rig.chance)
    watch.is_at_speed = True
    first = len(watch.taken) - 1
    wanted = {
        name: floor(motion.seconds / motion.sweeps * stream.rate_hz + 1e-6)
        for name, stream in streams_of(rig, plan).items()
    }
    while any(recorder.samples(name) < count for name, count in wanted.items()):
        recorder.wait(min(LOOK_S, motion.seconds / motion.sweeps))
        watch.take(axis.turn_look(rig.clock))
    recordings = recorder.stop()
    if abs(watch.taken[-1].angle_deg - end_deg) < 0.2 * margin_deg:
        raise DeviceFault(
            f"{axis.name}: at {watch.taken[-1].angle_deg:g}° the sweep was over before it was read; it turned faster"
            f" than {motion.rate_dps:g} °/s; home it and look at its calibration of speed"
        )
    parts = {name: recording.part(0, wanted[name]) for name, recording in recordings.items()}
    return watch.measured(first), parts


def _is_inside(watch: RateWatch, look: TurnLook, start_deg: float, margin_deg: float) -> bool:
    watch.taken.append(look)
    if look.taken_s - watch.taken[0].taken_s > SPEED_LIMIT_S:
        raise watch.fault(f"did not leave {start_deg:g}° within {SPEED_LIMIT_S:g} s")
    return abs(look.angle_deg - start_deg) >= margin_deg


def stop_and_see(rig: OpenRig, axis: str) -> None:
    """Decelerate to rest and see it there. Raises: DeviceFault."""
    stop_all({axis: rig.axes[axis]}, rig.clock)


def streams_of(rig: OpenRig, plan: Plan) -> dict[str, Stream]:
    """Return the streams that carry channels of the plan."""
    names = dict.fromkeys(channel.partition(".")[0] for channel in plan.channels)
    return {name: rig.streams[name] for name in names if name in rig.streams}


def as_readings(recordings: Mapping[str, Recording], plan: Plan, began_s: float) -> dict[str, ChannelReading]:
    """Return the samples of every stream, by channel, of those that the plan reads."""
    return {
        name: reading
        for recording in recordings.values()
        for name, reading in _joined([recording], plan, began_s).items()
    }


def _joined(recordings: list[Recording], plan: Plan, began_s: float) -> dict[str, ChannelReading]:
    """Join the samples of several recordings of one stream, end to end."""
    return {
        channel: ChannelReading(
            channel,
            np.concatenate([recording.values[channel] for recording in recordings]),
            float(recordings[0].polled_s[0]) if recordings[0].polled_s.size else began_s,
            1.0 / recordings[0].rate_hz,
            recordings[0].units[channel],
        )
        for channel in recordings[0].values
        if channel in plan.channels
    }


def _worst(recordings: list[Recording]) -> StreamTiming:
    """Return one timing of several recordings of one stream.

    What is missing is counted together, the clock is that of the least certain.
    """
    timings = [timing(recording, align(recording)) for recording in recordings]
    worst = max(timings, key=lambda timing: timing.offset_uncertainty_s)
    return StreamTiming(
        worst.stream,
        sum(timing.samples for timing in timings),
        worst.offset_s,
        worst.offset_uncertainty_s,
        worst.drift,
        worst.drift_uncertainty,
        sum(timing.missing for timing in timings),
        sum(timing.doubled for timing in timings),
        sum(timing.doubtful for timing in timings),
        next((timing.first_gap for timing in timings if timing.first_gap), ""),
        max((timing.rate_error for timing in timings), key=abs),
    )
