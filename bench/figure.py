"""One measured figure and the target it is held against."""

from collections.abc import Callable
from dataclasses import dataclass
from timeit import Timer


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

    @property
    def is_met(self) -> bool:
        return self.value <= self.target if self.at_most else self.value >= self.target


def best_s(work: Callable[[], object], least_total_s: float = 0.3, repeats: int = 5) -> float:
    """Seconds of one call: the best of several series, each long enough to be measured."""
    timer = Timer(work)
    work()
    count = 1
    while timer.timeit(count) < least_total_s / repeats:
        count *= 2
    return min(timer.repeat(repeats, count)) / count
