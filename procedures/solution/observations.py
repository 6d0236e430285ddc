"""From judged dwells to observations: the one way in which a run's numbers reach a solver, a row a dwell.

Only accepted dwells of the design enter, at the attitude that was read back and at the rates that were measured, in the
order of the plan, so that an
interrupted run and its uninterrupted brother give the same rows.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.frames import ANGLES
from ams.inputs.samples_of_dwells import sampled_of
from ams.observations import Observations, Sampled
from procedures.errors import JournalError
from procedures.plan.channels import TemperatureChannel
from procedures.records.dwells import DwellRecord
from rig.description.signal_chain import Chain


def observations_of(
    dwells: Iterable[DwellRecord],
    channels: Mapping[str, str],
    temperature: TemperatureChannel | str | None = None,
    source: str = "run",
    chains: Mapping[str, Chain] | None = None,
    run: str = "",
    counts: Mapping[str, float] | None = None,
) -> Observations:
    """Return accepted design dwells as rows.

    ``channels``: sensor axis (``x``) to full channel name (``dmm.x``). ``temperature``: the sensor's own channel, or
    the environment whose reading stands for it, or None. Roll and yaw are 0 where the rig has no such axis.

    ``chains``, by full channel name, bring readings to the declared supply and load resistor, dwell by dwell. ``run``:
    as commands take it. ``counts``, by full channel name: what one count is declared to be.

    Raises: JournalError where a (replication, point) pair stands twice, or an accepted dwell lacks a finite reading.
    """
    rows = design_dwells(dwells)
    _refuse_repeats(rows, source)
    return Observations(
        replication=np.array([row.replication for row in rows], dtype=np.int64),
        point=np.array([row.point for row in rows], dtype=np.int64),
        pitch_rad=_attitude_rad(rows, "pitch"),
        roll_rad=_attitude_rad(rows, "roll"),
        outputs={axis: _means(rows, channel, source, chains) for axis, channel in channels.items()},
        yaw_rad=_attitude_rad(rows, "yaw") if rows and _knows_yaw(rows[0]) else None,
        temperature_degc=temperatures_degc(rows, temperature, source, chains),
        time_s=run_times_s(rows),
        euler_rate_rad_s=_euler_rate_rad_s(rows),
        mounting=_mounting(rows),
        step=np.array([row.step for row in rows], dtype=np.int64),
        units=units_of(rows, channels),
        sampled=_sampled(rows, channels, source, chains or {}, counts or {}) if rows else {},
        source=source,
        run=run,
    )


def design_dwells(dwells: Iterable[DwellRecord]) -> list[DwellRecord]:
    """Return the accepted dwells of the design, in the order of the plan."""
    return sorted((dwell for dwell in dwells if dwell.accepted and dwell.purpose == "design"), key=lambda row: row.step)


def units_of(rows: Sequence[DwellRecord], channels: Mapping[str, str]) -> dict[str, str]:
    """Return the unit of every axis' readings; none where nothing was read."""
    if not rows:
        return {}
    readings = rows[0].readings
    return {axis: readings[channel].unit for axis, channel in channels.items() if channel in readings}


def _mounting(rows: Sequence[DwellRecord]) -> IntArray | None:
    """Return (N,) where the package was moved in between; None where it never was."""
    labels = np.array([row.mounting for row in rows], dtype=np.int64)
    return labels if np.unique(labels).size > 1 else None


def run_times_s(dwells: Sequence[DwellRecord]) -> FloatArray:
    """Return (N,) middle of every dwell, seconds since the start of the first.

    Rig seconds inside an epoch; epochs are placed by the wall clock, since a restart begins a new monotonic clock, and
    never before the end of the one before: the twin's seconds may pass faster than those of the wall clock.
    """
    if not dwells:
        return np.zeros(0)
    origin_utc, shift_s, ended_s = dwells[0].started_utc, dict[int, float](), -np.inf
    for epoch in sorted({dwell.epoch for dwell in dwells}):
        of_epoch = [dwell for dwell in dwells if dwell.epoch == epoch]
        by_wall_clock_s = (of_epoch[0].started_utc - origin_utc).total_seconds() - of_epoch[0].started_s
        shift_s[epoch] = max(by_wall_clock_s, ended_s - min(dwell.started_s for dwell in of_epoch))
        ended_s = max(dwell.ended_s for dwell in of_epoch) + shift_s[epoch]
    began_s = dwells[0].started_s + shift_s[dwells[0].epoch]
    return np.array([0.5 * (dwell.started_s + dwell.ended_s) + shift_s[dwell.epoch] - began_s for dwell in dwells])


