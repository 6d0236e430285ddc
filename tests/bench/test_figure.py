"""How often work is done to be measured: often where it is quick, and no longer than a figure is worth."""

from collections.abc import Callable

import pytest

import bench.figure
from bench.figure import MOST_S, Effort


class _Timer:
    """Of work that takes a known time, the first call more."""

    cost_s, warms_up_s = 0.0, 0.0
    calls: list[int]

    def __init__(self, work: Callable[[], object]) -> None:
        work()

    def timeit(self, count: int) -> float:
        self.calls.append(count)
        return count * self.cost_s + (self.warms_up_s if len(self.calls) == 1 else 0.0)


def measured(monkeypatch: pytest.MonkeyPatch, cost_s: float, warms_up_s: float = 0.0) -> tuple[float, list[int]]:
    calls: list[int] = []
    timer = type("Measured", (_Timer,), {"cost_s": cost_s, "warms_up_s": warms_up_s, "calls": calls})
    monkeypatch.setattr(bench.figure, "Timer", timer)
    return Effort().best_s(lambda: None), calls


@pytest.mark.parametrize("cost_s", [1e-6, 1e-3, 0.1, 1.0, 3.0, 5.0, 30.0])
def test_a_figure_is_the_time_of_one_call_and_takes_no_longer_than_it_is_worth(
    monkeypatch: pytest.MonkeyPatch, cost_s: float
) -> None:
    best_s, calls = measured(monkeypatch, cost_s, warms_up_s=0.5 * cost_s)
    assert best_s == pytest.approx(cost_s if cost_s < MOST_S else 1.5 * cost_s)
    assert sum(calls) * cost_s <= MOST_S + cost_s


def test_quick_work_is_measured_in_five_series_each_long_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    _, calls = measured(monkeypatch, 1e-3)
    assert sum(count * 1e-3 >= 0.3 / 5 for count in calls) == 5
