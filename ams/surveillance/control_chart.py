"""A sensor's history: control charts of what is its own, and an alarm where it is not what it was.

Every calibration is judged with what was known before it. As found, a characteristic must lie inside the prediction
interval of the calibrations before, where the last one lay, y ± t·√2·s, or further along their line, with s the scatter
between runs (:mod:`ams.surveillance.regime`); else the sensor has made a *step* (a drop, an overload, a repair), or it
is another sensor (a *mix-up*: its characteristics are those that another sensor of the archive had). Over the
calibrations since the last step a slope is tested, *drift*, and whether they lie on two levels rather than on a line: a
step further back, that was too small to be seen from one calibration or before the scatter was known.

Levels: at one calibration the chance of any false step alarm over all characteristics is 0.2 %, of any false drift
alarm 0.1 % (Bonferroni over the characteristics). A sound sensor calibrated twice a year for eight years then has less
than 5 % chance of any false alarm in all that time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.errors import ArchiveUnknown
from ams.parameter_words import words_of_characteristic
from ams.statistics.distributions import chi_square_tail
from ams.statistics.intervals import t_factor
from ams.surveillance.between_runs import pooled_scatter
from ams.surveillance.regime import DRIFT_LEVEL, LEAST_DOF, LEAST_POINTS_OF_DRIFT, Regime
from ams.surveillance.series import SECONDS_PER_YEAR, PointLabel, Population
from ams.surveillance.stated_changes import FEW_DOF

LEAST_CALIBRATIONS = 3 + int(LEAST_DOF)
"""Of a sensor alone, the first that is judged: a line takes two, and what is left about it is the scatter."""
_NEWEST_P, _OTHERS_P = 1e-6, 1e-4
_REMEMBERED = 3


@dataclass(frozen=True)
class Finding:
    """Something that happened to a sensor."""

    kind: Literal["step", "drift", "mix-up"]
    at: PointLabel
    """The calibration that is off, or from which on the level is another; of a drift that which told it."""
    seen: PointLabel
    """The newest calibration when it was told."""
    characteristics: tuple[str, ...]
    """Those that told it, the strongest first; of a mix-up all."""
    size_deg: float
    """Of the strongest, as an angle; of a drift, a year."""
    partner: str | None
    """Of a mix-up: whose characteristics these are."""
    sentence: str
    rig_cause: str | None = None
    """What the rig's check sensor says of the same run, where it says that the rig changed."""


@dataclass(frozen=True)
class Chart:
    """One characteristic over the years, in its own unit; n calibrations."""

    name: str
    value: FloatArray
    shared: FloatArray
    """What of the value all sensors of its runs changed alike: the meter's, and in no judgement of the sensor."""
    standard_uncertainty: FloatArray
    """Of the calibrations themselves."""
    prediction_low: FloatArray
    """The prediction interval of the calibrations before, at the level of the alarm; NaN where there is none."""
    prediction_high: FloatArray
    centre: FloatArray
    """Mean since the last step, of what was known before; NaN at the start."""
    scatter: float
    """Standard deviation between runs, as known at the end."""
    scatter_dof: float
    """Degrees of freedom that it is known by, and ``rate_standard_uncertainty``, which is made of it."""
    is_alarm: BoolArray
    rate_per_year: float | None
    """Since the last step; None with fewer than five calibrations."""
    rate_standard_uncertainty: float | None
    deg_per_unit: float
    """What a change of one unit is as an angle at full sensitivity."""


