"""Motion over time: several axes are led along a profile while the streams are recorded.

A rate axis knows no profile; it is given a rate at every update, the profile's own for the time until the next one and
a part of what it lags behind. Where it really is, is asked at every update as well, and only that enters the solution:
the profile may be followed badly, it cannot be followed wrongly. Source: CR IV-A (ramp), IV-C (harmonic).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import pi, sin
from typing import cast

import numpy as np

from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell, Follow
from procedures.run.alignment import Alignment, align, timing
from procedures.run.judge import Measurement
from procedures.run.measure import Announcement, OpenRig, look
from procedures.run.recorder import Recorder, Recording, recording
from procedures.run.records import ChannelReading, MotionRecord
from procedures.run.turning import streams_of
from rig.devices.abilities import RateAxis, TurnLook, Wait
from rig.errors import DeviceFault
from rig.motion import stop_all

LEAD_S = 0.5
"""Recorded at rest before and behind the motion."""
CATCH_UP_S = 0.5
"""What an axis lags behind is made up in about this time: faster would overshoot what it can accelerate."""
LEAST_RATE_DPS = 1e-3
FARTHEST_OFF_DEG = 5.0
ANGLE, LOOKED, TAKEN = "angle_deg", "looked_s", "taken_s"
"""Names of what a dwell stores beside the channels: ``axes.pitch.angle_deg``, ``imu.taken_s``; seconds since the motion
began."""


def profile_deg(motion: Follow, axis: str, after_s: float) -> float:
    """How far an axis is from its start. Before the motion 0, behind it where it ended."""
    span_deg, elapsed_s = motion.span_deg[axis], min(max(after_s, 0.0), motion.seconds)
    if motion.shape == "ramp":
        return span_deg * elapsed_s / motion.seconds
    return span_deg * sin(2.0 * pi * motion.frequency_hz[axis] * elapsed_s)


def top_rate_dps(motion: Follow, axis: str) -> float:
    """The largest rate of the profile."""
    span_deg = abs(motion.span_deg[axis])
    return span_deg / motion.seconds if motion.shape == "ramp" else span_deg * 2.0 * pi * motion.frequency_hz[axis]


def acceleration_dps2(motion: Follow, axis: str) -> float:
    """The largest acceleration on the way, without the start: 0 of a ramp."""
    if motion.shape == "ramp":
        return 0.0
    return abs(motion.span_deg[axis]) * (2.0 * pi * motion.frequency_hz[axis]) ** 2


def range_deg(motion: Follow, axis: str) -> tuple[float, float]:
    """Lowest and highest angle from the start."""
    places = [profile_deg(motion, axis, motion.seconds * part / 1000.0) for part in range(1001)]
    return min(places), max(places)


@dataclass
class _Led:
    """One axis on its way."""

    axis: RateAxis
    start_deg: float
    looks: list[TurnLook] = field(default_factory=list)
    is_turning: bool = False

    def lead(self, rig: OpenRig, place: Callable[[float], float], now_s: float, update_s: float) -> None:
        """Look where it is, then give it the rate until the next update. Raises: DeviceFault where it has run away."""
        self.looks.append(self.axis.turn_look(rig.clock))
        off_deg = self.start_deg + place(now_s) - self.looks[-1].angle_deg
        if abs(off_deg) > FARTHEST_OFF_DEG:
            raise DeviceFault(
                f"{self.axis.name}: {off_deg:+.3g} deg off its profile, allowed {FARTHEST_OFF_DEG:g} deg; the axis was"
                " told to decelerate to rest; ask for a slower motion or look at the drive"
            )
        rate_dps = (place(now_s + update_s) - place(now_s)) / update_s + off_deg / CATCH_UP_S
        rate_dps = min(max(rate_dps, -self.axis.top_rate_dps), self.axis.top_rate_dps)
        if abs(rate_dps) >= LEAST_RATE_DPS:
            self.axis.start_rate(rate_dps)
        elif self.is_turning:
            self.axis.stop()
        self.is_turning = abs(rate_dps) >= LEAST_RATE_DPS


def follow(
    rig: OpenRig, plan: Plan, dwell: Dwell, motion: Follow, announcement: Announcement, wait: Wait
) -> Measurement:
    """One dwell along a motion. Every axis is at rest when this returns or raises.

    Raises: RequestRefused (before anything moved), DeviceFault (the axes were stopped), WaitEnded, RigError.
    """
    before = look(rig, dwell.targets_deg)
    led = {name: _Led(cast("RateAxis", rig.axes[name]), before.axes[name].position_deg) for name in motion.span_deg}
    for name, one in led.items():
        one.axis.check_rate(top_rate_dps(motion, name))
    with recording(streams_of(rig, plan), rig.clock, wait, is_timed=True) as recorder:
        recorder.start()
        announcement.read(rig.chance)
        recorder.wait(LEAD_S)
        began_s = rig.clock.monotonic_s()
        try:
            _lead(rig, motion, led, began_s, recorder)
        finally:
            stop_all({name: rig.axes[name] for name in led}, rig.clock)
        recorder.wait(LEAD_S)
        recordings = recorder.stop()
    aligned = {name: align(one) for name, one in recordings.items()}
    readings = _stored(plan, motion, led, recordings, aligned, began_s)
    timings = tuple(timing(one, aligned[name]) for name, one in recordings.items())
    after = look(rig, dwell.targets_deg)
    return Measurement(before, after, readings, True, 0.0, MotionRecord(streams=timings))


def _lead(rig: OpenRig, motion: Follow, led: Mapping[str, _Led], began_s: float, recorder: Recorder) -> None:
    updates = int(motion.seconds / motion.update_s + 1e-6)
    for update in range(updates + 1):
        recorder.wait(max(began_s + update * motion.update_s - rig.clock.monotonic_s(), 0.0))
        now_s = rig.clock.monotonic_s() - began_s
        for name, one in led.items():
            one.lead(rig, lambda after_s, name=name: profile_deg(motion, name, after_s), now_s, motion.update_s)  # type: ignore[misc]


def _stored(
    plan: Plan,
    motion: Follow,
    led: Mapping[str, _Led],
    recordings: Mapping[str, Recording],
    aligned: Mapping[str, Alignment],
    began_s: float,
) -> dict[str, ChannelReading]:
    readings = {}
    for name, one in led.items():
        angles = np.array([look.angle_deg for look in one.looks])
        looked_s = np.array([look.taken_s for look in one.looks]) - began_s
        for what, values in ((ANGLE, angles), (LOOKED, looked_s)):
            key = f"axes.{name}.{what}"
            readings[key] = ChannelReading(key, values, began_s, motion.update_s)
    for name, recorded in recordings.items():
        taken_s = aligned[name].rig_s(recorded.device_s) - began_s
        wanted = {channel: values for channel, values in recorded.values.items() if channel in plan.channels}
        for key, values in {**wanted, f"{name}.{TAKEN}": taken_s}.items():
            readings[key] = ChannelReading(key, values, began_s + float(taken_s[0]), 1.0 / recorded.rate_hz)
    return readings
