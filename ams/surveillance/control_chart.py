"""A sensor's history: control charts of what is its own, and an alarm where it is not what it was.

Every calibration is judged with what was known before it. As found, a characteristic must lie inside the prediction
interval of the last calibration, y ± t·√2·s, with s the scatter between runs (:mod:`ams.surveillance.between_runs`);
else the
sensor has made a *step* (a drop, an overload, a repair), or it is another sensor (a *mix-up*: its characteristics are
those that another sensor of the archive had). Over the calibrations since the last step a slope is tested: *drift*.

Levels: at one calibration the chance of any false step alarm over all characteristics is 0.2 %, of any false drift
alarm 0.1 % (Bonferroni over the characteristics). A sound sensor calibrated twice a year for eight years then has less
than 5 % chance of any false alarm in all that time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Literal

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.errors import ArchiveUnknown
from ams.parameter_words import words_of_characteristic
from ams.statistics.distributions import chi_square_tail
from ams.statistics.intervals import t_quantile
from ams.surveillance.between_runs import DIFFERENCE_EFFICIENCY, Scatter, pooled_scatter
from ams.surveillance.series import SECONDS_PER_YEAR, PointLabel, Population

STEP_LEVEL = 0.002
DRIFT_LEVEL = 0.001
LEAST_DOF = 2.0
"""Below this a scatter is not known well enough to judge by."""
LEAST_CALIBRATIONS = 1 + ceil(LEAST_DOF / DIFFERENCE_EFFICIENCY)
"""Of a sensor alone, before its own scatter is known so well."""
LEAST_POINTS_OF_DRIFT = 5
_NEWEST_P, _OTHERS_P = 1e-6, 1e-4
_REMEMBERED = 3


@dataclass(frozen=True)
class Finding:
    """Something that happened to a sensor."""

    kind: Literal["step", "drift", "mix-up"]
    at: PointLabel
    """The calibration that told it."""
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
    standard_uncertainty: FloatArray
    """Of the calibrations themselves."""
    prediction_low: FloatArray
    """The prediction interval of the calibration before, at the level of the alarm; NaN where there is none."""
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

    @property
    def conclusion(self) -> str:
        """What can be said where nothing was found, and what cannot be judged yet; empty where something was."""
        if len(self.labels) == 1:
            return f"cannot judge yet (1 of {LEAST_CALIBRATIONS} calibrations): there is no other to compare it with"
        if not self.is_judged:
            few = len(self.labels) < LEAST_CALIBRATIONS
            known = f" ({len(self.labels)} of {LEAST_CALIBRATIONS} calibrations)" if few else ""
            return f"cannot judge yet{known}: the scatter between runs is not known of this kind of sensor"
        if self.findings:
            return ""
        left = "no calibration left the prediction interval of the one before"
        if len(self.labels) < LEAST_POINTS_OF_DRIFT:
            known = f"{len(self.labels)} of {LEAST_POINTS_OF_DRIFT} calibrations"
            return f"no step was found: {left}; of a drift it cannot judge yet ({known})"
        return f"nothing was found: {left}, and nothing drifts"


@dataclass
class _Watch:
    """One sensor as its calibrations come in."""

    coordinates: FloatArray
    drawn_rad: FloatArray
    """(n, p) what each calibration's own uncertainty lets it scatter."""
    years: FloatArray
    prior: Scatter
    regime: list[int] = field(default_factory=lambda: [0])
    """Calibrations since the last step, mix-ups left out."""
    squares: FloatArray = field(init=False)
    differences: int = 0

    def __post_init__(self) -> None:
        self.squares = np.zeros(self.coordinates.shape[1])

    @property
    def scatter(self) -> Scatter:
        return self.prior.with_sensor(self.squares, self.differences)

    def difference_variance(self, index: int) -> FloatArray:
        """Return the (p,) variance of a calibration less the last one.

        It is the scatter between runs, or what the two calibrations themselves cannot tell where that is more.
        """
        stated = self.drawn_rad[index] ** 2 + self.drawn_rad[self.regime[-1]] ** 2
        return np.asarray(np.maximum(2.0 * self.scatter.variance, stated))

    def accept(self, index: int) -> None:
        """Add the next calibration of an unchanged sensor."""
        self.squares = self.squares + 0.5 * (self.coordinates[index] - self.coordinates[self.regime[-1]]) ** 2
        self.differences += 1
        self.regime.append(index)

    def begin_anew(self, index: int) -> None:
        """Start a new regime with the first calibration after a step."""
        self.regime = [index]


