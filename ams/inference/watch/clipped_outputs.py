"""Outputs that stand at a rail: an amplifier's or a meter's end of range, where they are no measure of what is sensed.

Three outputs have a length that has to be g, which a clipped one breaks. One or two have an angle for every number that
they give. What tells a rail is that readings at the highest or the lowest number of the output are equal to the last
digit: where a step is finer than the noise, one that lies near that end is on that very number with a probability of
0.4 steps a standard deviation at most, clipped or not moving. So many of them on it as chance does not do once in
10⁶ are a rail, unless the output repeats other numbers as often: one without noise, one that is read more often than
it is measured, a step that is wider than it looks. Where other outputs repeat their numbers with it, the package was in
one attitude, and nothing had any noise.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.inference.watch.seen_output import SeenOutput
from ams.inputs.equal_readings import chance_of_a_number
from ams.units import printed

LEAST_CLIPPED: Final = 3
"""Rows at a rail."""
_CHANCE: Final = 1e-6
_CHANCE_NAMED: Final = 1e-3
"""Of an end that is named and not flagged."""
_NEAR_SD: Final = 8.0
_LEAST_OTHERS: Final = 16
"""Readings that are at no end, to hold the ends against."""
_MOST_EQUAL: Final = 0.1
"""Share of those that are equal to their neighbour, or stand on a number that is repeated beyond chance."""
_UNLIKELY: Final = 0.05
"""That chance repeats such a number as often as it is."""
_MOST_CHANCE: Final = 0.5
"""Of one number: with a step that is wider than the noise an output repeats itself rightly."""
_LEAST_NAMED: Final = 20
"""Rows at an end that is not proven to be a rail, and may be one."""
_OFTENER: Final = 5.0
"""So many times as often as any number at no end."""

Rails = Mapping[str, Sequence[float]]
"""Levels at which outputs were found clipped, by column."""
NO_RAILS: Final[Rails] = {}


@dataclass
class _End:
    """The highest number of an output, or by ``sign`` −1 the lowest, and the rows about it."""

    sign: float
    stated: float
    is_known: bool = False
    is_doubtful: bool = False
    """It is hardly by chance that so many rows are on it, and not proven that it is none."""
    level: float = -np.inf
    """By the sign."""
    rows: int = 0
    unflagged: int = 0
    """Rows that were answered before it was known."""
    _near: int = 0
    """Rows that lay near it; near one that it was before, more may have been counted."""
    _equal: int = 0
    """Rows on it that tell, each in another attitude than the one before or with noise in it."""
    _judged_from: int = LEAST_CLIPPED
    _judged_at: int = 0
    _companion: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def level_v(self) -> float:
        return self.sign * self.level

    def take(self, values: FloatArray, in_run: BoolArray, others: Sequence[FloatArray]) -> BoolArray | None:
        """Take (n,) further readings; return which of them are at the end, None where none is.

        ``in_run``: those that repeat a number for so long that the output hangs. ``others``: other outputs.
        """
        highest = float(np.fmax.reduce(values) if self.sign > 0.0 else -np.fmin.reduce(values))
        if highest > self.level:
            is_far = highest - self.level > _NEAR_SD * self.stated
            self.level, self.is_known, self._near = highest, False, 0 if is_far else self._near
            self.rows = self.unflagged = self._equal = 0
            self._judged_from, self._companion, self.is_doubtful = LEAST_CLIPPED, np.empty(0), False
        nearest = self.level_v - self.sign * _NEAR_SD * self.stated
        if not self.sign * nearest <= highest:
            return None
        is_near = values >= nearest if self.sign > 0.0 else values <= nearest
        self._near += int(np.count_nonzero(is_near))
        if highest < self.level:
            return None
        at: BoolArray = values == self.level_v
        self.rows += int(np.count_nonzero(at))
        self._equal += self._telling(at & ~in_run, others)
        return at

    def _telling(self, at: BoolArray, others: Sequence[FloatArray]) -> int:
        """Return how many rows at the end differ in any other output from the one before there."""
        rows = np.flatnonzero(at)
        if not others or not rows.size:
            return int(rows.size)
        beside = np.stack([values[rows] for values in others])
        before = beside[:, :1] + 1.0 if not self._companion.size else self._companion[:, np.newaxis]
        self._companion = beside[:, -1]
        differ = (np.diff(np.concatenate([before, beside], axis=1), axis=1) != 0.0).any(axis=0)
        return int(np.count_nonzero(differ))

    def stands_out(self, others: FloatArray, rows: int) -> bool:
        """Return whether so many of all rows are at this end, as at none of the (n,) ``others`` that are at none."""
        if self.is_doubtful:
            return True
        if self.rows < _LEAST_NAMED or others.size < _LEAST_OTHERS:
            return False
        most = float(np.unique(others, return_counts=True)[1].max()) / others.size
        return self.rows >= _OFTENER * most * (rows - self.rows)

    def judge(self, seen: SeenOutput, ends: Sequence[float], rows: int, *, is_last: bool = False) -> None:
        """Find whether it is a rail, by the noise and the step that the output shows.

        ``ends``: both numbers; ``rows``: of the output. Not at every row: when those at the end are half as many more,
        and after the last one.
        """
        least = LEAST_CLIPPED if is_last else self._judged_from
        if self.is_known or self._equal < least or rows == self._judged_at:
            return
        self._judged_from, self._judged_at = self._equal + max(self._equal // 2, 1), rows
        sd, others = seen.noise(self.stated), seen.newest_but(ends)
        if _repeats(others, sd, _MOST_CHANCE):
            return
        chance = chance_of_a_number(seen.step_at_most(self.level_v, sd), sd)
        if chance >= _MOST_CHANCE or _repeats(others, sd, chance):
            return
        equal, trials = np.full(1, self._equal - 1.0), np.full(1, max(self._near, self._equal) - 1.0)
        by_chance = float(_tail(equal, trials, chance)[0])
        self.is_known, self.is_doubtful = by_chance < _CHANCE, by_chance < _CHANCE_NAMED


def _tail(equal: FloatArray, trials: FloatArray, chance: float) -> FloatArray:
    """Return at most how probable (n,) so many and more equal ones are among so many trials, by Chernoff's bound."""
    share = equal / np.maximum(trials, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        others = np.where(share < 1.0, (1.0 - share) * np.log((1.0 - share) / (1.0 - chance)), 0.0)
        apart = np.where(share > 0.0, share * np.log(share / chance), 0.0) + others
    return np.where(share > chance, np.exp(-trials * apart), 1.0)


def _repeats(values: FloatArray, sd: float, chance: float) -> bool:
    """Return whether (n,) readings at no end repeat their numbers too, or are too few to tell."""
    if values.size < _LEAST_OTHERS or np.mean(np.diff(values) == 0.0) > _MOST_EQUAL:
        return True
    ordered = np.sort(values)
    numbers, counts = np.unique(ordered, return_counts=True)
    reach = 0.5 * _NEAR_SD * sd
    near = np.searchsorted(ordered, numbers + reach, "right") - np.searchsorted(ordered, numbers - reach, "left")
    by_chance = _tail(counts.astype(float) - 1.0, near.astype(float) - 1.0, chance)
    return bool(counts[(counts > 1) & (by_chance < _UNLIKELY)].sum() > _MOST_EQUAL * values.size)


_PROVEN: Final = (
    "equal to the last digit as its noise does not have it: clipped, at a rail of the amplifier or the end of the "
    "meter's range; "
)
_MISSING: Final = "they are taken as missing"
_BEFORE: Final = (
    "{} of them were answered before that was known and have no flag: their angles are wrong; the others are taken as "
    "missing"
)
_UNPROVEN: Final = (
    "and at no other number nearly as often: an output that is clipped looks like that, and so does a package that "
    "rests there with less noise than stated or than a step; these rows do not tell which and have no flag; look "
    "before the angles are used"
)


class ClippedOutputs:
    """Outputs by column, each with its standard deviation, as they come.

    ``rails``: levels at which they are known to be clipped, as all rows told when they were read before.
    """

    def __init__(self, noise: Mapping[str, float], rails: Rails, units: Mapping[str, str]) -> None:
        self._rails, self._units, self.rows = rails, units, 0
        self._ends = {name: (_End(1.0, sd), _End(-1.0, sd)) for name, sd in noise.items()}

    def take(
        self, readings: Mapping[str, FloatArray], in_runs: Mapping[str, BoolArray], seen: Mapping[str, SeenOutput]
    ) -> Iterator[tuple[str, BoolArray]]:
        """Take further rows of all outputs; yield by column which (n,) of them are at a rail, where any is."""
        self.rows += next(iter(readings.values())).size
        for name, ends in self._ends.items():
            others = [readings[other] for other in seen if other != name]
            met = [(end, end.take(readings[name], in_runs[name], others)) for end in ends]
            at_rails = []
            for end, at in met:
                if at is None:
                    continue
                end.judge(seen[name], [each.level_v for each in ends], self.rows)
                if end.is_known or end.level_v in self._rails.get(name, ()):
                    at_rails.append(at)
                else:
                    end.unflagged += int(np.count_nonzero(at))
            if at_rails:
                yield name, np.logical_or.reduce(at_rails)

    def finish(self, seen: Mapping[str, SeenOutput]) -> None:
        """Judge by all rows."""
        for name, ends in self._ends.items():
            for end in ends:
                end.judge(seen[name], [each.level_v for each in ends], self.rows, is_last=True)

    def rails(self) -> Rails:
        """Return the levels that outputs are clipped at, by column."""
        found = {name: [end.level_v for end in self._found(name)] for name in self._ends}
        return {name: levels for name, levels in found.items() if levels}

    def has_unflagged(self) -> bool:
        """Return whether rows at a rail were answered before it was known."""
        return any(end.unflagged for name in self._ends for end in self._found(name))

    def doubts(self, seen: Mapping[str, SeenOutput], frozen: Mapping[str, int]) -> Iterator[str]:
        """Say of every rail where it is, how many rows stand at it, and how many were answered before it was known.

        And of every end that stands out and is not proven to be one, that it may be, unless the output has rows that
        are told as ``frozen``.
        """
        for name, ends in self._ends.items():
            for end in ends:
                unit = printed(self._units[name]) if name in self._units else ""
                which = "highest" if end.sign > 0.0 else "lowest"
                said = f"{name} stands at {end.level_v:.7g} {unit} in {end.rows} rows, its {which} number, "
                if end in self._found(name):
                    yield said + _PROVEN + (_MISSING if not end.unflagged else _BEFORE.format(end.unflagged))
                elif not frozen[name] and end.stands_out(
                    seen[name].newest_but([each.level_v for each in ends]), self.rows
                ):
                    yield said + _UNPROVEN

    def _found(self, name: str) -> list[_End]:
        return [end for end in self._ends[name] if end.is_known or end.level_v in self._rails.get(name, ())]
