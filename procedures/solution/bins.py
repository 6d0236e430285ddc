"""From dwells along a motion over time to observations: one row a bin of mean rates and mean readings."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.frames import ANGLES, body_rates_rad_s, euler_rates_rad_s
from ams.observations import Observations
from procedures.errors import JournalError
from procedures.plan.plan import Plan
from procedures.plan.steps import Follow
from procedures.records.dwells import ANGLE, LOOKED, TAKEN, ChannelReading, DwellRecord
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.earth_turn import with_turned_earth
from procedures.solution.observations import run_times_s, units_of
from procedures.solution.request import SensorRows


def profile_observations(item: SensorRows) -> Observations:
    """Return one row a bin of every dwell: mean rates between two looks, mean readings of the samples between."""
    rows, plan, channels, source = item.at_declared(), item.plan, item.channels, item.source
    parts = [_bins(row, plan, channels, source) for row in rows]
    angles_rad = {name: np.concatenate([part.angles_rad[name] for part in parts]) for name in ANGLES}
    found = Observations(
        replication=np.repeat([row.replication for row in rows], [part.count for part in parts]),
        point=np.concatenate([np.arange(1, part.count + 1) for part in parts]),
        pitch_rad=angles_rad["pitch"],
        roll_rad=angles_rad["roll"],
        yaw_rad=angles_rad["yaw"],
        outputs={axis: np.concatenate([part.outputs[axis] for part in parts]) for axis in channels},
        time_s=np.concatenate(
            [part.middle_s + start_s for part, start_s in zip(parts, run_times_s(rows), strict=True)]
        ),
        euler_rate_rad_s=np.concatenate([part.rates_rad_s for part in parts]),
        units=units_of(rows, channels),
        source=source,
    )
    found = with_scanned_volts(found, item.rig, item.sensor)
    return with_turned_earth(found, item.rig, item.sensor) if item.plan.counts_earth else found


@dataclass(frozen=True)
class _Bins:
    count: int
    middle_s: FloatArray
    angles_rad: Mapping[str, FloatArray]
    rates_rad_s: FloatArray
    outputs: Mapping[str, FloatArray]


def _bins(row: DwellRecord, plan: Plan, channels: Mapping[str, str], source: str) -> _Bins:
    """Edges are looks of the first axis; the others are looked at moments later and interpolated.

    The angular velocity of a bin is the mean over its updates: the mean of a product (a rate times the cosine of an
    angle) is not the product of the means.
    """
    motion = next(step.motion for step in plan.dwells if step.step == row.step)
    assert isinstance(motion, Follow)
    every = round(motion.bin_s / motion.update_s)
    looked = {name: (_samples(row, name, LOOKED), _samples(row, name, ANGLE)) for name in motion.span_deg}
    first_s = next(iter(looked.values()))[0]
    bins = (first_s.size - 1) // every
    ticks_s = first_s[: bins * every + 1]
    angles = np.stack([np.full(ticks_s.size, row.targets_deg.get(name, 0.0)) for name in ANGLES], axis=-1)
    for index, name in enumerate(ANGLES):
        if name in looked:
            angles[:, index] = np.interp(ticks_s, *looked[name])
    middles, rates = _mean_motion(np.deg2rad(angles), ticks_s, every)
    edges_s = ticks_s[::every]
    return _Bins(
        count=bins,
        middle_s=(edges_s[1:] + edges_s[:-1]) / 2.0,
        angles_rad=dict(zip(ANGLES, middles.T, strict=True)),
        rates_rad_s=rates,
        outputs={
            axis: _mean_between(
                row.readings[channel], row.readings[f"{channel.partition('.')[0]}.{TAKEN}"], edges_s, source
            )
            for axis, channel in channels.items()
        },
    )


def _mean_motion(angles_rad: FloatArray, ticks_s: FloatArray, every: int) -> tuple[FloatArray, FloatArray]:
    """(M, 3) angles in the middle of every bin, and the rates of the angles that make its mean angular velocity."""
    seconds = np.diff(ticks_s)[:, None]
    velocity = body_rates_rad_s((angles_rad[1:] + angles_rad[:-1]) / 2.0, np.diff(angles_rad, axis=0) / seconds)
    edges_s = ticks_s[::every]
    mean = np.add.reduceat(velocity * seconds, np.arange(0, seconds.size, every)) / np.diff(edges_s)[:, None]
    halves = (edges_s[1:] + edges_s[:-1]) / 2.0
    middles = np.stack([np.interp(halves, ticks_s, angles_rad[:, index]) for index in range(3)], axis=-1)
    return middles, euler_rates_rad_s(middles, mean)


def _samples(row: DwellRecord, axis: str, what: str) -> FloatArray:
    return row.readings[f"axes.{axis}.{what}"].samples


def _mean_between(reading: ChannelReading, taken: ChannelReading, edges_s: FloatArray, source: str) -> FloatArray:
    """Return the mean of a sampled channel between edges: its straight lines from sample to sample, integrated."""
    times_s, values = taken.samples, reading.samples
    if edges_s[0] < times_s[0] or edges_s[-1] > times_s[-1]:
        raise JournalError(
            f"{source}: {reading.channel}: recorded from {times_s[0]:.3g} s to {times_s[-1]:.3g} s, the motion lasted "
            f"from {edges_s[0]:.3g} s to {edges_s[-1]:.3g} s; nothing was solved; verify the journal"
        )
    moments = np.union1d(times_s, edges_s)
    there = np.interp(moments, times_s, values)
    area = np.concatenate([[0.0], np.cumsum(np.diff(moments) * (there[1:] + there[:-1]) / 2.0)])
    mean: FloatArray = np.diff(area[np.searchsorted(moments, edges_s)]) / np.diff(edges_s)
    return mean