def history_of(population: Population, sensor: str) -> History:
    """Return the history of one sensor among all of its kind.

    Raises: ArchiveUnknown where it is not among them.
    """
    rows = population.rows_of(sensor)
    if rows.start == rows.stop:
        raise ArchiveUnknown(f"history: sensor {sensor!r}: has no calibration here that counts; name one that has")
    labels = tuple(population.labels[rows])
    coordinates, years = population.coordinates[rows], population.years[rows]
    watch = _Watch(coordinates, population.scatter_rad[rows], years, pooled_scatter(population, leave_out=sensor))
    width = coordinates.shape[1]
    low, high, centre = (np.full(coordinates.shape, np.nan) for _ in range(3))
    alarms = np.zeros(coordinates.shape, dtype=bool)
    findings: list[Finding] = []
    has_drifted, is_judged = False, False
    for index in range(1, len(labels)):
        scatter, last = watch.scatter, coordinates[watch.regime[-1]]
        known = scatter.dof >= LEAST_DOF
        half = t_quantile(1.0 - STEP_LEVEL / width, scatter.dof) * np.sqrt(watch.difference_variance(index))
        half = np.where(known, half, np.nan)
        low[index], high[index] = last - half, last + half
        centre[index] = coordinates[watch.regime].mean(axis=0)
        is_judged |= bool(known.any())
        alarms[index] = np.abs(coordinates[index] - last) > half
        if not alarms[index].any():
            watch.accept(index)
            drifting = _drifting(watch)
            if drifting.any() and not has_drifted:
                findings.append(_drift(population, watch, labels[index], drifting))
                has_drifted = True
            continue
        other = _whose(population, rows, index, watch)
        if other is not None:
            findings.append(_mix_up(population, labels[index], coordinates[index] - last, other))
            continue
        findings.append(_step(population, labels[index], coordinates[index] - last, alarms[index]))
        watch.begin_anew(index)
        has_drifted = False
    charts = _charts(population, rows, (low, high, centre), alarms, watch)
    return History(
        sensor, labels, charts, population.rotation_deg(rows), _settled(population, findings, watch), is_judged
    )


def rates(years: FloatArray, coordinates: FloatArray, scatter: Scatter) -> tuple[FloatArray, FloatArray]:
    """Return the (p,) slopes per year and their standard uncertainties, by least squares under a known scatter."""
    centred = years - years.mean()
    spread = float(centred @ centred)
    return centred @ coordinates / spread, np.sqrt(scatter.variance / spread)


def _drifting(watch: _Watch) -> BoolArray:
    """Return (p,) which slopes since the last step are real."""
    width = watch.coordinates.shape[1]
    scatter = watch.scatter
    if len(watch.regime) < LEAST_POINTS_OF_DRIFT:
        return np.zeros(width, dtype=bool)
    slope, spread = rates(watch.years[watch.regime], watch.coordinates[watch.regime], scatter)
    limit = t_quantile(1.0 - DRIFT_LEVEL / width, scatter.dof)
    return np.asarray((scatter.dof >= LEAST_DOF) & (np.abs(slope) > limit * spread))


def _whose(population: Population, rows: slice, index: int, watch: _Watch) -> str | None:
    """Return the sensor whose characteristics these are; None where they are nobody's, or not so far from its own.

    Another sensor is what the median of its last three calibrations before this one says, so that its own mix-up at
    the same time does not hide it.
    """
    label, found = population.labels[rows.start + index], population.coordinates[rows.start + index]
    value, scale = (getattr(population.characteristics, name)[rows.start + index] for name in ("value", "scale"))
    width = found.size
    variance, newest = watch.difference_variance(index), watch.coordinates[watch.regime[-1]]
    if chi_square_tail(float(((found - newest) ** 2 / variance).sum()), width) > _NEWEST_P:
        return None
    best, partner = _OTHERS_P, None
    for start, stop in _others(population, label):
        before = population.characteristics.value[max(start, stop - _REMEMBERED) : stop]
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


def _step(population: Population, at: PointLabel, change: FloatArray, alarms: BoolArray) -> Finding:
    names = _strongest(population, np.where(alarms, np.abs(change), 0.0), int(alarms.sum()))
    size = float(np.degrees(np.abs(change[alarms]).max()))
    sentence = (
        f"{at.sensor}: at {at.created_utc:%Y-%m-%d} {_in_words(names)} left the prediction interval of the last "
        f"calibration, by {size:.4f}° as an angle: the sensor made a step (drop, overload, repair?)"
    )
    return Finding("step", at, names, size, None, sentence)


