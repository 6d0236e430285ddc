"""A journal of any size that another hand empties or writes over in place loses no dwell that was committed."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from journals import HEADER, a_clock, a_dwell

from procedures.errors import JournalReplaced
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.kept_rows import KeptRows
from procedures.journal.storage import JOURNAL_FILE

SAMPLES = 3000
"""A channel: longer than a page, so that SQLite reads them out of the file and not out of its memory."""
LOG = JOURNAL_FILE + "-wal"


def _zeros(path: Path) -> None:
    with open(path, "r+b") as file:
        file.write(bytes(path.stat().st_size))


HANDS: dict[str, Callable[[Path], None]] = {
    "emptied": lambda folder: os.truncate(folder / JOURNAL_FILE, 0),
    "emptied, its log too": lambda folder: [os.truncate(folder / name, 0) for name in (JOURNAL_FILE, LOG)] and None,
    "written over": lambda folder: _zeros(folder / JOURNAL_FILE),
    "removed": lambda folder: (folder / JOURNAL_FILE).unlink(),
}


def _committed(journal: Journal, first: int, count: int) -> None:
    for step in range(first, first + count):
        journal.commit_dwell(a_dwell(step, samples=SAMPLES), a_clock())


@pytest.mark.parametrize("hand", HANDS)
@pytest.mark.parametrize("is_reopened", [False, True])
def test_every_dwell_with_long_samples_is_saved(tmp_path: Path, hand: str, *, is_reopened: bool) -> None:
    """5.8 MB: 41 of 100 such dwells were left where the connection's memory was what they were taken out of."""
    folder = tmp_path / "run"
    folder.mkdir()
    journal = Journal.create(folder / JOURNAL_FILE, HEADER, a_clock())
    _committed(journal, 0, 40)
    if is_reopened:
        journal.close()
        journal = Journal.open_for_append(folder / JOURNAL_FILE)
    _committed(journal, 40, 40)
    HANDS[hand](folder)
    with pytest.raises(JournalReplaced):
        journal.require_as_written()
    found = journal.salvage_into(tmp_path / "copy", a_clock())
    assert (found.dwells, found.quarantined, found.events) == (80, (), 81)
    assert journal.has_dwell(a_dwell(79))
    with JournalReader.open(tmp_path / "copy") as reader:
        reader.verify()
        assert [dwell.step for dwell in reader.dwells()] == list(range(80))


def test_where_the_disk_of_temporary_files_is_full_the_run_goes_on_and_the_copy_names_what_it_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = KeptRows.__init__

    def small(kept: KeptRows) -> None:
        made(kept)
        kept.connections[1].execute("PRAGMA max_page_count = 200")

    monkeypatch.setattr(KeptRows, "__init__", small)
    for hand in ("removed", "emptied"):
        folder = tmp_path / hand
        folder.mkdir()
        journal = Journal.create(folder / JOURNAL_FILE, HEADER, a_clock())
        _committed(journal, 0, 80)
        HANDS[hand](folder)
        found = journal.salvage_into(tmp_path / f"copy of {hand}", a_clock())
        assert found.dwells + len(found.quarantined) == 80
        assert (found.dwells == 80) is (hand == "removed")
        assert found.dwells > 0


def test_a_closed_journal_leaves_no_file_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SQLITE_TMPDIR", str(tmp_path))
    kept = KeptRows()
    kept.add([], [(n, n, 1, 1, 1, "text", bytes(100_000), "sum") for n in range(100)])
    assert list(tmp_path.iterdir()) == [], "it has no name from the first moment"
    kept.close()
