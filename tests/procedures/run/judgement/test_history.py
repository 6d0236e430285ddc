"""What a process that takes a run up makes of its journal: it judges as the one before would have gone on to."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from journals import a_dwell
from small_run import Bench, bench, dwells_of, measured

from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Request, Spool
from procedures.journal.voids import KIND, voided_in
from procedures.records.dwells import DwellRecord, Event, NoiseReference
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.judgement.history import History, history_of
from procedures.run.resume import resume

_NARROW = ("samples = 5", "samples = 5\nmax_noise_factor = 1.5\nretries = 6")


@pytest.fixture(scope="module", autouse=True)
def _often_by_chance() -> Iterator[None]:
    """Let chance alone reject healthy dwells now and then: which ones hangs on the reference."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("procedures.run.judgement.judge.NOISE_FALSE_ALARM", 0.02)
        yield


class _StopsAt:
    """Asks for a stop after each of these design dwells."""

    def __init__(self, run_dir: Path, *dwells: int) -> None:
        self._spool, self._dwells = Spool(run_dir), set(dwells)

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done in self._dwells:
            self._dwells.remove(progress.dwells_done)
            self._spool.submit(Request("stop", "anna", "2026-03-01T12:00:00+00:00", "lunch"))


@pytest.fixture(scope="module")
def narrow(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("narrow"), procedure=(_NARROW,))


@pytest.fixture(scope="module")
def twice_resumed(narrow: Bench) -> Path:
    run_dir = narrow.folder / "resumed"
    assert narrow.run(run_dir, observer=_StopsAt(run_dir, 6)).state is State.STOPPED
    assert resume(run_dir, "carla", observer=_StopsAt(run_dir, 14)).state is State.STOPPED
    assert resume(run_dir, "carla").state is State.FINISHED
    return run_dir


def test_a_run_that_was_resumed_twice_rejects_what_an_uninterrupted_one_rejects(
    narrow: Bench, twice_resumed: Path
) -> None:
    assert narrow.run(narrow.folder / "whole").state is State.FINISHED
    whole, resumed = dwells_of(narrow.folder / "whole"), dwells_of(twice_resumed)
    assert _rejected(whole), "else the reference decided nothing"
    assert _rejected(resumed) == _rejected(whole)
    assert measured(resumed) == measured(whole)


def _rejected(dwells: list[DwellRecord]) -> list[tuple[int, int, tuple[str, ...]]]:
    return [
        (dwell.step, dwell.attempt, dwell.reasons)
        for dwell in dwells
        if not (dwell.accepted or dwell.purpose == "check")
    ]


def test_every_seam_is_held_against_the_first_check_set_so_that_small_steps_cannot_add_up(twice_resumed: Path) -> None:
    with JournalReader.open(twice_resumed) as reader:
        assert [event.detail["against_epoch"] for event in reader.events("seam")] == [1, 1]


def test_the_noise_reference_of_a_resume_knows_no_check_set_but_the_first(narrow: Bench, twice_resumed: Path) -> None:
    dwells = dwells_of(twice_resumed)
    wanted = NoiseReference()
    for dwell in dwells:
        if dwell.accepted and (dwell.purpose != "check" or dwell.epoch == 1):
            wanted.learn(dwell.readings)
    found = history_of(dwells, 3, narrow.plan)
    assert len(found.measured_once) == len(narrow.plan.dwells)
    for channel in ("dmm.x", "dmm.y", "dmm.z"):
        assert found.noise().standard_deviation(channel) == wanted.standard_deviation(channel)


def test_a_check_set_from_before_a_remount_is_no_baseline(narrow: Bench, twice_resumed: Path) -> None:
    """The package sits anew: another zero is no step, and the first whole check set behind it is what counts."""
    dwells = dwells_of(twice_resumed)
    before = tuple(dwell for dwell in dwells if dwell.epoch == 1)
    assert history_of(before, 1, narrow.plan).baseline_epoch == 1
    assert history_of(before, 1, narrow.plan, remounted_after=1).baseline_epoch is None
    assert history_of(dwells, 3, narrow.plan, remounted_after=1).baseline_epoch == 2
    assert history_of(dwells, 3, narrow.plan, accepted=(2,), remounted_after=2).baseline_epoch == 3


def test_attempts_of_a_step_go_on_counting_over_a_restart_and_those_of_a_check_set_do_not() -> None:
    dwells = (a_dwell(7, attempt=1, accepted=False), a_dwell(7, attempt=2, accepted=False), a_dwell(8))
    found = History((*dwells, replace(a_dwell(9), purpose="check")), 2, None, None)
    assert [found.attempts(step) for step in (7, 8, 9, 10)] == [2, 1, 0, 0]


def test_of_two_words_about_one_dwell_the_first_stands() -> None:
    words = [
        Event(number, datetime(2026, 3, 1, tzinfo=UTC), 0.0, KIND, {"by": by, "reason": why, "dwells": [[7, 1, 1]]}, "")
        for number, by, why in ((1, "anna", "the table was bumped"), (2, "carla", "to be sure"))
    ]
    assert voided_in(words) == {(7, 1, 1): "voided by anna: the table was bumped"}
