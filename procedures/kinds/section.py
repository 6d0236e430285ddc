"""What the report says of a sensor that is told by its readings: tables of texts and curves.

The attitude's pages turn volts into angles; a gyro or a magnetometer has none, so its pages are these.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.calibration_budget import AxisBudget
from ams.arrays import FloatArray
from ams.calibration_result import Calibration, ParameterEstimate
from ams.frames import wrap_deg
from ams.parameter_words import words_of
from ams.rounding import two_digits, with_uncertainty
from ams.statistics.intervals import degrees_of_freedom
from ams.units import printed
from procedures.numbers import p_value, three_digits
from procedures.plan.plan import Plan
from procedures.plan.steps import Turn
from procedures.records.dwells import DwellRecord
from procedures.solution.budget_view import FORMS as BUDGET_FORMS
from procedures.solution.budget_view import budget_view
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from rig.description.rig_file import AxisTruth, RigDescription, Sensor

UnitOf = Callable[[str], str]
"""Axis to the unit of its readings."""
_NUMBER: Final = re.compile(r"[-+−]?\d+(\.\d+)?(e[-+]\d+)?")
_NO_NUMBER: Final = frozenset(("", "·", "—", "∞", "> 10 000", "not determined"))
LARGEST_PRINTED = 0.1
"""An uncertainty of a clock's drift beyond says that nothing is known."""


