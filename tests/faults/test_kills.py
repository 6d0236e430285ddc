"""SIGKILL at every named place and at random moments: nothing acknowledged is lost, nothing is measured twice unseen,
and the coefficients are those of the run that nobody killed. Source of the method: SQLite's n-th failure loops."""

from collections.abc import Callable

import numpy as np
import pytest
from device_sets import RIGS, device_set
from killing import Target, after, kill_and_resume, run_child

from rig.crash_points import CrashPoint

DELIVERY = (CrashPoint.SOLVED, CrashPoint.SETS_WRITTEN, CrashPoint.PUBLISHED, CrashPoint.REPORTED)
STANDING = (CrashPoint.PAUSED, CrashPoint.HELD)
OF_A_RUN = tuple(point for point in CrashPoint if point not in (*DELIVERY, *STANDING))
"""What every run that meets no trouble passes."""
PASSAGES = {
    CrashPoint.RUN_CREATED: 1,
    CrashPoint.EPOCH_OPENED: 1,
    CrashPoint.BEFORE_CHECKPOINT: 1,
    CrashPoint.ENDING: 1,
    CrashPoint.MADE_SAFE: 1,
}
"""Of those that are not passed at every dwell."""

MakeTarget = Callable[[str], Target]


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> MakeTarget:
    made: dict[str, Target] = {}

    def make(name: str) -> Target:
        if name not in made:
            folder = tmp_path_factory.mktemp(name)
            made[name] = Target.of(device_set(name, folder), folder)
        return made[name]

    return make


@pytest.mark.parametrize("devices", RIGS)
def test_fault_01_killed_at_every_named_place_nothing_is_lost(target: MakeTarget, devices: str) -> None:
    """Each place once, at a passage drawn anew for each set of devices."""
    chance, aimed = np.random.default_rng(sorted(RIGS).index(devices)), target(devices)
    for point in OF_A_RUN:
        passage = int(chance.integers(1, PASSAGES.get(point, 20) + 1))
        assert kill_and_resume(aimed, (f"{point}:{passage}", None), chance) >= 1, f"{point} was never passed"


@pytest.mark.parametrize("devices", RIGS)
def test_fault_01_killed_at_random_moments_nothing_is_lost(target: MakeTarget, devices: str) -> None:
    chance, aimed, kills = np.random.default_rng(100 + sorted(RIGS).index(devices)), target(devices), 0
    while kills < 15:
        kills += kill_and_resume(aimed, (None, after(chance.uniform(0.0, aimed.whole_s))), chance)


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("devices", RIGS)
def test_fault_01_killed_at_every_passage_of_every_place_nothing_is_lost(target: MakeTarget, devices: str) -> None:
    """The k-th passage of any place, k = 1, 2, … until a run is not killed any more; then random moments."""
    chance, aimed, kills, passage = np.random.default_rng(7), target(devices), 0, 0
    while True:
        passage += 1
        killed = kill_and_resume(aimed, (f"any:{passage}", None), chance)
        if not killed:
            break
        kills += killed
    assert passage > 250, "a run passes so many places"
    while kills < 1000:
        kills += kill_and_resume(aimed, (None, after(chance.uniform(0.0, aimed.whole_s))), chance)


def test_a_run_that_nobody_kills_passes_the_harness(target: MakeTarget) -> None:
    """The harness itself: no kill is reported where there was none, and every dwell was acknowledged."""
    aimed = target("table-3458a")
    ended = run_child(lambda seen: aimed.bench.run(aimed.new_folder(), observer=seen), None)
    assert (ended.was_killed, ended.acknowledged) == (False, len(aimed.bench.plan.dwells))
