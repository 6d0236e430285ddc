"""The check sensor's chart: it tells whether a change was the sensor's, the table's or the meter's.

A permanent check sensor is never taken off its mount and is calibrated in every run. Its characteristics are read as

- *meter gain*: what all its sensitivities changed alike; *meter offset*: what all its offsets changed alike;
- *table tilt*: the rotation of the whole package, which nobody remounted (a mount that moved looks the same);
- *sensor*: what is left, in which its axes differ from one another (offsets, sensitivities, angles between axes).

Every component is charted three ways. A Shewhart chart compares a run with the mean of those before it,
± t·s·√(1 + 1/m). An exponentially weighted mean (λ = 0.2) of these deviations finds what creeps and steps that are
small, and the calibrations are looked at for two levels: a step further back, before limits existed. A run that is not
what it was begins anew.

s is the scatter between runs: what the component's own runs leave about a straight line, so that no drift is in it
(:mod:`ams.surveillance.regime`), weighed with that of its like, the other axes' parts and the other sensors' runs
(:mod:`ams.surveillance.between_runs`), unless an F-test says that it does not scatter as they do: a meter that changes
from day to day does so to all axes alike, and a base may lean to one side more than to the other. It is never less than
the certificates' uncertainties.

Before there are four differences no limit exists, and nothing is said to have stayed as it was: what the certificates'
uncertainties alone do not explain is told (:func:`unexplained_changes`), and that it cannot be judged yet. It is told
on until six degrees of freedom are behind the limits, and how wide these are always.

What all its axes do alike may still be its own (its supply, its temperature). The other sensors of the same run are the
witnesses: what they changed alike since their own last calibration is the meter's, if it is what the check sensor says.
Where all sensors of a run together tell what they changed alike (:mod:`ams.surveillance.shared_changes`), that is told,
and no alarm of the check sensor by itself beside it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.errors import ArchiveUnknown
from ams.statistics.distributions import f_tail
from ams.statistics.intervals import t_quantile
from ams.surveillance.between_runs import Scatter
from ams.surveillance.check_components import METER_GAIN, Component, components_of, is_gain, is_offset
from ams.surveillance.regime import LEAST_DOF, Regime
from ams.surveillance.series import PointLabel, Population
from ams.surveillance.shared_changes import SharedChange
from ams.surveillance.stated_changes import FEW_DOF, StatedScatter, explained_rad

Cause = Literal["sensor", "table", "meter", "open"]

LEVEL = 0.002
"""Chance of any false alarm in one run."""
WITNESS_FACTOR = 3.0
LEAST_DIFFERENCES = 4
EWMA_WEIGHT = 0.2
CHARTS = 3
"""Tests of one component in one run: of the run alone, of the weighted mean, of a step further back."""
UNLIKE_LEVEL = 0.05
"""Chance that a component which scatters as its like is taken for one that does not."""


@dataclass(frozen=True)
class ComponentChart:
    """One component over n runs, degrees (as an angle at full sensitivity), against the first run."""

    name: str
    value_deg: FloatArray
    centre_deg: FloatArray
    """Mean of the runs before, since the last change; NaN for the first."""
    low_deg: FloatArray
    """Where the run was to lie; NaN while too little is known."""
    high_deg: FloatArray
    ewma_deg: FloatArray
    """The weighted mean of the deviations, added to the centre; NaN while too little is known."""
    is_alarm: BoolArray
    family: str
    """Components that the certificates' uncertainties are the same for."""
    before: tuple[int, ...]
    """The runs behind the latest centre."""
    scatter_dof: float
    """Degrees of freedom of the scatter behind the latest limits."""


@dataclass(frozen=True)
class CheckFinding:
    """A run in which the check sensor was not what it was, and what is behind it."""

    at: PointLabel
    cause: Cause
    component: str
    size_deg: float
    sentence: str


