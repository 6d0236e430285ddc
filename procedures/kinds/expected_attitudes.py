"""Which uncertainty a plan of attitudes should reach, as its solution will state it.

The solver itself is asked (:mod:`procedures.solution.expected`): same model, same weights, same covariance, at the
noise, the lack of fit and the drift that are believed beforehand and are told with the figures.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import gcd
from typing import Final

import numpy as np

from ams.calibration.together.in_step_hidden import hidden_in_words
from ams.errors import AmsError
from ams.models.drifting import REFERENCE_NAME
from ams.models.extended import TRACELESS_NAME
from ams.models.model import Model
from ams.models.registry import model_named
from ams.parameter_words import words_of
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.expected import ExpectedAxis
from procedures.kinds.kind import DesignFigures, Forecast
from procedures.kinds.recommendations import recommendations
from procedures.plan.designs import DesignPoint
from procedures.plan.drift_bias import drift_bias, time_correlation
from procedures.plan.judged_design import judge_design
from procedures.plan.order import SHUFFLED
from procedures.plan.plan import Plan
from procedures.plan.sequential import usage_pitch_deg
from procedures.plan.specific_force import columns_of
from procedures.plan.undeclared import undeclared_of_plan
from procedures.records.declared_gaps import thermometer_remarks
from procedures.solution.beliefs import AxisBelief, Pilot, beliefs_of
from procedures.solution.expected import Believed, ExpectedSensor, PlannedRows, Usage, expected_sensor
from procedures.solution.expected_readings import read_adaptively
from procedures.solution.foreseen import foreseen_warnings, use_remarks
from procedures.solution.level_of_base import level_warnings
from procedures.solution.request import joint_priors_in_words
from procedures.solution.type_b import gravity_warnings
from rig.description.rig_file import RigDescription

_NO_PARAMETERS = (TRACELESS_NAME, REFERENCE_NAME, "reference_temperature_degc")
"""Stated beside the parameters: made from others, or chosen."""
_STEPS_PER_DEG: Final = 1000
_TURN: Final = 360 * _STEPS_PER_DEG
_FEWEST_ROLLS: Final = 2
"""With no more there is no step that they could lie off."""
_MOST_WAVES: Final = 72
"""A turn: finer ones are of steps below 5°."""


def forecast_of_design(
    rig: RigDescription,
    procedure: ProcedureDescription,
    plan: Plan,
    further: Iterable[str],
    pilot: Pilot | None = None,
) -> Forecast:
    """Judge a design of attitudes and the uncertainties that it should reach. ``further``: advice of its kind."""
    judged = judge_design(plan.design, plan.usage_pitch_deg)
    usage = usage_of(procedure, plan)
    beliefs = beliefs_of(rig, plan.solve, plan.dwell.samples, plan.replications, plan.sensors, pilot)
    believed = read_adaptively(rig, plan.dwell, plan.sensors, beliefs)
    of_sensor = {
        serial: Believed(
            {axis: belief for (name, axis), belief in believed.items() if name == serial}, plan.dwell.samples
        )
        for serial in plan.sensors
    }
    rows = _planned_rows(plan)
    sensors = _expected_sensors(rig, procedure, plan, rows, of_sensor, usage)
    first = next(iter(next(iter(sensors.values())).solution.axes.values()))
    parameters = [item.name for item in first.parameters if item.name not in _NO_PARAMETERS]
    correlation = time_correlation_of(plan)
    figures = DesignFigures(
        parameters=tuple(words_of(name).label for name in parameters),
        rank=len(parameters),
        degrees_of_freedom=first.degrees_of_freedom,
        figure_of_merit_sqrt=judged.figures.figure_of_merit_sqrt,
        usage_figure_of_merit_sqrt=judged.figures.usage_figure_of_merit_sqrt,
        time_correlation=correlation,
        drift_bias=_drift_bias(plan),
        roll_errors_alike_every_deg=_alike_every_deg(plan),
    )
    followed = recommendations(plan, believed, sensors)
    return Forecast(
        expected=tuple(_axes(sensors, believed, plan.dwell.samples)),
        advice=(
            *(expected.advice for expected in followed if expected.advice),
            *_advice(plan),
            *_never_enough(plan, sensors),
            *further,
        ),
        design=figures,
        angles={serial: sensor.angles for serial, sensor in sensors.items()},
        usage_pitch_deg=usage.pitch_deg,
        reservations=(*_reservations_of_rig_and_solution(rig, plan), *_foreseen(rig, plan, rows, of_sensor)),
        remarks=tuple(_remarks(rig, plan)),
        recommendations=followed,
    )


def _remarks(rig: RigDescription, plan: Plan) -> Iterator[str]:
    yield from undeclared_of_plan(rig, plan).remarks
    yield from (said.text for said in thermometer_remarks(rig, plan.sensors.values(), plan.solve.temperature))
    if plan.environment is None:
        yield from use_remarks(rig, plan.solve, plan.sensors)


def _alike_every_deg(plan: Plan) -> float | None:
    """Return the period of errors of the roll axis that every point has alike; None where rolls lie in no even steps.

    Such errors pass for a turn of the package: whether they are within what is declared no residual tells.
    """
    steps = {round(point.roll_deg * _STEPS_PER_DEG) for point in plan.design.points}
    waves = _TURN // gcd(_TURN, *(step - min(steps) for step in steps))
    return 360.0 / waves if len(steps) > _FEWEST_ROLLS and waves <= _MOST_WAVES else None


def usage_of(procedure: ProcedureDescription, plan: Plan) -> Usage:
    """Return where the sensors will be used: as stated, else two thirds of the calibrated range."""
    return Usage(usage_pitch_deg(procedure, plan.design), procedure.design.usage_noise_arcsec)


def _planned_rows(plan: Plan) -> PlannedRows:
    """Return the rows in the order of their visits, at the plateau of every replication."""
    plateaus = plan.environment.plateaus_degc if plan.environment is not None else ()
    each = plan.replications // max(len(plateaus), 1)
    row_of = {point.label: number for number, point in enumerate(plan.design.points)}
    visited: dict[int, list[int]] = {}
    for dwell in plan.design_dwells:
        visited.setdefault(dwell.replication, []).append(row_of[dwell.point])
    return PlannedRows(
        plan.design.points,
        plan.replications,
        [degc for degc in plateaus for _ in range(each)] or None,
        plan.expected.p50_s / plan.replications,
        [visited[replication] for replication in sorted(visited)],
    )


def _expected_sensors(
    rig: RigDescription,
    procedure: ProcedureDescription,
    plan: Plan,
    rows: PlannedRows,
    believed: Mapping[str, Believed],
    usage: Usage,
) -> dict[str, ExpectedSensor]:
    found = {}
    for serial, sensor in plan.sensors.items():
        try:
            found[serial] = expected_sensor(rig, plan.solve, serial, sensor, rows, believed[serial], usage)
        except AmsError as error:
            raise procedure.error(("solve", "model"), f"{serial} cannot be solved from this plan: {error}") from None
    return found


def _foreseen(rig: RigDescription, plan: Plan, rows: PlannedRows, believed: Mapping[str, Believed]) -> Iterator[str]:
    """Yield what the solutions will be reserved about; what all sensors share is said once."""
    of_sensor = {
        serial: foreseen_warnings(rig, plan.solve, serial, sensor, rows, believed[serial])
        for serial, sensor in plan.sensors.items()
    }
    for text in dict.fromkeys(text for texts in of_sensor.values() for text in texts):
        whose = [serial for serial, texts in of_sensor.items() if text in texts]
        yield text if len(whose) == len(of_sensor) else f"{', '.join(whose)}: {text}"


def _axes(
    sensors: Mapping[str, ExpectedSensor], believed: Mapping[tuple[str, str], AxisBelief], samples: int
) -> Iterator[ExpectedAxis]:
    for serial, sensor in sensors.items():
        for axis, solution in sensor.solution.axes.items():
            belief = believed[serial, axis]
            stated = [item for item in solution.parameters if item.standard_uncertainty != 0.0]
            yield ExpectedAxis(
                sensor=serial,
                axis=axis,
                noise_v=belief.noise_v(samples),
                noise_source=f"{belief.noise_source}; {belief.components_source}",
                coning_deg=belief.coning_deg,
                standard_uncertainty={item.name: item.standard_uncertainty for item in stated},
                half_width_95={
                    item.name: None if item.interval_95 is None else 0.5 * (item.interval_95[1] - item.interval_95[0])
                    for item in stated
                },
            )


def time_correlation_of(plan: Plan) -> float:
    """Return the correlation of time with the terms of the model in the first replication."""
    return time_correlation(*_first_replication(plan))


def _first_replication(plan: Plan) -> tuple[Model, Sequence[DesignPoint], float]:
    """Return the model of the first axis of the first sensor, the points in their order, and its nominal V/g."""
    by_label = {point.label: point for point in plan.design.points}
    points = [by_label[dwell.point] for dwell in plan.design_dwells if dwell.replication == 1]
    serial, sensor = next(iter(plan.sensors.items()))
    axis = str(next(iter(sensor.channels)))
    model = model_named(plan.solve.model_of(serial, rolls=sensor.rolls), axis)
    return model, points, sensor.nominal_v_per_g(axis) or 1.0


def _drift_bias(plan: Plan) -> dict[str, Mapping[str, float]]:
    """Return what a drift leaves under each order, for the first axis of the first sensor."""
    serial, sensor = next(iter(plan.sensors.items()))
    axis = str(next(iter(sensor.channels)))
    once = {(point.pitch_deg, point.yaw_deg, point.roll_deg): point for point in reversed(plan.design.points)}
    design = replace(plan.design, points=tuple(sorted(once.values(), key=lambda point: point.label)))
    model = model_named(plan.solve.model_of(serial), axis)
    return drift_bias(model, design, sensor.nominal_v_per_g(axis) or 1.0)


def _reservations_of_rig_and_solution(rig: RigDescription, plan: Plan) -> Iterator[str]:
    """Yield what the report will hold against the result whatever the rows are."""
    yield from level_warnings(rig)
    yield from dict.fromkeys(text for sensor in plan.sensors.values() for text in gravity_warnings(rig, sensor))
    if plan.solve.joint:
        priors = joint_priors_in_words(plan.solve.joint_priors_arcsec.items())
        yield (
            "package and table are solved together; the expected uncertainties are those of each axis by itself"
            f"{f', and hold nothing of {priors}' if priors else ''}"
        )


def _never_enough(plan: Plan, sensors: Mapping[str, ExpectedSensor]) -> Iterator[str]:
    """Say where ``[stop]`` asks for what all replications together are not expected to reach."""
    rule = plan.sequential
    if rule is None:
        return
    worst = max(
        ((angle.u95_deg, serial, name) for serial, sensor in sensors.items() for name, angle in sensor.angles.items()),
        default=None,
    )
    if worst is not None and worst[0] > rule.half_width_deg:
        yield (
            f"[stop] half_width_deg = {rule.half_width_deg:g} is not expected to be reached: after all "
            f"{plan.replications} replications U95 of {worst[2]} of {worst[1]} is {worst[0]:.2g}°, so the run measures "
            "them all"
        )


def _advice(plan: Plan) -> Iterator[str]:
    """Yield what beside TP's recommendations would serve the run."""
    if plan.reference is not None and plan.is_at_rest and not plan.reference.tells_slip_from_tilt:
        yield (
            "reference visits at attitudes that do not differ in pitch and in roll cannot tell a slip of the table "
            "from a tilt of its base, and of a lone sensor not from its own change: name two, such as [check] "
            "pitch_deg = [0, 30], roll_deg = [0, 60]"
        )
    yield from _advice_on_what_comes_back(plan)


