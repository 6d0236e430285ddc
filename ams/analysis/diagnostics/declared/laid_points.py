"""Whether the zero of a gyro was another one as the package was laid, of which the rows say nothing.

A package is laid on a table three ways, so that each of its axes turns in turn. What stands on the ground (the Earth's
rate, gravity on the zero, a cable) is then another offset of all rows of one laying. Two things show it. Points at
which the same attitude and rates are stated, such as those at rest of every laying, read otherwise: no equation of a
sensor explains that. And what the equation leaves goes alike over the points that turned about one axis, where the
stated uncertainties take it for errors that differ from point to point: of an offset of one of three layings a third is
in that of the sensor. Source: Draper and Smith, Applied Regression Analysis, pure error.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import LEAST_DOF, independent
from ams.analysis.diagnostics.weighed_means import weighed_means
from ams.arrays import FloatArray, IntArray
from ams.findings import Finding
from ams.models.gyro import velocity_of_dps
from ams.rounding import significant
from ams.statistics.distributions import f_tail

LAID_OTHERWISE: Final = "points that are stated alike"
_SAME: Final = 1e-3
"""Of the largest rate, and radians: what is stated closer than this is one and the same."""
_ALIKE: Final = 0.005
"""Chance below which what is left goes alike over the points that turned about one axis."""


@dataclass(frozen=True)
class LaidOtherwise:
    """Of one gyro: points that are stated alike and read otherwise."""

    columns: FloatArray
    """(N, c) one of each such point."""
    size_v: float
    """Largest less smallest mean of points that are stated alike."""
    p_value: float


def laid_otherwise(evidence: Evidence, output: int, known: FloatArray) -> LaidOtherwise | None:
    """Return whether points that are stated alike read otherwise than the replications scatter; None: no such points.

    ``known``: (K, c) of the points that something else is told to do.
    """
    group, variance, dof = _stated_alike(evidence), float(evidence.precision_variance[output]), float(evidence.grid.dof)
    every = np.eye(group.max() + 1)[group]
    several = every[:, every.sum(axis=0) > 1.0]
    if several.shape[1] == 0 or not variance > 0.0:
        return None
    root, means = np.sqrt(evidence.layout.readings), evidence.point_effects[:, output]
    given = independent(root[:, None] * np.hstack([every, known]))
    numbers = group.size - given.shape[1]
    if numbers < 1:
        return None
    left = root * means - given @ np.linalg.lstsq(given, root * means)[0]
    p_value = float(f_tail(float(left @ left) / variance / numbers, float(numbers), dof))
    size_v = max(float(np.ptp(means[column > 0.0])) for column in several.T)
    points = np.flatnonzero(several.any(axis=1))
    return LaidOtherwise(np.eye(group.size)[:, points][evidence.layout.point], size_v, p_value)


def laid_finding(found: LaidOtherwise) -> Finding:
    """Return that something is not in the rows."""
    fact = (
        "points at which the same attitude and the same rates are stated read otherwise, by "
        f"{significant(found.size_v)} V (largest less smallest), alike in every replication: the package was laid "
        "another way, and with it the Earth's rate that it sees or gravity on its zero, or the zero moved in step with "
        "the order of the points; the offset holds the mean of them, and the stated uncertainties do not hold what "
        "they differ by"
    )
    what_to_do = (
        "put the Earth's rate along the axis that turns into the rates of every row, those at rest too, and state yaw "
        "and roll as the package lay"
    )
    details: dict[str, float | str | None] = {"test": LAID_OTHERWISE, "size": found.size_v, "unit": "V"}
    return Finding("lack-of-fit", fact, True, found.p_value, details=details, is_held=False, what_to_do=what_to_do)


def is_alike_over_turns(evidence: Evidence, output: int, known: FloatArray) -> bool:
    """Return whether what repeats goes alike over the points that turned about one axis, against its scatter there."""
    columns = _turned_alike(evidence)
    weighed = weighed_means(evidence, output, known, columns)
    if weighed is None or columns.shape[1] < 2:
        return False
    _, numbers, explains = weighed.explained(columns)
    rest, dof = weighed.square - explains, weighed.dof - numbers
    if dof < LEAST_DOF or numbers == 0:
        return False
    ratio = (explains / numbers) / max(rest / dof, 1.0)
    return float(f_tail(ratio, float(numbers), float(dof))) <= _ALIKE


def _stated_alike(evidence: Evidence) -> IntArray:
    """Return (K,) the number of a group of points at which the same is stated."""
    rows, velocity = evidence.rows, velocity_of_dps(evidence.rows)
    yaw = np.zeros_like(rows.pitch_rad) if rows.yaw_rad is None else rows.yaw_rad
    largest = float(np.abs(velocity).max(initial=0.0)) or 1.0
    stated = np.column_stack([rows.pitch_rad, yaw, rows.roll_rad, velocity / largest])
    steps = np.round(evidence.layout.mean_by_point(stated) / _SAME)
    return np.unique(steps, axis=0, return_inverse=True)[1].reshape(-1)


def _turned_alike(evidence: Evidence) -> FloatArray:
    """Return (K, d) 1 where a point turned about one of d directions of the package, in either sense."""
    velocity = evidence.layout.mean_by_point(velocity_of_dps(evidence.rows))
    speed = np.linalg.norm(velocity, axis=1)
    turns = speed > _SAME * speed.max(initial=0.0)
    unit = velocity / np.where(turns, speed, 1.0)[:, None]
    along = np.einsum("ki,kj->kij", unit, unit).reshape(speed.size, -1)  # alike in both senses
    steps = np.round(along[turns], 2)
    _, direction = np.unique(steps, axis=0, return_inverse=True)
    columns = np.zeros((speed.size, int(direction.max(initial=-1)) + 1))
    columns[np.flatnonzero(turns), direction.reshape(-1)] = 1.0
    return columns
