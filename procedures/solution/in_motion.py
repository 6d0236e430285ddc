"""Solving what moved or stood in a field: gyros (CR), straight lines (SR), profiles, and what a long rest says.

The same solvers as everywhere; only what a row is exposed to is known in another way.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import sqrt
from typing import Any, cast

import numpy as np

from ams.calibration.calibrate import calibrate
from ams.calibration.document import to_document
from ams.calibration_result import Calibration
from ams.errors import AmsError, DesignError
from ams.inputs.request import CalibrationRequest
from ams.models.field_line import FieldLine
from ams.models.model import Model
from ams.models.straight_line import StraightLine
from ams.observations import Observations
from ams.statistics.noise import allan_deviation, read_coefficients
from procedures.plan.plan import Plan
from procedures.records.declared_supply import at_declared, correcting
from procedures.records.dwells import DwellRecord
from procedures.solution.motion_observations import (
    design_dwells,
    dwell_observations,
    known_levels,
    profile_observations,
)
from procedures.solution.request import SolvedSensor, StaticAxis, budgets_of, request_of
from procedures.solution.type_b import level_remarks
from rig.description.rig_file import RigDescription, Sensor

UNITS: Mapping[str, str] = {"acceleration": "g", "rate": "dps", "field": "ut"}
"""Of what a sensor measures, as it is written in a key."""
COVERAGE = 2.0


def is_solved_here(plan: Plan) -> bool:
    """Everything but attitudes of accelerometers; of those SR's two positions."""
    return not plan.is_at_rest or plan.design.kind == "up-down"


def solve_motion(
    dwells: Iterable[DwellRecord], rig: RigDescription, plan: Plan, source: str
) -> dict[str, SolvedSensor]:
    """Solve every sensor of the plan; a sensor that cannot be solved says why and hinders no other."""
    rows = [at_declared(row, correcting(rig.chain)) for row in design_dwells(dwells)]
    return {name: _solve(name, sensor, rows, rig, plan, f"{source}, {name}") for name, sensor in plan.sensors.items()}


def unit_of(rig: RigDescription, channel: str) -> str:
    """The unit of a channel: V behind a readout, its own on a stream."""
    name, _, own = channel.partition(".")
    return "v" if name in rig.readouts else rig.streams[name].channel_units()[own]


def _solve(
    name: str, sensor: Sensor, rows: list[DwellRecord], rig: RigDescription, plan: Plan, source: str
) -> SolvedSensor:
    channels = {str(axis): channel for axis, channel in sensor.channels.items()}
    if not rows:
        return SolvedSensor(
            name, dwell_observations(rows, channels, source), None, "no dwell of the design is accepted"
        )
    if plan.kind == "profile":
        observations = profile_observations(rows, plan, channels, source)
    else:
        observations = dwell_observations(rows, channels, source)
    if plan.static is not None:
        return SolvedSensor(name, observations, None, None, static=_static(sensor, rows, rig, plan))
    try:
        if plan.solve.model == "linear":
            return SolvedSensor(name, observations, _lines(observations, rows, rig, plan, sensor), None)
        return _by_model(name, observations, rig, plan, sensor)
    except AmsError as error:
        return SolvedSensor(name, observations, None, str(error))


def _by_model(name: str, observations: Observations, rig: RigDescription, plan: Plan, sensor: Sensor) -> SolvedSensor:
    """CR's gyros, or accelerometers on their way."""
    foreign = sorted({unit_of(rig, channel) for channel in sensor.channels.values()} - {"v"})
    if foreign:
        return SolvedSensor(name, observations, None, _not_volts(plan.solve.model, foreign[0]))
    request = request_of(name, rig, sensor, plan.solve)
    if plan.solve.model == "gyro":
        request = replace(request, model="gyro", table=None, shared_errors={}, nominal_axes=_nominal(sensor))
    elif plan.solve.model == "pitch-roll":
        observations = replace(observations, yaw_rad=None)
    solved = calibrate(observations, request)
    if plan.solve.model != "gyro":
        solved = replace(solved, remarks=(*solved.remarks, *level_remarks(rig)))
    return SolvedSensor(name, observations, solved, None, budgets_of(solved, request, rig))


def _nominal(sensor: Sensor) -> dict[str, str]:
    return {str(axis): str(axis) for axis in sensor.channels}


def _not_volts(model: str, unit: str) -> str:
    return (
        f"the model {model!r} states volts, the channels carry {unit}; nothing was solved; declare counts_per_unit and "
        'unit = "v" for them, or use solve.model = "linear"'
    )


