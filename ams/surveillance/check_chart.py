"""The check sensor's chart: it tells whether a change was the sensor's, the table's or the meter's.

A permanent check sensor is never taken off its mount and is calibrated in every run. Its characteristics are read as

- *meter gain*: what all its sensitivities changed alike; *meter offset*: what all its offsets changed alike;
- *table tilt*: the rotation of the whole package, which nobody remounted (a mount that moved looks the same);
- *sensor*: what is left, in which its axes differ from one another (offsets, sensitivities, angles between axes).

What all its axes do alike may still be its own (its supply, its temperature). The other sensors of the same run are the
witnesses: what they changed alike since their own last calibration is the meter's, if it is what the check sensor says.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ams.arrays import BoolArray, FloatArray
from ams.errors import ArchiveUnknown
from ams.statistics.intervals import t_quantile
from ams.surveillance.between_runs import DIFFERENCE_EFFICIENCY
from ams.surveillance.series import PointLabel, Population

Cause = Literal["sensor", "table", "meter", "open"]

LEVEL = 0.002
"""Chance of any false alarm in one run."""
WITNESS_FACTOR = 3.0
LEAST_DIFFERENCES = 4
METER_GAIN, METER_OFFSET = "meter gain", "meter offset"


@dataclass(frozen=True)
class ComponentChart:
    """One component over n runs, degrees (as an angle at full sensitivity), against the first run."""

    name: str
    value_deg: FloatArray
    low_deg: FloatArray
    """The prediction interval of the run before; NaN while too little is known."""
    high_deg: FloatArray
    is_alarm: BoolArray


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


def check_history(population: Population, sensor: str) -> CheckHistory:
    """Return the chart of a check sensor. Raises: ArchiveUnknown where it is not among the population."""
    rows = population.rows_of(sensor)
    if rows.start == rows.stop:
        raise ArchiveUnknown(f"history: check sensor {sensor!r}: has no calibration here; name one that has")
    labels = tuple(population.labels[rows])
    components = _components(population, rows)
    level = LEVEL / len(components)
    charts = tuple(_chart(name, values, level) for name, values in components.items())
    findings = tuple(_findings(population, labels, charts))
    return CheckHistory(sensor, labels, charts, findings)


def check_sensors(population: Population, rig: str) -> tuple[str, ...]:
    """Return the check sensors of a rig."""
    return tuple(dict.fromkeys(label.sensor for label in population.labels if label.is_check and label.rig == rig))


def _components(population: Population, rows: slice) -> dict[str, FloatArray]:
    """Return (n,) radians by name, or (n, m) of what is judged together."""
    change = population.coordinates[rows] - population.coordinates[rows][0]
    kinds = np.array(population.kinds)
    gains, offsets = change[:, _is_gain(kinds)], change[:, kinds == "offset_v"]
    own = [part - part.mean(axis=1, keepdims=True) for part in (offsets, gains)]
    tilt = np.radians(population.rotation_deg(rows))
    return {
        METER_GAIN: gains.mean(axis=1),
        METER_OFFSET: offsets.mean(axis=1),
        **{f"table tilt {axis}": tilt[:, place] for place, axis in enumerate("xyz")},
        **{
            f"sensor {name}": np.concatenate([*own, change[:, kinds == "angle_deg"]], axis=1)[:, place]
            for place, name in enumerate(_own_names(population))
        },
    }


def _own_names(population: Population) -> list[str]:
    names = population.characteristics.names
    kinds = np.array(population.kinds)
    order = [
        *np.flatnonzero(kinds == "offset_v"),
        *np.flatnonzero(_is_gain(kinds)),
        *np.flatnonzero(kinds == "angle_deg"),
    ]
    return [names[int(place)] for place in order]


def _is_gain(kinds: NDArray[np.str_]) -> BoolArray:
    return np.asarray(np.char.startswith(kinds, "sensitivity"))


def _chart(name: str, values: FloatArray, level: float) -> ComponentChart:
    """Chart every run against the one before, with the scatter of the differences before it; a step begins anew."""
    low, high = np.full(values.size, np.nan), np.full(values.size, np.nan)
    alarms = np.zeros(values.size, dtype=bool)
    squares, differences, last = 0.0, 0, 0
    for place in range(1, values.size):
        if differences >= LEAST_DIFFERENCES:
            dof = DIFFERENCE_EFFICIENCY * differences
            half = float(t_quantile(1.0 - level, dof)) * float(np.sqrt(2.0 * squares / differences))
            low[place], high[place] = values[last] - half, values[last] + half
            alarms[place] = not low[place] <= values[place] <= high[place]
        if not alarms[place]:
            squares, differences = squares + 0.5 * (values[place] - values[last]) ** 2, differences + 1
        last = place
    return ComponentChart(name, np.degrees(values), np.degrees(low), np.degrees(high), alarms)


def _findings(
    population: Population, labels: Sequence[PointLabel], charts: Sequence[ComponentChart]
) -> Iterator[CheckFinding]:
    for place, label in enumerate(labels):
        for chart in charts:
            if chart.is_alarm[place]:
                change = float(chart.value_deg[place] - chart.value_deg[place - 1])
                spread = float(chart.high_deg[place] - chart.low_deg[place]) / 2.0
                yield _explained(population, label, chart.name, change, spread)


def _explained(population: Population, at: PointLabel, component: str, change: float, spread: float) -> CheckFinding:
    when = f"{at.sensor} at {at.created_utc:%Y-%m-%d}: {component} {change:+.4f} deg"
    if component.startswith("table"):
        told = "table", f"{when}: the table or its base turned, or the check sensor moved on its mount"
    elif component.startswith("sensor"):
        told = "sensor", f"{when}: its axes differ from one another: the check sensor itself changed"
    else:
        told = _by_other_sensors(population, at, component, change, spread, when)
    return CheckFinding(at, told[0], component, abs(change), told[1])  # type: ignore[arg-type]


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
        return "meter", f"{when}: {seen.size} other sensors of that run changed alike ({middle:+.4f} deg): the meter"
    if abs(middle) <= WITNESS_FACTOR * error:
        return "sensor", f"{when}: {seen.size} other sensors of that run did not change: the check sensor itself"
    return "open", f"{when}: {seen.size} other sensors of that run changed otherwise ({middle:+.4f} deg): look at both"


def _witnesses_deg(population: Population, at: PointLabel, component: str) -> FloatArray:
    """Return (m,) what every other sensor of the run changed alike in its axes, degrees.

    It is the change since the sensor's own last calibration.
    """
    kinds = np.array(population.kinds)
    columns = _is_gain(kinds) if component == METER_GAIN else kinds == "offset_v"
    rows = [
        place
        for place, label in enumerate(population.labels)
        if label.run_id is not None and label.run_id == at.run_id and label.sensor != at.sensor
        and place > 0 and population.labels[place - 1].sensor == label.sensor
    ]  # fmt: skip
    changes = population.coordinates[rows] - population.coordinates[[place - 1 for place in rows]]
    return np.degrees(changes[:, columns].mean(axis=1)) if rows else np.zeros(0)