@dataclass(frozen=True)
class History:
    """One sensor over the years."""

    sensor: str
    labels: tuple[PointLabel, ...]
    charts: tuple[Chart, ...]
    rotation_deg: FloatArray
    """(n, 3) of the package on the table against its first calibration: mounting, not judged."""
    findings: tuple[Finding, ...]
    is_judged: bool
    """False while too little is known to judge anything."""
    unexplained: str = ""
    """What the newest calibration changed beyond what the calibrations themselves state, while too few tell how far
    the sensor scatters; empty for nothing."""
    explained_deg: float | None = None
    """The largest change, as an angle, that what they state explains; None where that was not asked."""

    @property
    def rests_on_few(self) -> bool:
        """Whether too few calibrations tell how far the sensor scatters, so that what they state must be asked."""
        return len(self.labels) > 1 and min(chart.scatter_dof for chart in self.charts) < FEW_DOF

    @property
    def unseen_deg(self) -> tuple[float, float] | None:
        """The step at the newest calibration, and the drift a year, that had to be exceeded to be seen; the largest."""
        known = [chart for chart in self.charts if chart.rate_standard_uncertainty is not None]
        if not known or len(known) < len(self.charts):
            return None
        level = 1.0 - DRIFT_LEVEL / len(known)
        steps = [0.5 * (chart.prediction_high[-1] - chart.prediction_low[-1]) * chart.deg_per_unit for chart in known]
        drifts = [
            t_factor(level, chart.scatter_dof) * (chart.rate_standard_uncertainty or 0.0) * chart.deg_per_unit
            for chart in known
        ]
        return float(max(steps)), float(max(drifts))

    @property
    def conclusion(self) -> str:
        """What can be said where nothing was found, and what cannot be judged yet; empty where something was."""
        if len(self.labels) == 1:
            return f"cannot judge yet (1 of {LEAST_CALIBRATIONS} calibrations): there is no other to compare it with"
        beside = f"; {self.unexplained}" if self.unexplained else ""
        if not beside and self.explained_deg is not None:
            beside = f"; what the calibrations state of themselves explains changes up to {self.explained_deg:.4f}°"
        if not self.is_judged:
            few = len(self.labels) < LEAST_CALIBRATIONS
            known = f" ({len(self.labels)} of {LEAST_CALIBRATIONS} calibrations)" if few else ""
            return f"cannot judge yet{known}: the scatter between runs is not known of this kind of sensor{beside}"
        if self.findings:
            return ""
        left = "no calibration left the prediction interval of those before"
        if len(self.labels) < LEAST_POINTS_OF_DRIFT:
            known = f"{len(self.labels)} of {LEAST_POINTS_OF_DRIFT} calibrations"
            return f"no step was found: {left}; of a drift it cannot judge yet ({known}){beside}"
        unseen = self.unseen_deg
        hidden = "" if unseen is None else f" (a step below {unseen[0]:.4f}° or a drift below {unseen[1]:.4f}° a year "
        hidden += "would not be seen)" if hidden else ""
        return f"nothing was found: {left}, and no drift shows{hidden}{beside}"


def history_of(population: Population, sensor: str) -> History:
    """Return the history of one sensor among all of its kind.

    Raises: ArchiveUnknown where it is not among them.
    """
    rows = population.rows_of(sensor)
    if rows.start == rows.stop:
        raise ArchiveUnknown(f"history: sensor {sensor!r}: has no calibration here that counts; name one that has")
    prior = pooled_scatter(population, leave_out=sensor)
    regime = Regime(population.coordinates[rows], population.scatter_rad[rows], population.years[rows], prior)
    watch = _Watch(population, rows, regime)
    for index in range(1, rows.stop - rows.start):
        watch.judge(index)
    return watch.history()