@dataclass(frozen=True)
class TextTable:
    """A table as it is printed."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    @property
    def are_numbers(self) -> tuple[bool, ...]:
        """Whether each column holds numbers, or what stands where there is none."""
        columns = tuple(zip(*self.rows, strict=True))
        return tuple(
            any(map(_NUMBER.fullmatch, cells)) and all(_NUMBER.fullmatch(cell) or cell in _NO_NUMBER for cell in cells)
            for cells in columns
        ) or (False,) * len(self.headings)


@dataclass(frozen=True)
class Curve:
    """One line or cloud of a plot."""

    label: str
    x: FloatArray
    y: FloatArray


@dataclass(frozen=True)
class Plot:
    """One picture, still as numbers."""

    name: str
    title: str
    caption: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    is_logarithmic: bool = False


@dataclass(frozen=True)
class SensorPage:
    """Everything that is said about one sensor."""

    result: str
    """One sentence."""
    doubts: tuple[str, ...]
    tables: tuple[TextTable, ...]
    plots: tuple[Plot, ...]


def section_of(record: RunRecord, solved: SolvedSensor) -> SensorPage:
    """Return the tables of a calibration that is told by its readings; without one only what was recorded."""
    name, sensor, rig, calibration = solved.name, record.plan.sensors[solved.name], record.rig, solved.calibration
    recorded, unit_of = recorded_tables(record.dwells), solved.observations.unit_of
    if calibration is None:
        return SensorPage(f"{name}: not solved", (), recorded, ())
    truths = _truths(rig, name, sensor, unit_of)
    tables = (
        _parameters(calibration, truths),
        *_budgets(solved.budgets),
        _fits(calibration, sensor, unit_of),
        *_tests(calibration),
        *recorded,
        *_rates(_accepted(record.dwells), record.plan),
    )
    plots = tuple(_residual_plots(name, calibration, unit_of))
    return SensorPage(_result(name, calibration, unit_of), tuple(_doubts(name, calibration)), tables, plots)


def recorded_tables(dwells: Sequence[DwellRecord]) -> tuple[TextTable, ...]:
    """Return what the streams recorded: one table, or none where there were none."""
    return tuple(_timings(_accepted(dwells)))


def _accepted(dwells: Sequence[DwellRecord]) -> list[DwellRecord]:
    return [dwell for dwell in dwells if dwell.accepted and dwell.purpose == "design"]


def _result(name: str, calibration: Calibration, unit_of: UnitOf) -> str:
    parts = [
        f"{axis} {two_digits(solved_axis.standard_error_v)} {printed(unit_of(axis))}"
        for axis, solved_axis in calibration.axes.items()
    ]
    return f"{name}: model {calibration.model}, standard error of one row {', '.join(parts)}"


def _doubts(name: str, calibration: Calibration) -> Iterator[str]:
    for axis, solved_axis in calibration.axes.items():
        if solved_axis.replication is None:
            yield f"{name} {axis}: one replication only, so lack of fit and drift could not be tested."
        yield from (f"{name} {text}" for text in solved_axis.warnings)
    yield from (f"{name}: {text}" for text in calibration.warnings)


def _parameters(calibration: Calibration, truths: Mapping[str, Mapping[str, float]]) -> TextTable:
    rows = [
        (axis if index == 0 else "", *_parameter_cells(estimate, truths.get(axis, {}).get(estimate.name), bool(truths)))
        for axis, solved_axis in calibration.axes.items()
        for index, estimate in enumerate(solved_axis.parameters)
    ]
    simulated = ("twin's truth", "95 % interval holds it") if truths else ()
    headings = ("axis", "parameter", "unit", "value", "± (95 %)", "ν", *simulated)
    form = "real = A · reading + B" if calibration.convention == "SR" else "v = b + k·ω, CR's azimuth and coning angle"
    return TextTable("Parameters", headings, tuple(rows), form)


def _parameter_cells(estimate: ParameterEstimate, truth: float | None, is_simulated: bool) -> tuple[str, ...]:
    label, unit = words_of(estimate.name).lettered, words_of(estimate.name).unit
    interval = estimate.interval_95
    half = None if interval is None else 0.5 * (interval[1] - interval[0])
    value, expanded = ("not determined", "—") if estimate.value is None else with_uncertainty(estimate.value, half)
    cells = (label, unit, value, expanded, degrees_of_freedom(estimate.effective_degrees_of_freedom))
    if not is_simulated:
        return cells
    if truth is None or interval is None:
        return (*cells, "—" if truth is None else f"{truth:.6g}", "—")
    return (*cells, with_uncertainty(truth, half)[0], "yes" if interval[0] <= truth <= interval[1] else "no")


def _budgets(budgets: Mapping[str, AxisBudget]) -> Iterator[TextTable]:
    """Yield a table of what each source alone puts into each parameter, and what all make of it."""
    views = {axis: budget_view(budget) for axis, budget in budgets.items()}
    rows = [
        (
            axis if index == 0 else "",
            row.source,
            row.type,
            degrees_of_freedom(row.degrees_of_freedom) if row.type else "",
            *row.cells,
            row.stated,
        )
        for axis, view in views.items()
        for index, row in enumerate(view.rows)
    ]
    if rows:
        parameters = next(iter(views.values())).headings
        headings = ("axis", "source", "type", "ν", *(f"{label} ({unit})" for label, unit in parameters), "stated")
        yield TextTable("Uncertainty budget", headings, tuple(rows), BUDGET_FORMS)


def _fits(calibration: Calibration, sensor: Sensor, unit_of: UnitOf) -> TextTable:
    rows = tuple(
        (
            axis,
            sensor.channels[axis],  # type: ignore[index]
            f"{two_digits(solved_axis.standard_error_v)} {printed(unit_of(axis))}",
            str(solved_axis.degrees_of_freedom),
        )
        for axis, solved_axis in calibration.axes.items()
    )
    return TextTable("Fit", ("axis", "channel", "standard error of one row", "degrees of freedom"), rows)


def _tests(calibration: Calibration) -> Iterator[TextTable]:
    rows = []
    for axis, solved_axis in calibration.axes.items():
        if solved_axis.replication is None:
            continue
        tests = {"lack of fit": solved_axis.replication.lack_of_fit, **solved_axis.replication.drift}
        for subject, test in tests.items():
            label = subject if subject == "lack of fit" else f"drift of {words_of(subject).lettered}"
            rows.append((axis, label, three_digits(test.t), three_digits(test.f_95), p_value(test.p_value)))
    if rows:
        note = "Significant only among all tests of all axes of the run (Holm's correction, each axis with its share)."
        yield TextTable("Replication", ("axis", "test", "T", "F₀.₉₅", "p"), tuple(rows), note)


def _rates(rows: Sequence[DwellRecord], plan: Plan) -> Iterator[TextTable]:
    """Yield the measured rates beside what was asked for."""
    turns = {step.step: step.motion for step in plan.dwells if isinstance(step.motion, Turn)}
    cells = []
    for row in rows:
        turn = turns.get(row.step)
        if turn is not None and row.motion is not None:
            measured = row.motion.rates_dps[turn.turned_axis]
            value, uncertainty = with_uncertainty(measured, row.motion.rate_uncertainty_dps[turn.turned_axis])
            turned = f"{row.motion.turned_deg / 360.0:+.3f}"
            cells.append((str(row.replication), turn.turned_axis, f"{turn.rate_dps:+g}", value, uncertainty, turned))
    if not cells:
        return
    note = "Rates from position and time; u is their standard uncertainty."
    headings = ("replication", "axis", "set (°/s)", "measured (°/s)", "u (°/s)", "revolutions")
    yield TextTable("Rates", headings, tuple(cells), note)


def _timings(rows: Sequence[DwellRecord]) -> Iterator[TextTable]:
    """Yield the streams over all dwells: samples, what was missing, how the device's clock ran."""
    found: dict[str, list[tuple[int, int, float, float]]] = {}
    drifts: dict[str, list[float]] = {}
    for row in rows:
        for stream in () if row.motion is None else row.motion.streams:
            lost = stream.missing + stream.doubled + stream.doubtful
            found.setdefault(stream.stream, []).append(
                (stream.samples, lost, stream.offset_uncertainty_s, stream.drift)
            )
            drifts.setdefault(stream.stream, []).append(stream.drift_uncertainty)
    if not found:
        return
    cells = tuple(
        (
            stream,
            str(sum(row[0] for row in ones)),
            str(sum(row[1] for row in ones)),
            two_digits(1e3 * max(row[2] for row in ones)),
            f"{1e6 * float(np.median([row[3] for row in ones])):.1f}",
            _ppm(float(np.median(drifts[stream]))),
        )
        for stream, ones in found.items()
    )
    headings = ("stream", "samples", "lost", "u(offset), largest (ms)", "drift (ppm)", "u(drift) (ppm)")
    yield TextTable(
        "Recorded",
        headings,
        cells,
        "Offset and drift of its clock against the rig's by a line through the stamps of least delay; medians.",
    )


