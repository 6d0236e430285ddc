"""Straight lines of SR, real = gain · reading + offset: every axis with the errors of its known levels.

A magnetometer is solved with the field across its axes where its attitudes determine that:
:mod:`procedures.solution.triad`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ams.analysis.calibration_budget import AxisBudget, axis_budget
from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL
from ams.analysis.diagnostics.declared.declared_field import FieldAxis, field_finding, judge_field
from ams.analysis.diagnostics.declared.unlike_axes import with_unlike_axes
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration.document import to_document
from ams.calibration.findings_document import budget_document, findings_document
from ams.calibration.solving.model_choice import requested_model
from ams.calibration_result import AxisCalibration, Calibration
from ams.errors import DesignError
from ams.findings import Finding
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import COURSES, SharedError
from ams.models.field_line import FieldLine
from ams.models.field_triad import FieldTriad, to_package
from ams.models.model import Model
from ams.models.straight_line import StraightLine
from ams.observations import Observations
from ams.sets.verdict_conditions import DIRECTIONS_NOT_MEASURED
from ams.solve.layout import layout_of
from procedures.solution.declared_directions import declared_in_package
from procedures.solution.levels import LevelError, LevelRows, known_levels, levels_of
from procedures.solution.request import SensorRows, SolvedSensor
from procedures.solution.run_findings import with_run_findings
from procedures.solution.said_of_run import said_of_run
from procedures.solution.temperature_of_use import calibrated_degc
from procedures.solution.triad import TriadAxis, triad_of
from procedures.solution.type_b import shared_errors

EARTH_UT = 50.0
"""What stands across an axis where nothing is declared; the Earth's field has 25 to 65 µT."""
_LEAST_TOGETHER = 2
"""Axes that can contradict each other."""


def solve_lines(item: SensorRows, observations: Observations) -> SolvedSensor:
    """Solve every axis by itself on the rows that tell it something. Source: SR 4.1. Raises: AmsError."""
    if observations.mounting is not None:
        raise DesignError(
            f"{observations.source}: the package was moved in between: straight lines take one mounting; nothing was "
            "solved; take back what was measured before the package was moved"
        )
    axes: dict[str, AxisCalibration] = {}
    budgets: dict[str, AxisBudget] = {}
    declared: dict[str, DeclaredDirection] = {}
    lines = lines_of(item, observations)
    warnings = dict.fromkeys(
        f"axis {label}: it was exposed to one level only: no line goes through it; it has no result"
        for label in item.channels
        if label not in lines
    )
    for label, line in lines.items():
        request = line_request(item, label, line)
        solved = calibrate(line.rows, request)
        axes[label] = solved.axes[label]
        if any(estimate.value is not None for estimate in axes[label].parameters):
            solved_by = requested_model(label, line.rows, layout_of(line.rows), request)
            budgets[label] = axis_budget(axes[label], line.errors, model=solved_by)
        warnings |= dict.fromkeys(solved.warnings)
    declared = {
        label: declared_in_package(item.sensor, label, line.rows.unit_of(label)) for label, line in lines.items()
    }
    if not axes:
        raise DesignError("no axis was exposed to two levels: nothing was solved; turn it, or lay it along the field")
    along = [label for label, line in lines.items() if not isinstance(line.model, FieldTriad)]
    warnings |= dict.fromkeys(_across(item, along))
    said = said_of_run(item, observations, {label: line.errors for label, line in lines.items()})
    warnings |= dict.fromkeys(said.warnings)
    is_along_all = len(along) > 1 and item.sensor.measures != "field"
    remarks = (*((DIRECTIONS_NOT_MEASURED,) if is_along_all else ()), *said.remarks)
    calibration = Calibration(with_unlike_axes(axes, declared), "linear", "SR", tuple(warnings), remarks)
    solved_sensor = SolvedSensor(item.name, observations, calibration, None, budgets)
    return with_run_findings(solved_sensor, [*_field_findings(item, lines), *said.undeclared.findings])