@dataclass(frozen=True)
class CheckHistory:
    """A check sensor over its runs."""

    sensor: str
    labels: tuple[PointLabel, ...]
    charts: tuple[ComponentChart, ...]
    findings: tuple[CheckFinding, ...]
    differences: int
    """Between runs that belong together: what the scatter is known from."""
    unexplained: tuple[str, ...] = ()
    """What of the latest run the certificates' uncertainties alone do not explain, while few runs tell limits."""

    @property
    def is_judged(self) -> bool:
        """Whether limits exist for the latest run."""
        return bool(self.charts) and all(bool(np.isfinite(chart.low_deg[-1])) for chart in self.charts)

    @property
    def rests_on_few(self) -> bool:
        """Whether too few runs tell limits, so that what the certificates state must be asked."""
        return len(self.labels) > 1 and not (
            self.is_judged and min(chart.scatter_dof for chart in self.charts) >= FEW_DOF
        )

    @property
    def unseen_deg(self) -> Mapping[str, float]:
        """How far the latest run might have been off unseen: the widest limit of table, meter and sensor."""
        found: dict[str, float] = {}
        for chart in self.charts:
            whose, _, _ = chart.name.partition(" ")
            half = 0.5 * float(chart.high_deg[-1] - chart.low_deg[-1])
            found[whose] = max(half, found.get(whose, 0.0))
        return found


def check_history(population: Population, sensor: str, shared: Sequence[SharedChange] = ()) -> CheckHistory:
    """Return the chart of a check sensor; ``shared``: what all sensors of a run changed alike.

    Raises: ArchiveUnknown where it is not among the population.
    """
    rows = population.rows_of(sensor)
    if rows.start == rows.stop:
        raise ArchiveUnknown(
            f"history: check sensor {sensor!r}: has no calibration here that counts; name one that has"
        )
    labels = tuple(population.labels[rows])
    components = components_of(population, sensor, rows)
    watched = _watched(components, population.years[rows], LEVEL / (CHARTS * len(components)))
    findings = tuple(_findings(population, labels, watched, shared))
    charts = tuple(component.chart() for component in watched)
    return CheckHistory(sensor, labels, charts, findings, min(component.differences for component in watched))


def unexplained_changes(check: CheckHistory, stated: Sequence[tuple[Sequence[str], StatedScatter]]) -> tuple[str, ...]:
    """Return what of the latest run the certificates do not explain, Student's t over all components together.

    ``stated``: of every run what its set states (:func:`ams.surveillance.stated_changes.stated_families`).
    """
    families = list(stated[-1][0])
    unexplained = []
    for chart in check.charts:
        before = [stated[run][1] for run in chart.before]
        limits_rad = explained_rad(before, stated[-1][1], len(check.charts))
        explained = float(np.degrees(limits_rad[families.index(chart.family)]))
        change = float(chart.value_deg[-1] - chart.centre_deg[-1])
        if abs(change) > explained:
            unexplained.append(f"{chart.name} {change:+.4f}°, where the certificates explain {explained:.4f}°")
    return tuple(unexplained)


def check_sensors(population: Population, rig: str) -> tuple[str, ...]:
    """Return the check sensors of a rig."""
    return tuple(dict.fromkeys(label.sensor for label in population.labels if label.is_check and label.rig == rig))


