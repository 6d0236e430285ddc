"""A journal that grows is verified once, piece by piece: the list names what a reader of the whole names, for less."""

import shutil
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from run_folders import STARTED_UTC, make_run, stored_run

from procedures.journal import damage
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.owner import owning
from procedures.journal.status import verified_so_far
from procedures.journal.status.metrics import figures_of, metrics_text
from procedures.journal.status.run_list import RunList
from procedures.journal.status.status import status
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from rig.clock import VirtualClock

LATER = VirtualClock(datetime.now(UTC) + timedelta(days=1))
SHARE = 5


@pytest.fixture(autouse=True)
def small_shares(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verified_so_far, "SHARE", SHARE)


@pytest.fixture
def hashed(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The lengths of the dwells whose SHA-256 was taken for a search, in order."""
    lengths: list[int] = []
    original = damage.hash_dwell

    def hash_and_tell(text: str | bytes, samples: bytes) -> str:
        lengths.append(len(samples))
        return original(text, samples)

    monkeypatch.setattr(damage, "hash_dwell", hash_and_tell)
    return lengths


class _Growing:
    """A run that lives, and commits when it is told to."""

    def __init__(self, folder: Path) -> None:
        header, measured = stored_run()
        folder.mkdir()
        self.folder, self.clock, self._dwells = folder, VirtualClock(STARTED_UTC), _endless(measured)
        self.journal = Journal.create(folder / "journal.sqlite", replace(header, run_id=folder.name), self.clock)

    def commit(self, dwells: int) -> None:
        for _ in range(dwells):
            self.journal.commit_dwell(next(self._dwells), self.clock)


def _endless(measured: tuple[DwellRecord, ...]) -> Iterator[DwellRecord]:
    attempt = 0
    while True:
        attempt += 1
        yield from (replace(dwell, attempt=attempt) for dwell in measured)


@pytest.fixture
def growing(tmp_path: Path) -> Iterator[_Growing]:
    run = _Growing(tmp_path / "run")
    with owning(run.folder):
        yield run
    run.journal.close()


def _damaged(listing: RunList) -> tuple[str, ...]:
    (run,) = listing.read()
    assert run.trouble == ""
    return run.damaged


def _whole(folder: Path) -> tuple[str, ...]:
    with JournalReader.open(folder) as reader:
        return reader.damage().names


def _change(folder: Path, statement: str) -> None:
    with closing(sqlite3.connect(folder / "journal.sqlite")) as connection:
        assert connection.execute(statement).rowcount == 1
        connection.commit()


def test_a_look_at_a_run_that_grows_verifies_what_is_new_and_a_share_of_the_rest(
    growing: _Growing, hashed: list[int]
) -> None:
    listing = RunList(growing.folder.parent, verifies=True)
    growing.commit(60)
    assert _damaged(listing) == ()
    for _ in range(20):
        hashed.clear()
        growing.commit(2)
        assert _damaged(listing) == ()
        assert 2 <= len(hashed) <= 2 + SHARE


def test_what_a_list_that_reads_on_tells_of_a_run_is_what_its_status_tells(growing: _Growing) -> None:
    listing = RunList(growing.folder.parent, verifies=True)
    for _ in range(30):
        growing.commit(1)
        (run,) = listing.read()
        assert run.status == status(growing.folder)
        assert run.status is not None
        assert (run.dwells_done, run.dwells_planned) == (run.status.dwells_done, run.status.dwells_planned)


NEWEST_DWELL = "UPDATE dwells SET {} WHERE number = (SELECT max(number) FROM dwells)"
NEWEST_EVENT = "UPDATE events SET {} WHERE sequence = (SELECT max(sequence) FROM events)"


@pytest.mark.parametrize(
    "statement",
    [
        NEWEST_DWELL.format("sha256 = 'other'"),
        NEWEST_EVENT.format("sha256 = 'other'"),
        "DELETE FROM dwells WHERE number = (SELECT max(number) FROM dwells)",
    ],
)
def test_another_end_than_the_one_that_was_read_is_read_anew(growing: _Growing, statement: str) -> None:
    listing = RunList(growing.folder.parent, verifies=True)
    growing.commit(40)
    assert _damaged(listing) == ()
    (growing.folder / "journal.count").unlink()
    _change(growing.folder, statement)
    assert _damaged(listing) == _whole(growing.folder)


@pytest.mark.parametrize("statement", ["UPDATE dwells SET samples = x'00' WHERE number = 30",
                                       "UPDATE dwells SET accepted = 1 - accepted WHERE number = 2",
                                       "UPDATE dwells SET sha256 = 'other' WHERE number = 17",
                                       "DELETE FROM dwells WHERE number = 20",
                                       "UPDATE events SET detail = detail || ' ' WHERE sequence = 25",
                                       "DELETE FROM events WHERE sequence = 3"])  # fmt: skip
def test_what_changes_under_a_run_that_goes_on_is_named_within_the_looks_that_read_it_all(
    growing: _Growing, statement: str
) -> None:
    listing = RunList(growing.folder.parent, verifies=True)
    growing.commit(40)
    assert _damaged(listing) == ()
    (growing.folder / "journal.count").unlink()
    _change(growing.folder, statement)
    named = _whole(growing.folder)
    assert named
    looks = [_damaged(listing) for _ in range(2 * 45 // SHARE)]
    assert looks[-1] == named
    first = looks.index(named)
    assert all(look == named for look in looks[first:]), "what was found stays told"


def test_when_its_process_has_ended_a_journal_is_verified_whole(tmp_path: Path) -> None:
    run = _Growing(tmp_path / "run")
    listing = RunList(tmp_path, LATER, verifies=True)
    with owning(run.folder):
        run.commit(40)
        assert _damaged(listing) == ()
        _change(run.folder, "UPDATE dwells SET samples = x'00' WHERE number = 30")
        assert _damaged(listing) == ()
    assert _damaged(listing) == _whole(run.folder) != ()
    run.journal.close()


def test_another_file_under_the_name_is_read_anew(tmp_path: Path) -> None:
    """As a program does that restores a copy: with the same end, and other bytes before it."""
    run = _Growing(tmp_path / "run")
    listing = RunList(tmp_path, verifies=True)
    run.commit(40)
    run.journal.close()
    with owning(run.folder):
        assert _damaged(listing) == ()
        journal, copy = run.folder / "journal.sqlite", tmp_path / "copy"
        shutil.copy(journal, copy)
        with closing(sqlite3.connect(copy)) as connection:
            connection.execute("UPDATE dwells SET samples = x'00' WHERE number = 30")
            connection.commit()
        copy.rename(journal)
        assert _damaged(listing) == _whole(run.folder) != ()


def _damages() -> Iterator[Callable[[int], str]]:
    yield lambda at: f"UPDATE dwells SET samples = x'00' WHERE number = {at}"
    yield lambda at: f"UPDATE dwells SET step = step + 1000 WHERE number = {at}"
    yield lambda at: f"UPDATE events SET monotonic_s = monotonic_s + 1 WHERE sequence = {at}"
    yield lambda at: f"DELETE FROM events WHERE sequence = {at}"
    yield lambda at: f"DELETE FROM dwells WHERE number = {at}"


def test_read_in_any_pieces_a_search_finds_what_a_whole_one_finds(tmp_path: Path) -> None:
    chance = np.random.default_rng(20261130)
    run = _Growing(tmp_path / "run")
    run.commit(30)
    run.journal.close()
    (run.folder / "journal.count").unlink()
    for index, made in enumerate(_damages()):
        folder = Path(shutil.copytree(run.folder, tmp_path / f"damaged-{index}"))
        for at in chance.choice(range(2, 30), 3, replace=False):
            _change(folder, made(int(at)))
        with JournalReader.open(folder) as reader:
            search = reader.new_search()
            for _ in range(60):
                reader.read_on(search, at_most=int(chance.integers(0, 4)))
            reader.read_on(search)
            assert search.damage == reader.damage()
            assert search.damage.names


def test_an_event_that_nobody_can_read_is_named_and_hides_neither_counts_nor_the_other_metrics(tmp_path: Path) -> None:
    whole, bad = make_run(tmp_path / "a", State.FINISHED), make_run(tmp_path / "b", State.FINISHED)
    _change(bad, "UPDATE events SET detail = '}' WHERE sequence = 4")
    first, second = sorted(RunList(tmp_path, verifies=True).read(), key=lambda run: run.path)
    assert (first.path, first.damaged, first.status) == (whole, (), status(whole))
    assert (second.trouble, second.damaged, second.status) == ("", _whole(bad), None)
    assert second.dwells_done == first.dwells_done > 0
    lines = metrics_text(figures_of((first, second))).splitlines()
    assert 'calrig_run_damaged{run="b"} 1' in lines
    assert 'calrig_run_damaged{run="a"} 0' in lines
    assert f'calrig_run_dwells_done{{run="a"}} {first.dwells_done}' in lines
