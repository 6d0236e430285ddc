"""Motion over time: several axes are led along a profile while the streams are recorded.

A rate axis knows no profile; it is given a rate at every update, the profile's own for the time until the next one and
a part of what it lags behind. Where it really is, is asked at every update as well, and only that enters the solution:
the profile may be followed badly, it cannot be followed wrongly. Source: CR IV-A (ramp), IV-C (harmonic).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from procedures.plan.plan import Plan
from procedures.plan.profiles import profile_deg, top_rate_dps
from procedures.plan.steps import Dwell, Follow
from procedures.records.dwells import ANGLE, LOOKED, TAKEN, ChannelReading, Measurement, MotionRecord
from procedures.run.dwell.alignment import Alignment, align, timing
from procedures.run.dwell.measure import Announcement, OpenRig, look
from procedures.run.dwell.stream_recorder import Recorder, Recording, recording
from procedures.run.dwell.turning import streams_of
from rig.abilities.abilities import RateAxis, TurnLook, Wait
from rig.errors import DeviceFault
from rig.motion.move import stop_all

LEAD_S = 0.5
"""Recorded at rest before and behind the motion."""
CATCH_UP_S = 0.5
"""What an axis lags behind is made up in about this time: faster would overshoot what it can accelerate."""
LEAST_RATE_DPS = 1e-3
FARTHEST_OFF_DEG = 5.0
"""Names of what a dwell stores beside the channels: ``axes.pitch.angle_deg``, ``imu.taken_s``; seconds since the motion
began."""


@dataclass
class _Led:
    """One axis on its way."""

    axis: RateAxis
    start_deg: float
    looks: list[TurnLook] = field(default_factory=list)
    is_turning: bool = False

    def lead(self, rig: OpenRig, position_at: Callable[[float], float], now_s: float, update_s: float) -> None:
        """Look where it is, then give it the rate until the next update. Raises: DeviceFault where it has run away."""
        self.looks.append(self.axis.turn_look(rig.clock))
        off_deg = self.start_deg + position_at(now_s) - self.looks[-1].angle_deg
        if abs(off_deg) > FARTHEST_OFF_DEG:
            raise DeviceFault(
                f"{self.axis.name}: {off_deg:+.3g}° off its profile, allowed {FARTHEST_OFF_DEG:g}°; the axis was"
                " told to decelerate to rest; ask for a slower motion or look at the drive"
            )
        rate_dps = (position_at(now_s + update_s) - position_at(now_s)) / update_s + off_deg / CATCH_UP_S
        rate_dps = min(max(rate_dps, -self.axis.top_rate_dps), self.axis.top_rate_dps)
        if abs(rate_dps) >= LEAST_RATE_DPS:
            self.axis.start_rate(rate_dps)
        elif self.is_turning:
            self.axis.stop()
        self.is_turning = abs(rate_dps) >= LEAST_RATE_DPS


def follow(
    rig: OpenRig, plan: Plan, dwell: Dwell, motion: Follow, announcement: Announcement, wait: Wait
) -> Measurement:
    """Measure one dwell along a motion. Every axis is at rest when this returns or raises.

    Raises: RequestRefused (before anything moved), DeviceFault (the axes were stopped), WaitEnded, RigError.
    """
    before = look(rig, dwell.targets_deg)
    led = {name: _Led(cast("RateAxis", rig.axes[name]), before.axes[name].position_deg) for name in motion.span_deg}
    for name, leader in led.items():
        leader.axis.check_rate(top_rate_dps(motion, name))
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
    aligned = {name: align(recording) for name, recording in recordings.items()}
    readings = _stored(plan, motion, led, recordings, aligned, began_s)
    timings = tuple(timing(recording, aligned[name]) for name, recording in recordings.items())
    after = look(rig, dwell.targets_deg)
    return Measurement(before, after, readings, True, 0.0, MotionRecord(streams=timings))


def _lead(rig: OpenRig, motion: Follow, led: Mapping[str, _Led], began_s: float, recorder: Recorder) -> None:
    updates = int(motion.seconds / motion.update_s + 1e-6)
    for update in range(updates + 1):
        recorder.wait(max(began_s + update * motion.update_s - rig.clock.monotonic_s(), 0.0))
        now_s = rig.clock.monotonic_s() - began_s
        for name, leader in led.items():
            leader.lead(rig, lambda after_s, name=name: profile_deg(motion, name, after_s), now_s, motion.update_s)  # type: ignore[misc]


def _stored(
    plan: Plan,
    motion: Follow,
    led: Mapping[str, _Led],
    recordings: Mapping[str, Recording],
    aligned: Mapping[str, Alignment],
    began_s: float,
) -> dict[str, ChannelReading]:
    readings = {}
    for name, leader in led.items():
        angles = np.array([look.angle_deg for look in leader.looks])
        looked_s = np.array([look.taken_s for look in leader.looks]) - began_s
        for what, values, unit in ((ANGLE, angles, "deg"), (LOOKED, looked_s, "s")):
            key = f"axes.{name}.{what}"
            readings[key] = ChannelReading(key, values, began_s, motion.update_s, unit)
    for name, recorded in recordings.items():
        taken_s = aligned[name].rig_s(recorded.device_s) - began_s
        wanted = {channel: values for channel, values in recorded.values.items() if channel in plan.channels}
        units = {**recorded.units, f"{name}.{TAKEN}": "s"}
        for key, values in {**wanted, f"{name}.{TAKEN}": taken_s}.items():
            started_s = began_s + float(taken_s[0])
            readings[key] = ChannelReading(key, values, started_s, 1.0 / recorded.rate_hz, units[key])
    return readings