def _advice_on_what_comes_back(plan: Plan) -> Iterator[str]:
    """Tell where what is alike in every replication passes for terms of the model."""
    if plan.order in SHUFFLED or plan.replications == 1:
        return
    model, visited, nominal_v_per_g = _first_replication(plan)
    pitch_rad, roll_rad = np.deg2rad([(point.pitch_deg, point.roll_deg) for point in visited]).T
    hidden = hidden_in_words(columns_of(model, visited, nominal_v_per_g), pitch_rad, roll_rad)
    if hidden:
        yield (
            f'the order "{plan.order}" is the same in every replication: {hidden}; '
            'order = "neighbours" turns it into noise'
        )


def advice_on_usage(plan: Plan) -> Iterator[str]:
    """Tell where the usage range reaches beyond what is calibrated."""
    if plan.usage_pitch_deg is None:
        return
    low, high = min(plan.design.pitch_values_deg), max(plan.design.pitch_values_deg)
    if not low <= plan.usage_pitch_deg[0] < plan.usage_pitch_deg[1] <= high:
        yield (
            f"the usage range {plan.usage_pitch_deg[0]:g}° to {plan.usage_pitch_deg[1]:g}° reaches beyond the "
            f"calibration, {low:g}° to {high:g}°: nothing is validated there"
        )
