"""Following a run: what is told piece by piece is what the journal holds, and a look costs what is new."""

import os
from pathlib import Path

import numpy as np
import pytest
from example_files import ROOT
from journals import a_clock
from small_run import bench, dwells_of

from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import Authorisation, close_run, void_from
from procedures.journal.status.follower import Follower, News
from procedures.journal.status.status import status
from procedures.records.progress import Progress
from procedures.records.states import State


class Following:
    """An observer that follows the very run that tells it."""

    def __init__(self, run_dir: Path) -> None:
        self._follower = Follower(run_dir)
        self.news: list[News] = []

    def on_event(self, progress: Progress) -> None:
        self.news.append(self._follower.poll())


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[News]]:
    folder = tmp_path_factory.mktemp("followed")
    following = Following(folder / "run")
    bench(folder).run(folder / "run", observer=following)
    following.on_event(None)  # type: ignore[arg-type]
    return folder / "run", following.news


def test_what_is_told_piece_by_piece_is_the_whole_journal(followed: tuple[Path, list[News]]) -> None:
    run_dir, news = followed
    with JournalReader.open(run_dir) as reader:
        assert [event for added in news for event in added.events] == list(reader.events())
    found, held = [dwell for some in news for dwell in some.dwells], dwells_of(run_dir)
    assert [(entry.record.step, entry.record.attempt, entry.record.accepted) for entry in found] == [
        (dwell.step, dwell.attempt, dwell.accepted) for dwell in held
    ]
    for each_dwell, dwell in zip(found, held, strict=True):
        assert each_dwell.record.readings == {}
        for channel, reading in dwell.readings.items():
            assert each_dwell.mean[channel] == pytest.approx(float(np.mean(reading.samples)), rel=1e-15)
            assert each_dwell.standard_deviation[channel] == pytest.approx(reading.standard_deviation, rel=1e-9)


def test_a_follower_that_comes_late_knows_the_same(followed: tuple[Path, list[News]]) -> None:
    run_dir, news = followed
    late = Follower(run_dir).poll()
    assert (late.status, late.sequence) == (news[-1].status, news[-1].sequence)
    assert late.status.state is State.FINISHED
    assert late.status.dwells_done == late.status.dwells_planned


def test_a_run_that_goes_on_tells_how_far_it_is_and_what_a_request_refers_to(
    followed: tuple[Path, list[News]],
) -> None:
    run_dir, news = followed
    with JournalReader.open(run_dir) as reader:
        entered = {event.sequence: str(event.detail["to"]) for event in reader.events("state")}
    going = [added.status.to_document() for added in news if added.status.state is State.RUNNING and added.is_alive]
    assert {entered[entry["state_sequence"]] for entry in going} == {"running"}
    assert [entry["replication"] for entry in going if entry["dwells_done"] in (1, 13)][:2] == [1, 2]
    assert (going[-1]["replications"], going[-1]["rejected"]) == (2, 0)
    assert "state_sequence" not in news[-1].status.to_document()


def test_states_are_told_as_they_were_entered(followed: tuple[Path, list[News]]) -> None:
    _, news = followed
    assert [added.status.state for added in news if any(event.kind == "state" for event in added.events)][-2:] == [
        State.RUNNING,
        State.FINISHED,
    ]
    assert all(added.is_alive for added in news[:-1])


def test_a_quiet_run_costs_a_look_at_its_bell(
    followed: tuple[Path, list[News]], monkeypatch: pytest.MonkeyPatch
) -> None:
    run_dir, _ = followed
    os.utime(run_dir / "journal.count", (1e9, 1e9))
    follower = Follower(run_dir, clock=a_clock())
    follower.poll()
    monkeypatch.setattr(JournalReader, "events", lambda *_, **__: pytest.fail("read a journal that did not change"))
    assert follower.poll().events == ()


def test_what_is_taken_back_or_closed_is_seen_at_the_next_look(tmp_path: Path) -> None:
    small, run_dir = bench(tmp_path), tmp_path / "run"
    small.run(run_dir)
    follower = Follower(run_dir)
    before = follower.poll().status
    taken_back = void_from(run_dir, small.plan.design_dwells[-2].step, Authorisation("anna", "door open"))
    close_run(run_dir, Authorisation("anna", "sensor sold"))
    after = follower.poll().status
    assert (after.dwells_done, taken_back) == (before.dwells_done - 2, 2)
    assert (after.state, after.why) == (State.CLOSED, "sensor sold (asked for by anna)")
    assert after == status(run_dir)


def test_journals_of_earlier_versions_are_followed_too() -> None:
    for journal in sorted((ROOT / "tests" / "data").glob("**/journal.sqlite")):
        news = Follower(journal.parent).poll()
        assert news.status.dwells_done <= news.status.dwells_planned
        assert news.sequence > 0
