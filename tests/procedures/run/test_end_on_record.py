"""When the engine says that a run's end is on record: what its stop guard takes for a goodbye hangs on it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from small_run import StopAt, bench

from ams.errors import WriteFailed
from procedures.errors import StorageFailed
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar import kept_beside
from procedures.journal.sidecar.last_words import read_last_words
from procedures.records.states import ACTIVE, State
from procedures.run import stop_page
from procedures.run.services import RunServices
from rig.clock import Clock


class Record:
    """What stood on record whenever the engine said that the end does."""

    def __init__(self, run_dir: Path) -> None:
        self.run_dir = run_dir
        self.found: list[tuple[State, bool, bool]] = []
        """State in the journal; whether there are last words; whether there is a page."""

    def look(self) -> None:
        with JournalReader.open(self.run_dir) as reader:
            state = reader.state()
        has_words = read_last_words(self.run_dir, None) is not None
        self.found.append((state, has_words, (self.run_dir / stop_page.PAGE).exists()))


@pytest.fixture
def record(tmp_path: Path) -> Record:
    return Record(tmp_path / "run")


def _run(record: Record, folder: Path, **collaborators: object) -> None:
    bench(folder).run(record.run_dir, services=RunServices(ended=record.look), **collaborators)


def _journal_refuses_the_end(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    append_event = Journal.append_event

    def append(journal: Journal, kind: str, detail: Mapping[str, Any], clock: Clock) -> None:
        if kind == "state" and detail["to"] not in ACTIVE:
            raise error
        append_event(journal, kind, detail, clock)

    monkeypatch.setattr(Journal, "append_event", append)


@pytest.mark.parametrize(("dwells", "state"), [(None, State.FINISHED), (3, State.STOPPED)])
def test_an_end_is_on_record_once_it_is_in_the_journal(
    record: Record, tmp_path: Path, dwells: int | None, state: State
) -> None:
    observer = {} if dwells is None else {"observer": StopAt(record.run_dir, dwells)}
    _run(record, tmp_path, **observer)
    assert record.found == [(state, False, False)]


def test_a_defect_of_ours_is_on_record_with_its_page(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def commit(_journal: Journal, *_arguments: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(Journal, "commit_dwell", commit)
    with pytest.raises(ZeroDivisionError):
        _run(record, tmp_path)
    assert record.found == [(State.FAILED, False, True)]


def test_last_words_are_a_record_where_the_disk_refuses_the_journal(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _journal_refuses_the_end(monkeypatch, StorageFailed("disk full"))
    _run(record, tmp_path)
    assert record.found == [(State.RUNNING, True, True)]


def test_where_neither_is_taken_nothing_is_on_record(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(_path: Path, _content: bytes) -> None:
        raise WriteFailed("disk full")

    _journal_refuses_the_end(monkeypatch, StorageFailed("disk full"))
    monkeypatch.setattr(kept_beside, "write_whole", refused)
    _run(record, tmp_path)
    assert record.found == []


def test_an_end_that_memory_refuses_is_not_on_record(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _journal_refuses_the_end(monkeypatch, MemoryError())
    with pytest.raises(MemoryError):
        _run(record, tmp_path)
    assert record.found == []


def test_an_end_whose_page_is_due_and_cannot_be_made_is_not_on_record(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(_folder: Path) -> None:
        raise OSError(24, "Too many open files")

    _journal_refuses_the_end(monkeypatch, StorageFailed("Too many open files"))
    monkeypatch.setattr(stop_page, "page_environment", refused)
    with pytest.raises(OSError, match="Too many open files"):
        _run(record, tmp_path)
    assert record.found == []
