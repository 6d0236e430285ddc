"""What each cause does to the readings of two visits, (K, A) over all axes of all sensors, and the fit of it.

Each datum is brought to unit variance: the scatter of readings, of seating the table anew, and of knowing the axes
imperfectly stands in the covariance. Source: as of :mod:`ams.surveillance.common_mode`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.frames import specific_force
from ams.surveillance.turns import AXES_OF_TABLE, BASE, PITCH, YAW, force_changes

MODEL_ERROR = 0.02
"""Of the change itself: how well sensitivities and directions are known while a run goes on."""
OF_LONE, OF_ALIKE = "own", "like"
"""Of a lone sensor's axis, and of the axes of one name in all sensors: how the column of what it does begins."""
SAME = 1e-6
"""Relative: what differs by less is the same to a least-squares fit."""
_ROUNDING = 4.0 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class WatchedAxes:
    """A axes of one or more sensors."""

    sensor: tuple[str, ...]
    axis: tuple[str, ...]
    meter: tuple[str, ...]
    """What reads it: axes with the same word share gain and offset."""
    k: FloatArray
    """(A, 3) sensitive axis in table axes, units of the reading per g."""
    rolls: BoolArray | None = None
    """(A,) whether the roll axis turns it; None: every one. Roll does not reach what stands on a sting."""

    @property
    def is_rolled(self) -> BoolArray:
        """Return (A,) whether the roll axis turns each."""
        return np.ones(len(self.axis), dtype=bool) if self.rolls is None else self.rolls

    @property
    def sensors(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(self.sensor))


@dataclass(frozen=True)
class Visits:
    """A later visit to K attitudes less an earlier one."""

    pitch_rad: FloatArray
    roll_rad: FloatArray
    change: FloatArray
    """(K, A) in the unit of the reading, NaN where an axis was not read in both."""
    reading: FloatArray
    """(K, A) the reading itself."""
    variance: FloatArray
    """(K, A) of the change, by the scatter of readings."""
    degrees_of_freedom: float
    """By which the variances are known; the smallest."""
    seating_rad: float = 0.0
    """Standard uncertainty of the *difference* of two seatings, about each axis of the table."""
    warmth_g: float = 0.0
    """The most that the recorded change of temperature between the visits can have done to an axis."""
    is_momentary: bool = False
    """Whether the later one is a single dwell among others: no temperature did that to all sensors alike."""
    drifted: FloatArray | None = None
    """(K, A) one standard uncertainty of what each axis drifted by itself, alike at all attitudes: where a drift was
    taken from the change, how well it is known. None where no axis drifts."""
    yaw_rad: FloatArray | None = None
    """Of a gimbal."""


@dataclass(frozen=True)
class Estimate:
    """Size of one common part."""

    value: float
    """Radians, relative, or in the unit of the reading."""
    standard_uncertainty: float


@dataclass(frozen=True)
class Whitened:
    """Data and columns of some sensors, each datum with unit variance and independent."""

    y: FloatArray
    columns: Mapping[str, FloatArray]
    fits_all: int
    """Numbers that fit whatever all sensors do alike: one for every attitude and name of an axis."""

    def left(self, names: Sequence[str]) -> tuple[float, int]:
        """Return (sum of squares left, rank) of a fit."""
        if not names:
            return float(self.y @ self.y), 0
        matrix = self._matrix(names)
        solved, _, rank, _ = np.linalg.lstsq(matrix, self.y, rcond=SAME)
        rest = self.y - matrix @ solved
        return float(rest @ rest), int(rank)

    def estimates(self, names: Sequence[str], scale: float) -> dict[str, Estimate]:
        """Return each part with its standard uncertainty; what the data do not tell apart is shared out."""
        matrix, norms = self._matrix(names), self._norms(names)
        inverse = np.linalg.pinv(matrix, rcond=SAME)
        values, spreads = inverse @ self.y, np.sqrt(scale * (inverse**2).sum(axis=1))
        return {
            name: Estimate(float(value / norm), float(spread / norm))
            for name, value, spread, norm in zip(names, values, spreads, norms, strict=True)
        }

    def _matrix(self, names: Sequence[str]) -> FloatArray:
        return np.stack([self.columns[name] for name in names], axis=1) / self._norms(names)

    def _norms(self, names: Sequence[str]) -> FloatArray:
        norms = np.array([float(np.linalg.norm(self.columns[name])) for name in names])
        return np.where(norms > 0.0, norms, 1.0)


