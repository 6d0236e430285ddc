"""What the sensors of a run changed alike since their own last calibrations: the meter's, or the table's, not theirs.

A gain of the meter is common to all sensors that it reads, and so is a turn of the table to all check sensors that stay
mounted. Each sensor by itself tells it from its own scatter only; n sensors together tell a change √n times smaller,
and tell it in the second run, since what they differ by among one another is known by then.

Components are those of a check sensor (:mod:`ams.surveillance.check_components`): gain and offset of the meter from
every sensor that was calibrated on the rig before, the rotation from check sensors alone, since the others were
remounted. Run by run the changes d_s since each sensor's last calibration on this rig are fitted by one common part,
d_s = c_s·μ + e_s, where c_s is 1 for gain and rotation and goes as 1 / sensitivity for an offset of the meter in volts.

1. Begun from those more than half of the sensors that lie closest together, the next nearest is taken in while it does
   what these do; who does otherwise stays apart. So sensors that are off never widen what they are held against.
2. The scatter of e is what the sensors that agree differ by, in this run and the ones before; it is never less than
   their certificates state. μ is held against Student's t of it.
3. Where those that agree differ by more than the runs before foretell (F), no majority did alike, and nothing is told
   of the run. Of the runs before those count that agree in the same way, from the quieter half outward.
4. Where five runs or more tell how much the meter wanders from run to run, every μ is held against that as well, the
   first ones too, by the median so that one change does not hide the next: a meter that always does so has not changed,
   and what sensors of one make do every year alike, as they age, is theirs and no meter's.

What is told, and nothing else, is taken out of all that this rig calibrated since, but of sensors that stayed apart.
Who did so once is left as it was measured from then on: nobody knows how much of what came before is in it. While
fewer runs tell than (4) asks for, an age that all have is told as well: such a change is not *distinct*, and makes no
interval longer (:mod:`ams.surveillance.interval_advice`).

The watch of a run (:mod:`ams.surveillance.common_mode`) fits the same causes to readings at visits, whose scatter it
knows; between calibrations there are no readings, and the scatter has to be learned over the years.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import accumulate, compress
from operator import or_

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ams.arrays import BoolArray, FloatArray
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, f_quantile
from ams.statistics.intervals import t_quantile
from ams.surveillance.check_components import (
    METER_GAIN,
    METER_OFFSET,
    TILT,
    alike,
    is_gain,
    is_offset,
    variance_of_families,
)
from ams.surveillance.common_mode_words import who_agree
from ams.surveillance.series import Population

LEVEL = 0.002
"""Chance of any false alarm in one run."""
PAIR_EFFICIENCY = 2.0 / 3.0
"""Degrees of freedom of each difference between successive runs: neighbours share a calibration, correlated by −1/2."""
LEAST_WANDER = 5
"""Runs from which on it is known how much the meter changes from one to the next."""
USUAL_LEVEL = 0.01
"""Chance that what a meter does from run to run is taken for more than that."""
_TILTS = ("table tilt x", "table tilt y", "table tilt z")


@dataclass(frozen=True)
class SharedChange:
    """What several sensors changed alike in one run."""

    run_id: str
    rig: str
    since_utc: datetime
    """The earliest calibration of the run: from then on all that the rig calibrates is so."""
    component: str
    """Of a check sensor: ``meter gain``, ``meter offset``, ``table tilt x`` …"""
    size_rad: float
    """As an angle at full sensitivity; of an offset at the median sensitivity of the kind."""
    standard_uncertainty_rad: float
    sensors: tuple[str, ...]
    """That did so."""
    apart: tuple[str, ...]
    """Who did otherwise, in that run or in one before: it is taken out of nothing of theirs."""
    sentence: str
    is_distinct: bool
    """Whether runs enough tell that it is no more of what goes on from run to run, such as an age that all have."""


def shared_changes(population: Population) -> tuple[SharedChange, ...]:
    """Return what the sensors of each run changed alike, the earliest first, on every rig by itself."""
    if not population.numbers.sensitivity.all():
        return ()
    of_gain = [*_of_gain(population)]
    found = [*of_gain, *_of_offset(population, of_gain), *_of_rotation(population)]
    return tuple(sorted(found, key=lambda change: change.since_utc))


def without_shared(population: Population, changes: Sequence[SharedChange]) -> Population:
    """Return the population without what all sensors of a run changed alike, which is no sensor's."""
    return replace(population, shared_rad=taken_out_rad(population, changes)) if changes else population


