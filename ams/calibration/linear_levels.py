"""Linear calibrations from a CSV file: known levels against readings, and the JSON document of what comes out.

Columns: ``replication,point``, the known level as ``reference_<unit>`` for every axis or ``reference_<axis>_<unit>``
for one (an empty cell: the row says nothing about this axis), and a reading per axis, ``<name>_<unit>``. Units are what
the columns say, and the answers carry them: real = gain·measured + offset. Source: SR 4.1.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ams.analysis.calibration_budget import axis_budget
from ams.analysis.diagnostics.declared.unlike_axes import with_unlike_axes
from ams.calibration.calibrate import calibrate
from ams.calibration.document import Document, to_document
from ams.calibration.findings_document import budget_document, findings_document
from ams.calibration.solving.model_choice import requested_model
from ams.calibration_result import Calibration, SensorVerdict
from ams.errors import DesignError, ObservationsError
from ams.inputs.csv_table import PLAIN, CsvForm, CsvTable, labels, numbers, parse_csv, refuse_missing_columns
from ams.inputs.declared_direction import DeclaredDirection, nominal_of_unit
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.models.linear import fit_line
from ams.models.straight_line import StraightLine
from ams.observations import Observations
from ams.sets.stated_findings import LEVELS_NOT_COUNTED
from ams.sets.verdict_conditions import DIRECTIONS_NOT_MEASURED
from ams.solve.layout import layout_of

SCALE, ZERO = "scale of the known levels", "zero of the known levels"
"""Names of what a reference may be wrong by; the places are those of its ``level_errors``."""
_OPTIONS: Mapping[str, str] = MappingProxyType(
    {SCALE: "--reference-uncertainty-ppm", ZERO: "--reference-zero-uncertainty"}
)
_LARGEST_SPREAD = 0.01
"""Levels of one point may differ by this part of the whole span."""


@dataclass(frozen=True)
class Levels:
    """One axis: its rows and the units that its columns state."""

    observations: Observations
    model: StraightLine


def read_levels(path: str | Path, axes: Mapping[str, str], form: CsvForm = PLAIN) -> dict[str, Levels]:
    """Read the levels of every axis; ``axes`` maps an axis to the column of its readings.

    Raises:
        ObservationsError: the file cannot be read or says something impossible; nothing was solved.
    """
    return levels_of_table(parse_csv(Path(path), form), axes)


def levels_of_table(table: CsvTable, axes: Mapping[str, str]) -> dict[str, Levels]:
    """Read the levels of every axis from a table. Raises: ObservationsError, as for a file."""
    refuse_missing_columns(table, ("replication", "point", *axes.values()))
    return {axis: _levels(table, axis, column) for axis, column in axes.items()}


def linear_document(levels: Mapping[str, Levels], request: CalibrationRequest) -> Document:
    """Return the document of axes that are each solved on their own rows.

    ``{"axes": {…}}``, the shape of a fit with the units of these columns.
    """
    request = replace(request, tested_axes=len(levels))
    solved = _solved_lines(levels, request)
    axes = {
        axis: _axis_document(axis, found, solved[axis], request) if axis in solved else _two_levels(found, request)
        for axis, found in levels.items()
    }
    return {
        "axes": axes,
        "verdict": _verdict_of(axes.values()),
        "model": "linear",
        "convention": "SR",
        **({"remarks": [DIRECTIONS_NOT_MEASURED]} if len(levels) > 1 else {}),
    }


def _verdict_of(axes: Iterable[Document]) -> SensorVerdict:
    """Return the verdict of axes each solved by itself: that of the worst."""
    verdicts = [axis.pop("verdict", "usable") for axis in axes]
    return next(verdict for verdict in ("not usable", "usable", "sound") if verdict in verdicts)


def calibrated_levels(levels: Mapping[str, Levels], request: CalibrationRequest) -> Calibration:
    """Return the solution of all axes as one calibration, which a coefficient set is made of.

    Raises: DesignError for two levels once, which leave nothing to tell an uncertainty from.
    """
    for axis, found in levels.items():
        if found.observations.rows == 2:
            raise DesignError(
                f"{found.observations.source}: axis {axis}: two levels once: the line passes through both and nothing "
                "tells its uncertainty: no set can be made of it; add readings"
            )
    request = replace(request, tested_axes=len(levels))
    solved = _solved_lines(levels, request).values()
    axes = {axis: solved_axis for part in solved for axis, solved_axis in part.axes.items()}
    texts = dict.fromkeys(text for part in solved for text in part.warnings)
    remarks = dict.fromkeys(text for part in solved for text in part.remarks)
    if len(levels) > 1:
        remarks |= {DIRECTIONS_NOT_MEASURED: None}
    return Calibration(axes, "linear", "SR", tuple(texts), tuple(remarks))


def scale_error(uncertainty_ppm: float) -> SharedError:
    """Return the one relative error of all known levels, as a relative standard uncertainty states it."""
    return SharedError(SCALE, "level", 1e-6 * uncertainty_ppm, stated=f"u {uncertainty_ppm:g} ppm", columns=(0,))


def zero_error(uncertainty: float) -> SharedError:
    """Return the one error that is added to all known levels, in their unit, as its standard uncertainty states it."""
    return SharedError(ZERO, "level", uncertainty, stated=f"u {uncertainty:g}, in the unit of the levels", columns=(1,))


def _not_counted(axis: str, request: CalibrationRequest) -> tuple[str, ...]:
    """Say what of a reference nobody stated, so that the uncertainties of an axis are too small by it."""
    stated = {error.name for error in request.shared_errors.get(axis, ())}
    unknown = [name for name in _OPTIONS if name not in stated]
    if not unknown:
        return ()
    return (
        f"{LEVELS_NOT_COUNTED} ({' and '.join(name.partition(' ')[0] for name in unknown)}): no residual shows it; a "
        "scale that is wrong by a part is a gain that is wrong by it, a zero (a field that stands there besides) is an "
        f"offset that is wrong by all of it; {' and '.join(_OPTIONS[name] for name in unknown)} of "
        f"calrig fit {'brings it' if len(unknown) == 1 else 'bring them'} in",
    )


def _calibrated(axis: str, levels: Levels, request: CalibrationRequest) -> Calibration:
    solved = calibrate(levels.observations, _line_request(axis, levels, request))
    return replace(solved, warnings=(*solved.warnings, *_not_counted(axis, request)))


def _line_request(axis: str, levels: Levels, request: CalibrationRequest) -> CalibrationRequest:
    """Return what is asked of one axis."""
    declared = {axis: _declared(axis, levels.model, request)}
    return replace(request, nominal_axes={axis: axis}, models={axis: levels.model}, declared=declared)


def _declared(axis: str, model: StraightLine, request: CalibrationRequest) -> DeclaredDirection:
    """Return what is declared of an axis, or what the unit of its readings says."""
    declared = request.declared.get(axis, DeclaredDirection(axis))
    if declared.sensitivity is not None:
        return declared
    return replace(declared, sensitivity=nominal_of_unit(model.measured_unit, model.unit))


def _solved_lines(levels: Mapping[str, Levels], request: CalibrationRequest) -> dict[str, Calibration]:
    """Return the axes that are no two levels once, each solved by itself and held against the others."""
    is_exact = {axis: found.observations.rows == 2 and request.temperature == "none" for axis, found in levels.items()}
    solved = {axis: _calibrated(axis, found, request) for axis, found in levels.items() if not is_exact[axis]}
    declared = {axis: _declared(axis, levels[axis].model, request) for axis in solved}
    judged = with_unlike_axes({axis: calibration.axes[axis] for axis, calibration in solved.items()}, declared)
    return {axis: replace(calibration, axes={axis: judged[axis]}) for axis, calibration in solved.items()}


def _levels(table: CsvTable, axis: str, column: str) -> Levels:
    reference = _reference_column(table, axis)
    model = StraightLine(axis, reference.rpartition("_")[2], _unit(table, column))
    used = [index for index, cell in enumerate(table.column(reference)) if cell or reference.count("_") == 1]
    part = CsvTable(
        table.file,
        table.columns,
        tuple(table.lines[index] for index in used),
        tuple(table.rows[index] for index in used),
        table.form,
    )
    if not used:
        raise ObservationsError(f"{table.file}: column {reference}: no level is given; nothing was solved; fill it in")
    nothing, level = np.zeros(len(used)), numbers(part, reference)
    temperature = numbers(part, "temperature_degc") if "temperature_degc" in part.columns else None
    observations = Observations(
        replication=labels(part, "replication"),
        point=labels(part, "point"),
        pitch_rad=nothing,
        roll_rad=nothing,
        outputs={axis: numbers(part, column)},
        units={axis: model.measured_unit},
        temperature_degc=temperature,
        time_s=numbers(part, "time_s") if "time_s" in part.columns else None,
        reference_level=level,
        level_errors=np.stack([level, np.ones_like(level)], axis=1),
        source=table.file,
    )
    _refuse_wandering_levels(part, reference, observations)
    return Levels(observations, model)


def _reference_column(table: CsvTable, axis: str) -> str:
    reference_columns = [name for name in table.columns if name.startswith(f"reference_{axis}_")]
    shared = [name for name in table.columns if name.startswith("reference_") and name.count("_") == 1]
    found = reference_columns or shared
    if len(found) != 1:
        raise ObservationsError(
            f"{table.file}: line 1: axis {axis}: got {len(found)} columns of known levels "
            f"({', '.join(found) or 'none'}), allowed one: reference_{axis}_<unit> or reference_<unit>, such as "
            "reference_g; nothing was solved"
        )
    return found[0]


def _unit(table: CsvTable, column: str) -> str:
    name, _, unit = column.rpartition("_")
    if not name or not unit:
        raise ObservationsError(
            f"{table.file}: line 1: column {column}: its name states no unit, allowed <name>_<unit>, such as ax_counts "
            "or sx_v; nothing was solved; rename the column"
        )
    return unit


def _refuse_wandering_levels(table: CsvTable, column: str, observations: Observations) -> None:
    level = observations.reference_level
    assert level is not None
    _, first, index = np.unique(observations.point, return_index=True, return_inverse=True)
    off = np.abs(level - level[first][index])
    allowed = _LARGEST_SPREAD * float(np.ptp(level))
    if off.max() > allowed:
        row = int(np.argmax(off))
        raise ObservationsError(
            f"{table.file}: line {table.lines[row]}: column {column}: point {observations.point[row]} has "
            f"{level[row]:g} here and {level[first][index][row]:g} on line {table.lines[int(first[index[row]])]}; "
            f"allowed a difference up to {allowed:g}; nothing was solved; correct the level or the point label"
        )


def _axis_document(axis: str, levels: Levels, calibration: Calibration, request: CalibrationRequest) -> Document:
    solved = to_document(calibration)["axes"][axis]  # type: ignore[index]
    measured, (gain, offset) = levels.model.measured_unit, levels.model.parameter_names
    document = {key: value for key, value in solved.items() if not key.endswith(("_v", "_per_g"))}
    document["parameters"] = {
        estimate.name: {
            **solved["parameters"][estimate.name],
            "interval_95": None if estimate.interval_95 is None else list(estimate.interval_95),
        }
        for estimate in calibration.axes[axis].parameters
    }
    document["findings"] = findings_document(calibration.axes[axis])
    if any(estimate.value is not None for estimate in calibration.axes[axis].parameters):
        errors = request.shared_errors.get(axis, ())
        rows = levels.observations
        solved_by = requested_model(axis, rows, layout_of(rows), _line_request(axis, levels, request))
        document["budget"] = budget_document(axis_budget(calibration.axes[axis], errors, model=solved_by))
    document["verdict"] = calibration.verdict
    document[f"standard_error_{measured}"] = solved["standard_error_v"]
    document[f"residuals_{measured}"] = calibration.axes[axis].residuals_v.tolist()
    return _renamed(document, {gain: "gain", offset: "offset"}, measured)


def _renamed(document: Document, quantities: Mapping[str, str], measured: str) -> Document:
    """Return the replication tests keyed by quantity, and sigmas by the unit that they have."""
    replication = document["replication"]
    if not isinstance(replication, dict):
        return document
    tp = {
        key.removesuffix("_v") + f"_{measured}" if key.endswith("_v") else key: v
        for key, v in replication["tp"].items()
    }
    tp["drift"] = {quantities.get(name, name): test for name, test in tp["drift"].items()}
    drift = {quantities.get(name, name): test for name, test in replication["drift"].items()}
    document["replication"] = {**replication, "drift": drift, "tp": tp}
    return document


def _two_levels(levels: Levels, request: CalibrationRequest) -> Document:
    """Return the solution of SR's two equations: exact, and nothing left over to judge the error by."""
    rows, model = levels.observations, levels.model
    assert rows.reference_level is not None
    line = fit_line(rows.outputs[model.nominal_axis], rows.reference_level).line
    unknown = {"standard_uncertainty": None, "tp_standard_uncertainty": None, "interval_95": None}
    names = model.parameter_names
    return {
        "parameters": {name: {"value": v, **unknown} for name, v in zip(names, (line.gain, line.offset), strict=True)},
        "covariance": [[None, None], [None, None]],
        "degrees_of_freedom": 0,
        "effective_degrees_of_freedom": dict.fromkeys(names),
        "replication": None,
        "warnings": [
            "two levels once: the line passes through both and nothing tells its uncertainty; add readings",
            *_not_counted(model.nominal_axis, request),
        ],
        "remarks": [],
        "findings": [],
        f"standard_error_{model.measured_unit}": None,
        f"residuals_{model.measured_unit}": [0.0, 0.0],
    }