def _refuse_repeats(rows: Sequence[DwellRecord], source: str) -> None:
    seen: dict[tuple[int, int], int] = {}
    for row in rows:
        key = (row.replication, row.point)
        if key in seen:
            raise JournalError(
                f"{source}: replication {row.replication}, point {row.point} was accepted twice: steps {seen[key]} and "
                f"{row.step}, allowed is once; nothing was solved; verify the journal"
            )
        seen[key] = row.step


def _attitude_rad(rows: Sequence[DwellRecord], axis: str) -> FloatArray:
    """Return the attitude as read back or told by a reference.

    Of an axis that turned, its start: where it is enters no equation.
    """
    angles_deg = [attitude_deg(row, axis, absent=0.0) for row in rows]
    return np.asarray(np.deg2rad(np.array(angles_deg, dtype=float)))


def attitude_deg(row: DwellRecord, axis: str, *, absent: float) -> float:
    """Return the angle of one axis that a dwell was taken at, ``absent`` where the rig has no such axis."""
    known = row.targets_deg if _rate_dps(row, axis) else row.measured_deg
    return known.get(axis, absent)


def _knows_yaw(row: DwellRecord) -> bool:
    return "yaw" in row.measured_deg or "yaw" in row.targets_deg


def _rate_dps(row: DwellRecord, axis: str) -> float:
    return 0.0 if row.motion is None else row.motion.rates_dps.get(axis, 0.0)


def _euler_rate_rad_s(rows: Sequence[DwellRecord]) -> FloatArray | None:
    """Return (N, 3) rates of pitch, yaw and roll as measured; None where no dwell turned an axis."""
    if not any(row.motion is not None and row.motion.rates_dps for row in rows):
        return None
    return np.asarray(np.deg2rad([[_rate_dps(row, axis) for axis in ANGLES] for row in rows]))


def _sampled(
    rows: Sequence[DwellRecord],
    channels: Mapping[str, str],
    source: str,
    chains: Mapping[str, Chain],
    counts: Mapping[str, float],
) -> dict[str, Sampled]:
    """Return what the samples of every axis show, as they were read, brought to its outputs by its mean factor."""
    found, point = {}, np.array([row.point for row in rows])
    for axis, channel in channels.items():
        samples = [row.readings[channel].samples for row in rows]
        as_read = sampled_of(samples, point, counts.get(channel))
        factor = float(np.abs(_factors(rows, channel, source, chains)).mean())
        step = None if as_read.step is None else as_read.step / factor
        found[axis] = Sampled(step, as_read.variance / factor**2, as_read.points)
    return found


def _means(
    rows: Sequence[DwellRecord], channel: str, source: str, chains: Mapping[str, Chain] | None = None
) -> FloatArray:
    means = _read(rows, channel, source)
    return means if channel not in (chains or {}) else np.asarray(means / _factors(rows, channel, source, chains or {}))


def _factors(rows: Sequence[DwellRecord], channel: str, source: str, chains: Mapping[str, Chain]) -> FloatArray:
    """Return (N,) what readings have more than they would have by declaration."""
    chain = chains.get(channel)
    if chain is None:
        return np.ones(len(rows))
    supplies_v = _read(rows, chain.supply_channel, source) if chain.ratiometric and chain.supply_channel else None
    factors = [
        chain.factor(
            None if supplies_v is None else float(supplies_v[index]),
            None if chain.load_resistor_at is None else row.temperature_degc.get(chain.load_resistor_at),
        )
        for index, row in enumerate(rows)
    ]
    return np.array(factors, dtype=float)


def _read(rows: Sequence[DwellRecord], channel: str, source: str) -> FloatArray:
    means = np.array([row.readings[channel].mean if channel in row.readings else np.nan for row in rows])
    bad = np.flatnonzero(~np.isfinite(means))
    if bad.size:
        raise JournalError(
            f"{source}: {channel}: the accepted dwell of step {rows[int(bad[0])].step} has no finite mean; needed is a "
            "finite one in every accepted dwell; nothing was solved; verify the journal"
        )
    return means


def temperatures_degc(
    rows: Sequence[DwellRecord],
    temperature: TemperatureChannel | str | None,
    source: str,
    chains: Mapping[str, Chain] | None,
) -> FloatArray | None:
    """Return (N,) the temperature of a sensor at its dwells; None where it is not known of each.

    Raises: JournalError where the sensor's own channel has no finite reading.
    """
    if temperature is None:
        return None
    if isinstance(temperature, TemperatureChannel):
        return temperature.offset_degc + temperature.slope_degc_per_v * _means(
            rows, temperature.channel, source, chains
        )
    read = np.array([row.temperature_degc.get(temperature, np.nan) for row in rows], dtype=float)
    return read if read.size and bool(np.isfinite(read).all()) else None
