"""Laws of the list of runs: it tells what each run's own status tells, disturbs none, and no damage hides a run."""

import sqlite3
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from run_folders import STARTED_UTC, make_run, stored_run

from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import add_note
from procedures.journal.sidecar.owner import owning
from procedures.journal.status.run_list import RunList
from procedures.journal.status.status import status
from procedures.records.states import ACTIVE, State
from rig.clock import VirtualClock

LATER = VirtualClock(datetime.now(UTC) + timedelta(days=1))
"""A day on, no journal changed just now."""


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The folders whose journals were opened, in order."""
    paths: list[Path] = []
    original = JournalReader.open

    def open_and_tell(path: Path) -> JournalReader:
        paths.append(path)
        return original(path)

    monkeypatch.setattr(JournalReader, "open", staticmethod(open_and_tell))
    return paths


@pytest.mark.parametrize("state", [State.RUNNING, State.HELD, State.TRIPPED, State.STOPPED, State.FINISHED])
@pytest.mark.parametrize("is_alive", [False, True])
def test_an_entry_tells_what_the_status_of_the_run_tells(state: State, is_alive: bool, tmp_path: Path) -> None:
    run = make_run(tmp_path / "run", state, dwells=20)
    if is_alive:
        with owning(run):
            (listed,), found = RunList(tmp_path).read(), status(run)
    else:
        (listed,), found = RunList(tmp_path).read(), status(run)
    assert (listed.path, listed.state, listed.is_alive, listed.trouble) == (run, found.state, is_alive, "")
    assert (listed.dwells_done, listed.dwells_planned) == (found.dwells_done, found.dwells_planned)
    assert (listed.title, listed.started_utc) == ("title of run", STARTED_UTC)
    assert (listed.state is State.INTERRUPTED) == (state in ACTIVE and not is_alive)


def test_the_latest_start_comes_first_whatever_the_folders_are_called(tmp_path: Path) -> None:
    for name, day in (("b", 2), ("a", 1), ("c", 0)):
        make_run(tmp_path / name, State.FINISHED, started_utc=STARTED_UTC + timedelta(days=day))
    assert [entry.path.name for entry in RunList(tmp_path).read()] == ["b", "a", "c"]


def test_the_latest_is_the_first_of_the_list_that_can_be_read_and_no_other_is_read_to_its_dwells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    days = {"a": 1, "b": 3, "c": 2, "d": 3, "e": 4, "f": 0}
    runs = {name: make_run(tmp_path / name, State.STOPPED, started_utc=STARTED_UTC + timedelta(days=day))
            for name, day in days.items()}  # fmt: skip
    (runs["e"] / "journal.sqlite").write_bytes(b"")
    counted: list[Path] = []
    accepted_steps = JournalReader.accepted_steps

    def count(reader: JournalReader) -> set[int]:
        counted.append(reader.path.parent)
        return accepted_steps(reader)

    monkeypatch.setattr(JournalReader, "accepted_steps", count)
    latest, left_out = RunList(tmp_path).latest()
    assert (latest and latest.path, [run.path for run in left_out]) == (runs["b"], [runs["e"]])
    assert counted == [runs["b"]]
    listed = RunList(tmp_path).read()
    assert (latest, *left_out) == (listed[0], listed[-1])


def test_a_folder_that_is_not_there_or_holds_other_things_holds_no_run(tmp_path: Path) -> None:
    (tmp_path / "notes").mkdir()
    (tmp_path / "archive.sqlite").write_bytes(b"")
    assert RunList(tmp_path).read() == ()
    assert RunList(tmp_path / "nowhere").read() == ()


def test_only_what_changed_is_read_again(tmp_path: Path, opened: list[Path]) -> None:
    runs = [make_run(tmp_path / name, State.STOPPED) for name in ("a", "b", "c")]
    listing = RunList(tmp_path, LATER)
    first = listing.read()
    opened.clear()
    assert listing.read() == first
    assert opened == []
    add_note(runs[1], "anna", "seen")
    opened.clear()
    listing.read()
    assert opened == [runs[1]]


def test_a_journal_that_changed_just_now_is_read_again(tmp_path: Path, opened: list[Path]) -> None:
    """Two commits may share one time stamp, so that the files look the same."""
    run = make_run(tmp_path / "run", State.STOPPED)
    listing = RunList(tmp_path, VirtualClock(datetime.now(UTC)))
    listing.read()
    opened.clear()
    listing.read()
    assert opened == [run]


def test_every_commit_is_seen_though_the_list_was_just_read_and_the_writer_never_waits(tmp_path: Path) -> None:
    header, measured = stored_run()
    run = tmp_path / "run"
    run.mkdir()
    clock, listing = VirtualClock(STARTED_UTC), RunList(tmp_path)
    journal = Journal.create(run / "journal.sqlite", header, clock)
    journal._connection.set_busy_timeout(0)  # a writer that had to wait would fail
    done = []
    for dwell in measured:
        journal.commit_dwell(dwell, clock)
        (listed,) = listing.read()
        done.append(listed.dwells_done)
    journal.close()
    designed = {dwell.step for dwell in header.plan.design_dwells}
    accepted = [dwell.accepted and dwell.step in designed for dwell in measured]
    assert done == list(np.cumsum(accepted))


def test_a_lock_that_comes_and_goes_is_seen_without_reading_the_journal_again(
    tmp_path: Path, opened: list[Path]
) -> None:
    run = make_run(tmp_path / "run", State.RUNNING)
    listing = RunList(tmp_path, LATER)
    assert [entry.state for entry in listing.read()] == [State.INTERRUPTED]
    opened.clear()
    with owning(run):
        assert listing.alive() == (run,)
        assert [entry.state for entry in listing.read()] == [State.RUNNING]
    assert listing.alive() == ()
    assert [entry.state for entry in listing.read()] == [State.INTERRUPTED]
    assert opened == []


@pytest.mark.parametrize("kind", ["empty", "text", "cut", "count"])
def test_a_damaged_journal_is_an_entry_with_a_sentence(kind: str, tmp_path: Path) -> None:
    whole, bad = make_run(tmp_path / "a", State.FINISHED), make_run(tmp_path / "b", State.FINISHED)
    journal = bad / "journal.sqlite"
    content = {"empty": b"", "text": b"not a database at all", "cut": journal.read_bytes()[:5000]}
    if kind == "count":
        (bad / "journal.count").write_text("nonsense", encoding="utf-8")
    else:
        journal.write_bytes(content[kind])
    before = journal.read_bytes()
    good, listed = RunList(tmp_path).read()
    assert (good.path, good.state) == (whole, State.FINISHED)
    assert (listed.path, listed.state, listed.started_utc, listed.title) == (bad, None, None, "")
    assert "journal." in listed.trouble
    assert "Traceback" not in listed.trouble
    assert journal.read_bytes() == before


def test_whatever_byte_rots_the_list_still_tells_of_every_run(tmp_path: Path) -> None:
    """Two hundred journals with a page's worth of other bytes somewhere: each is an entry, none ends the list."""
    chance = np.random.default_rng(20260501)
    journal = make_run(tmp_path / "whole", State.FINISHED) / "journal.sqlite"
    content = journal.read_bytes()
    for number in range(200):
        rotten = bytearray(content)
        location = int(chance.integers(0, len(rotten)))
        width = int(chance.choice([1, 16, 4096]))
        rotten[location : location + width] = chance.bytes(len(rotten[location : location + width]))
        folder = tmp_path / f"rotten-{number:03}"
        folder.mkdir()
        (folder / "journal.sqlite").write_bytes(bytes(rotten))
    listed = RunList(tmp_path).read()
    assert len(listed) == 201
    assert next(entry for entry in listed if entry.path.name == "whole").state is State.FINISHED
    assert all(entry.trouble or entry.state is not None for entry in listed)
    assert any(entry.trouble for entry in listed)


