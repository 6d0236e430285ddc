"""One measured figure and the target it is held against, and how much is done to measure it."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from timeit import Timer
from typing import TypeVar

T = TypeVar("T")
MOST_S = 10.0
"""So long one figure is measured, unless a single call takes longer."""


@dataclass(frozen=True)
class Figure:
    """A line of the table."""

    what: str
    value: float
    unit: str
    target: float
    at_most: bool
    """True: the value must not exceed the target; false: it must reach it."""
    note: str = ""
    is_gated: bool = False
    """A ratio to a peer measured beside it: a busy machine slows both, so missing its target is a failure."""

    @property
    def is_met(self) -> bool:
        return self.value <= self.target if self.at_most else self.value >= self.target


@dataclass(frozen=True)
class Effort:
    """How much a benchmark does: enough to measure, or, where it is tiny, just enough to see that it works."""

    is_tiny: bool = False

    def amount(self, whole: T, tiny: T) -> T:
        """Choose an amount of work."""
        return tiny if self.is_tiny else whole

    def best_s(self, work: Callable[[], object], least_total_s: float = 0.3, repeats: int = 5) -> float:
        """Return the seconds of one call: the best of several series, each long enough to be measured.

        Work that takes long is done less often: once where the first call, which else warms up, took all there is.
        """
        timer = Timer(work)
        spent_s = first_s = timer.timeit(1)
        if self.is_tiny or spent_s > MOST_S:
            return first_s
        count, best_s = 1, inf
        for _ in range(repeats):
            while (series_s := timer.timeit(count)) < least_total_s / repeats:
                count *= 2
            spent_s, best_s = spent_s + series_s, min(best_s, series_s / count)
            if spent_s > MOST_S:
                break
        return best_s