def _ppm(drift_uncertainty: float) -> str:
    return two_digits(1e6 * drift_uncertainty) if drift_uncertainty < LARGEST_PRINTED else "too short to tell"


def _residual_plots(name: str, calibration: Calibration, unit_of: UnitOf) -> Iterator[Plot]:
    """Yield the residuals over what was fitted: a straight cloud about zero says that the model holds."""
    units = {unit_of(axis) for axis in calibration.axes}
    unit = printed(units.pop()) if len(units) == 1 else "channel's unit"
    curves = tuple(
        Curve(axis, np.asarray(solved_axis.fitted_v), np.asarray(solved_axis.residuals_v))
        for axis, solved_axis in calibration.axes.items()
    )
    yield Plot(
        f"{name}-residuals", "Residuals", "Reading less fit, one point a row.", f"fitted reading ({unit})",
        f"residual ({unit})", curves,
    )  # fmt: skip


def _truths(rig: RigDescription, name: str, sensor: Sensor, unit_of: UnitOf) -> dict[str, dict[str, float]]:
    """Return axis to parameter to what the twin really is; empty at the bench and for turned mounts."""
    straight = (sensor.mount.x, sensor.mount.y, sensor.mount.z) == ("+x", "+y", "+z")
    if rig.twin is None or not rig.is_simulated or not straight:
        return {}
    known = {str(axis): truth for axis, truth in rig.twin.truth.get(name, {}).items()}
    return {axis: _truth(truth, sensor, unit_of(axis)) for axis, truth in known.items()}


def _truth(truth: AxisTruth, sensor: Sensor, unit: str) -> dict[str, float]:
    """Return what a twin's axis really is; of a dead one no reading can be turned into the real quantity."""
    along = truth.per_unit * float(np.cos(np.deg2rad(truth.coning_deg)))
    quantity = sensor.sensed_unit
    known = {
        "offset_v": truth.at_zero,
        f"sensitivity_v_per_{quantity}": truth.per_unit,
        "coning_deg": truth.coning_deg,
        "azimuth_deg": wrap_deg(truth.azimuth_deg + 90.0),
    }
    if along:
        known |= {f"gain_{quantity}_per_{unit}": 1.0 / along, f"offset_{quantity}": -truth.at_zero / along}
    return known