@dataclass(frozen=True)
class Line:
    """What one axis is solved by."""

    model: Model
    rows: Observations
    errors: tuple[SharedError, ...]


def lines_of(
    item: SensorRows, observations: Observations, scatter: Mapping[str, float] | None = None
) -> Mapping[str, Line]:
    """Return the line of every axis that was exposed to two levels or more.

    ``scatter``: of the readings of every axis, for rows that are planned; None: as they show it.
    """
    triad = triad_of(item, observations, scatter)
    lines = {
        label: _of_triad(item, observations, label, triad[label])
        if label in triad
        else _line(item, observations, label)
        for label in item.channels
    }
    return {label: line for label, line in lines.items() if line is not None}


def line_request(item: SensorRows, label: str, line: Line) -> CalibrationRequest:
    """Return what is asked of one axis."""
    return CalibrationRequest(
        nominal_axes={label: label},
        models={label: line.model},
        declared={label: declared_in_package(item.sensor, label, line.rows.unit_of(label))},
        shared_errors={label: line.errors},
        tested_axes=item.tested_axes,
        known_of_run=item.known_of_run,
        time_term=item.plan.solve.time_term == "linear",
    )


def _line(item: SensorRows, observations: Observations, label: str) -> Line | None:
    """Return the line along the nominal direction; None where there are no two levels."""
    levels = known_levels(item, observations, label)
    if levels.level.size == 0 or float(np.ptp(levels.level)) == 0.0:
        return None
    line = StraightLine if levels.sense is None else FieldLine
    model = line(label, item.sensor.sensed_unit, observations.unit_of(label))
    return Line(model, _rows(observations, label, levels), _errors(item, observations, label, levels.errors))


def _of_triad(item: SensorRows, observations: Observations, label: str, axis: TriadAxis) -> Line:
    rows = replace(
        observations,
        outputs={label: observations.outputs[label]},
        units={label: observations.unit_of(label)},
        reference_level=axis.applied_ut,
        level_errors=_columns(axis.errors),
        source=f"{observations.source}, axis {label}",
    )
    of_field = [replace(error, error=replace(error.error, effect="field")) for error in axis.errors]
    return Line(axis.model, rows, _errors(item, observations, label, of_field))


def _field_findings(item: SensorRows, lines: Mapping[str, Line]) -> Iterator[Finding]:
    """Yield what all axes together say of their field; nothing where fewer than two were solved as components of it."""
    triads = {label: (line, line.model) for label, line in lines.items() if isinstance(line.model, FieldTriad)}
    if len(triads) < _LEAST_TOGETHER:
        return
    (first, model), *_ = triads.values()
    assert first.rows.reference_level is not None
    test = judge_field(
        to_package(model.package_axes, first.rows),
        np.array(model.coil),
        first.rows.reference_level,
        {label: _seen(label, line, of_axis) for label, (line, of_axis) in triads.items()},
        layout_of(first.rows),
        is_declared=model.sensitive_axis is None,
    )
    # The level of a run is shared out by axes: a test of several has the share of all of them.
    if test is not None:
        yield field_finding(test, len(triads) * LEVEL / item.tested_axes / MOST_TESTS, "µT")


def _seen(label: str, line: Line, model: FieldTriad) -> FieldAxis:
    columns = line.rows.level_errors
    of_level = [] if columns is None else [(error.name, columns[:, list(error.columns)]) for error in line.errors]
    errors = {name: each for name, each in of_level if each.shape[1] > 0}
    return FieldAxis(line.rows.outputs[label], np.array(model.surroundings), errors)