class _Watched:
    """One component as its runs come in."""

    def __init__(self, component: Component, years: FloatArray, level: float) -> None:
        self.component, self.level = component, level
        values, stated = component.values[:, None], np.sqrt(component.stated)[:, None]
        self.regime = Regime(values, stated, years, component.prior, step_level=level)
        self.columns = np.full((4, values.size), np.nan)
        self.before: tuple[int, ...] = ()
        self.changes: list[_Change] = []
        self.differences = 0
        self.ewma, self.weighted = 0.0, 0
        self.left = self.regime.left

    def prior(self, relatives: "Sequence[_Watched]") -> Scatter:
        """Return the scatter by other sensors and by the relatives; nothing where its own differs from it."""
        known, rank = self.component.prior, self.component.family_rank
        squares, dof = known.prior_dof[0] * known.variance[0], float(known.prior_dof[0])
        left = [relative.left for relative in relatives]
        of_relatives = sum(count for _, count in left)
        if rank > 1 and of_relatives > 0:
            worth = (rank - 1) * of_relatives / len(left)
            squares += worth * sum(float(part[0]) for part, _ in left) / of_relatives
            dof += worth
        squares_left, left_dof = self.left
        if dof > 0.0 and left_dof > 0 and squares > 0.0:
            tail = float(f_tail(squares_left[0] / left_dof / (squares / dof), left_dof, dof))
            if min(tail, 1.0 - tail) < 0.5 * UNLIKE_LEVEL:
                squares = dof = 0.0
        return Scatter(np.array([squares / dof if dof > 0.0 else 0.0]), np.array([dof]), np.array([dof]))

    def judge(self, index: int, prior: Scatter) -> None:
        """Hold the next run against those before it, then look whether a step further back shows."""
        self._hold(index, prior)
        self.left = self.regime.left

    def _hold(self, index: int, prior: Scatter) -> None:
        squares_left, left_dof = self.left
        most = np.fmax(prior.variance, squares_left / max(left_dof, 1)) if left_dof > 0 else prior.variance
        self.regime.prior = replace(prior, variance=most)
        change = self._outside(index)
        if change is not None:
            self._begin_anew([index], change)
            return
        self.regime.members.append(index)
        self.differences += 1
        self.regime.prior = prior
        inside = self.regime.step_inside() if self.differences >= LEAST_DIFFERENCES else None
        if inside is not None:
            since = self.regime.members[inside[0] :]
            self._begin_anew(
                since, _Change(since[0], index, float(self.regime.change_at(inside[0])[0]), self._half(index))
            )

    def _begin_anew(self, members: list[int], change: "_Change") -> None:
        self.changes.append(change)
        self.regime.begin_anew(members)
        self.ewma, self.weighted = 0.0, 0

    def _half(self, index: int) -> float:
        return float(self.columns[2, index] - self.columns[1, index]) / 2.0

    def _outside(self, index: int) -> "_Change | None":
        """Chart a run: centre, low, high and weighted mean."""
        members, stated_rad2 = self.regime.members, self.component.stated
        value, count = float(self.component.values[index]), len(members)
        centre = float(self.component.values[members].mean())
        stated = float(stated_rad2[index] + stated_rad2[members].mean() / count)
        self.columns[0, index], self.before = centre, tuple(members)
        scatter = self.regime.scatter
        dof = float(scatter.dof[0])
        if self.differences + 1 < LEAST_DIFFERENCES or dof < LEAST_DOF:
            return None
        spread = 1.0 + 1.0 / count
        sigma = float(np.sqrt(max(float(scatter.variance[0]), stated / spread, np.finfo(float).tiny)))
        factor = float(t_quantile(1.0 - self.level, dof))
        half = factor * sigma * float(np.sqrt(spread))
        self.ewma = EWMA_WEIGHT * (value - centre) / float(np.sqrt(spread)) + (1.0 - EWMA_WEIGHT) * self.ewma
        self.weighted += 1
        of_mean = EWMA_WEIGHT / (2.0 - EWMA_WEIGHT) * (1.0 - (1.0 - EWMA_WEIGHT) ** (2 * self.weighted))
        has_crept = abs(self.ewma) > factor * sigma * float(np.sqrt(of_mean))
        self.columns[1:4, index] = centre - half, centre + half, centre + self.ewma
        return _Change(index, index, value - centre, half) if abs(value - centre) > half or has_crept else None

    def chart(self) -> ComponentChart:
        """Return what was charted, degrees."""
        centre, low, high, ewma = np.degrees(self.columns)
        alarms = np.zeros(self.component.values.size, dtype=bool)
        alarms[[change.at for change in self.changes]] = True
        values = np.degrees(self.component.values)
        dof = float(self.regime.scatter.dof[0])
        name, family = self.component.name, self.component.family
        return ComponentChart(name, values, centre, low, high, ewma, alarms, family, self.before, dof)


@dataclass(frozen=True)
class _Change:
    """A component that was not what it was."""

    at: int
    """The run from which on it is another."""
    seen: int
    """The run that told it."""
    size_rad: float
    half_rad: float
    """What a single run may be off by."""


