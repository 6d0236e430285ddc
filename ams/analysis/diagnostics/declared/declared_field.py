"""Whether all axes of a magnetometer see the one field that each of them was solved in.

Every axis by itself has its offset and its three components free, and bends them to whatever field it is told of. All
together are one body in one field: what stands beside the coil, and the direction of the coil, are the same for each.
y_j = o_j + M_j·T·(c·a + B): the rows of all axes are asked for a change of B and of c across itself, beside every o_j
and M_j. Where B was declared that change is the contradiction. Where it was solved, a change of B is given, and what
stands along the coil by one axis is held against what stands there by the others. The errors that the rig declares
(indices, base, scale of the coil) and the scatter of the readings are in the covariance, and what the whole leaves
beyond them enlarges it. Source: MATH 10.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray, block_diagonal
from ams.findings import Finding
from ams.frames import AXES
from ams.solve.layout import Layout
from ams.statistics.distributions import f_tail
from ams.units import signed

TEST: Final = "one field for all axes"
_LEAST_DOF: Final = 3
_TINY: Final = 1e-24
"""Of a squared reading in the unit of the field: readings that do not scatter leave nothing to divide by."""
_DISTINGUISHED: Final = 1e-6
"""Of a column's square: a direction that the attitudes leave less of is not tested."""


@dataclass(frozen=True)
class FieldAxis:
    """One axis of the magnetometer."""

    reading: FloatArray
    """(N,)"""
    beside: FloatArray
    """(3,) what stands beside the coil's field by this axis, level axes."""
    errors: Mapping[str, FloatArray]
    """Name to (N, q): what one standard uncertainty of each part of an error does to the known level of the axis."""


@dataclass(frozen=True)
class FieldTest:
    """What all axes say together."""

    p_value: float
    beside: FloatArray
    """(3,) what stands beside the coil beyond what was declared; zero where it was solved."""
    coil_rad: float
    """By which the coil lies off its declared direction."""
    along: Mapping[str, float]
    """What stands along the coil by each axis, beyond what all have together; empty where it was declared."""


def judge_field(
    to_package: FloatArray,
    coil: FloatArray,
    applied: FloatArray,
    axes: Mapping[str, FieldAxis],
    layout: Layout,
    *,
    is_declared: bool,
) -> FieldTest | None:
    """Return the test of (N, 3, 3) attitudes in a coil's field of (N,) strength along a unit vector.

    None where too few points are left to judge it by, or an axis is not seen to read its own field.
    """
    judged = [_seen(to_package, coil, applied, label, axis, layout) for label, axis in axes.items()]
    seen = [each for each in judged if each is not None]
    if len(seen) < len(judged):
        return None
    given, tested = (block_diagonal([each.basis for each in seen]), np.vstack([each.turned for each in seen]))
    beside = np.vstack([each.beside for each in seen])
    if is_declared:
        tested = np.hstack([beside, tested])
    else:
        given = np.hstack([given, beside])
        tested = np.hstack([block_diagonal([each.beside @ coil[:, None] for each in seen])[:, :-1], tested])
    root = np.linalg.cholesky(_covariance(seen))
    given, tested, y = (
        np.linalg.solve(root, part) for part in (given, tested, np.concatenate([each.y for each in seen]))
    )
    spanned, sizes, _ = np.linalg.svd(given, full_matrices=False)
    spanned = spanned[:, sizes > _DISTINGUISHED * sizes[0]]
    lengths = np.linalg.norm(tested, axis=0)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    unit = (tested - spanned @ (spanned.T @ tested)) / lengths
    left = y - spanned @ (spanned.T @ y)
    values, vectors = np.linalg.eigh(unit.T @ unit)
    kept = values > _DISTINGUISHED
    dof = y.size - spanned.shape[1] - int(kept.sum())
    if not kept.any() or dof < _LEAST_DOF:
        return None
    found = (vectors[:, kept] / values[kept]).T @ (unit.T @ left)
    explained = float(np.sum(values[kept] * found**2))
    # What neither the field nor what is declared explains is no reason to blame the field.
    rest = max((float(left @ left) - explained) / dof, 1.0)
    p_value = float(f_tail(explained / found.size / rest, float(found.size), float(dof)))
    changes, turned = np.split(vectors[:, kept] @ found / lengths, [-2])
    coil_rad = float(np.linalg.norm(turned))
    if is_declared:
        return FieldTest(p_value, changes, coil_rad, {})
    along = np.append(changes, 0.0) - changes.sum() / len(axes)
    return FieldTest(p_value, np.zeros(3), coil_rad, dict(zip(axes, along.tolist(), strict=True)))