def _across(item: SensorRows, labels: Sequence[str]) -> Iterator[str]:
    """Say what a line along the nominal direction cannot know: the field across an axis does not turn with it."""
    if item.sensor.measures != "field" or not labels:
        return
    levels = levels_of(item.plan)
    known = None if levels is None else levels.surroundings_ut
    strength_ut = EARTH_UT if known is None else float(np.linalg.norm(known))
    subject = "each line" if len(labels) == len(item.channels) else f"the line of {' and '.join(labels)}"
    yield (
        f"{subject} takes its axis as lying along its nominal direction: of a field across it, one that lies or is "
        f"set beside it senses {strength_ut * np.sin(np.deg2rad(1.0)):.2g} µT for each degree (in a field of "
        f"{strength_ut:.3g} µT across), the same in both senses; that is in the offset, not in its uncertainty; lay "
        "every axis of the package along and against a coil of known field, which tells how each lies, or keep the "
        "field across the coil small"
    )


def _errors(
    item: SensorRows, observations: Observations, label: str, errors: Sequence[LevelError]
) -> tuple[SharedError, ...]:
    """Return the errors of meter and sensor as they are, and everything else as an error of the known levels."""
    degc = calibrated_degc(item.plan.solve.temperature, observations.temperature_degc)
    of_reading = [
        shared_error
        for shared_error in shared_errors(item.rig, item.sensor, calibrated_degc=degc)[label]
        if shared_error.effect in ("reading", "gain", "departure", "specific-force", "crosstalk", *COURSES)
    ]
    ends = np.cumsum([error.columns.shape[1] for error in errors]).tolist()
    starts = [0, *ends]
    of_level = [
        replace(error.error, columns=tuple(range(start, end)))
        for error, start, end in zip(errors, starts, ends, strict=False)
    ]
    return (*of_reading, *of_level)


def _rows(observations: Observations, label: str, levels: LevelRows) -> Observations:
    """Return one axis' rows: a model of lines takes the sense of a row, if it has one, as its pitch."""
    nothing = np.zeros(levels.rows.size)
    return Observations(
        replication=observations.replication[levels.rows],
        point=observations.point[levels.rows],
        pitch_rad=nothing if levels.sense is None else np.arcsin(np.clip(levels.sense, -1.0, 1.0)),
        roll_rad=nothing,
        outputs={label: levels.reading},
        units={label: observations.unit_of(label)},
        time_s=None if observations.time_s is None else observations.time_s[levels.rows],
        reference_level=levels.level,
        level_errors=_columns(levels.errors),
        scanned_v=None if observations.scanned_v is None else observations.scanned_v[levels.rows],
        from_level=None if observations.from_level is None else observations.from_level[levels.rows],
        sampled={label: observations.sampled[label]} if label in observations.sampled else {},
        step=None if observations.step is None else observations.step[levels.rows],
        source=f"{observations.source}, axis {label}",
        run=observations.run,
    )


def _columns(errors: Sequence[LevelError]) -> FloatArray | None:
    return np.concatenate([error.columns for error in errors], axis=1) if errors else None


def lines_document(calibration: Calibration, budgets: Mapping[str, AxisBudget]) -> dict[str, Any]:
    """Return straight lines as JSON: the shape of a fit, with intervals, and standard errors in the reading's unit."""
    axes: dict[str, Any] = {}
    for label, section in cast("dict[str, Any]", to_document(calibration)["axes"]).items():
        solved = calibration.axes[label]
        measured = solved.parameters[0].name.rpartition("_per_")[2]
        kept = {key: value for key, value in section.items() if not key.endswith(("_v", "_per_g"))}
        intervals = {
            parameter.name: None if parameter.interval_95 is None else list(parameter.interval_95)
            for parameter in solved.parameters
        }
        for name, interval in intervals.items():
            kept["parameters"][name]["interval_95"] = interval
        standard_error = {f"standard_error_{measured}": section["standard_error_v"]}
        axes[label] = {**kept, **standard_error, "findings": findings_document(solved)}
        if label in budgets:
            axes[label]["budget"] = budget_document(budgets[label])
    return {
        "axes": axes,
        "verdict": calibration.verdict,
        "model": calibration.model,
        "convention": calibration.convention,
    }
