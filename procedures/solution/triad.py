"""A magnetometer in two levels with everything that its attitudes tell: every axis' three components and the field.

What stands beside the coil is declared, or solved with all axes together; its errors, by scatter and by everything that
the rig declares, enter the known levels of every axis. Where the attitudes determine it no further (one pair of
senses, one axis only) there is nothing here, and an axis has the straight line along its nominal direction.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ams.arrays import FloatArray
from ams.frames import AXES
from ams.inputs.shared_errors import SharedError
from ams.models.field_triad import FieldTriad, Vector, to_package
from ams.observations import Observations
from ams.solve.field_across import LARGEST_CONDITION, FieldAcross, field_across
from procedures.plan.rotations import body_axis
from procedures.solution.levels import LevelError, errors_of_field, levels_of
from procedures.solution.request import SensorRows

ACROSS = "field across"
"""Part of the covariance, see ams.analysis.calibration_budget."""
_UNIT = "ut"
_OBSERVABLE_U = 5.0
"""Uncertainties that an axis' slope is away from zero, as for a straight line."""
_ROUNDING = 1e-9
"""Of the largest reading: what follows by less is arithmetic."""


@dataclass(frozen=True)
class TriadAxis:
    """One axis: its model, the coil's field row by row, and what its levels are wrong by."""

    model: FieldTriad
    applied_ut: FloatArray
    errors: tuple[LevelError, ...]


@dataclass(frozen=True)
class _Fields:
    """The coil's field row by row, its unit vector and what stands beside it, level axes."""

    applied_ut: FloatArray
    coil: FloatArray
    beside_ut: FloatArray


def triad_of(
    item: SensorRows, observations: Observations, scatter: Mapping[str, float] | None = None
) -> Mapping[str, TriadAxis]:
    """Return every axis whose components the attitudes determine; none for a magnet or for what is no field.

    ``scatter``: of the readings of every axis, for rows that are planned; None: as they show it.
    """
    levels = levels_of(item.plan)
    if item.sensor.measures != "field" or levels is None or levels.method == "magnet-difference":
        return {}
    coils = {coil for row in item.dwells if row.motion is not None for coil in row.motion.field_ut}
    if len(coils) != 1 or any(row.motion is None for row in item.dwells):
        return {}
    (coil,) = coils
    direction = np.array(item.rig.field[coil].direction)
    direction = direction / np.linalg.norm(direction)
    applied = np.array([row.motion.field_ut.get(coil, 0.0) for row in item.dwells if row.motion is not None])
    mounted = _package_axes(item)
    turned = to_package(mounted, observations)
    readings = {label: observations.outputs[label] for label in item.channels}
    if not all(np.isfinite(reading).all() for reading in readings.values()):
        return {}
    along = {label: turned[:, AXES.index(label)] for label in readings}
    readings = {
        label: reading for label, reading in readings.items() if _follows(along[label], direction, applied, reading)
    }
    if not readings:
        return {}
    if levels.surroundings_ut is not None:
        beside_ut = np.array(levels.surroundings_ut)
        return _declared(item, observations, list(readings), _Fields(applied, direction, beside_ut))
    found = field_across(turned, direction, applied, readings, scatter)
    return {} if found is None else _solved(item, observations, applied, direction, found)


def _follows(along: FloatArray, coil: FloatArray, applied: FloatArray, reading: FloatArray) -> bool:
    """Tell whether an axis follows the coil's field; one that does not (unplugged, at its rail) tells nothing here.

    ``along``: (N, 3) its nominal direction in level axes.
    """
    columns = np.column_stack([along @ coil * applied, np.ones_like(applied), along])
    inverse = np.linalg.pinv(columns)
    found = inverse @ reading
    left = reading - columns @ found
    scatter = np.sqrt(left @ left / max(left.size - columns.shape[1], 1))
    by_scatter = _OBSERVABLE_U * scatter * np.linalg.norm(inverse[0])
    return bool(abs(found[0]) > by_scatter and abs(found[0]) * np.ptp(applied) > _ROUNDING * np.abs(reading).max())


def _declared(
    item: SensorRows, observations: Observations, labels: Sequence[str], fields: _Fields
) -> Mapping[str, TriadAxis]:
    mounted, axes = _package_axes(item), dict[str, TriadAxis]()
    applied, beside_ut = fields.applied_ut, fields.beside_ut
    rows = replace(observations, reference_level=applied)
    for label in labels:
        model = FieldTriad(label, _UNIT, observations.unit_of(label), mounted, _vector(fields.coil), _vector(beside_ut))
        basis = model.basis(rows)
        lengths = np.linalg.norm(basis, axis=0)
        if not lengths.all() or np.linalg.cond(basis / lengths) > LARGEST_CONDITION:
            continue
        _, slope, *across = model.start(rows, observations.outputs[label])
        lies = _lies(label, slope, *across)
        errors = errors_of_field(item, observations, label, _in_stage(mounted, lies), beside_ut)
        axes[label] = TriadAxis(model, applied, errors)
    return axes


def _solved(
    item: SensorRows, observations: Observations, applied: FloatArray, coil: FloatArray, found: FieldAcross
) -> Mapping[str, TriadAxis]:
    mounted = _package_axes(item)
    turned = to_package(mounted, observations)
    lies = {label: row / row[AXES.index(label)] for label, row in found.matrix.items()}
    beside = {label: found.across + coil * along for label, along in found.along.items()}
    errors_of = {
        label: errors_of_field(item, observations, label, _in_stage(mounted, lies[label]), beside[label])
        for label in lies
    }
    reached = _reached(errors_of, found)
    axes: dict[str, TriadAxis] = {}
    scatter = SharedError(ACROSS, "field", 1.0)
    for label, errors in errors_of.items():
        share = turned.transpose(0, 2, 1) @ lies[label]
        carried = [
            replace(error, columns=error.columns - share @ reached[error.error.name])
            if error.error.name in reached
            else error
            for error in errors
        ]
        model = FieldTriad(
            label,
            _UNIT,
            observations.unit_of(label),
            mounted,
            _vector(coil),
            _vector(beside[label]),
            _vector(lies[label]),
        )
        axes[label] = TriadAxis(model, applied, (*carried, LevelError(scatter, share @ found.noise)))
    return axes


def _reached(errors_of: Mapping[str, tuple[LevelError, ...]], found: FieldAcross) -> Mapping[str, FloatArray]:
    """Return by error the (3, q) that it does to the field across, by the readings of all axes."""
    reached: dict[str, FloatArray] = {}
    for label, errors in errors_of.items():
        slope = found.matrix[label][AXES.index(label)]
        for error in errors:
            effect = found.gain[label] @ (slope * error.columns)
            reached[error.error.name] = reached.get(error.error.name, np.zeros((3, 1))) + effect
    return reached


def _package_axes(item: SensorRows) -> tuple[Vector, Vector, Vector]:
    x, y, z = (_vector(body_axis(item.sensor, axis)) for axis in AXES)
    return x, y, z


def _in_stage(mounted: tuple[Vector, Vector, Vector], lies: FloatArray) -> FloatArray:
    return np.asarray(lies @ np.array(mounted))


def _lies(label: str, slope: float, *across: float) -> FloatArray:
    along = AXES.index(label)
    return np.insert(np.array(across) / slope, along, 1.0)


def _vector(components: FloatArray) -> Vector:
    return cast("Vector", tuple(components.tolist()))
