"""Does a dwell fit what the dwells before it say of every sensor axis: a running fit, for gross errors only.

Each axis is v = b + k·f, f the specific force in the axes of its stage, fitted to the dwells so far about the declared
mount and sensitivity. A reading further from its prediction than six standard deviations, and than what drift or a soft
mount can do, is doubted; and the pattern of the doubted channels tells what happened: channels that changed places, an
axis that sits on another tooth than its read-back says, a sensor that is gone. Dwells before it at which the same would
not have shown are doubted with it.
Source: TP (2), (4), (5) for f, on a gimbal CR (III-B).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import permutations
from math import inf, sqrt
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.frames import ANGLES, specific_force
from procedures.records.dwells import DwellRecord, without_readings
from rig.description.rig_file import Sensor

LEAST_G = 0.002
"""Below this no reading is doubted: 0.1° at the most sensitive attitude, more than drift within a run."""
SIGMAS = 6.0
FEWEST_DEGREES = 10
"""So many more dwells than parameters before the fit's own scatter counts."""
MOST_PERMUTED = 4
TEETH = (1, 2, 10)
WHOLE_DEG = (1.0, 10.0)


@dataclass(frozen=True)
class Doubt:
    """What speaks against a dwell that its own readings do not."""

    kind: Literal["channels", "slip", "unexplained"]
    reasons: tuple[str, ...]
    dubious: tuple[DwellRecord, ...] = ()
    """Accepted dwells before it that would have looked right all the same, without their readings; never of the check
    set.
    """


@dataclass
class _Line:
    """One channel, in units of its nominal sensitivity: ridge regression about the declared mount."""

    nominal_v_per_g: float
    start: FloatArray
    """(4,) offset and k of a perfect sensor."""
    rolls: bool = True
    """Whether the roll axis turns it."""
    information: FloatArray = field(default_factory=lambda: (LEAST_G / SIGMAS) ** 2 * np.eye(4))
    moments: FloatArray = field(default_factory=lambda: np.zeros(4))
    squares: float = 0.0
    count: int = 0

    def learn(self, basis: FloatArray, value_g: float) -> None:
        left_g = value_g - float(self.start @ basis)
        self.information = self.information + np.outer(basis, basis)
        self.moments = self.moments + left_g * basis
        self.squares += left_g**2
        self.count += 1

    def predict(self, basis: FloatArray) -> tuple[float, float]:
        """Return (value, doubted beyond), g."""
        solved = np.linalg.solve(self.information, np.stack([self.moments, basis], axis=1))
        value_g = float((self.start + solved[:, 0]) @ basis)
        scatter_g = max(LEAST_G / SIGMAS, self._scatter_g(solved[:, 0]))
        return value_g, SIGMAS * scatter_g * sqrt(1.0 + float(basis @ solved[:, 1]))

    def _scatter_g(self, change: NDArray[np.floating[Any]]) -> float:
        degrees = self.count - change.size
        if degrees < FEWEST_DEGREES:
            return 0.0
        return sqrt(max(self.squares - float(change @ self.moments), 0.0) / degrees)


@dataclass(frozen=True)
class _Seen:
    """A dwell in the fit's own terms."""

    values_g: Mapping[str, float]
    """Channel to reading over nominal sensitivity."""
    attitude_deg: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class _Kept:
    """A dwell that was learned, as small as it can be told again."""

    dwell: DwellRecord
    """Without its readings."""
    channels: tuple[str, ...]
    """One and the same for all that were read alike."""
    values_g: FloatArray

    @property
    def seen(self) -> _Seen:
        return _Seen(dict(zip(self.channels, self.values_g.tolist(), strict=True)), self.dwell.measured_deg)


