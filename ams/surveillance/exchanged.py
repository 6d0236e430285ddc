"""Sensors of one run whose serial numbers or cables were exchanged: each has the characteristics of another one's set.

Two calibrations of each tell it, the one before and the new one: both changed beyond what their sets state, and what
was calibrated as A fits the set that B had before, far better than that of A. Their sets before must differ by more
than they state themselves, so that sensors which are alike within their uncertainties are never named. What a sensor
scatters between runs is not known from two calibrations: "far better" is an F test of what the sensors' characteristics
are off their own sets before against what they are off those that they fit, as if both were scatter, which is right for
whatever scatter there is. Three and more that went round (A as B, B as C, C as A) are told in the same way.

Sensitivities are compared per m/s², since g is another one at another site. A gain of the meter is in all that it read,
and no sensor's: the mean change of all sensitivities is the same whoever was exchanged with whom, and is taken out.

Where the exchange was in the run before, the sensors are seen as exchanged once more, back again: each fits the set of
before that, and the sets of the run between are those of others.
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
    """A sensor with the set that it has from a run, and its latest ones from before."""

    new: CoefficientSet
    before: CoefficientSet
    earlier: CoefficientSet | None = None
    """Before that one; None where there is none, or where a person answers for the one before."""


@dataclass(frozen=True)
class Exchange:
    """What tells that a sensor was exchanged with others of its run."""

    sentence: str
    """Names all of its round."""
    is_of_before: bool
    """Whether the sets before are the others', and the new ones the sensors' own."""


class _Numbers:
    """A set as the characteristics of its sensor."""

    def __init__(self, coefficients: CoefficientSet) -> None:
        found = characteristics_of(numbers_of(coefficients))
        self.coefficients, self.value, self.scale = coefficients, found.value[0], found.scale[0]
        self.is_gain = np.array([name.startswith("sensitivity_") for name in found.names])
        self.gravity_mps2 = coefficients.gravity_mps2 if numbers_of(coefficients).unit == "g" else 1.0

    def off_rad(self, other: "_Numbers") -> FloatArray:
        """Return (p,) what it is off another one, as small angles; sensitivities by their logarithms, per m/s²."""
        off = (self.value - other.value) / other.scale
        ratio = self.value / np.where(self.is_gain, other.value, 1.0) * (other.gravity_mps2 / self.gravity_mps2)
        is_ratio = self.is_gain & (ratio > 0.0)
        return np.where(is_ratio, np.log(np.where(is_ratio, ratio, 1.0)), off)

    def explained_rad(self, other: "_Numbers", tests: int) -> FloatArray:
        """Return (p,) how far two sets of one sensor are off each other at most, by what both state."""
        return explained_rad([other.stated], self.stated, tests)

    @cached_property
    def stated(self) -> StatedScatter:
        return stated_scatter(self.coefficients.document, self.coefficients.sensor)


def exchanged(sensors: Sequence[Recalibrated]) -> Mapping[str, Exchange]:
    """Return what tells of each sensor that looks exchanged; empty for none.

    Raises: SetError for a set whose model is not installed here.
    """
    found: dict[str, Exchange] = {}
    for group in _of_a_kind(sensors).values():
        for way in _rounds(group):
            round_of = [group[index] for index in way]
            is_of_before = _is_of_before(round_of)
            sentence = _sentence(round_of, is_of_before=is_of_before)
            found |= dict.fromkeys((sensor.new.sensor for sensor in round_of), Exchange(sentence, is_of_before))
    return found


def _is_of_before(sensors: Sequence[Recalibrated]) -> bool:
    """Return whether all of a round were exchanged when they got the sets before, and are back now."""
    earlier = [sensor.earlier for sensor in sensors if sensor.earlier is not None]
    if len(earlier) < len(sensors):
        return False
    then = [Recalibrated(sensor.before, old) for sensor, old in zip(sensors, earlier, strict=True)]
    since = [Recalibrated(sensor.new, old) for sensor, old in zip(sensors, earlier, strict=True)]
    return len(exchanged(then)) == len(sensors) and not exchanged(since)


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


def _rounds(sensors: Sequence[Recalibrated]) -> list[tuple[int, ...]]:
    """Return the sensors of each round by their places, each before the one whose set it fits."""
    if len(sensors) < 2:
        return []
    new, before = [_Numbers(sensor.new) for sensor in sensors], [_Numbers(sensor.before) for sensor in sensors]
    off = np.array([[made.off_rad(old) for old in before] for made in new])
    gain = new[0].is_gain
    of_all = off.diagonal().T[:, gain].mean()
    found: dict[int, tuple[int, ...]] = {}
    for of_meter in (0.0, of_all):
        squares = ((off - of_meter * gain) ** 2).sum(axis=2)
        np.fill_diagonal(squares, np.inf)
        for way in _ways(squares.argmin(axis=1).tolist()):
            if not set(way) & set(found) and _is_exchange(way, off, new, before):
                found |= dict.fromkeys(way, way)
    return list(dict.fromkeys(found.values()))


def _ways(nearest: Sequence[int]) -> list[tuple[int, ...]]:
    """Return what comes back to where it began, each once, from its least place on."""
    found = []
    for first in range(len(nearest)):
        way = [first]
        while (after := nearest[way[-1]]) not in way:
            way.append(after)
        if after == first == min(way):
            found.append(tuple(way))
    return found


def _is_exchange(way: Sequence[int], off: FloatArray, new: Sequence[_Numbers], before: Sequence[_Numbers]) -> bool:
    """Return whether the sets of a round fit those of each other far better than their own, and differ."""
    count, width, gain = len(new), off.shape[2], new[0].is_gain
    after = [*way[1:], way[0]]
    unexchanged, fitted = off[list(way), list(way)], off[list(way), after]
    unexchanged = unexchanged - unexchanged[:, gain].mean() * gain
    fitted = fitted - fitted[:, gain].mean() * gain
    ratio = (unexchanged**2).sum() / max((fitted**2).sum(), float(np.finfo(float).tiny))
    # By the degrees of freedom of a single sensor: what all of a round scatter may be common to them.
    if float(f_tail(ratio, width, width)) >= LEVEL / (2.0 * count):
        return False
    tests = count * width
    return all(
        (np.abs(unexchanged[at]) > new[index].explained_rad(before[index], tests)).any()
        and (np.abs(before[index].off_rad(before[other])) > before[index].explained_rad(before[other], tests)).any()
        for at, (index, other) in enumerate(zip(way, after, strict=True))
    )


def _sentence(way: Sequence[Recalibrated], *, is_of_before: bool) -> str:
    after = {sensor.new.sensor: other for sensor, other in zip(way, [*way[1:], way[0]], strict=True)}
    in_order = sorted(way, key=lambda sensor: sensor.new.sensor)
    names = [sensor.new.sensor for sensor in in_order]
    who = f"{', '.join(names[:-1])} and {names[-1]}"
    if is_of_before:
        sets = "; ".join(f"{sensor.new.sensor}'s of {sensor.before.created_utc:%Y-%m-%d}" for sensor in in_order)
        return (
            f"{who} look exchanged in their sets before ({sets}), not now: each output fits its own set of before that"
        )
    fits = "; ".join(
        f"{name}'s output fits {after[name].new.sensor}'s set of {after[name].before.created_utc:%Y-%m-%d}, and not "
        f"its own of {sensor.before.created_utc:%Y-%m-%d}"
        for name, sensor in zip(names, in_order, strict=True)
    )
    return f"{who} look exchanged: {fits}"