@dataclass(frozen=True)
class _Seen:
    """The means of one axis at its K points, all in the unit of the field."""

    basis: FloatArray
    """(K, 4)"""
    beside: FloatArray
    """(K, 3) by what stands beside the coil."""
    turned: FloatArray
    """(K, 2) by the coil's direction, radians."""
    y: FloatArray
    variance: FloatArray
    """(K,) by the scatter of the readings."""
    errors: Mapping[str, FloatArray]
    """Name to (K, q)."""


def _seen(
    to_package: FloatArray, coil: FloatArray, applied: FloatArray, label: str, axis: FieldAxis, layout: Layout
) -> _Seen | None:
    across = np.linalg.svd(coil[None, :])[2][1:].T
    field = to_package @ axis.beside + (to_package @ coil) * applied[:, None]
    rows = np.column_stack([np.ones_like(applied), field])
    solved = np.linalg.lstsq(rows, axis.reading, rcond=None)[0]
    slope = solved[1 + AXES.index(label)]
    if not abs(slope) > _DISTINGUISHED * np.abs(solved[1:]).max():
        return None
    lies, reading = solved[1:] / slope, axis.reading / slope
    beside = np.einsum("k,nkl->nl", lies, to_package)
    left = reading - rows @ (solved / slope)
    about, dof = layout.about_points(left), applied.size - layout.points
    if dof == 0:
        about, dof = left, max(applied.size - rows.shape[1], 1)
    return _Seen(
        layout.mean_by_point(rows),
        layout.mean_by_point(beside),
        layout.mean_by_point(applied[:, None] * (beside @ across)),
        layout.mean_by_point(reading),
        max(float(about @ about) / dof, _TINY) / layout.readings,
        {name: layout.mean_by_point(columns) for name, columns in axis.errors.items()},
    )


def _covariance(seen: Sequence[_Seen]) -> FloatArray:
    """Return that of all points, axis after axis: errors of one name have the same cause for every axis."""
    covariance = np.diag(np.concatenate([each.variance for each in seen]))
    widths = {name: columns.shape[1] for each in seen for name, columns in each.errors.items()}
    for name, width in widths.items():
        effect = np.vstack([each.errors.get(name, np.zeros((each.y.size, width))) for each in seen])
        covariance += effect @ effect.T
    return covariance


def field_finding(test: FieldTest, level: float, unit: str) -> Finding:
    """Return the finding of all axes together, in the words of a laboratory."""
    is_significant = test.p_value <= level
    coil = f"the coil lies {np.degrees(test.coil_rad):.2g}° off its declared direction"
    if test.along:
        each = ", ".join(f"{signed(along, 3)} by {axis}" for axis, along in test.along.items())
        what = f"what stands along the coil differs between the axes, {unit} about their mean: {each}; {coil}"
    else:
        each = ", ".join(signed(component, 3) for component in test.beside.tolist())
        what = f"beside the coil stands {each} {unit} more than declared, and {coil}"
    fact = (
        f"all axes together contradict the field that each was solved in (p = {test.p_value:.2g}): at best {what}; "
        "offsets and sensitivities are bent to the wrong field and their intervals do not hold that"
        if is_significant
        else f"all axes together agree on the field that each was solved in (p = {test.p_value:.2g})"
    )
    details: dict[str, float | str | None] = {
        "test": TEST,
        "coil_deg": float(np.degrees(test.coil_rad)),
        "beside_ut": float(np.linalg.norm(test.beside)),
    }
    what_to_do = (
        "measure the surroundings with the coil off, look for iron and for what was switched meanwhile, and correct "
        "surroundings_ut or the coil's direction, or leave surroundings_ut out so that it is solved"
    )
    return Finding(
        "field-contradicted",
        fact,
        is_significant,
        test.p_value,
        details=details,
        is_held=False,
        what_to_do=what_to_do if is_significant else "",
    )