class _Watch:
    """One sensor as its calibrations come in."""

    def __init__(self, population: Population, rows: slice, regime: Regime) -> None:
        self.population, self.rows, self.regime = population, rows, regime
        self.labels = tuple(population.labels[rows])
        self.low, self.high, self.centre = (np.full(regime.coordinates.shape, np.nan) for _ in range(3))
        self.alarms = np.zeros(regime.coordinates.shape, dtype=bool)
        self.findings: list[Finding] = []
        self.has_drifted = False

    def judge(self, index: int) -> None:
        """Hold the next calibration against those before it."""
        regime, value = self.regime, self.regime.coordinates[index]
        self.low[index], self.high[index] = regime.prediction(index)
        self.centre[index] = regime.coordinates[regime.members].mean(axis=0)
        outside = (value < self.low[index]) | (value > self.high[index])
        if not outside.any():
            regime.members.append(index)
            outside = self._apart(index)
        self.alarms[index] = outside
        if not outside.any():
            return
        change = value - regime.newest
        other = _whose(self.population, self.rows, index, regime)
        if other is not None:
            self.findings.append(_mix_up(self.population, self.labels[index], change, other))
            return
        self.findings.append(_step(self.population, self.labels[index], self.labels[index], change, outside))
        regime.begin_anew([index])
        self.has_drifted = False

    def _apart(self, index: int) -> BoolArray:
        """Look at the regime with the newest in it: tell what it shows, and return (p,) where the newest alone is off.

        Then it is taken out again.
        """
        regime = self.regime
        nowhere = np.zeros(regime.newest.size, dtype=bool)
        inside = regime.step_inside()
        if inside is None:
            self._tell_drift(index)
            return nowhere
        begins, where = inside
        if begins == len(regime.members) - 1:
            regime.members.pop()
            return where
        at = regime.members[begins]
        if self.has_drifted:  # what looked like a drift is a step
            self.findings.remove([finding for finding in self.findings if finding.kind == "drift"][-1])
        change = regime.change_at(begins)
        self.alarms[at] |= where
        self.findings.append(_step(self.population, self.labels[at], self.labels[index], change, where))
        regime.begin_anew(regime.members[begins:])
        self.has_drifted = False
        return nowhere

    def _tell_drift(self, index: int) -> None:
        drifting = self.regime.drifting()
        if drifting.any() and not self.has_drifted:
            self.findings.append(_drift(self.population, self.regime, self.labels[index], drifting))
            self.has_drifted = True

    def history(self) -> History:
        """Return what came out, settled with the whole history at hand."""
        is_judged = bool(np.isfinite(self.low).any())
        self.findings, self.regime = _settled(self.population, self.findings, self.regime)
        return History(
            self.labels[0].sensor,
            self.labels,
            self._charts(),
            self.population.rotation_deg(self.rows),
            tuple(self.findings),
            is_judged,
        )

    def _charts(self) -> tuple[Chart, ...]:
        found, rows, regime = self.population.characteristics, self.rows, self.regime
        scatter, scale = regime.scatter, found.scale[rows.start : rows.start + 1]
        has_rate = len(regime.members) >= LEAST_POINTS_OF_DRIFT
        slope, spread = regime.slopes
        shared = np.zeros_like(self.low) if self.population.shared_rad is None else self.population.shared_rad[rows]
        low, high, centre = ((part + shared) * scale for part in (self.low, self.high, self.centre))
        return tuple(
            Chart(
                name,
                found.value[rows, index],
                shared[:, index] * scale[0, index],
                found.standard_uncertainty[rows, index],
                low[:, index],
                high[:, index],
                centre[:, index],
                float(np.sqrt(scatter.variance[index]) * scale[0, index]),
                float(scatter.dof[index]),
                self.alarms[:, index],
                float(slope[index] * scale[0, index]) if has_rate else None,
                float(spread[index] * scale[0, index]) if has_rate else None,
                float(np.degrees(1.0 / scale[0, index])),
            )
            for index, name in enumerate(found.names)
        )


def _whose(population: Population, rows: slice, index: int, regime: Regime) -> str | None:
    """Return the sensor whose characteristics these are; None where they are nobody's, or not so far from its own.

    Another sensor is what the median of its last three calibrations before this one says, so that its own mix-up at
    the same time does not hide it.
    """
    label, found = population.labels[rows.start + index], population.coordinates[rows.start + index]
    scale, first = population.characteristics.scale[rows.start + index], population.first_scale[rows.start + index]
    value = found * first
    width = found.size
    variance, newest = regime.difference_variance(index), regime.newest
    if chi_square_tail(float(((found - newest) ** 2 / variance).sum()), width) > _NEWEST_P:
        return None
    best, partner = _OTHERS_P, None
    for start, stop in _others(population, label):
        last = slice(max(start, stop - _REMEMBERED), stop)
        before = population.coordinates[last] * population.first_scale[last]
        distance = (np.median(before, axis=0) - value) / scale
        chance = float(chi_square_tail(float((distance**2 / variance).sum()), width))
        if chance > best:
            best, partner = chance, population.labels[start].sensor
    return partner


