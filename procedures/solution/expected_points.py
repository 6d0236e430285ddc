"""What the solution of planned points will say of its uncertainties: the rows, models and errors of a run, beforehand.

Dwells are made as the plan has them. What a solved run does with its dwells (:mod:`procedures.solution.by_model`,
:mod:`procedures.solution.lines`) is done with these, at the outputs of a sensor without errors, and the solver's own
forecast states the uncertainties.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from math import radians, sqrt

import numpy as np

from ams.arrays import FloatArray
from ams.calibration.solving.expectation import ExpectedSolution, expect
from ams.frames import AXES, body_rates_rad_s
from ams.models.accelerometer import vector_from_angles
from ams.observations import Observations, Sampled
from ams.solve.expected import Belief
from ams.solve.resolution import rounded_variance
from procedures.plan.plan import Plan
from procedures.plan.rotations import UP, body_axis, to_stage
from procedures.plan.steps import Dwell, Rest, Turn
from procedures.records.dwells import ChannelReading, DwellRecord, MotionRecord
from procedures.solution.beliefs import NOMINAL_CONING_DEG
from procedures.solution.by_model import observed
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.expected import assumed_degc
from procedures.solution.levels import applied_ut, levels_of
from procedures.solution.lines import line_request, lines_of
from procedures.solution.request import SensorRows, request_of
from rig.description.rig_file import AxisTruth, RigDescription, Sensor

_BEGIN_UTC = datetime(2000, 1, 1, tzinfo=UTC)
"""Planned dwells follow each other; when the first begins enters no result."""


@dataclass(frozen=True)
class ExpectedPoints:
    """One sensor axis as it will be solved from the points."""

    solution: ExpectedSolution
    noise: float
    """Standard deviation of a dwell's mean, in the unit of the channel."""
    truth: AxisTruth


Solver = Callable[[SensorRows, Observations, Mapping[str, Belief]], Mapping[str, ExpectedSolution]]
"""Rows without errors and what is believed of their noise to every axis as it will be solved."""


def by_model(item: SensorRows, rows: Observations, beliefs: Mapping[str, Belief]) -> Mapping[str, ExpectedSolution]:
    """Forecast what :func:`procedures.solution.by_model.solve_by_model` will state."""
    return expect(rows, request_of(item.name, item.rig, item.sensor, item.plan.solve, rows), beliefs).axes


def by_lines(item: SensorRows, rows: Observations, beliefs: Mapping[str, Belief]) -> Mapping[str, ExpectedSolution]:
    """Forecast what :func:`procedures.solution.lines.solve_lines` will state."""
    lines = lines_of(item, rows, {label: belief.precision for label, belief in beliefs.items()})
    return {
        label: expect(line.rows, line_request(item, label, line), beliefs).axes[label] for label, line in lines.items()
    }


def expected_points(
    rig: RigDescription, plan: Plan, name: str, sensor: Sensor, solver: Solver
) -> dict[str, ExpectedPoints]:
    """Return every axis whose noise the twin knows; of the others nothing is guessed. Raises: ams.errors.AmsError."""
    known = {} if rig.twin is None else {str(axis): truth for axis, truth in rig.twin.truth.get(name, {}).items()}
    channels = {
        axis: channel for axis, channel in sensor.channels.items() if str(axis) in known and known[str(axis)].noise
    }
    if not channels:
        return {}
    truths = {str(axis): known[str(axis)] for axis in channels}
    measured = sensor.model_copy(update={"channels": channels})
    item = SensorRows(name, measured, _planned_dwells(rig, plan, channels.values()), rig, plan, "plan")
    rows = observed(item)
    sensed = _sensed(item, rows)
    degc = planned_degc(rig, plan, sensor)
    recorded_degc = None if degc is None else np.full(rows.rows, degc)
    rows = replace(rows, temperature_degc=recorded_degc)
    rows = replace(rows, outputs={axis: _output(item, axis, truths[axis], sensed) for axis in truths})
    rows = with_scanned_volts(rows, rig, measured)
    beliefs = {axis: _belief(item, axis, truth.noise) for axis, truth in truths.items()}
    solutions = solver(item, rows, beliefs)
    return {
        axis: ExpectedPoints(solution, beliefs[axis].precision, truths[axis]) for axis, solution in solutions.items()
    }


def planned_degc(rig: RigDescription, plan: Plan, sensor: Sensor) -> float | None:
    """Return the mean temperature that a plan sets, else what use is taken to be counted from.

    None without either, and where the solution models temperature.
    """
    if plan.environment is not None and plan.solve.temperature == "none":
        return float(np.mean(plan.environment.plateaus_degc))
    return assumed_degc(rig, plan.solve, sensor)


