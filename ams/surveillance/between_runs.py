"""How far two calibrations of an unchanged sensor differ: the scatter between runs, day and remount included.

It is learned from successive differences, d² / 2, which a slow drift hardly touches. Over all sensors of a kind the
median is taken (times 1 / 0.4549, the median of χ² with one degree of freedom), so that those which drift, dropped or
were mixed up do not count; with few differences the mean. A sensor's own differences are then weighed in, so that one
that scatters more than its kind is soon judged by itself. How many degrees of freedom the others are worth follows from
how much the sensors' own scatters differ among each other: variances moderated as by Smyth (2004), fitted to the
logarithms, here by their median and median deviation.

No more than a thousand calibrations of others are learned from: they never count for more than a thousand degrees of
freedom beside a sensor's own, so more would change nothing but the time that a history takes. It is the sensors that
follow in the order of their names, the first behind the last: which they are depends on no calibration's outcome.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, digamma, trigamma
from ams.surveillance.series import Population

MEDIAN_OF_CHI_SQUARE_1 = 0.4549364
ROBUST_FROM = 6
"""Differences from which on the median is taken."""
MEDIAN_EFFICIENCY = 0.37
"""Degrees of freedom of the median form, of each difference."""
DIFFERENCE_EFFICIENCY = 2.0 / 3.0
"""Successive differences share calibrations: degrees of freedom of each (von Neumann)."""
UNKNOWN_PRIOR_DOF = 10.0
"""Where there are too few sensors to tell how alike they are."""
LEAST_PRIOR_DOF, MOST_PRIOR_DOF = 4.0, 1000.0
SENSORS_TO_TELL, DIFFERENCES_TO_TELL = 8, 3
LEARNED_FROM = 1000
"""Calibrations of other sensors from which on the sensors that follow are not asked any more."""


@dataclass(frozen=True)
class Scatter:
    """Variance of one calibration about its sensor's level, rad², with the degrees of freedom it is known by."""

    variance: FloatArray
    """(p,)"""
    dof: FloatArray
    """(p,) zero where nothing is known."""
    prior_dof: FloatArray
    """(p,) what it counts for beside a sensor's own."""

    def with_sensor(self, squares: FloatArray, differences: int) -> "Scatter":
        """Return the scatter weighed with the sum of d² / 2 of a sensor's own differences, (p,)."""
        sensor_dof = DIFFERENCE_EFFICIENCY * differences
        dof = self.prior_dof + sensor_dof
        sensor_squares = squares * (sensor_dof / differences) if differences else np.zeros_like(self.variance)
        total = self.prior_dof * self.variance + sensor_squares
        return Scatter(np.where(dof > 0.0, total / np.where(dof > 0.0, dof, 1.0), np.nan), dof, dof)


def pooled_scatter(population: Population, leave_out: str | None = None) -> Scatter:
    """Return the scatter of a kind of package from its other sensors, those that follow ``leave_out`` by name first.

    It is the same for all characteristics of a kind.
    """
    same = np.diff(population.sensor_index) == 0
    selected = _selected(population, leave_out)
    kept = same & np.array(
        [label.sensor in selected and not label.is_check for label in population.labels[1:]], dtype=bool
    )
    halves = 0.5 * np.diff(population.coordinates, axis=0)[kept] ** 2
    sensors = population.sensor_index[1:][kept]
    width = len(population.kinds)
    variance, dof, prior = np.zeros(width), np.zeros(width), np.zeros(width)
    for kind in set(population.kinds):
        columns = [index for index, name in enumerate(population.kinds) if name == kind]
        variance[columns], dof[columns] = _of_kind(halves[:, columns].ravel())
        prior[columns] = np.minimum(dof[columns], _prior_dof(halves[:, columns], sensors))
    return Scatter(variance, dof, prior)


def names_behind(names: Iterable[str], name: str | None) -> list[str]:
    """Return the names but the given one, sorted, beginning with those behind it and going round."""
    behind: list[str] = []
    before: list[str] = []
    for sensor in sorted(set(names)):
        (behind if name is None or sensor > name else before).append(sensor)
    return [other for other in (*behind, *before) if other != name]


def _selected(population: Population, leave_out: str | None) -> frozenset[str]:
    """Return the sensors that the scatter is learned from."""
    counts = Counter(label.sensor for label in population.labels if not label.is_check)
    order = names_behind(counts, leave_out)
    known = accumulate((counts[name] for name in order), initial=0)
    return frozenset(name for name, before in zip(order, known, strict=False) if before < LEARNED_FROM)


def _of_kind(halves: FloatArray) -> tuple[float, float]:
    if halves.size == 0:
        return 0.0, 0.0
    if halves.size < ROBUST_FROM:
        return float(halves.mean()), DIFFERENCE_EFFICIENCY * halves.size
    return float(np.median(halves)) / MEDIAN_OF_CHI_SQUARE_1, MEDIAN_EFFICIENCY * halves.size


def _prior_dof(halves: FloatArray, sensors: IntArray) -> float:
    """Return the degrees of freedom of the distribution from which the sensors' own variances seem to be drawn."""
    counts = np.bincount(sensors)
    sensors_with_enough = np.flatnonzero(counts >= DIFFERENCES_TO_TELL)
    if sensors_with_enough.size < SENSORS_TO_TELL:
        return UNKNOWN_PRIOR_DOF
    sensor_variance = (
        np.bincount(sensors, weights=halves.mean(axis=1))[sensors_with_enough] / counts[sensors_with_enough]
    )
    half_dof = 0.5 * DIFFERENCE_EFFICIENCY * counts[sensors_with_enough] * halves.shape[1]
    logarithms = np.log(np.maximum(sensor_variance, np.finfo(float).tiny)) - digamma(half_dof) + np.log(half_dof)
    deviation = SD_PER_MEDIAN_DEVIATION * np.median(np.abs(logarithms - np.median(logarithms)))
    excess = float(deviation**2 - trigamma(half_dof).mean())
    if excess <= 0.0:
        return MOST_PRIOR_DOF
    candidates = np.geomspace(LEAST_PRIOR_DOF, MOST_PRIOR_DOF, 200)
    return float(candidates[int(np.argmin(np.abs(trigamma(0.5 * candidates) - excess)))])