def _watched(components: Sequence[Component], years: FloatArray, level: float) -> list[_Watched]:
    """Watch every component, run by run."""
    watched = [_Watched(component, years, level) for component in components]
    relatives = [
        [other for other in watched if other is not sensor and other.component.family == sensor.component.family]
        for sensor in watched
    ]
    for index in range(1, years.size):
        priors = [sensor.prior(others) for sensor, others in zip(watched, relatives, strict=True)]
        for sensor, prior in zip(watched, priors, strict=True):
            sensor.judge(index, prior)
    return watched


def _findings(
    population: Population, labels: Sequence[PointLabel], watched: Sequence[_Watched], shared: Sequence[SharedChange]
) -> Iterator[CheckFinding]:
    """Yield what all sensors of a run of the check sensor changed alike, then what it did beside that."""
    known: set[tuple[PointLabel, str]] = set()
    by_run = {label.run_id: label for label in labels[1:]}
    for common in shared:
        at = by_run.get(common.run_id)
        if at is not None and at.sensor in common.sensors:
            known.add((at, common.component))
            cause: Cause = "meter" if common.component.startswith("meter") else "table"
            yield CheckFinding(at, cause, common.component, float(np.degrees(abs(common.size_rad))), common.sentence)
    changes = [(change, component.component.name) for component in watched for change in component.changes]
    for change, name in sorted(changes, key=lambda pair: pair[0].seen):
        if (labels[change.at], name) not in known:
            yield _explained(population, labels, name, change)


def _explained(population: Population, labels: Sequence[PointLabel], component: str, changed: _Change) -> CheckFinding:
    at, seen = labels[changed.at], labels[changed.seen]
    change, spread = float(np.degrees(changed.size_rad)), float(np.degrees(changed.half_rad))
    later = "" if seen == at else f" (seen at {seen.created_utc:%Y-%m-%d})"
    when = f"{at.sensor} at {at.created_utc:%Y-%m-%d}: {component} {change:+.4f}°{later}"
    if component.startswith("table"):
        blamed = "table", f"{when}: the table or its base turned, or the check sensor moved on its mount"
    elif component.startswith("sensor"):
        blamed = "sensor", f"{when}: its axes differ from one another: the check sensor itself changed"
    else:
        blamed = _by_other_sensors(population, at, component, change, spread, when)
    return CheckFinding(at, blamed[0], component, abs(change), blamed[1])  # type: ignore[arg-type]


def _by_other_sensors(
    population: Population, at: PointLabel, component: str, change: float, spread: float, when: str
) -> tuple[Cause, str]:
    """Ask the other sensors of the same run: return the cause and a sentence for it."""
    seen = _witnesses_deg(population, at, component)
    if seen.size == 0:
        return "open", f"{when}: the meter or the check sensor: no other sensor of that run was calibrated before"
    middle = float(np.median(seen))
    error = float(np.std(seen, ddof=1)) / np.sqrt(seen.size) if seen.size > 1 else spread
    allowed = float(np.hypot(spread, WITNESS_FACTOR * error))
    if abs(middle - change) <= allowed < abs(middle) + allowed and abs(middle) > WITNESS_FACTOR * error:
        return "meter", f"{when}: {seen.size} other sensors of that run changed alike ({middle:+.4f}°): the meter"
    if abs(middle) <= WITNESS_FACTOR * error:
        return "sensor", f"{when}: {seen.size} other sensors of that run did not change: the check sensor itself"
    return "open", f"{when}: {seen.size} other sensors of that run changed otherwise ({middle:+.4f}°): look at both"


def _witnesses_deg(population: Population, at: PointLabel, component: str) -> FloatArray:
    """Return (m,) what every other sensor of the run changed alike in its axes, degrees.

    It is the change since the sensor's own last calibration.
    """
    columns = is_gain(population) if component == METER_GAIN else is_offset(population)
    rows = [
        index
        for index, label in enumerate(population.labels)
        if label.run_id is not None and label.run_id == at.run_id and label.sensor != at.sensor
        and index > 0 and population.labels[index - 1].sensor == label.sensor
    ]  # fmt: skip
    changes = population.coordinates[rows] - population.coordinates[[row - 1 for row in rows]]
    return np.degrees(changes[:, columns].mean(axis=1)) if rows else np.zeros(0)
