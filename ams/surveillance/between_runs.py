"""How far two calibrations of an unchanged sensor differ: the scatter between runs, day and remount included.

Of other sensors it is learned from how far a calibration lies from the straight line through the one before and the one
behind it in time, e² / (1 + w² + (1 − w)²), so that no drift is in it, however large; of a sensor that was calibrated
twice, from the difference, d² / 2. Over all sensors of a kind the median is taken (times 1 / 0.4549, the median of χ²
with one degree of freedom), so that those which dropped or were mixed up do not count; with few of them the mean. What
a sensor's own calibrations leave about straight lines (:mod:`ams.surveillance.regime`) is then weighed in, so that one
that scatters more than its kind is soon judged by itself. How many degrees of freedom the others are worth follows from
how much the sensors' own scatters differ among each other: variances moderated as by Smyth (2004), fitted to the
logarithms, here by their median and median deviation.

No more than a thousand calibrations of others are learned from: they never count for more than a thousand degrees of
freedom beside a sensor's own, so more would change nothing but the time that a history takes. It is the sensors that
follow in the order of their names, the first behind the last: which they are depends on no calibration's outcome.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, digamma, trigamma
from ams.surveillance.series import Population

MEDIAN_OF_CHI_SQUARE_1 = 0.4549364
ROBUST_FROM = 6
"""Deviations from which on the median is taken."""
MEDIAN_EFFICIENCY = 0.25
"""Degrees of freedom of the median form, of each deviation."""
MEAN_EFFICIENCY = 18.0 / 35.0
"""Successive deviations share calibrations, with correlations −2/3 and 1/6: degrees of freedom of each."""
UNKNOWN_PRIOR_DOF = 10.0
"""Where there are too few sensors to tell how alike they are."""
LEAST_PRIOR_DOF, MOST_PRIOR_DOF = 4.0, 1000.0
SENSORS_TO_TELL, DEVIATIONS_TO_TELL = 8, 3
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

    def with_sensor(self, squares: FloatArray, sensor_dof: int) -> "Scatter":
        """Return the scatter weighed with a sensor's own sum of squares, (p,), of so many degrees of freedom."""
        dof = self.prior_dof + sensor_dof
        total = self.prior_dof * self.variance + squares
        return Scatter(np.where(dof > 0.0, total / np.where(dof > 0.0, dof, 1.0), np.nan), dof, dof)


def pooled_scatter(population: Population, leave_out: str | None = None) -> Scatter:
    """Return the scatter of a kind of package from its other sensors, those that follow ``leave_out`` by name first.

    It is the same for all characteristics of a kind.
    """
    return scatter_of(population, population.coordinates, population.kinds, leave_out)


def scatter_of(
    population: Population, values: FloatArray, kinds: Sequence[str], leave_out: str | None = None
) -> Scatter:
    """Return the scatter of (N, p) values of the population's calibrations; columns of one kind have one scatter."""
    squares, sensors = _squared_deviations(population, values, _selected(population, leave_out))
    width = len(kinds)
    variance, dof, prior = np.zeros(width), np.zeros(width), np.zeros(width)
    for kind in set(kinds):
        columns = [index for index, name in enumerate(kinds) if name == kind]
        variance[columns], dof[columns] = _of_kind(squares[:, columns].ravel())
        prior[columns] = np.minimum(dof[columns], _prior_dof(squares[:, columns], sensors))
    return Scatter(variance, dof, prior)


def _squared_deviations(
    population: Population, coordinates: FloatArray, selected: frozenset[str]
) -> tuple[FloatArray, IntArray]:
    """Return (m, p) the variance of a calibration that each deviation tells, rad², and (m,) whose it is."""
    years, sensors = population.years, population.sensor_index
    counted = np.array([label.sensor in selected and not label.is_check for label in population.labels], dtype=bool)
    middle = 1 + np.flatnonzero(counted[1:-1] & (sensors[:-2] == sensors[2:]))
    before, span = years[middle] - years[middle - 1], years[middle + 1] - years[middle - 1]
    weight = np.where(span > 0.0, 1.0 - before / np.where(span > 0.0, span, 1.0), 0.5)[:, None]
    line = weight * coordinates[middle - 1] + (1.0 - weight) * coordinates[middle + 1]
    of_middle = (coordinates[middle] - line) ** 2 / (1.0 + weight**2 + (1.0 - weight) ** 2)
    second = 1 + np.flatnonzero(counted[1:] & (sensors[1:] == sensors[:-1]))
    second = second[np.bincount(sensors)[sensors[second]] == 2]
    of_pair = 0.5 * (coordinates[second] - coordinates[second - 1]) ** 2
    return np.concatenate([of_middle, of_pair]), np.concatenate([sensors[middle], sensors[second]])


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


def _of_kind(squares: FloatArray) -> tuple[float, float]:
    if squares.size == 0:
        return 0.0, 0.0
    if squares.size < ROBUST_FROM:
        return float(squares.mean()), MEAN_EFFICIENCY * squares.size
    return float(np.median(squares)) / MEDIAN_OF_CHI_SQUARE_1, MEDIAN_EFFICIENCY * squares.size


def _prior_dof(squares: FloatArray, sensors: IntArray) -> float:
    """Return the degrees of freedom of the distribution from which the sensors' own variances seem to be drawn."""
    counts = np.bincount(sensors)
    sensors_with_enough = np.flatnonzero(counts >= DEVIATIONS_TO_TELL)
    if sensors_with_enough.size < SENSORS_TO_TELL:
        return UNKNOWN_PRIOR_DOF
    sensor_variance = (
        np.bincount(sensors, weights=squares.mean(axis=1))[sensors_with_enough] / counts[sensors_with_enough]
    )
    half_dof = 0.5 * MEAN_EFFICIENCY * counts[sensors_with_enough] * squares.shape[1]
    logarithms = np.log(np.maximum(sensor_variance, np.finfo(float).tiny)) - digamma(half_dof) + np.log(half_dof)
    deviation = SD_PER_MEDIAN_DEVIATION * np.median(np.abs(logarithms - np.median(logarithms)))
    excess = float(deviation**2 - trigamma(half_dof).mean())
    if excess <= 0.0:
        return MOST_PRIOR_DOF
    candidates = np.geomspace(LEAST_PRIOR_DOF, MOST_PRIOR_DOF, 200)
    return float(candidates[int(np.argmin(np.abs(trigamma(0.5 * candidates) - excess)))])
