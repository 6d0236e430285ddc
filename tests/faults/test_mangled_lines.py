"""Every line of a rig flips bits, loses, doubles and delays, commands and replies alike, at random: a short campaign of
every driver that moves an axis never goes on beyond its limits, never has a wrong number without a word, keeps every
dwell that it told of, and ends with its page and the exit status of the table.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from device_sets import EVERY_AXIS, SHORTER, SLOW_DPS, device_set
from fault_scripts import Parameters, Story, parameters_of, tell_of, worst_deviation
from small_run import Bench

from procedures.delivery.deliver import sensors_document, solve_run
from procedures.journal.journal_reader import JournalReader
from procedures.records.progress import Progress
from procedures.records.states import EXIT_STATUS, State
from procedures.run.stop_page import PAGE, UNASKED
from rig.description.fault_plan import FaultPlan

MOST_U = 4.0
HEARD_S = 2.0
"""An axis that a damaged command sends elsewhere is stopped by then: a look, its confirmation, a driver's patience."""
SELDOM, OFTEN = 0.0007, 0.003
"""Chance of each of the four kinds, for each piece each way."""
KINDS: dict[str, dict[str, object]] = {
    "flip-bit": {},
    "drop": {},
    "duplicate": {"delay_s": 0.3},
    "delay": {"delay_s": 1.5},
}


@dataclass
class Heard:
    """What whoever looks at the run is told of its dwells."""

    dwells: int = 0
    kinds: Counter[str] = field(default_factory=Counter)

    def on_event(self, progress: Progress) -> None:
        self.kinds[progress.event] += 1
        self.dwells += progress.event in ("dwell", "rejected")


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Bench, Parameters]]:
    made: dict[str, tuple[Bench, Parameters]] = {}

    def make(driver: str) -> tuple[Bench, Parameters]:
        if driver not in made:
            bench = device_set(driver, tmp_path_factory.mktemp(driver), SHORTER)
            assert bench.run(bench.folder / "clean").state is State.FINISHED
            made[driver] = bench, parameters_of(sensors_document(solve_run(bench.folder / "clean")))
        return made[driver]

    return make


def _mangled(seed: int, probability: float) -> FaultPlan:
    rules = {
        f"{kind}-{on}": {"kind": kind, "line": "*", "on": on, "probability": probability, **keys}
        for kind, keys in KINDS.items()
        for on in ("question", "reply")
    }
    return FaultPlan.model_validate({"seed": seed, "fault": rules})


def _tell(bench: Bench, run_dir: Path, seed: int, probability: float, known: Parameters) -> Story:
    heard = Heard()
    story = tell_of(bench, run_dir, _mangled(seed, probability), lambda _: heard, stopped_within_deg=HEARD_S * SLOW_DPS)
    if story.outcome is None:  # the rig could not be opened: nothing began
        return story
    with JournalReader.open(run_dir) as reader:
        assert reader.committed_dwells() == heard.dwells
    assert story.outcome.exit_status == EXIT_STATUS[story.outcome.state]
    if story.outcome.state in UNASKED:
        assert (run_dir / PAGE).is_file()
    if story.is_finished and not story.is_flagged:
        assert worst_deviation(story, known) <= MOST_U, f"silently off: {story.happened}"
    return story


@pytest.mark.parametrize(
    "seeds",
    [range(2), pytest.param(range(2, 60), marks=[pytest.mark.soak, pytest.mark.timeout(3600)])],
    ids=str,
)
@pytest.mark.parametrize("driver", EVERY_AXIS)
def test_lines_that_mangle_commands_and_replies_at_random_leave_no_wrong_number_and_no_motion_without_a_word(
    clean: Callable[[str], tuple[Bench, Parameters]], tmp_path: Path, driver: str, seeds: range
) -> None:
    bench, known = clean(driver)
    struck = 0
    for seed in seeds:
        try:
            story = _tell(bench, tmp_path / str(seed), seed, OFTEN if seed % 2 else SELDOM, known)
        except BaseException as error:
            error.add_note(f"seed {seed}")
            raise
        struck += len(story.happened)
    assert struck > 20 * len(seeds)
