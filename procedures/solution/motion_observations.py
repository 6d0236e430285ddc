"""From judged dwells with motion or fields to observations: rates, profiles and known levels.

As :mod:`procedures.solution.observations`, only accepted dwells of the design enter, in the order of the plan, with
what was measured: rates from position and time, attitudes read back or told by a reference, fields that stood.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.frames import body_rates_rad_s, euler_rates_rad_s
from ams.models.linear import magnet_difference
from ams.observations import Observations
from procedures.errors import JournalError
from procedures.plan.plan import Plan
from procedures.plan.rotations import UP, body_axis, to_stage
from procedures.plan.steps import Follow
from procedures.records.dwells import ANGLE, LOOKED, TAKEN, ChannelReading, DwellRecord
from procedures.solution.observations import run_times_s, units_of
from rig.description.rig_file import RigDescription, Sensor

AXES = ("pitch", "yaw", "roll")
LEAST_ALONG = 0.5
"""SR's two positions: rows where an axis is less along gravity or a coil say nothing about it."""


@dataclass(frozen=True)
class LevelRows:
    """One axis: which rows tell it something, its known levels there and its readings."""

    rows: IntArray
    level: FloatArray
    reading: FloatArray
    sense: FloatArray | None = None
    """±1: along or against a coil beside which an unknown field stands."""


def design_dwells(dwells: Iterable[DwellRecord]) -> list[DwellRecord]:
    """Accepted dwells of the design, in the order of the plan."""
    return sorted((dwell for dwell in dwells if dwell.accepted and dwell.purpose == "design"), key=lambda row: row.step)


def dwell_observations(rows: Sequence[DwellRecord], channels: Mapping[str, str], source: str) -> Observations:
    """One row a dwell: attitude, rates of the angles and the mean reading of every channel."""
    rates_dps = np.array([[_rate_dps(row, axis) for axis in AXES] for row in rows]).reshape(len(rows), 3)
    return Observations(
        replication=np.array([row.replication for row in rows], dtype=np.int64),
        point=np.array([row.point for row in rows], dtype=np.int64),
        pitch_rad=_attitude_rad(rows, "pitch"),
        roll_rad=_attitude_rad(rows, "roll"),
        yaw_rad=_attitude_rad(rows, "yaw"),
        outputs={axis: np.array([_mean(row, channel, source) for row in rows]) for axis, channel in channels.items()},
        time_s=run_times_s(rows),
        euler_rate_rad_s=np.deg2rad(rates_dps),
        units=units_of(rows, channels),
        source=source,
    )


def profile_observations(
    rows: Sequence[DwellRecord], plan: Plan, channels: Mapping[str, str], source: str
) -> Observations:
    """One row a bin of every dwell: mean rates between two looks, mean readings of the samples between."""
    parts = [_bins(row, plan, channels, source) for row in rows]
    place = {name: np.concatenate([part.angles_rad[name] for part in parts]) for name in AXES}
    return Observations(
        replication=np.repeat([row.replication for row in rows], [part.count for part in parts]),
        point=np.concatenate([np.arange(1, part.count + 1) for part in parts]),
        pitch_rad=place["pitch"],
        roll_rad=place["roll"],
        yaw_rad=place["yaw"],
        outputs={axis: np.concatenate([part.outputs[axis] for part in parts]) for axis in channels},
        time_s=np.concatenate(
            [part.middle_s + start_s for part, start_s in zip(parts, run_times_s(rows), strict=True)]
        ),
        euler_rate_rad_s=np.concatenate([part.rates_rad_s for part in parts]),
        units=units_of(rows, channels),
        source=source,
    )


def known_levels(
    observations: Observations, rows: Sequence[DwellRecord], plan: Plan, rig: RigDescription, sensor: Sensor, axis: str
) -> LevelRows:
    """What the nominal axis of a sensor was exposed to: specific force (g), angular velocity (dps), field (uT)."""
    reading = observations.outputs[axis]
    if plan.levels is not None and plan.levels.method == "magnet-difference":
        return _magnet_levels(rows, reading)
    if plan.levels is not None and plan.levels.surroundings_ut is None:
        return _levels_beside_the_unknown(observations, rows, rig, sensor, axis)
    level = np.array([_level(observations, place, row, plan, rig, sensor, axis) for place, row in enumerate(rows)])
    kept = np.arange(level.size)
    if sensor.measures == "acceleration":
        kept = np.flatnonzero(np.abs(level) > LEAST_ALONG)
    return LevelRows(kept, level[kept], reading[kept])


def _level(
    observations: Observations,
    place: int,
    row: DwellRecord,
    plan: Plan,
    rig: RigDescription,
    sensor: Sensor,
    axis: str,
) -> float:
    assert observations.yaw_rad is not None
    assert observations.euler_rate_rad_s is not None
    angles = observations.pitch_rad[place], observations.yaw_rad[place], observations.roll_rad[place]
    along = body_axis(sensor, axis)
    if sensor.measures == "rate":
        rate = body_rates_rad_s(np.array([angles]), observations.euler_rate_rad_s[place : place + 1])[0]
        return float(np.rad2deg(rate) @ along)
    level = UP if sensor.measures == "acceleration" else _field_ut(row, plan, rig)
    return float(along @ to_stage(*angles) @ level)


def _field_ut(row: DwellRecord, plan: Plan, rig: RigDescription) -> FloatArray:
    """In level axes: what stands without the coil, and what was applied."""
    assert plan.levels is not None
    assert plan.levels.surroundings_ut is not None
    assert row.motion is not None
    total = np.array(plan.levels.surroundings_ut)
    for coil, field_ut in row.motion.field_ut.items():
        direction = np.array(rig.field[coil].direction)
        total = total + field_ut * direction / np.linalg.norm(direction)
    return total