def _lines(
    observations: Observations, rows: list[DwellRecord], rig: RigDescription, plan: Plan, sensor: Sensor
) -> Calibration:
    """Every axis by itself on the rows that tell it something: real = gain · reading + offset. Source: SR 4.1."""
    axes, warnings = {}, dict[str, None]()
    for axis, channel in sensor.channels.items():
        label = str(axis)
        levels = known_levels(observations, rows, plan, rig, sensor, label)
        if levels.level.size == 0 or float(np.ptp(levels.level)) == 0.0:
            warnings[f"axis {label}: it was exposed to one level only: no line goes through it; it has no result"] = (
                None
            )
            continue
        nothing = np.zeros(levels.rows.size)
        own = Observations(
            replication=observations.replication[levels.rows],
            point=observations.point[levels.rows],
            pitch_rad=nothing if levels.sense is None else np.arcsin(np.clip(levels.sense, -1.0, 1.0)),
            roll_rad=nothing,
            outputs_v={label: levels.reading},
            time_s=None if observations.time_s is None else observations.time_s[levels.rows],
            reference_level=levels.level,
            source=f"{observations.source}, axis {label}",
        )
        line = StraightLine if levels.sense is None else FieldLine
        model: Model = line(label, UNITS[sensor.measures], unit_of(rig, channel))
        solved = calibrate(own, CalibrationRequest(nominal_axes={label: label}, models={label: model}))
        axes[label] = solved.axes[label]
        warnings |= dict.fromkeys(solved.warnings)
    if not axes:
        raise DesignError("no axis was exposed to two levels: nothing was solved; turn it, or lay it along the field")
    return Calibration(axes, "linear", "SR", tuple(warnings))


def lines_document(calibration: Calibration) -> dict[str, Any]:
    """Straight lines as JSON: the shape of a fit, with intervals, and standard errors in the unit of the reading."""
    axes: dict[str, Any] = {}
    for label, section in cast("dict[str, Any]", to_document(calibration)["axes"]).items():
        solved = calibration.axes[label]
        measured = solved.parameters[0].name.rpartition("_per_")[2]
        kept = {key: value for key, value in section.items() if not key.endswith(("_v", "_per_g"))}
        intervals = {one.name: None if one.interval_95 is None else list(one.interval_95) for one in solved.parameters}
        for name, interval in intervals.items():
            kept["parameters"][name]["interval_95"] = interval
        axes[label] = {**kept, f"standard_error_{measured}": section["standard_error_v"]}
    return {"axes": axes, "model": calibration.model, "convention": calibration.convention}


def _static(sensor: Sensor, rows: list[DwellRecord], rig: RigDescription, plan: Plan) -> dict[str, StaticAxis]:
    return {str(axis): _static_axis(sensor, channel, rows, rig, plan) for axis, channel in sensor.channels.items()}


def _static_axis(sensor: Sensor, channel: str, rows: list[DwellRecord], rig: RigDescription, plan: Plan) -> StaticAxis:
    """Of the longest look: the Allan deviation at the time of use says how far two neighbouring means lie apart."""
    assert plan.static is not None
    reading = rows[0].readings[channel]
    allan = allan_deviation(reading.samples_v, reading.interval_s)
    coefficients = read_coefficients(allan)
    count = reading.samples_v.size
    factor = min(max(round(plan.static.use_s / reading.interval_s), 1), count // 2)
    at_use = float(allan_deviation(reading.samples_v, reading.interval_s, [factor]).deviation[0])
    drift_deg = _drift_deg(sensor, unit_of(rig, channel), at_use, plan.static.use_s)
    means = [row.readings[channel].mean_v for row in rows]
    return StaticAxis(
        unit=unit_of(rig, channel),
        mean=float(np.mean(means)),
        mean_uncertainty=float(np.std(means, ddof=1) / sqrt(len(means)))
        if len(means) > 1
        else float(allan.deviation[-1]),
        tau_s=tuple(allan.tau_s.tolist()),
        allan_deviation=tuple(allan.deviation.tolist()),
        random_walk_per_sqrt_s=coefficients.random_walk_per_sqrt_s,
        bias_instability=coefficients.bias_instability,
        is_bottom_reached=coefficients.is_bottom_reached,
        use_s=plan.static.use_s,
        allowed_deg=plan.static.allowed_deg,
        drift_deg=drift_deg,
        verdict=_verdict(drift_deg, plan.static.use_s, plan.static.allowed_deg),
    )


def _drift_deg(sensor: Sensor, unit: str, deviation: float, use_s: float) -> float | None:
    """Zeroed by the mean over as long as it is used: √2 of the deviation at that time, integrated for a rate."""
    if sensor.measures == "rate" and unit == "dps":
        return COVERAGE * sqrt(2.0) * deviation * use_s
    per_g = 1.0 if unit == "g" else abs(sensor.nominal_sensitivity_v_per_g)
    if sensor.measures == "acceleration" and per_g:
        return float(np.rad2deg(COVERAGE * sqrt(2.0) * deviation / per_g))
    return None


def _verdict(drift_deg: float | None, use_s: float, allowed_deg: float) -> str:
    if drift_deg is None:
        return "no verdict: nothing says how many degrees its reading is"
    relation = "within" if drift_deg <= allowed_deg else "beyond"
    return f"drifts by {drift_deg:.3g} deg (k = 2) in {use_s:g} s, {relation} the allowed ±{allowed_deg:g} deg"