def whiten(axes: WatchedAxes, visits: Visits, among: Sequence[str]) -> Whitened:
    """Return data and columns of the sensors ``among``."""
    kept = np.array([name in among for name in axes.sensor], dtype=bool)
    columns = columns_of(axes, visits, kept, is_lone=len(among) == 1)
    pieces_y: list[FloatArray] = []
    pieces: dict[str, list[FloatArray]] = {name: [] for name in columns}
    drifts: list[FloatArray] = []
    spread = model_error(axes, visits)
    for index in range(visits.pitch_rad.size):
        read = kept & np.isfinite(visits.change[index])
        if not read.any():
            continue
        rounding = (_ROUNDING * visits.reading[index, read]) ** 2 + np.finfo(float).tiny
        imperfect = (spread[index] * sensitivity_of(axes)[read]) ** 2
        covariance = np.diag(visits.variance[index, read] + imperfect + rounding)
        for name in AXES_OF_TABLE:
            if name not in columns:
                continue
            turned = visits.seating_rad * columns[name][index, read]
            covariance = covariance + np.outer(turned, turned)
        factor = np.linalg.cholesky(covariance)
        pieces_y.append(np.linalg.solve(factor, visits.change[index, read]))
        for name, column in columns.items():
            pieces[name].append(np.linalg.solve(factor, column[index, read]))
        if visits.drifted is not None:
            drifts.append(np.linalg.solve(factor, np.diag(visits.drifted[index])[read]))
    empty = [np.zeros(0)]
    whitened = {name: np.concatenate(found or empty) for name, found in pieces.items()}
    y = np.concatenate(pieces_y or empty)
    if visits.drifted is not None and y.size > 0:
        y, *beside = _beside(np.concatenate(drifts), [y, *whitened.values()])
        whitened = dict(zip(whitened, beside, strict=True))
    names = {(at, axes.axis[index]) for at, index in np.argwhere(np.isfinite(visits.change) & kept).tolist()}
    return Whitened(y, whitened, len(names))


def _beside(drifts: FloatArray, whitened: Sequence[FloatArray]) -> list[FloatArray]:
    """Return each (n,) of unit variance, which share (n, A) errors D as well, each of unit variance: (I + DDᵀ)^(−½)."""
    shared, sizes, _ = np.linalg.svd(drifts, full_matrices=False)
    lessened = 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)
    return [values - shared @ (lessened * (shared.T @ values)) for values in whitened]


def sensitivity_of(axes: WatchedAxes) -> FloatArray:
    """Return (A,) in the unit of the reading per g."""
    return np.asarray(np.linalg.norm(axes.k, axis=1))


def model_error(axes: WatchedAxes, visits: Visits) -> FloatArray:
    """Return (K,) what imperfectly known axes make of the changes of an attitude, g."""
    relative = visits.change / sensitivity_of(axes)
    squares = np.where(np.isfinite(relative), relative, 0.0) ** 2
    read = np.maximum(np.isfinite(relative).sum(axis=1), 1)
    return np.asarray(MODEL_ERROR * np.sqrt(squares.sum(axis=1) / read))


def columns_of(axes: WatchedAxes, visits: Visits, kept: BoolArray, *, is_lone: bool) -> dict[str, FloatArray]:
    """Name to (K, A) what one unit of a cause does."""
    columns = _turns(axes, visits, kept)
    reading = np.where(np.isfinite(visits.reading), visits.reading, 0.0)
    for meter in dict.fromkeys(word for word, is_kept in zip(axes.meter, kept, strict=True) if is_kept):
        shared = np.array([word == meter for word in axes.meter], dtype=float)
        columns[f"gain of {meter}"] = reading * shared
        columns[f"offset of {meter}"] = np.ones_like(reading) * shared
    groups = {} if visits.is_momentary and not is_lone else _groups(axes, kept, is_lone=is_lone)
    for label, members in groups.items():
        columns[f"{OF_LONE if is_lone else OF_ALIKE} offset of {label}"] = np.ones_like(reading) * members
        columns[f"{OF_LONE if is_lone else OF_ALIKE} sensitivity of {label}"] = _along(axes, visits) * members
    return columns


def _turns(axes: WatchedAxes, visits: Visits, kept: BoolArray) -> dict[str, FloatArray]:
    """Name of a turn to (K, A) what a radian does. Where roll reaches any of the ``kept``, the fixture stands on it."""
    rolls = axes.is_rolled
    if rolls.all() or (rolls & kept).any():
        moved = force_changes(visits.pitch_rad, visits.roll_rad, visits.yaw_rad)
        columns = {name: change @ axes.k.T for name, change in moved.items()}
        if rolls.all():
            return columns
    on_sting = {
        name: change @ axes.k.T for name, change in force_changes(visits.pitch_rad, None, visits.yaw_rad).items()
    }
    if not (rolls & kept).any():
        return on_sting
    shared = {name: on_sting[name] for name in (PITCH, YAW, BASE) if name in on_sting}
    return {name: np.where(rolls, column, shared.get(name, 0.0)) for name, column in columns.items()}


def _along(axes: WatchedAxes, visits: Visits) -> FloatArray:
    """Return (K, A) what the axes sense, in the unit of the reading."""
    sensed = specific_force(visits.pitch_rad, visits.roll_rad, visits.yaw_rad) @ axes.k.T
    if axes.is_rolled.all():
        return np.asarray(sensed)
    level = np.zeros_like(visits.roll_rad)
    return np.where(axes.is_rolled, sensed, specific_force(visits.pitch_rad, level, visits.yaw_rad) @ axes.k.T)


def _groups(axes: WatchedAxes, kept: BoolArray, *, is_lone: bool) -> dict[str, FloatArray]:
    """Label to (A,) ones for the axes that one temperature moves alike: those of one name in all sensors."""
    labels = [f"{sensor} {axis}" if is_lone else axis for sensor, axis in zip(axes.sensor, axes.axis, strict=True)]
    names = dict.fromkeys(label for label, is_kept in zip(labels, kept, strict=True) if is_kept)
    return {name: np.array([label == name for label in labels], dtype=float) * kept for name in names}
