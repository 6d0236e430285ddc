"""The check sensor's chart: it tells whether a change was the sensor's, the table's or the meter's.

A permanent check sensor is never taken off its mount and is calibrated in every run. Its characteristics are read as

- *meter gain*: what all its sensitivities changed alike; *meter offset*: what all its offsets changed alike;
- *table tilt*: the rotation of the whole package, which nobody remounted (a mount that moved looks the same);
- *sensor*: what is left, in which its axes differ from one another (offsets, sensitivities, angles between axes).

Every component is charted twice. A Shewhart chart compares a run with the mean of those before it, ± t·s·√(1 + 1/m),
s being the scatter between runs: of the other sensors' runs and its own together for what is the sensor's and the
meter's (:mod:`ams.surveillance.between_runs`), its own about all three axes for the tilt, and never less than the
certificates' own uncertainties. An exponentially weighted mean (λ = 0.2) of the same deviations, each turned into a
normal one (Quesenberry 1991), finds what creeps and steps that are small. A run that is not what it was begins anew.

Before there are four differences no limit exists, and nothing is said to have stayed as it was: what the certificates'
uncertainties alone do not explain is told, and that it cannot be judged yet.

What all its axes do alike may still be its own (its supply, its temperature). The other sensors of the same run are the
witnesses: what they changed alike since their own last calibration is the meter's, if it is what the check sensor says.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ams.arrays import BoolArray, FloatArray
from ams.errors import ArchiveUnknown
from ams.statistics.distributions import f_tail, normal_quantile
from ams.statistics.intervals import t_quantile
from ams.surveillance.between_runs import pooled_scatter
from ams.surveillance.series import PointLabel, Population

Cause = Literal["sensor", "table", "meter", "open"]

LEVEL = 0.002
"""Chance of any false alarm in one run."""
WITNESS_FACTOR = 3.0
LEAST_DIFFERENCES = 4
EWMA_WEIGHT = 0.2
DIFFERENCE_EFFICIENCY = 2.0 / 3.0
"""Successive differences share calibrations: degrees of freedom of each (von Neumann)."""
STATED_LEVEL = 0.95
METER_GAIN, METER_OFFSET = "meter gain", "meter offset"


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
    stated_deg: FloatArray
    """Expanded uncertainty of the difference from the centre by the certificates alone (95 %)."""


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

    @property
    def is_judged(self) -> bool:
        """Whether limits exist for the latest run."""
        return bool(self.charts) and bool(np.isfinite(self.charts[0].low_deg[-1]))

    @property
    def unexplained(self) -> tuple[str, ...]:
        """What of the latest run the certificates' uncertainties alone do not explain, while no limit exists."""
        if self.is_judged or len(self.labels) < 2:
            return ()
        changes = ((chart, float(chart.value_deg[-1] - chart.centre_deg[-1])) for chart in self.charts)
        return tuple(
            f"{chart.name} {change:+.4f}°, where the certificates explain {chart.stated_deg[-1]:.4f}°"
            for chart, change in changes
            if abs(change) > chart.stated_deg[-1]
        )


def check_history(population: Population, sensor: str) -> CheckHistory:
    """Return the chart of a check sensor. Raises: ArchiveUnknown where it is not among the population."""
    rows = population.rows_of(sensor)
    if rows.start == rows.stop:
        raise ArchiveUnknown(
            f"history: check sensor {sensor!r}: has no calibration here that counts; name one that has"
        )
    labels = tuple(population.labels[rows])
    components = _components(population, rows)
    known = _known_scatter(population, sensor, rows, components)
    level = LEVEL / (2 * len(components))
    charts = _charts(components, known, level)
    findings = tuple(_findings(population, labels, charts))
    return CheckHistory(sensor, labels, charts, findings, _differences(charts))


def check_sensors(population: Population, rig: str) -> tuple[str, ...]:
    """Return the check sensors of a rig."""
    return tuple(dict.fromkeys(label.sensor for label in population.labels if label.is_check and label.rig == rig))


def _components(population: Population, rows: slice) -> dict[str, FloatArray]:
    """Return (n,) radians by name, or (n, m) of what is judged together."""
    change = population.coordinates[rows] - population.coordinates[rows][0]
    kinds = np.array(population.kinds)
    gains, offsets = change[:, _is_gain(kinds)], change[:, kinds == "offset_v"]
    centred = [part - part.mean(axis=1, keepdims=True) for part in (offsets, gains)]
    tilt = np.radians(population.rotation_deg(rows))
    return {
        METER_GAIN: gains.mean(axis=1),
        METER_OFFSET: offsets.mean(axis=1),
        **{f"table tilt {axis}": tilt[:, index] for index, axis in enumerate("xyz")},
        **{
            f"sensor {name}": np.concatenate([*centred, change[:, kinds == "angle_deg"]], axis=1)[:, index]
            for index, name in enumerate(_sensors_in_order(population))
        },
    }


