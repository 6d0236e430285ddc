"""SIGKILL at every named place and at random moments: nothing acknowledged is lost, nothing is measured twice unseen,
and the coefficients are those of the run that nobody killed. Source of the method: SQLite's n-th failure loops."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asking import put
from device_sets import RIGS, device_set
from fault_scripts import Person
from killing import Target, after, kill_and_resume, require_kept, run_child
from small_run import resumed

from procedures.journal.requests.spool import Spool
from procedures.journal.status.status import status
from procedures.records.progress import Progress, RunObserver
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from rig.assembly.open_rig import open_rig
from rig.crash_points import CrashPoint
from rig.description.fault_plan import FaultPlan

pytestmark = pytest.mark.timeout(600)
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


@pytest.mark.parametrize(
    ("first", "share"),
    [
        pytest.param(0, 2 * len(RIGS), id="dealt out"),
        pytest.param(len(RIGS), 2 * len(RIGS), id="the others", marks=pytest.mark.thorough),
        pytest.param(0, 1, id="all", marks=pytest.mark.soak),
    ],
)
@pytest.mark.parametrize("devices", RIGS)
def test_fault_01_killed_at_every_named_place_nothing_is_lost(
    target: MakeTarget, devices: str, first: int, share: int
) -> None:
    """Each place once, at a passage drawn anew for each set of devices; dealt out, the sets share the places."""
    number = sorted(RIGS).index(devices)
    chance, aimed = np.random.default_rng(number), target(devices)
    for point in OF_A_RUN[(first + number) % share :: share]:
        passage = int(chance.integers(1, PASSAGES.get(point, 20) + 1))
        assert kill_and_resume(aimed, (f"{point}:{passage}", None), chance) >= 1, f"{point} was never passed"


@pytest.mark.parametrize(
    "most", [1, pytest.param(8, marks=pytest.mark.thorough), pytest.param(15, marks=pytest.mark.soak)]
)
@pytest.mark.parametrize("devices", RIGS)
def test_fault_01_killed_at_random_moments_nothing_is_lost(target: MakeTarget, devices: str, most: int) -> None:
    chance, aimed, kills = np.random.default_rng(100 + sorted(RIGS).index(devices)), target(devices), 0
    while kills < most:
        kills += kill_and_resume(aimed, (None, after(chance.uniform(0.0, aimed.whole_s))), chance)


class Asks:
    """Passes on what it sees, and asks something of the run after its third dwell."""

    def __init__(self, seen: RunObserver, run_dir: Path, kind: str) -> None:
        self._seen, self._spool, self._kind = seen, Spool(run_dir), kind

    def on_event(self, progress: Progress) -> None:
        self._seen.on_event(progress)
        if self._kind and progress.event == "dwell" and progress.dwells_done == 3:
            put(self._spool, self._kind, "bert", "please")


@pytest.mark.parametrize(
    ("point", "question"),
    [
        (CrashPoint.PAUSED, "pause"),
        (CrashPoint.HELD, ""),
        (CrashPoint.MADE_SAFE, "abort"),
        pytest.param(CrashPoint.ENDING, "abort", marks=pytest.mark.thorough),
        pytest.param(CrashPoint.ENDING, "stop", marks=pytest.mark.thorough),
    ],
)
def test_fault_01_killed_while_it_stands_still_or_gives_up_a_run_is_resumed(
    target: MakeTarget, point: CrashPoint, question: str
) -> None:
    """Held: the meter's line is pulled out. What was asked of the dead process is not asked of the next."""
    aimed = target("table-3458a")
    run_dir = aimed.new_folder()
    cut = {"line": "readouts.dmm", "kind": "hang-up", "away_s": 20.0, "at_s": 60.0}
    faults = None if question else FaultPlan.model_validate({"fault": {"cut": cut}})

    def work(seen: RunObserver) -> Outcome:
        run_dir.mkdir()
        with open_rig(aimed.bench.rig, faults=faults) as rig:
            person = Person(run_dir, Asks(seen, run_dir, question))
            return begin(run_dir, aimed.bench.header(run_dir), aimed.bench.plan, rig, person, person)

    ended = run_child(work, f"{point}:1")
    assert ended.was_killed, f"{point} was never passed"
    require_kept(run_dir, ended.acknowledged, [])
    assert status(run_dir).state is State.INTERRUPTED
    assert resumed(run_dir).state is State.FINISHED
    aimed.require_the_clean_result(run_dir)


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
    assert passage > 200, "a run passes so many places"
    while kills < 1000:
        kills += kill_and_resume(aimed, (None, after(chance.uniform(0.0, aimed.whole_s))), chance)


def test_a_run_that_nobody_kills_passes_the_harness(target: MakeTarget) -> None:
    """The harness itself: no kill is reported where there was none, and every dwell was acknowledged."""
    aimed = target("table-3458a")
    ended = run_child(lambda seen: aimed.bench.run(aimed.new_folder(), observer=seen), None)
    assert (ended.was_killed, ended.acknowledged) == (False, len(aimed.bench.plan.dwells))
