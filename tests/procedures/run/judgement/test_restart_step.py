"""A step at the seam is found, a healthy restart and an honest drift are not called one."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from journals import a_dwell
from small_run import bench, resumed
from unattended_run import UnattendedRun, asks, run_unattended

from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from procedures.run.judgement.restart_step import compare

SIGMA_V, SAMPLES = 2e-5, 20
LEVELS_V = (-2.5, 2.5, 0.0, 1.2, -0.7, 0.1)


def _check_set(chance: np.random.Generator, change_v: float = 0.0) -> dict[int, DwellRecord]:
    return {step: _visit(chance, step, change_v) for step in range(6)}


def _visit(chance: np.random.Generator, step: int, change_v: float) -> DwellRecord:
    dwell = a_dwell(step)
    readings = {
        channel: replace(reading, samples=LEVELS_V[step] + change_v + chance.normal(0.0, SIGMA_V, SAMPLES))
        for channel, reading in dwell.readings.items()
    }
    return replace(dwell, readings=readings, targets_deg={"pitch": 10.0 * step, "roll": 0.0})


def _steps(before: dict[int, DwellRecord], after: dict[int, DwellRecord], visits: list[DwellRecord]) -> int:
    return sum(entry.is_step for entry in compare(before, after, visits))


def test_fewer_than_one_percent_of_a_thousand_healthy_restarts_stop() -> None:
    chance = np.random.default_rng(4)
    before = _check_set(chance)
    stopped = sum(bool(_steps(before, _check_set(chance), [])) for _ in range(1000))
    assert stopped < 10, "18 comparisons at 1e-6 each: one in fifty thousand is expected"


def test_every_channel_at_every_attitude_is_compared() -> None:
    chance = np.random.default_rng(4)
    assert len(compare(_check_set(chance), _check_set(chance), [])) == 18


@pytest.mark.parametrize("standard_errors", [10.0, -10.0])
def test_a_step_of_ten_standard_errors_is_found_up_or_down(standard_errors: float) -> None:
    chance = np.random.default_rng(5)
    step_v = standard_errors * SIGMA_V * np.sqrt(2.0 / SAMPLES)
    assert _steps(_check_set(chance), _check_set(chance, step_v), []) == 18


def test_t_is_the_change_over_its_standard_error() -> None:
    chance = np.random.default_rng(6)
    before, after = _check_set(chance), _check_set(chance)
    entry = compare(before, after, [])[0]
    readings = [dwell.readings["dmm.x"].samples for dwell in (*before.values(), *after.values())]
    pooled_v2 = np.mean([values.var(ddof=1) for values in readings])
    change_v = after[0].readings["dmm.x"].mean - before[0].readings["dmm.x"].mean
    assert entry.t == pytest.approx(change_v / np.sqrt(2.0 * pooled_v2 / SAMPLES), rel=1e-12)
    assert entry.t_limit == pytest.approx(5.05, abs=0.05)  # t at 228 degrees of freedom, 1e-6 two-sided; normal: 4.89


def test_a_sensor_that_drifts_from_visit_to_visit_is_not_called_broken() -> None:
    chance = np.random.default_rng(7)
    drift_v = 8.0 * SIGMA_V / np.sqrt(SAMPLES)
    visits = [_visit(chance, step, number * drift_v) for number in range(4) for step in range(6)]
    before, after = _check_set(chance), _check_set(chance, 4.0 * drift_v)
    assert _steps(before, after, []) > 0
    assert _steps(before, after, visits) == 0


@pytest.mark.parametrize(("degrees", "is_found"), [(1, True), (5, True), (6, False)])
def test_few_visits_by_chance_apart_do_not_hide_a_step(degrees: int, is_found: bool) -> None:
    """Scatter between visits counts from six degrees of freedom on: t of one at 1e-6 is six hundred thousand."""
    chance = np.random.default_rng(8)
    apart_v = 40.0 * SIGMA_V
    visits = [_visit(chance, 0, sign * apart_v) for sign in (1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0)[: degrees + 1]]
    assert (_steps(_check_set(chance), _check_set(chance, 10.0 * SIGMA_V), visits) == 18) is is_found


def _quiet(value_v: float) -> dict[int, DwellRecord]:
    dwell = a_dwell(0)
    reading = replace(dwell.readings["dmm.x"], samples=np.full(5, value_v))
    return {0: replace(dwell, readings={"dmm.x": reading})}


def test_without_noise_any_change_is_a_step_and_none_is_none() -> None:
    assert _steps(_quiet(1.0), _quiet(1.0), []) == 0
    assert _steps(_quiet(1.0), _quiet(1.1), []) == 1


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_fewer_than_ten_of_a_thousand_healthy_resumes_on_twins_stop(tmp_path: Path) -> None:
    """Whole runs, stopped after three dwells and resumed: drivers, settling, judging and all."""
    short = (("replications = 2", "replications = 1"), ("step = 30.0", "step = 60.0"))
    tripped = 0
    for seed in range(1000):
        folder = tmp_path / str(seed)
        folder.mkdir()
        small = bench(folder, rig=(("seed = 7", f"seed = {seed}"),), procedure=short)
        unattended = UnattendedRun(folder / "run", after={3: asks("stop")})
        assert run_unattended(small, unattended).state is State.STOPPED
        tripped += resumed(unattended.run_dir).state is State.TRIPPED
        shutil.rmtree(folder)
    assert tripped < 10