def _sensors_in_order(population: Population) -> list[str]:
    names = population.characteristics.names
    kinds = np.array(population.kinds)
    order = [
        *np.flatnonzero(kinds == "offset_v"),
        *np.flatnonzero(_is_gain(kinds)),
        *np.flatnonzero(kinds == "angle_deg"),
    ]
    return [names[int(index)] for index in order]


def _is_gain(kinds: NDArray[np.str_]) -> BoolArray:
    return np.asarray(np.char.startswith(kinds, "sensitivity"))


@dataclass(frozen=True)
class _Component:
    """What is known of one component's scatter beside its own runs."""

    family: str
    """Components of one family have one scatter, each its share of it."""
    share: float
    prior_variance: float
    prior_dof: float
    stated: FloatArray
    """(n,) variance by the certificates."""


def _known_scatter(
    population: Population, sensor: str, rows: slice, components: Mapping[str, FloatArray]
) -> dict[str, _Component]:
    kinds = np.array(population.kinds)
    pooled = pooled_scatter(population, leave_out=sensor)
    stated = population.scatter_rad[rows] ** 2
    groups = {"gain": _is_gain(kinds), "offset": kinds == "offset_v", "angle": kinds == "angle_deg"}
    across = _across_variance(population, rows)
    found = {}
    for name in components:
        if name.startswith("table"):
            found[name] = _Component("tilt", 1.0, 0.0, 0.0, across)
            continue
        group = "gain" if "gain" in name or "sensitivity" in name else "offset" if "offset" in name else "angle"
        columns = groups[group]
        count = int(columns.sum())
        share = {"angle": 1.0}.get(group, 1.0 / count if name.startswith("meter") else 1.0 - 1.0 / count)
        prior = (float(pooled.variance[columns][0]), float(pooled.prior_dof[columns][0])) if count else (0.0, 0.0)
        mean_stated = stated[:, columns].mean(axis=1) if count else np.zeros(len(stated))
        found[name] = _Component(group, max(share, 1e-9), *prior, mean_stated * share)
    return found


def _across_variance(population: Population, rows: slice) -> FloatArray:
    """Return the (n,) variance of a rotation by the certificates: that of directions, over the axes that tell it."""
    numbers = population.numbers
    k, covariance = numbers.k[rows], numbers.scatter[rows][..., 1:, 1:]
    size = np.linalg.norm(k, axis=-1)
    unit = k / size[..., None]
    along = np.einsum("nai,naij,naj->na", unit, covariance, unit)
    across = (np.trace(covariance, axis1=-2, axis2=-1) - along) / (2.0 * size**2)
    return np.asarray(across.mean(axis=1) / max(k.shape[1] - 1, 1))


class _Watched:
    """One component as its runs come in."""

    def __init__(self, values: FloatArray, known: _Component) -> None:
        self.values, self.known = values, known
        self.regime = [0]
        self.squares, self.differences = 0.0, 0
        self.ewma, self.weighted = 0.0, 0

    def accept(self, index: int, *, begins_anew: bool) -> None:
        if begins_anew:
            self.regime, self.ewma, self.weighted = [index], 0.0, 0
            return
        self.squares += 0.5 * (self.values[index] - self.values[self.regime[-1]]) ** 2 / self.known.share
        self.differences += 1
        self.regime.append(index)


def _charts(
    components: Mapping[str, FloatArray], known: Mapping[str, _Component], level: float
) -> tuple[ComponentChart, ...]:
    """Chart every component, run by run, each family's scatter from all its components."""
    watched = {name: _Watched(values, known[name]) for name, values in components.items()}
    size = next(iter(components.values())).size
    columns = {name: np.full((5, size), np.nan) for name in components}
    alarms = {name: np.zeros(size, dtype=bool) for name in components}
    for index in range(1, size):
        scatters = {sensor.known.family: _family_scatter(watched, sensor.known.family) for sensor in watched.values()}
        for name, sensor in watched.items():
            variance, dof = scatters[sensor.known.family]
            columns[name][:, index], alarms[name][index] = _judged(sensor, index, variance, dof, level)
        for name, sensor in watched.items():
            sensor.accept(index, begins_anew=bool(alarms[name][index]))
    return tuple(
        _chart(name, values, columns[name], alarms[name])
        for name, values in components.items()
    )  # fmt: skip


