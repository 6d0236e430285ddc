"""Laws of the learned durations: right as often as they say, on made-up rigs whose spreads nobody tells them."""

import numpy as np
import pytest

from procedures.plan.learned_times import LearnedTimes, PartSums, again_of, learned_from, sums_of
from procedures.plan.step_times import AGAIN, StepPart

PARTS = {"move pitch up to 30 deg": (60, 7.3), "settle": (120, 3.0), "read": (120, 12.0), "begin": (1, 20.0)}
"""Name to how many steps a run has of it, and what the files expect of one, seconds."""


def _run(
    chance: np.random.Generator, ratios: dict[str, float], between: float, shared: float = 0.0
) -> dict[str, PartSums]:
    """``shared``: by how much all parts of a run are slower or quicker together."""
    found, night = {}, 1.0 + shared * chance.standard_normal()
    for name, (count, expected_s) in PARTS.items():
        ratio = ratios[name] * night * (1.0 + between * chance.standard_normal())
        steps_s = expected_s * (ratio + 0.15 * chance.standard_normal(count))
        found[name] = sums_of([(expected_s, float(taken_s)) for taken_s in steps_s])
    return found


def _parts() -> list[StepPart]:
    return [StepPart(None, name, expected_s) for name, (count, expected_s) in PARTS.items() for _ in range(count)]


@pytest.mark.parametrize(("between", "shared"), [(0.0, 0.0), (0.02, 0.0), (0.1, 0.0), (0.02, 0.1)])
def test_after_ten_runs_the_p50_is_exceeded_by_half_and_the_p90_by_a_tenth(between: float, shared: float) -> None:
    chance = np.random.default_rng(20)
    ratios = {name: float(chance.uniform(0.5, 2.0)) for name in PARTS}
    trials, over = 300, np.zeros(2)
    for _ in range(trials):
        learned = learned_from([_run(chance, ratios, between, shared) for _ in range(10)])
        p50_s, p90_s, _ = learned.durations(_parts())
        took_s = sum(sums.measured_s for sums in _run(chance, ratios, between, shared).values())
        over += [took_s > p50_s, took_s > p90_s]
    assert over[0] / trials == pytest.approx(0.5, abs=0.1)
    assert over[1] / trials == pytest.approx(0.1, abs=0.06)


@pytest.mark.parametrize("later", [0.28, 0.12, 0.04])
def test_runs_that_mostly_take_the_same_time_and_seldom_a_window_longer_are_foreseen_as_that(later: float) -> None:
    """A few dwells on quiet devices: no number has half of the runs above it, and none may have more than that."""
    chance = np.random.default_rng(21)
    steps = [StepPart(None, "settle", 3.0), StepPart(None, "rest", 200.0)]

    def run_s() -> float:
        return 200.0 + 3.0 + (1.5 if chance.uniform() < later else 0.0)

    trials, over, reached = 1000, np.zeros(2), np.zeros(2)
    for _ in range(trials):
        past = [{"settle": sums_of([(3.0, run_s() - 200.0)]), "rest": sums_of([(200.0, 200.0)])} for _ in range(10)]
        foreseen_s, took_s = np.array(learned_from(past).durations(steps)[:2]), run_s()
        over += took_s > foreseen_s + 1e-6
        reached += took_s >= foreseen_s - 1e-6
    assert over[0] / trials <= 0.5
    assert reached[0] / trials >= 0.5
    assert over[1] / trials <= 0.16
    assert reached[1] / trials >= 0.04


@pytest.mark.parametrize("times", [1, 4])
def test_a_dwell_that_is_seldom_measured_again_lengthens_the_p90_as_often_as_it_should(times: int) -> None:
    """Skewed: 20 dwells of 30 s, each repeated with 3 %; also where the plan is four times the past ones."""
    chance = np.random.default_rng(22)

    def run(dwells: int) -> dict[str, PartSums]:
        reads = sums_of([(30.0, float(30.0 * chance.normal(1.0, 0.01))) for _ in range(dwells)])
        return {"read": reads, AGAIN: again_of([reads], [45.0] * chance.binomial(dwells, 0.03))}

    trials, over = 600, np.zeros(2)
    for _ in range(trials):
        learned = learned_from([run(20) for _ in range(10)])
        foreseen_s = np.array(learned.durations([StepPart(None, "read", 30.0)] * 20 * times)[:2])
        over += sum(sums.measured_s for sums in run(20 * times).values()) > foreseen_s
    assert over[0] / trials == pytest.approx(0.5, abs=0.1)
    assert over[1] / trials == pytest.approx(0.1, abs=0.06)


def test_a_plan_of_another_size_is_foreseen_from_the_same_runs() -> None:
    chance = np.random.default_rng(3)
    learned = learned_from([_run(chance, dict.fromkeys(PARTS, 1.3), 0.0) for _ in range(10)])
    p50_s, p90_s, parts = learned.durations(_parts() * 4)
    assert p50_s == pytest.approx(4 * 1.3 * sum(count * each_s for count, each_s in PARTS.values()), rel=0.02)
    assert parts["settle"].count == 480
    assert sum(part.p50_s for part in parts.values()) == pytest.approx(p50_s, rel=2e-3)
    assert 0.0 < p90_s - p50_s < sum(part.p90_s - part.p50_s for part in parts.values())


def test_a_move_of_a_size_never_made_is_told_by_the_axis_other_moves_and_a_new_part_by_the_files() -> None:
    runs = [{"move pitch up to 30 deg": sums_of([(10.0, 14.0), (5.0, 7.0)])} for _ in range(3)]
    learned = learned_from(runs)
    p50_s, _, parts = learned.durations([StepPart(0, "move pitch over 100 deg", 50.0), StepPart(0, "read", 9.0)])
    assert parts["move pitch over 100 deg"].p50_s == pytest.approx(70.0)
    assert p50_s == pytest.approx(79.0)


@pytest.mark.parametrize("runs", [0, 1, 2])
def test_two_runs_teach_nothing(runs: int) -> None:
    learned = learned_from([{"read": sums_of([(10.0, 30.0)])}] * runs)
    assert learned == LearnedTimes()
    assert learned.durations([StepPart(0, "read", 10.0)])[0] == 10.0


def test_only_the_latest_runs_count() -> None:
    new, old = {"read": sums_of([(10.0, 10.0)])}, {"read": sums_of([(10.0, 99.0)])}
    assert learned_from([new] * 30 + [old] * 50).parts["read"].ratio == pytest.approx(1.0)