def _levels_beside_the_unknown(
    observations: Observations, rows: Sequence[DwellRecord], rig: RigDescription, sensor: Sensor, axis: str
) -> LevelRows:
    """Rows in which the axis lies along or against the coil; the level is what the coil adds."""
    assert observations.yaw_rad is not None
    along = body_axis(sensor, axis)
    sense, level = [], []
    for place, row in enumerate(rows):
        assert row.motion is not None
        ((coil, field_ut),) = row.motion.field_ut.items()
        direction = np.array(rig.field[coil].direction)
        angles = observations.pitch_rad[place], observations.yaw_rad[place], observations.roll_rad[place]
        component = float(along @ to_stage(*angles) @ direction) / float(np.linalg.norm(direction))
        sense.append(component)
        level.append(component * field_ut)
    kept = np.flatnonzero(np.abs(sense) > LEAST_ALONG)
    return LevelRows(kept, np.array(level)[kept], observations.outputs[axis][kept], np.array(sense)[kept])


def _magnet_levels(rows: Sequence[DwellRecord], reading: FloatArray) -> LevelRows:
    """SR's magnet: within a replication the difference that it makes tells its field, and that the levels.

    An axis is where the magnet changes its reading most: once up, once down.
    """
    kept: list[int] = []
    levels: list[float] = []
    for replication in sorted({row.replication for row in rows}):
        off, on = (
            {
                tuple(row.targets_deg.items()): place
                for place, row in enumerate(rows)
                if row.replication == replication and _is_applied(row) == is_on
            }
            for is_on in (False, True)
        )
        changed = {attitude: reading[on[attitude]] - reading[off[attitude]] for attitude in off if attitude in on}
        up, down = max(changed, key=lambda one: changed[one]), min(changed, key=lambda one: changed[one])
        found = magnet_difference(
            with_magnet=(float(reading[on[up]]), float(reading[on[down]])),
            without_magnet=(float(reading[off[up]]), float(reading[off[down]])),
        )
        kept += [off[up], off[down]]
        levels += found.real
    places = np.array(kept, dtype=np.int64)
    return LevelRows(places, np.array(levels), reading[places])


def _is_applied(row: DwellRecord) -> bool:
    return row.motion is not None and any(row.motion.field_ut.values())


def _rate_dps(row: DwellRecord, axis: str) -> float:
    return 0.0 if row.motion is None else row.motion.rates_dps.get(axis, 0.0)


def _attitude_rad(rows: Sequence[DwellRecord], axis: str) -> FloatArray:
    """Of an axis that turned, its start: where it is enters no equation."""
    told = [row.targets_deg.get(axis, 0.0) if _rate_dps(row, axis) else row.measured_deg.get(axis, 0.0) for row in rows]
    return np.asarray(np.deg2rad(np.array(told, dtype=float)))


def _mean(row: DwellRecord, channel: str, source: str) -> float:
    mean = row.readings[channel].mean if channel in row.readings else float("nan")
    if not np.isfinite(mean):
        raise JournalError(
            f"{source}: {channel}: the accepted dwell of step {row.step} has no finite mean; needed is one in every "
            "accepted dwell; nothing was solved; verify the journal"
        )
    return mean


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
    angles = np.stack([np.full(ticks_s.size, row.targets_deg.get(name, 0.0)) for name in AXES], axis=-1)
    for place, name in enumerate(AXES):
        if name in looked:
            angles[:, place] = np.interp(ticks_s, *looked[name])
    middles, rates = _mean_motion(np.deg2rad(angles), ticks_s, every)
    edges_s = ticks_s[::every]
    return _Bins(
        count=bins,
        middle_s=(edges_s[1:] + edges_s[:-1]) / 2.0,
        angles_rad=dict(zip(AXES, middles.T, strict=True)),
        rates_rad_s=rates,
        outputs={
            axis: _mean_between(row.readings[channel], _taken(row, channel), edges_s, source)
            for axis, channel in channels.items()
        },
    )


def _taken(row: DwellRecord, channel: str) -> ChannelReading:
    """When the samples of a channel were taken."""
    return row.readings[f"{channel.partition('.')[0]}.{TAKEN}"]


def _mean_motion(angles_rad: FloatArray, ticks_s: FloatArray, every: int) -> tuple[FloatArray, FloatArray]:
    """(M, 3) angles in the middle of every bin, and the rates of the angles that make its mean angular velocity."""
    seconds = np.diff(ticks_s)[:, None]
    velocity = body_rates_rad_s((angles_rad[1:] + angles_rad[:-1]) / 2.0, np.diff(angles_rad, axis=0) / seconds)
    edges_s = ticks_s[::every]
    mean = np.add.reduceat(velocity * seconds, np.arange(0, seconds.size, every)) / np.diff(edges_s)[:, None]
    halves = (edges_s[1:] + edges_s[:-1]) / 2.0
    middles = np.stack([np.interp(halves, ticks_s, angles_rad[:, place]) for place in range(3)], axis=-1)
    return middles, euler_rates_rad_s(middles, mean)


def _samples(row: DwellRecord, axis: str, what: str) -> FloatArray:
    return row.readings[f"axes.{axis}.{what}"].samples


def _mean_between(reading: ChannelReading, taken: ChannelReading, edges_s: FloatArray, source: str) -> FloatArray:
    """Mean of a sampled channel between edges: its straight lines from sample to sample, integrated."""
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