def _others(population: Population, label: PointLabel) -> list[tuple[int, int]]:
    """Return the first row and the row after the last of every other sensor's calibrations before this one."""
    ends = [*population.starts[1:].tolist(), len(population.labels)]
    now = label.created_utc.timestamp() / SECONDS_PER_YEAR
    found = []
    for start, end in zip(population.starts.tolist(), ends, strict=True):
        stop = start + int(np.searchsorted(population.years[start:end], now))
        if population.labels[start].sensor != label.sensor and stop > start:
            found.append((start, stop))
    return found


def _step(population: Population, at: PointLabel, seen: PointLabel, change: FloatArray, where: BoolArray) -> Finding:
    names = _strongest(population, np.where(where, np.abs(change), 0.0), int(where.sum()))
    size = float(np.degrees(np.abs(change[where]).max()))
    later = "" if seen == at else f" (seen at {seen.created_utc:%Y-%m-%d})"
    sentence = (
        f"{at.sensor}: at {at.created_utc:%Y-%m-%d} {_in_words(names)} left what the calibrations before foretell, "
        f"by {size:.4f}° as an angle{later}: the sensor made a step (drop, overload, repair?)"
    )
    return Finding("step", at, seen, names, size, None, sentence)


def _mix_up(population: Population, at: PointLabel, change: FloatArray, partner: str) -> Finding:
    names = _strongest(population, np.abs(change), change.size)
    sentence = (
        f"{at.sensor}: what was calibrated as it at {at.created_utc:%Y-%m-%d} has the characteristics of {partner}: "
        "the two were mixed up; look at the serial numbers and at the other's calibration"
    )
    return Finding("mix-up", at, at, names, float(np.degrees(np.abs(change).max())), partner, sentence)


def _drift(population: Population, regime: Regime, at: PointLabel, drifting: BoolArray) -> Finding:
    slope, _ = regime.slopes
    names = _strongest(population, np.where(drifting, np.abs(slope), 0.0), int(drifting.sum()))
    rate = float(np.degrees(np.abs(slope[drifting]).max()))
    sentence = (
        f"{at.sensor}: {_in_words(names)} drift, by {rate:.4f}° a year as an angle, since "
        f"{len(regime.members)} calibrations (seen at {at.created_utc:%Y-%m-%d})"
    )
    return Finding("drift", at, at, names, rate, None, sentence)


def _strongest(population: Population, strength: FloatArray, count: int) -> tuple[str, ...]:
    return tuple(population.characteristics.names[index] for index in np.argsort(-strength)[:count])


def _in_words(names: Sequence[str]) -> str:
    return ", ".join(map(words_of_characteristic, names))


def _settled(population: Population, findings: list[Finding], regime: Regime) -> tuple[list[Finding], Regime]:
    """Settle the findings with the whole history at hand, and return the calibrations since the last step.

    Steps of what goes up steadily are one drift, seen when it was first seen.
    """
    steps = [finding for finding in findings if finding.kind == "step"]
    if not steps:
        return findings, regime
    mixed = {finding.at.sha256 for finding in findings if finding.kind == "mix-up"}
    rows = population.rows_of(steps[0].at.sensor)
    kept = [index for index, label in enumerate(population.labels[rows]) if label.sha256 not in mixed]
    column = population.characteristics.names.index(steps[0].characteristics[0])
    if len(kept) < LEAST_POINTS_OF_DRIFT or not _is_steady(regime.years[kept], regime.coordinates[kept, column]):
        return findings, regime
    whole = replace(regime, members=kept, prior=regime.prior)
    telling = np.zeros(regime.newest.size, dtype=bool)
    telling[column] = True
    drift = _drift(population, whole, min(findings, key=lambda finding: finding.seen.created_utc).seen, telling)
    return [drift, *(finding for finding in findings if finding.kind == "mix-up")], whole


def _is_steady(years: FloatArray, values: FloatArray) -> bool:
    """Return whether a straight line leaves less than the best single step does."""
    line = np.polynomial.polynomial.polyfit(years - years.mean(), values, 1)
    of_line = float(((values - np.polynomial.polynomial.polyval(years - years.mean(), line)) ** 2).sum())
    halves = ((values[:cut], values[cut:]) for cut in range(1, values.size))
    of_step = min(float(((a - a.mean()) ** 2).sum() + ((b - b.mean()) ** 2).sum()) for a, b in halves)
    return of_line < of_step