def _mix_up(population: Population, at: PointLabel, change: FloatArray, partner: str) -> Finding:
    names = _strongest(population, np.abs(change), change.size)
    sentence = (
        f"{at.sensor}: what was calibrated as it at {at.created_utc:%Y-%m-%d} has the characteristics of {partner}: "
        "the two were mixed up; look at the serial numbers and at the other's calibration"
    )
    return Finding("mix-up", at, names, float(np.degrees(np.abs(change).max())), partner, sentence)


def _drift(population: Population, watch: _Watch, at: PointLabel, drifting: BoolArray) -> Finding:
    slope, _ = rates(watch.years[watch.regime], watch.coordinates[watch.regime], watch.scatter)
    names = _strongest(population, np.where(drifting, np.abs(slope), 0.0), int(drifting.sum()))
    rate = float(np.degrees(np.abs(slope[drifting]).max()))
    sentence = (
        f"{at.sensor}: {_in_words(names)} drift, by {rate:.4f}° a year as an angle, since "
        f"{len(watch.regime)} calibrations (seen at {at.created_utc:%Y-%m-%d})"
    )
    return Finding("drift", at, names, rate, None, sentence)


def _strongest(population: Population, strength: FloatArray, count: int) -> tuple[str, ...]:
    return tuple(population.characteristics.names[index] for index in np.argsort(-strength)[:count])


def _in_words(names: Sequence[str]) -> str:
    return ", ".join(map(words_of_characteristic, names))


def _settled(population: Population, findings: Sequence[Finding], watch: _Watch) -> tuple[Finding, ...]:
    """Settle the findings with the whole history at hand.

    Steps of what goes up steadily are one drift, seen when it was first seen.
    """
    steps = [finding for finding in findings if finding.kind == "step"]
    if not steps:
        return tuple(findings)
    mixed = {finding.at.sha256 for finding in findings if finding.kind == "mix-up"}
    rows = population.rows_of(steps[0].at.sensor)
    kept = [index for index, label in enumerate(population.labels[rows]) if label.sha256 not in mixed]
    years, coordinates = watch.years[kept], watch.coordinates[kept]
    column = population.characteristics.names.index(steps[0].characteristics[0])
    if len(kept) < LEAST_POINTS_OF_DRIFT or not _is_steady(years, coordinates[:, column]):
        return tuple(findings)
    whole = _Watch(watch.coordinates, watch.drawn_rad, watch.years, watch.prior, kept, watch.differences)
    whole.squares = watch.squares
    telling = np.zeros(coordinates.shape[1], dtype=bool)
    telling[column] = True
    drift = _drift(population, whole, min(findings, key=lambda finding: finding.at.created_utc).at, telling)
    return (drift, *(finding for finding in findings if finding.kind == "mix-up"))


def _is_steady(years: FloatArray, values: FloatArray) -> bool:
    """Return whether a straight line leaves less than the best single step does."""
    line = np.polynomial.polynomial.polyfit(years - years.mean(), values, 1)
    of_line = float(((values - np.polynomial.polynomial.polyval(years - years.mean(), line)) ** 2).sum())
    halves = ((values[:cut], values[cut:]) for cut in range(1, values.size))
    of_step = min(float(((a - a.mean()) ** 2).sum() + ((b - b.mean()) ** 2).sum()) for a, b in halves)
    return of_line < of_step


def _charts(
    population: Population,
    rows: slice,
    limits: tuple[FloatArray, FloatArray, FloatArray],
    alarms: BoolArray,
    watch: _Watch,
) -> tuple[Chart, ...]:
    found, scatter = population.characteristics, watch.scatter
    scale = found.scale[rows.start : rows.start + 1]
    has_rate = len(watch.regime) >= LEAST_POINTS_OF_DRIFT
    slope, spread = (
        rates(watch.years[watch.regime], watch.coordinates[watch.regime], scatter) if has_rate else (None, None)
    )
    low, high, centre = (part * scale for part in limits)
    return tuple(
        Chart(
            name,
            found.value[rows, index],
            found.standard_uncertainty[rows, index],
            low[:, index],
            high[:, index],
            centre[:, index],
            float(np.sqrt(scatter.variance[index]) * scale[0, index]),
            float(scatter.dof[index]),
            alarms[:, index],
            None if slope is None else float(slope[index] * scale[0, index]),
            None if spread is None else float(spread[index] * scale[0, index]),
            float(np.degrees(1.0 / scale[0, index])),
        )
        for index, name in enumerate(found.names)
    )