def taken_out_rad(population: Population, changes: Sequence[SharedChange]) -> FloatArray:
    """Return (N, p) what of the population's coordinates is the meter's, by the changes that were told."""
    shared = np.zeros_like(population.coordinates)
    gain, offset = np.flatnonzero(is_gain(population)), np.flatnonzero(is_offset(population))
    rigs, times_utc = np.array([(label.rig, label.created_utc) for label in population.labels], dtype=object).T
    for change in changes:
        rows = (rigs == change.rig) & (times_utc >= change.since_utc)
        for sensor in change.apart:
            rows[population.rows_of(sensor)] = False
        if change.component == METER_GAIN:  # which every output has as a whole, its offset too
            shared[np.ix_(rows, gain)] += change.size_rad * np.sign(population.numbers.sensitivity[rows])
            shared[np.ix_(rows, offset)] += change.size_rad * population.coordinates[np.ix_(rows, offset)]
        elif change.component == METER_OFFSET:
            shared[np.ix_(rows, offset)] += change.size_rad * _per_volt(population)[rows, None]
    return shared


def _per_volt(population: Population) -> FloatArray:
    """Return (N,) what an offset of the meter amounts to as an angle, against a package of the median sensitivity."""
    sensitivity = np.abs(population.numbers.sensitivity).mean(axis=1)
    return np.asarray(np.median(sensitivity) / sensitivity)


def _of_gain(population: Population) -> Iterator[SharedChange]:
    everybody = np.ones(len(population.labels), dtype=bool)
    ones = everybody.astype(float)
    variance = variance_of_families(population.numbers, population.characteristics)[METER_GAIN]
    for rig in _rigs(population):
        values = alike(population)[METER_GAIN]
        yield from _Watch(population, rig, METER_GAIN, values, ones, variance, everybody).changes()


def _of_offset(population: Population, of_gain: Sequence[SharedChange]) -> Iterator[SharedChange]:
    """Yield changes of the meter's offset beside those of its gain, which an offset has as well."""
    everybody = np.ones(len(population.labels), dtype=bool)
    variance = variance_of_families(population.numbers, population.characteristics)[METER_OFFSET]
    offsets = (population.coordinates - taken_out_rad(population, of_gain))[:, is_offset(population)]
    for rig in _rigs(population):
        values, column = offsets.mean(axis=1), _per_volt(population)
        yield from _Watch(population, rig, METER_OFFSET, values, column, variance, everybody).changes()


def _of_rotation(population: Population) -> Iterator[SharedChange]:
    mounted = np.array([label.is_check for label in population.labels], dtype=bool)
    checked = dict.fromkeys(label.sensor for label in population.labels if label.is_check)
    if len(checked) < 2:
        return
    ones = np.ones(len(population.labels))
    variance = variance_of_families(population.numbers, population.characteristics)[TILT]
    tilts = np.zeros((len(population.labels), 3))
    for sensor in checked:
        rows = population.rows_of(sensor)
        tilts[rows] = np.radians(population.rotation_deg(rows))
    for name, values in zip(_TILTS, tilts.T, strict=True):
        for rig in _rigs(population):
            yield from _Watch(population, rig, name, values, ones, variance, mounted).changes()


def _rigs(population: Population) -> tuple[str, ...]:
    return tuple(dict.fromkeys(label.rig for label in population.labels))


