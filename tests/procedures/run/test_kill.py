"""SIGKILL at any moment: nothing acknowledged is lost, nothing is measured twice, every number is the same."""

from pathlib import Path

import numpy as np
import pytest
from small_run import Bench, bench, dwells_of, in_child, killed_after, measured, resumed

from procedures.delivery import sensors_document, solve_run
from procedures.run.owner import is_owned
from procedures.run.states import State
from procedures.run.status import status
from procedures.run.storage import JOURNAL_FILE
from rig.clock import SystemClock


def _kill_and_compare(folder: Path, kills: int, seed: int) -> None:
    chance = np.random.default_rng(seed)
    small = bench(folder)
    clock = SystemClock()
    began_s = clock.monotonic_s()
    assert small.run(folder / "whole").state is State.FINISHED
    whole_s = clock.monotonic_s() - began_s
    clean, solution = measured(dwells_of(folder / "whole")), sensors_document(solve_run(folder / "whole"))
    assert clean.keys() == {dwell.step for dwell in small.plan.dwells if dwell.purpose != "check"}
    done, number = 0, 0
    while done < kills:
        number += 1
        run_dir = folder / f"run-{number}"
        done += _killed_run(small, run_dir, whole_s, chance)
        if (run_dir / JOURNAL_FILE).exists():  # else it was killed before there was a run, and nothing had moved
            assert measured(dwells_of(run_dir)) == clean
            assert sensors_document(solve_run(run_dir)) == solution


def _killed_run(small: Bench, run_dir: Path, whole_s: float, chance: np.random.Generator) -> int:
    """One run, killed and resumed until it is finished; returns how often it was killed."""
    kills = int(killed_after(in_child(lambda: small.run(run_dir)), chance.uniform(0.0, whole_s)))
    while (run_dir / JOURNAL_FILE).exists():
        assert not is_owned(run_dir)
        state = status(run_dir).state
        if state is State.FINISHED:
            break
        assert state is State.INTERRUPTED
        if chance.uniform() < 0.5:
            kills += killed_after(in_child(lambda: resumed(run_dir)), chance.uniform(0.0, whole_s))
            continue
        assert resumed(run_dir).state is State.FINISHED
    return kills


def test_a_run_killed_at_random_moments_ends_with_the_same_dwells(tmp_path: Path) -> None:
    _kill_and_compare(tmp_path, kills=40, seed=1)


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_a_run_killed_at_two_hundred_random_moments_ends_with_the_same_dwells(tmp_path: Path) -> None:
    _kill_and_compare(tmp_path, kills=200, seed=2)