@pytest.mark.parametrize("damage", ["detail = detail || ' '", "monotonic_s = monotonic_s + 1"])
def test_a_list_that_shows_counts_names_the_damage_that_the_status_of_the_run_names(
    damage: str, tmp_path: Path
) -> None:
    whole, bad = make_run(tmp_path / "a", State.FINISHED), make_run(tmp_path / "b", State.FINISHED)
    connection = sqlite3.connect(bad / "journal.sqlite")
    assert connection.execute(f"UPDATE events SET {damage} WHERE sequence = 4").rowcount == 1
    connection.commit()
    connection.close()
    with JournalReader.open(bad) as reader:
        named = reader.damage().names
    listed = {run.path: run for run in RunList(tmp_path, verifies=True).read()}
    assert (listed[whole].damaged, listed[bad].damaged) == ((), named)
    assert named[0].startswith("event 4 (")
    assert listed[bad].to_document()["damaged"] == list(named)
    assert "damaged" not in listed[whole].to_document()
    assert all(run.damaged == () for run in RunList(tmp_path).read()), "what only chooses a run reads less"


def test_a_run_that_is_removed_meanwhile_is_gone_from_the_list(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run", State.FINISHED)
    listing = RunList(tmp_path, LATER)
    listing.read()
    for file in run.iterdir():
        file.unlink()
    assert listing.read() == ()