def _planned_dwells(rig: RigDescription, plan: Plan, channels: Iterable[str]) -> tuple[DwellRecord, ...]:
    units = rig.channel_units()
    nothing = {name: ChannelReading(name, np.zeros(1), 0.0, 1.0, units.get(name, "v")) for name in channels}
    dwells, begin_s = [], 0.0
    for dwell in plan.design_dwells:
        end_s = begin_s + _recorded_s(dwell, 1.0)
        begin_utc, end_utc = (_BEGIN_UTC + timedelta(seconds=moment_s) for moment_s in (begin_s, end_s))
        dwells.append(
            DwellRecord(
                dwell.step, dwell.purpose, dwell.replication, dwell.point, attempt=1, epoch=1, accepted=True,
                reasons=(), targets_deg=dwell.targets_deg, measured_deg=dwell.targets_deg, temperature_degc={},
                readings=nothing, started_utc=begin_utc, ended_utc=end_utc, started_s=begin_s, ended_s=end_s,
                settle_s=0.0, sha256="", motion=_motion(dwell),
            )
        )  # fmt: skip
        begin_s = end_s
    return tuple(dwells)


def _motion(dwell: Dwell) -> MotionRecord:
    rates = {dwell.motion.turned_axis: dwell.motion.rate_dps} if isinstance(dwell.motion, Turn) else {}
    fields = {} if dwell.applied is None else {dwell.applied.coil: dwell.applied.field_ut}
    return MotionRecord(rates_dps=rates, field_ut=fields)


def _sensed(item: SensorRows, rows: Observations) -> FloatArray:
    """Return the (N, 3) specific force (g), angular velocity (°/s) or field (µT) in stage axes."""
    yaw_rad = np.zeros(rows.rows) if rows.yaw_rad is None else rows.yaw_rad
    angles = np.stack([rows.pitch_rad, yaw_rad, rows.roll_rad], axis=-1)
    if item.sensor.measures == "rate":
        assert rows.euler_rate_rad_s is not None, "planned dwells have rates"
        return np.asarray(np.rad2deg(body_rates_rad_s(angles, rows.euler_rate_rad_s)))
    vectors = np.tile(UP, (rows.rows, 1))
    if item.sensor.measures == "field":
        beside_ut = _beside_ut(item)
        vectors = np.stack([beside_ut + applied_ut(dwell, item.rig) for dwell in item.dwells])
    return np.stack([to_stage(*angle) @ vector for angle, vector in zip(angles, vectors, strict=True)])


def _beside_ut(item: SensorRows) -> FloatArray:
    """Return what stands beside the coils in level axes: as it is declared, else the twin's."""
    levels, twin = levels_of(item.plan), item.rig.twin
    if levels is not None and levels.surroundings_ut is not None:
        return np.array(levels.surroundings_ut)
    readouts = {channel.partition(".")[0] for channel in item.channels.values()}
    fields = [twin.streams[name].field_ut for name in readouts if twin is not None and name in twin.streams]
    return np.array(fields[0] if fields else (0.0, 0.0, 0.0))


def _output(item: SensorRows, axis: str, truth: AxisTruth, sensed: FloatArray) -> FloatArray:
    """Return what the axis reads of it, by its truth."""
    coning_rad = radians(truth.coning_deg or NOMINAL_CONING_DEG)
    k = vector_from_angles(axis, truth.per_unit, coning_rad, radians(truth.azimuth_deg))
    mounted = np.stack([body_axis(item.sensor, name) for name in AXES])
    return np.asarray(truth.at_zero + sensed @ (k @ mounted))


def _belief(item: SensorRows, axis: str, reading: float) -> Belief:
    """Return the noise of a dwell's mean, and what its samples will show of the counts they come in.

    Of dwells of several lengths it is the root of their mean variance.
    """
    channel = item.channels[axis]
    step = item.rig.channel_counts().get(channel)
    variance = reading**2 if step is None else rounded_variance(step, reading**2)
    share, points = _share_of_mean(item, channel.partition(".")[0]), len({dwell.point for dwell in item.dwells})
    return Belief(sqrt(variance * share), sampled=Sampled(step, variance * (1.0 - share), points))


def _share_of_mean(item: SensorRows, readout: str) -> float:
    """Return the variance of a dwell's mean as part of that of a sample."""
    if readout in item.rig.readouts:
        return 1.0 / item.plan.dwell.samples
    rate_hz = item.rig.streams[readout].samples_hz()
    plain_s = item.plan.dwell.samples / rate_hz
    counts = [max(_recorded_s(dwell, plain_s) * rate_hz, 1.0) for dwell in item.plan.design_dwells]
    return sum(1.0 / count for count in counts) / len(counts)


def _recorded_s(dwell: Dwell, plain_s: float) -> float:
    """Return for how long streams are recorded at a dwell, ``plain_s`` at one that neither turns nor rests for long."""
    match dwell.motion:
        case Turn():
            return dwell.motion.seconds
        case Rest():
            return dwell.motion.rest_seconds
    return plain_s