class _Watch:
    """One component on one rig as its runs come in."""

    def __init__(
        self,
        population: Population,
        rig: str,
        name: str,
        values: FloatArray,
        column: FloatArray,
        stated: FloatArray,
        counts: BoolArray,
    ) -> None:
        self.labels, self.rig, self.name = population.labels, rig, name
        self.values, self.column, self.stated, self.counts = values.copy(), column, stated, counts
        rigs, times_utc = np.array([(label.rig, label.created_utc) for label in population.labels], dtype=object).T
        self.is_here, self.times_utc = rigs == rig, times_utc
        self.scatters: list[_Scatter] = []
        """Of every run that was judged."""
        self.wander: list[float] = []
        """What the sensors of each run that was judged changed alike, told or not."""

    def changes(self) -> list[SharedChange]:
        """Return what was changed alike, run by run, beyond what the meter does from run to run."""
        runs: dict[str, list[int]] = {}
        for index in np.flatnonzero(self.is_here).tolist():
            run_id = self.labels[index].run_id
            if run_id is not None:
                runs.setdefault(run_id, []).append(index)
        order = sorted(runs, key=lambda run: min(self.times_utc[runs[run]]))
        found = [self._judged(run_id, runs[run_id]) for run_id in order]
        usual = self._usual()
        changes = [common for common in found if common is not None and abs(common.fit.size) > usual]
        apart = accumulate((dict.fromkeys(common.apart) for common in changes), or_)
        return [self._with_sentence(common, tuple(names)) for common, names in zip(changes, apart, strict=True)]

    def _usual(self) -> float:
        """Return how much is no change, by what is done from run to run; zero where too few runs tell."""
        if len(self.wander) < LEAST_WANDER:
            return 0.0
        spread = SD_PER_MEDIAN_DEVIATION * float(np.median(np.abs(self.wander)))
        return spread * float(t_quantile(1.0 - USUAL_LEVEL, PAIR_EFFICIENCY * len(self.wander)))

    def _judged(self, run_id: str, rows: Sequence[int]) -> "_Common | None":
        later = np.array([index for index in rows if self._follows(index)], dtype=np.int64)
        if later.size < 2:
            return None
        change, column = self.values[later] - self.values[later - 1], self.column[later]
        stated = self.stated[later] + self.stated[later - 1]
        before = _of_quiet_runs(self.scatters, float(stated.mean()))
        agree = _agreeing(change, column, before)
        fit = _Fit(change[agree], column[agree], before)
        self.scatters.append(_Scatter(fit.squares, fit.dof))
        if not before.foretells(self.scatters[-1]):
            return None
        self.wander.append(fit.size)
        if abs(fit.size) <= fit.limit(LEVEL / (2 + len(_TILTS))):
            return None
        since_utc = min(self.times_utc[rows])
        after = self.is_here & (self.times_utc >= since_utc)
        self.values[after] -= fit.size * self.column[after]  # so that who was absent is not said to have changed later
        names = tuple(self.labels[index].sensor for index in later)
        return _Common(run_id, since_utc, fit, names, tuple(compress(names, agree)))

    def _with_sentence(self, common: "_Common", apart: tuple[str, ...]) -> SharedChange:
        fit, who = common.fit, who_agree(common.alike, common.sensors)
        size, spread = float(np.degrees(fit.size)), float(np.degrees(fit.error))
        what = f"at {common.since_utc:%Y-%m-%d} {self.name} {size:+.4f}° (u {spread:.4f}°)"
        if self.name in _TILTS:
            said = f"{what}: {who} turned alike, who stayed mounted: the table or its base, not the sensors"
        else:
            said = (
                f"{what}: {who} of that run changed alike since their own last calibrations: the meter, or what all of "
                "them share (supply, temperature, age), not one sensor by itself"
            )
        is_distinct = len(self.wander) >= LEAST_WANDER
        return SharedChange(
            common.run_id, self.rig, common.since_utc, self.name, fit.size, fit.error, common.alike, apart, said,
            is_distinct,
        )  # fmt: skip

    def _follows(self, index: int) -> bool:
        """Return whether the sensor was calibrated on this rig before, and tells this component."""
        if index == 0 or not (self.counts[index] and self.counts[index - 1]):
            return False
        before, label = self.labels[index - 1], self.labels[index]
        return before.sensor == label.sensor and before.rig == label.rig


@dataclass(frozen=True)
class _Common:
    """What the sensors of one run changed alike by more than their scatter, be it usual or not."""

    run_id: str
    since_utc: datetime
    fit: "_Fit"
    sensors: tuple[str, ...]
    alike: tuple[str, ...]

    @property
    def apart(self) -> tuple[str, ...]:
        return tuple(name for name in self.sensors if name not in self.alike)


@dataclass(frozen=True)
class _Scatter:
    """How far changes differ among one another."""

    squares: float
    dof: float
    least: float = 0.0
    """Variance that the certificates state: it is never less."""

    @property
    def variance(self) -> float:
        return max(self.squares / self.dof, self.least)

    def foretells(self, later: "_Scatter") -> bool:
        """Return whether another run differs by no more; True where nothing is known."""
        if self.dof == 0.0:
            return True
        return later.squares <= self.variance * later.dof * float(f_quantile(1.0 - LEVEL, later.dof, self.dof))