def _chart(name: str, values: FloatArray, columns: FloatArray, alarms: BoolArray) -> ComponentChart:
    centre, low, high, ewma, stated = np.degrees(columns)
    return ComponentChart(name, np.degrees(values), centre, low, high, ewma, alarms, stated)


def _family_scatter(watched: Mapping[str, _Watched], family: str) -> tuple[float, float]:
    """Return the variance of a whole component of a family between runs, and its degrees of freedom."""
    relatives = [sensor for sensor in watched.values() if sensor.known.family == family]
    differences = sum(sensor.differences * min(sensor.known.share, 1.0) for sensor in relatives)
    if min(sensor.differences for sensor in relatives) < LEAST_DIFFERENCES:
        return np.nan, 0.0
    prior, prior_dof = relatives[0].known.prior_variance, relatives[0].known.prior_dof
    family_dof = DIFFERENCE_EFFICIENCY * differences
    squares = sum(sensor.squares * sensor.known.share for sensor in relatives) / differences
    dof = prior_dof + family_dof
    return (prior_dof * prior + family_dof * squares) / dof, dof


def _judged(sensor: _Watched, index: int, variance: float, dof: float, level: float) -> tuple[list[float], bool]:
    """Return centre, low, high, weighted mean and what the certificates explain, and whether it is an alarm."""
    centre = float(sensor.values[sensor.regime].mean())
    count = len(sensor.regime)
    stated_v = float(sensor.known.stated[index] + sensor.known.stated[sensor.regime].mean() / count)
    stated = float(t_quantile(STATED_LEVEL, np.inf)) * float(np.sqrt(stated_v))
    if not dof > 0.0:
        return [centre, np.nan, np.nan, np.nan, stated], False
    sigma = float(np.sqrt(max(variance * sensor.known.share * (1.0 + 1.0 / count), stated_v)))
    half = float(t_quantile(1.0 - level, dof)) * sigma
    deviation = (float(sensor.values[index]) - centre) / sigma
    sensor.ewma = EWMA_WEIGHT * _as_normal(deviation, dof) + (1.0 - EWMA_WEIGHT) * sensor.ewma
    sensor.weighted += 1
    spread = np.sqrt(EWMA_WEIGHT / (2.0 - EWMA_WEIGHT) * (1.0 - (1.0 - EWMA_WEIGHT) ** (2 * sensor.weighted)))
    has_crept = abs(sensor.ewma) > float(t_quantile(1.0 - level, np.inf)) * float(spread)
    is_alarm = abs(deviation) * sigma > half or has_crept
    return [centre, centre - half, centre + half, centre + sensor.ewma * sigma, stated], bool(is_alarm)


def _as_normal(deviation: float, dof: float) -> float:
    """Return the normal deviate that is as rare as a Student's t of so many degrees of freedom."""
    tail = 0.5 * float(f_tail(deviation**2, 1.0, dof))
    return float(np.copysign(-normal_quantile(max(tail, 1e-300)), deviation))


def _differences(charts: Sequence[ComponentChart]) -> int:
    """Return how many differences between runs belong together, of the component that has fewest."""
    return min((int(chart.value_deg.size - 1 - chart.is_alarm.sum()) for chart in charts), default=0)


def _findings(
    population: Population, labels: Sequence[PointLabel], charts: Sequence[ComponentChart]
) -> Iterator[CheckFinding]:
    for index, label in enumerate(labels):
        for chart in charts:
            if chart.is_alarm[index]:
                change = float(chart.value_deg[index] - chart.centre_deg[index])
                spread = float(chart.high_deg[index] - chart.low_deg[index]) / 2.0
                yield _explained(population, label, chart.name, change, spread)


def _explained(population: Population, at: PointLabel, component: str, change: float, spread: float) -> CheckFinding:
    when = f"{at.sensor} at {at.created_utc:%Y-%m-%d}: {component} {change:+.4f}°"
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
    kinds = np.array(population.kinds)
    columns = _is_gain(kinds) if component == METER_GAIN else kinds == "offset_v"
    rows = [
        index
        for index, label in enumerate(population.labels)
        if label.run_id is not None and label.run_id == at.run_id and label.sensor != at.sensor
        and index > 0 and population.labels[index - 1].sensor == label.sensor
    ]  # fmt: skip
    changes = population.coordinates[rows] - population.coordinates[[row - 1 for row in rows]]
    return np.degrees(changes[:, columns].mean(axis=1)) if rows else np.zeros(0)
