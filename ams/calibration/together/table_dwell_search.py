"""What each dwell shows of a turn of the table, over all axes of all packages.

The mathematics stands in :mod:`ams.calibration.together.table_dwells`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.residuals import GridResiduals, grid_residuals
from ams.analysis.diagnostics.wrong_dwells import LEAST_DOF
from ams.arrays import FloatArray, IntArray
from ams.calibration.together.dwell_scatter import (
    DwellScatter,
    chances_of_even_scatter,
    scatter_of_all,
    scatter_of_replications,
)
from ams.calibration_result import Calibration
from ams.frames import specific_force
from ams.inputs.known_of_run import DwellLabels, ProvedChange, is_among, labels_of
from ams.models.pitch_yaw_roll import MODEL, STING
from ams.observations import Observations
from ams.solve.extension import angles_of_points
from ams.solve.layout import Layout, layout_of
from ams.statistics.distributions import f_tail
from ams.surveillance.common_mode import CommonMode, judge_visits
from ams.surveillance.common_mode_causes import ROTATION, Cause
from ams.surveillance.common_mode_columns import Visits, WatchedAxes, whiten
from ams.surveillance.common_mode_words import turn_in_words
from ams.surveillance.turns import AXES_OF_TABLE, force_changes

_CONTRADICTED: Final = 0.01
"""The chance below which a cause does not explain a dwell."""
_SEEN: Final = 1e-6
"""Of the largest: a turn that the attitude shows less of is not seen."""
_ROUNDING: Final = 1e-12
"""Of the largest eigenvalue: a direction that is only rounding."""
_METER: Final = "the meter"
_UNEVEN: Final = 0.05
"""Chance, over all axes, of how unevenly replications scatter: where it is less, they do."""
_FEWEST_REPLICATIONS: Final = 2
"""Of which a dwell of one is held against the other."""


@dataclass(frozen=True)
class StoodPackage:
    """One package on the table, as it is solved."""

    name: str
    rows: Observations
    calibration: Calibration


@dataclass(frozen=True)
class SeenPackage:
    """One package as the search looks at it."""

    name: str
    axes: tuple[str, ...]
    rows: Observations
    is_rolled: bool
    """Whether roll reaches it: not what stands on a sting."""
    layout: Layout
    k: FloatArray
    """(A, 3) per g of specific force."""
    reading: FloatArray
    """(N, A)"""
    plain: FloatArray
    """(N, A) residuals with no effects of points: of two replications they say which one is wrong."""
    grid: GridResiduals
    is_uneven: bool = False
    """Whether each dwell is held against its own replication alone."""

    @cached_property
    def row_of(self) -> dict[DwellLabels, int]:
        """Labels of a dwell to its row."""
        return {labels: row for row, labels in enumerate(labels_of(self.rows))}

    @cached_property
    def dwell(self) -> dict[DwellLabels, int]:
        """Labels of a dwell to its place in the grid."""
        at = self.layout.replication * self.layout.points + self.layout.point
        return dict(zip(labels_of(self.rows), at.tolist(), strict=True))

    @cached_property
    def columns(self) -> FloatArray:
        """(N, A, n) what one radian about each of the n axes of the table does."""
        rows, outputs = self.rows, self.k.T
        changes = force_changes(rows.pitch_rad, rows.roll_rad if self.is_rolled else None, rows.yaw_rad)
        of_table = AXES_OF_TABLE if rows.yaw_rad is not None else AXES_OF_TABLE[:-1]
        nothing = np.zeros((rows.rows, outputs.shape[1]))
        return np.stack([changes[axis] @ outputs if axis in changes else nothing for axis in of_table], axis=2)

    def without(self, labels: DwellLabels) -> "SeenPackage":
        dwell = self.dwell.get(labels)
        return self if dwell is None else replace(self, grid=self.grid.without(dwell))

    def locations(self, labels: Sequence[DwellLabels]) -> tuple[IntArray, IntArray]:
        """Return (D,) places in the grid, -1 where the package was not read, and (D,) rows, any one there."""
        at = np.array([self.dwell.get(each, -1) for each in labels], dtype=np.int64)
        return at, np.array([self.row_of.get(each, 0) for each in labels], dtype=np.int64)

    @cached_property
    def scatter(self) -> DwellScatter:
        """What its dwells are held against."""
        return scatter_of_replications(self.grid) if self.is_uneven else scatter_of_all(self.grid)


def seen_package(package: StoodPackage, changes: Sequence[ProvedChange]) -> SeenPackage | None:
    rows, calibration = package.rows, package.calibration
    axes = [axis for axis in calibration.axes.values() if axis.residuals_v.size == rows.rows]
    is_rolled = calibration.model != STING.name
    is_yawed = calibration.model in (MODEL.name, STING.name)
    if not (calibration.convention == "TP" or is_yawed) or rows.mounting is not None or not axes:
        return None
    rows = rows if is_yawed else replace(rows, yaw_rad=None)
    layout = layout_of(rows)
    if layout.replications < _FEWEST_REPLICATIONS:
        return None
    plain = np.stack([axis.residuals_v for axis in axes], axis=1)
    yaw = None if rows.yaw_rad is None else layout.mean_by_point(rows.yaw_rad)
    pitch, roll = angles_of_points(rows, layout)
    roll = roll if is_rolled else np.zeros_like(roll)
    basis = np.column_stack([np.ones(layout.points), specific_force(pitch, roll, yaw)])
    dwell = layout.replication * layout.points + layout.point
    grid = grid_residuals(basis, plain, dwell, layout.replications, layout.points)
    for change in changes:
        grid = _beside(change, grid, rows, dwell, is_rolled=is_rolled)
    reading = np.stack([axis.fitted_v for axis in axes], axis=1)
    k = np.array([axis.sensitive_axis_v_per_g for axis in axes]) * (-1.0 if is_yawed else 1.0)
    scatters = grid.squares > 0.0
    if not (scatters.any() and np.isfinite(k).all()) or grid.dof <= LEAST_DOF:
        return None
    kept = np.flatnonzero(scatters)
    names = tuple(axes[index].axis for index in kept)
    left = replace(grid, residuals=grid.residuals[:, kept])
    return SeenPackage(package.name, names, rows, is_rolled, layout, k[kept], reading[:, kept], plain[:, kept], left)


def _beside(
    change: ProvedChange, grid: GridResiduals, rows: Observations, dwell: IntArray, *, is_rolled: bool
) -> GridResiduals:
    """Return the residuals beside what a change that is proved may have done to any output."""
    after, before = is_among(rows, change.after), is_among(rows, change.before)
    roll_rad = rows.roll_rad if is_rolled else np.zeros(rows.rows)
    force = np.column_stack([np.ones(rows.rows), specific_force(rows.pitch_rad, roll_rad, rows.yaw_rad)])
    on_grid = np.zeros((grid.present.size, force.shape[1]))
    on_grid[dwell] = after[:, None] * force
    for between in dwell[~(after | before)]:
        grid = grid.without(int(between))
    return grid.beside(on_grid)


@dataclass(frozen=True)
class Turns:
    """What each of D dwells shows of a turn of the table, beside the scatter of readings alone."""

    angles: FloatArray
    """(D, n) radians about each axis of the table; 0 where it is not seen."""
    covariance: FloatArray
    """(D, n, n)"""
    numbers: FloatArray
    """(D,) how many of them are seen."""

    def squares(self, seating: FloatArray) -> FloatArray:
        """Return (D,) what a turn explains beside readings and (n,) variances of seating, for each number."""
        whole = self.covariance + np.diag(seating)
        inverse = np.linalg.pinv(whole, rcond=_ROUNDING, hermitian=True)
        squares = np.einsum("di,dij,dj->d", self.angles, inverse, self.angles)
        return np.asarray(squares / np.maximum(self.numbers, 1.0))

    @cached_property
    def seating(self) -> FloatArray:
        """(n,) variance about each axis of the table of how it seats from dwell to dwell, rad²."""
        found = np.zeros(self.angles.shape[1])
        for axis in range(found.size):
            variance = self.covariance[:, axis, axis]
            seen = variance > 0.0
            weight = float(np.sum(1.0 / variance[seen]))
            if weight > 0.0:
                excess = float(np.sum(self.angles[seen, axis] ** 2 / variance[seen] - 1.0))
                found[axis] = max(excess / weight, 0.0)
        return found


@dataclass(frozen=True)
class DwellSearch:
    packages: tuple[SeenPackage, ...]
    labels: tuple[DwellLabels, ...]
    """(D)"""

    @property
    def dof(self) -> float:
        """Of the scatter of each axis, the dwell that is looked at apart."""
        return min(package.scatter.dof for package in self.packages) - 1

    @cached_property
    def turns(self) -> Turns:
        """By the scatter of all dwells but the one."""
        return self._turns([package.scatter.without for package in self.packages])

    @cached_property
    def alike(self) -> Turns:
        """By the scatter of all dwells: one that is far off has no more weight than the others."""
        return self._turns([package.scatter.variance for package in self.packages])

    @property
    def seating(self) -> FloatArray:
        """(n,) variance about each axis of the table of how it seats from dwell to dwell, rad²."""
        return self.alike.seating

    @property
    def _axes(self) -> int:
        """Of the table."""
        return int(self.packages[0].columns.shape[2])

    def _turns(self, variances: Sequence[FloatArray]) -> Turns:
        count, axes = len(self.labels), self._axes
        normal, field = np.zeros((count, axes, axes)), np.zeros((count, axes))
        for package, variance in zip(self.packages, variances, strict=True):
            at, row = package.locations(self.labels)
            # A residual has the variance σ² h, and a turn does h times its column to it.
            leverage = np.where(at >= 0, package.grid.leverages[at], 0.0)[:, None]
            weight = np.where(leverage > 0.0, 1.0 / variance[at], 0.0)
            columns = package.columns[row]
            normal += np.einsum("dai,da,daj->dij", columns, weight * leverage, columns)
            field += np.einsum("dai,da->di", columns, weight * package.grid.residuals[at])
        values, vectors = np.linalg.eigh(normal)
        seen = values > _SEEN * normal.max(initial=0.0)
        inverse = np.divide(1.0, values, out=np.zeros_like(values), where=seen)
        covariance = np.einsum("dik,dk,djk->dij", vectors, inverse, vectors)
        return Turns(np.einsum("dij,dj->di", covariance, field), covariance, seen.sum(axis=1).astype(float))

    def likeliest(self) -> int:
        """Return the dwell that a turn explains most of; of two replications the one that the fit is further from."""
        dwell = int(np.argmax(self.alike.squares(self.seating)))
        replication, point = self.labels[dwell]
        mates = [at for at, labels in enumerate(self.labels) if labels[1] == point and labels[0] != replication]
        if not self.is_of_two or len(mates) != 1:
            return dwell
        return max(dwell, mates[0], key=self._off_the_fit)

    @property
    def is_of_two(self) -> bool:
        """Whether both replications of a point stand as far from their mean."""
        return all(package.layout.replications == _FEWEST_REPLICATIONS for package in self.packages)

    def _off_the_fit(self, dwell: int) -> float:
        """Return what a turn explains of what a dwell reads off the fit, the effects of points in it."""
        normal, field = np.zeros((self._axes, self._axes)), np.zeros(self._axes)
        for package in self.packages:
            row = package.row_of.get(self.labels[dwell])
            if row is not None:
                at = package.dwell[self.labels[dwell]]
                weighed = package.columns[row] / package.scatter.variance[at][:, None]
                normal, field = normal + weighed.T @ package.columns[row], field + weighed.T @ package.plain[row]
        return float(field @ np.linalg.pinv(normal, rcond=_SEEN, hermitian=True) @ field)

    def without(self, labels: DwellLabels) -> "DwellSearch":
        return replace(self, packages=tuple(package.without(labels) for package in self.packages))

    @property
    def scatters_unevenly(self) -> bool:
        """Whether the replications of any axis plainly do not scatter alike."""
        chances = np.concatenate([chances_of_even_scatter(package.grid) for package in self.packages])
        return bool(chances.size * chances.min() <= _UNEVEN)

    def by_replication(self) -> "DwellSearch":
        """Return the search that holds each dwell against its own replication alone."""
        return replace(self, packages=tuple(replace(package, is_uneven=True) for package in self.packages))

    def p_value(self, dwell: int, rest: "DwellSearch") -> float:
        """Return the chance of a turn over all dwells. ``rest``: the search without the dwell."""
        numbers = float(self.turns.numbers[dwell])
        if self.dof < LEAST_DOF or not numbers:
            return 1.0
        square = float(self.turns.squares(rest.seating)[dwell])
        tried = len(self.labels) / (2.0 if self.is_of_two else 1.0)
        return min(1.0, tried * float(f_tail(square, numbers, self.dof)))

    def judged(self, dwell: int, rest: "DwellSearch") -> "Behind":
        """Return what is behind a dwell that stands out."""
        axes, rolls, parts = list[tuple[str, str]](), list[bool](), list[tuple[FloatArray, ...]]()
        for package in self.packages:
            at, row = package.dwell.get(self.labels[dwell]), package.row_of.get(self.labels[dwell])
            if at is None or row is None or not package.grid.leverages[at] > 0.0:
                continue
            leverage = package.grid.leverages[at]
            axes += [(package.name, axis) for axis in package.axes]
            rolls += [package.is_rolled] * len(package.axes)
            change, variance = package.grid.residuals[at] / leverage, package.scatter.without[at] / leverage
            parts.append((package.k, change, variance, package.reading[row]))
        k, change, variance, reading = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        names = tuple(name for name, _ in axes), tuple(axis for _, axis in axes)
        watched = WatchedAxes(*names, (_METER,) * len(axes), k, np.array(rolls))
        first = self.packages[0]
        row = first.row_of[self.labels[dwell]]
        yaw = first.rows.yaw_rad
        visits = Visits(
            first.rows.pitch_rad[row : row + 1], first.rows.roll_rad[row : row + 1], change[None], reading[None],
            variance[None], self.dof, float(np.sqrt(rest.seating.max())), is_momentary=True,
            yaw_rad=None if yaw is None else yaw[row : row + 1],
        )  # fmt: skip
        common = judge_visits(watched, visits, _CONTRADICTED)
        causes = (*common.stated, *common.also) if len(common.stated) == 1 else common.stated
        turn = next((cause for cause in causes if cause.kind == "table-rotation"), None)
        if turn is None or (turn.name == ROTATION and not common.rotation_rad > 0.0):
            return Behind(common, None, "")  # of what no turn of a size explains nothing is said of the table
        seen = replace(common, estimates=whiten(watched, visits, common.agreeing).estimates(turn.parts, 1.0))
        return Behind(common, turn, turn_in_words(seen, turn))


@dataclass(frozen=True)
class Behind:
    """What is behind a dwell that stands out."""

    common: CommonMode
    turn: Cause | None
    """Of the table, where it explains the dwell."""
    turn_in_words: str

    @property
    def is_table(self) -> bool:
        """Whether nothing but the table would look the same."""
        common = self.common
        return self.turn is not None and all(cause.kind == self.turn.kind for cause in (*common.stated, *common.also))