def _of_quiet_runs(scatters: Sequence[_Scatter], least: float) -> _Scatter:
    """Return the scatter of the quieter more than half of the runs, and of each noisier one while these foretell it.

    A run with a step in it would widen what all runs after it are held against.
    """
    if not scatters:
        return _Scatter(0.0, 0.0, least)
    ordered = sorted(scatters, key=lambda scatter: scatter.squares / scatter.dof)
    squares, dof = np.array([(scatter.squares, scatter.dof) for scatter in ordered]).T
    known_squares, known_dof = PAIR_EFFICIENCY * squares.cumsum(), PAIR_EFFICIENCY * dof.cumsum()
    last = len(ordered) // 2
    quieter, noisier = slice(last, -1), slice(last + 1, None)
    variance = np.maximum(known_squares[quieter] / known_dof[quieter], least)
    limit = variance * dof[noisier] * f_quantile(1.0 - LEVEL, dof[noisier], known_dof[quieter])
    last += int(np.argmax([*(squares[noisier] > limit), True]))
    return _Scatter(float(known_squares[last]), float(known_dof[last]), least)


def _agreeing(change: FloatArray, column: FloatArray, before: _Scatter) -> BoolArray:
    """Return (m,) which sensors do alike: from the closest majority outward, while the next does what these do."""
    agree, middle = _closest_majority(change, column)
    # From the middle of the majority, so that sums of squares lose no digits to a change that is large beside scatter.
    change = change - column * middle
    known = np.arange(int(agree.sum()), change.size, dtype=np.float64)
    limits = t_quantile(1.0 - LEVEL / change.size, known + (before.dof - 1.0)) * np.sqrt(1.0 + 1.0 / known)
    weights, moments, powers = column * column, column * change, change * change
    weight, moment, power = (float(terms[agree].sum()) for terms in (weights, moments, powers))
    for count, limit in zip(known.tolist(), limits.tolist(), strict=True):
        size = moment / weight
        away = np.abs(change - column * size)
        away[agree] = np.inf
        nearest = int(away.argmin())
        if away[nearest] > limit * math.sqrt(_pooled_variance(max(power - moment * size, 0.0), count - 1.0, before)):
            break
        agree[nearest] = True
        weight, moment, power = weight + weights[nearest], moment + moments[nearest], power + powers[nearest]
    return agree


def _closest_majority(change: FloatArray, column: FloatArray) -> tuple[BoolArray, float]:
    """Return (m,) which more than half of the changes have the least squares about their common part, and about what.

    Source: least trimmed squares, P. J. Rousseeuw, J. Am. Stat. Assoc. 79 (1984) 871: along the order of one parameter
    they are neighbours, where all sensitivities are alike; where not, the closest neighbours are taken.
    """
    ratio = change / column
    order, count = np.argsort(ratio), change.size // 2 + 1
    middle = float(ratio[order[change.size // 2]])
    columns, changes = sliding_window_view(column[order], count), sliding_window_view(change[order], count)
    from_middle = changes - columns * middle
    weight, moment = (columns * columns).sum(axis=1), (columns * from_middle).sum(axis=1)
    first = int(((from_middle * from_middle).sum(axis=1) - moment * moment / weight).argmin())
    agree = np.zeros(change.size, dtype=bool)
    agree[order[first : first + count]] = True
    return agree, middle + float(moment[first] / weight[first])


def _pooled_variance(squares: float, dof: float, before: _Scatter) -> float:
    """Return the variance of one change from a run and from those before, never less than is stated of it."""
    return max((squares + before.squares) / (dof + before.dof), before.least, float(np.finfo(float).tiny))


class _Fit:
    """The common part of m changes, and the scatter of one."""

    def __init__(self, change: FloatArray, column: FloatArray, before: _Scatter) -> None:
        weight = float(column @ column)
        self.size = float(column @ change) / weight
        self.squares = float(((change - column * self.size) ** 2).sum())
        self.dof = float(change.size - 1)
        self.all_dof = self.dof + before.dof
        self.error = float(np.sqrt(_pooled_variance(self.squares, self.dof, before) / weight))

    def limit(self, level: float) -> float:
        """Return how large the common part of sensors that did not change is at most."""
        return float(t_quantile(1.0 - level, self.all_dof)) * self.error
