"""How a cell of a magnetometer between two levels of a field is judged, for the study of silent scenes."""

from collections.abc import Iterator, Mapping

import numpy as np
from physics_scenes import FieldReadings, campaigns
from silent_cells import JudgedCell, holds, named, offset_and_k, significant
from silent_declared import BESIDE, COIL, Declared, separated

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL
from ams.analysis.diagnostics.declared.declared_field import FieldAxis, field_finding, judge_field
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.frames import AXES, from_level_axes
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.models.field_triad import FieldTriad, Vector
from ams.models.model import Model
from ams.models.straight_line import StraightLine
from ams.observations import Observations
from ams.solve.layout import Layout

_DOWN = np.array([0.0, 0.0, 1.0])
_COIL: Vector = (0.0, 0.0, 1.0)
_PACKAGE: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def of_field(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge two-level calibrations of a magnetometer; before, every axis was a straight line along its own."""
    design, declared = separated(design)
    drawn: FieldReadings = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    replications, levels = drawn.setup.replications, len(drawn.setup.levels)
    pitch = np.deg2rad(np.repeat([90.0, -90.0, 0.0, 0.0, 0.0, 0.0], levels))
    roll = np.deg2rad(np.repeat([0.0, 0.0, -90.0, 90.0, 180.0, 0.0], levels))
    turned = from_level_axes(pitch, np.zeros_like(pitch), roll)
    assert np.allclose(turned[::levels], drawn.to_package)
    applied = np.tile(drawn.nominal_coil_ut[:, 2], 6)
    field = turned @ drawn.nominal_earth_ut + turned[..., 2] * applied[:, None]
    beside: Vector = tuple(drawn.nominal_earth_ut.tolist())
    held: dict[str, list[FloatArray]] = {"after": [], "before": []}
    kinds = []
    for index in range(count):
        kinds_found: set[str] = set()
        axes: dict[str, FieldAxis] = {}
        for which, axis in enumerate(AXES):
            reading = drawn.counts[index, ..., which].reshape(-1)
            order = [which, *(other for other in range(3) if other != which)]
            truth = np.append(drawn.offset_counts[index, which], drawn.matrix_counts_per_ut[index, which, order])
            triad = FieldTriad(axis, "ut", "counts", _PACKAGE, _COIL, beside)
            line = StraightLine(axis, "ut", "counts")
            errors: Mapping[str, FloatArray] = {}
            for word, model, level in (("after", triad, applied), ("before", line, field[:, which])):
                rows = _field_rows(axis, reading, (pitch, roll, level), replications)
                if word == "after":
                    errors = dict(_declared_columns(declared, triad, rows, turned, applied))
                found = _of_model(axis, model, rows, errors if word == "after" else {})
                held[word].append(holds(found, truth[: 4 if word == "after" else 2])[:2])
                kinds_found |= significant(found.findings) if word == "after" else set()
            axes[axis] = FieldAxis(reading, drawn.nominal_earth_ut, errors)
        kinds.append(kinds_found | _of_all_axes(drawn, axes, turned, applied))
    shares = {word: offset_and_k(np.array(each)) for word, each in held.items()}
    rings = float(np.mean([bool(kinds_found) for kinds_found in kinds]))
    return JudgedCell(shares["after"], shares["before"], named(scene, size, kinds), rings)


def _declared_columns(
    declared: Declared, model: FieldTriad, rows: Observations, turned: FloatArray, applied: FloatArray
) -> Iterator[tuple[str, FloatArray]]:
    """Yield what one standard uncertainty of the surroundings, and of the coil's direction, does to the levels."""
    _, slope, *across = model.start(rows, rows.outputs[model.nominal_axis])
    lies = np.insert(np.array(across) / slope, AXES.index(model.nominal_axis), 1.0)
    replications = rows.rows // applied.size
    along = np.einsum("k,nkl->nl", lies, turned)
    if declared[BESIDE] > 0.0:
        yield "surroundings", np.tile(declared[BESIDE] * along, (replications, 1))
    if declared[COIL] > 0.0:
        sides = np.deg2rad(declared[COIL]) * along[:, :2] * applied[:, None]
        yield "direction of the coil", np.tile(sides, (replications, 1))


def _of_all_axes(
    drawn: FieldReadings, axes: Mapping[str, FieldAxis], turned: FloatArray, applied: FloatArray
) -> set[str]:
    """Return what all axes together say of the field, at the share of the level that they have in a run of three."""
    replications, rows = drawn.setup.replications, applied.size
    layout = Layout(
        np.repeat(np.arange(replications), rows), np.tile(np.arange(rows), replications),
        tuple(range(replications)), tuple(range(rows)),
    )  # fmt: skip
    attitudes, strength = np.tile(turned, (replications, 1, 1)), np.tile(applied, replications)
    test = judge_field(attitudes, _DOWN, strength, axes, layout, is_declared=True)
    return set() if test is None else significant([field_finding(test, LEVEL / MOST_TESTS, "µT")])


def _field_rows(
    axis: str, reading: FloatArray, stimulus: tuple[FloatArray, FloatArray, FloatArray], replications: int
) -> Observations:
    pitch, roll, level = (np.tile(column, replications) for column in stimulus)
    points = pitch.size // replications
    return Observations(
        np.repeat(np.arange(replications), points), np.tile(np.arange(points), replications), pitch, roll,
        {axis: reading}, units={axis: "counts"}, reference_level=level,
    )  # fmt: skip


def _of_model(axis: str, model: Model, rows: Observations, errors: Mapping[str, FloatArray]) -> AxisCalibration:
    shared, columns = [], []
    for name, column in errors.items():
        first = sum(each.shape[1] for each in columns)
        shared.append(SharedError(name, "level", 1.0, columns=tuple(range(first, first + column.shape[1]))))
        columns.append(column)
    if columns:
        rows = Observations(**{**vars(rows), "level_errors": np.hstack(columns)})
    request = CalibrationRequest(
        nominal_axes={axis: axis}, models={axis: model}, tested_axes=3, shared_errors={axis: tuple(shared)}
    )
    return calibrate(rows, request).axes[axis]
