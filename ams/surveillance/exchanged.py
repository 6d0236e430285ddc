"""Sensors of one run whose serial numbers or cables were exchanged: each has the characteristics of another one's set.

Two calibrations of each tell it, the one before and the new one: both changed beyond what their sets state, and what
was calibrated as A fits the set that B had before, far better than that of A. Their sets before must differ by more
than they state themselves, so that sensors which are alike within their uncertainties are never named. What a sensor
scatters between runs is not known from two calibrations: "far better" is an F test of what A's characteristics are off
its own set before against what they are off that of B, as if both were scatter, which is right for whatever scatter
there is. Three and more that went round (A as B, B as C, C as A) are told in the same way.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ams.arrays import FloatArray
from ams.sets.coefficients import CoefficientSet
from ams.statistics.distributions import f_tail
from ams.surveillance.characteristics import characteristics_of, numbers_of
from ams.surveillance.stated_changes import StatedScatter, explained_rad, stated_scatter

LEVEL = 0.001
"""Chance that a sensor fits another one's set far better than its own by chance, where it scatters about both."""


@dataclass(frozen=True)
class Recalibrated:
    """A sensor with the set that it has from a run, and its latest one from before."""

    new: CoefficientSet
    before: CoefficientSet


class _Numbers:
    """A set as the characteristics of its sensor."""

    def __init__(self, coefficients: CoefficientSet) -> None:
        found = characteristics_of(numbers_of(coefficients))
        self.coefficients, self.value, self.scale = coefficients, found.value[0], found.scale[0]

    def off_rad(self, other: "_Numbers") -> FloatArray:
        """Return (p,) what it is off another one, as small angles."""
        return np.asarray((self.value - other.value) / other.scale)

    def differs(self, other: "_Numbers", tests: int) -> bool:
        """Return whether two sets differ by more than both state."""
        explained = explained_rad([other.stated], self.stated, tests)
        return bool((np.abs(self.off_rad(other)) > explained).any())

    @cached_property
    def stated(self) -> StatedScatter:
        return stated_scatter(self.coefficients.document, self.coefficients.sensor)


def exchanged(sensors: Sequence[Recalibrated]) -> Mapping[str, str]:
    """Return the sensors that look exchanged, each with a sentence that names all of its round; empty for none.

    Raises: SetError for a set whose model is not installed here.
    """
    found: dict[str, str] = {}
    for group in _of_a_kind(sensors).values():
        found |= _rounds({sensor.new.sensor: sensor for sensor in group})
    return found


def _of_a_kind(sensors: Sequence[Recalibrated]) -> dict[tuple[object, ...], list[Recalibrated]]:
    """Return the sensors by what their sets must share to be compared: nominal axes, units, simulated or measured."""
    groups: dict[tuple[object, ...], list[Recalibrated]] = {}
    for sensor in sensors:
        new, before = (
            (entry.is_simulated, *((axis.nominal_axis, axis.form.sensitivity) for axis in entry.axes.values()))
            for entry in (sensor.new, sensor.before)
        )
        if new == before and numbers_of(sensor.new).sensitivity.all() and numbers_of(sensor.before).sensitivity.all():
            groups.setdefault(new, []).append(sensor)
    return groups


def _rounds(sensors: Mapping[str, Recalibrated]) -> dict[str, str]:
    if len(sensors) < 2:
        return {}
    new = {name: _Numbers(sensor.new) for name, sensor in sensors.items()}
    before = {name: _Numbers(sensor.before) for name, sensor in sensors.items()}
    seen_as = {name: other for name in sensors if (other := _whose(name, new, before)) is not None}
    found: dict[str, str] = {}
    for name in seen_as:
        way = [name]
        while (after := seen_as.get(way[-1])) is not None and after not in way:
            way.append(after)
        if after == name and name not in found:
            found |= dict.fromkeys(way, _sentence(way, seen_as, sensors))
    return found


def _whose(name: str, new: Mapping[str, _Numbers], before: Mapping[str, _Numbers]) -> str | None:
    """Return whose set before a sensor's new one fits, far better than its own; None where it fits nobody's."""
    squares = {other: float((new[name].off_rad(numbers) ** 2).sum()) for other, numbers in before.items()}
    nearest = min((other for other in before if other != name), key=lambda other: squares[other])
    ratio = squares[name] / max(squares[nearest], float(np.finfo(float).tiny))
    count = len(new[name].value)
    if float(f_tail(ratio, count, count)) >= LEVEL / len(before):
        return None
    tests = len(before) * count
    is_distinct = new[name].differs(before[name], tests) and before[name].differs(before[nearest], tests)
    return nearest if is_distinct else None


def _sentence(way: Sequence[str], seen_as: Mapping[str, str], sensors: Mapping[str, Recalibrated]) -> str:
    names = sorted(way)
    who = f"{', '.join(names[:-1])} and {names[-1]}"
    fits = "; ".join(
        f"{name}'s output fits {seen_as[name]}'s set of {sensors[seen_as[name]].before.created_utc:%Y-%m-%d}, and not "
        f"its own of {sensors[name].before.created_utc:%Y-%m-%d}"
        for name in names
    )
    return f"{who} look exchanged: {fits}"