class RunningFit:
    """Of packages on a table with pitch, roll and yaw; of anything else it knows nothing and doubts nothing."""

    def __init__(self, sensors: Mapping[str, Sensor], increments_deg: Mapping[str, float]) -> None:
        self._sensors = sensors
        self._increments_deg = increments_deg
        self._lines: dict[str, _Line] = {}
        self._kept: list[_Kept] = []
        self.forget()

    def forget(self) -> None:
        """Forget every fit: at another temperature every offset and sensitivity is another."""
        self._lines = dict(_lines(self._sensors))
        self._kept.clear()

    def learn(self, dwell: DwellRecord) -> None:
        """Take an accepted dwell in."""
        if not _is_still(dwell):
            return
        seen = self._seen(dwell)
        bases = _bases(seen.attitude_deg)
        for channel, value_g in seen.values_g.items():
            line = self._lines[channel]
            line.learn(bases[line.rolls], value_g)
        channels = tuple(seen.values_g)
        if self._kept and self._kept[-1].channels == channels:
            channels = self._kept[-1].channels
        self._kept.append(_Kept(without_readings(dwell), channels, np.array(list(seen.values_g.values()))))

    def doubt(self, dwell: DwellRecord) -> Doubt | None:
        """Return what contradicts a dwell; None where every channel is near its prediction, or nothing is predicted."""
        if not _is_still(dwell):
            return None
        seen = self._seen(dwell)
        expected = self._expected(seen.attitude_deg)
        doubted = [name for name, value in seen.values_g.items() if not _is_near(value, expected[name])]
        if not doubted:
            return None
        return self._swapped(seen, doubted) or self._slipped(seen) or self._unexplained(seen, doubted)

    def _seen(self, dwell: DwellRecord) -> _Seen:
        values = {
            name: reading.mean / self._lines[name].nominal_v_per_g
            for name, reading in dwell.readings.items()
            if name in self._lines
        }
        return _Seen(values, dwell.measured_deg)

    def _expected(self, attitude_deg: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        bases = _bases(attitude_deg)
        return {name: line.predict(bases[line.rolls]) for name, line in self._lines.items()}

    def _swapped(self, seen: _Seen, doubted: Sequence[str]) -> Doubt | None:
        """Return the channels of one readout that carry one another's readings."""
        if len({name.partition(".")[0] for name in doubted}) > 1 or not 2 <= len(doubted) <= MOST_PERMUTED:
            return None
        expected = self._expected(seen.attitude_deg)
        for order in permutations(doubted):
            swapped = dict(zip(doubted, order, strict=True))
            if all(
                _is_near(seen.values_g[name], self._as_read(name, other, expected)) for name, other in swapped.items()
            ):
                swaps = "; ".join(
                    f"{name}: reads what {other} should" for name, other in swapped.items() if name != other
                )
                reasons = (f"{swaps}: channels changed places",)
                return Doubt("channels", reasons, self._hidden(partial(self._permuted, swapped)))
        return None

    def _as_read(self, name: str, other: str, expected: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
        """Return what channel ``name`` would read of the sensor axis behind ``other``."""
        scale = self._lines[other].nominal_v_per_g / self._lines[name].nominal_v_per_g
        value_g, limit_g = expected[other]
        return scale * value_g, abs(scale) * limit_g

    def _permuted(self, swapped: Mapping[str, str], seen: _Seen) -> bool:
        """Return whether a dwell would look right with its channels changed as well."""
        expected = self._expected(seen.attitude_deg)
        return all(
            _is_near(seen.values_g[name], self._as_read(name, other, expected))
            for name, other in swapped.items()
            if name in seen.values_g
        )

    def _slipped(self, seen: _Seen) -> Doubt | None:
        """Find an axis that stands some teeth or whole degrees from where it says; one channel alone cannot tell."""
        if len(seen.values_g) < 2:
            return None
        for axis, by_deg in _slips(seen.attitude_deg, self._increments_deg):
            if self._fits(axis, by_deg, seen):
                sentence = f"{axis}: every sensor reads as if it stood {by_deg:+g}° from its own read-back"
                return Doubt("slip", (sentence,), self._hidden(partial(self._fits, axis, by_deg)))
        return None

    def _fits(self, axis: str, by_deg: float, seen: _Seen) -> bool:
        expected = self._expected({**seen.attitude_deg, axis: seen.attitude_deg[axis] + by_deg})
        return all(_is_near(value, expected[name]) for name, value in seen.values_g.items())

    def _hidden(self, would_fit: Callable[[_Seen], bool]) -> tuple[DwellRecord, ...]:
        """Return the last dwells in a row that fit the explanation as well as the truth."""
        found: list[DwellRecord] = []
        for kept in reversed(self._kept):
            if kept.dwell.purpose == "check" or not would_fit(kept.seen):
                break
            found.append(kept.dwell)
        return tuple(reversed(found))

    def _unexplained(self, seen: _Seen, doubted: Iterable[str]) -> Doubt:
        expected = self._expected(seen.attitude_deg)
        return Doubt(
            "unexplained", tuple(self._sentence(name, seen.values_g[name], expected[name]) for name in doubted)
        )

    def _sentence(self, name: str, value_g: float, expected: tuple[float, float]) -> str:
        scale_v = abs(self._lines[name].nominal_v_per_g)
        away_v = scale_v * abs(value_g - expected[0])
        return f"{name}: {away_v:.3g} V from what the dwells before predict, allowed {scale_v * expected[1]:.3g} V"


def _lines(sensors: Mapping[str, Sensor]) -> Iterator[tuple[str, _Line]]:
    for sensor in sensors.values():
        if not sensor.is_sensitivity_declared:
            continue  # no accelerometer
        for axis, channel in sensor.channels.items():
            declared, start = getattr(sensor.mount, axis), np.zeros(4)
            start[1 + "xyz".index(declared[1])] = 1.0 if declared[0] == "+" else -1.0
            yield channel, _Line(sensor.nominal_v_per_g(axis), start, sensor.rolls)


def _is_still(dwell: DwellRecord) -> bool:
    return dwell.measured_deg.keys() <= set(ANGLES)


def _bases(attitude_deg: Mapping[str, float]) -> Mapping[bool, FloatArray]:
    """Whether the roll axis turns a sensor to (4,), one and the specific force."""
    pitch_rad, roll_rad, yaw_rad = (np.deg2rad([attitude_deg.get(axis, 0.0)]) for axis in ("pitch", "roll", "yaw"))
    yaw = yaw_rad if "yaw" in attitude_deg else None
    stands = {True: roll_rad, False: 0.0 * roll_rad}
    return {rolls: np.append(1.0, specific_force(pitch_rad, roll, yaw)[0]) for rolls, roll in stands.items()}


def _is_near(value_g: float, expected: tuple[float, float]) -> bool:
    return abs(value_g - expected[0]) <= expected[1]


def _slips(attitude_deg: Mapping[str, float], increments_deg: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Yield axis and angle that a coupling may be off by, the smallest first."""
    for axis in attitude_deg:
        increment_deg = increments_deg.get(axis, 0.0) or inf
        sizes = sorted({*(n * increment_deg for n in TEETH if increment_deg < inf), *WHOLE_DEG})
        yield from ((axis, sign * size) for size in sizes for sign in (1.0, -1.0))
