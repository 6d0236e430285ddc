"""Folders of runs without a rig: each with the journal of a small run, as far as it came and in any state."""

import shutil
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from procedures.journal.header import RunHeader
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from rig.clock import VirtualClock

STORED = Path(__file__).parents[1] / "data" / "run_v1"
STARTED_UTC = datetime(2026, 5, 1, 18, 0, tzinfo=UTC)


@cache
def stored_run() -> tuple[RunHeader, tuple[DwellRecord, ...]]:
    """Header and dwells of the run that lies with the tests, read from a copy of it."""
    with TemporaryDirectory() as scratch:
        copy = Path(shutil.copytree(STORED, Path(scratch) / "run"))
        with JournalReader.open(copy) as reader:
            return reader.header, tuple(reader.dwells())


def make_run(folder: Path, state: State, *, started_utc: datetime = STARTED_UTC, dwells: int = 9) -> Path:
    """A run of which ``dwells`` were committed; nobody runs it."""
    header, measured = stored_run()
    folder.mkdir(parents=True)
    clock = VirtualClock(started_utc)
    begun = replace(header, run_id=folder.name, title=f"title of {folder.name}", created_utc=started_utc)
    journal = Journal.create(folder / "journal.sqlite", begun, clock)
    for dwell in measured[:dwells]:
        journal.commit_dwell(dwell, clock)
    journal.append_event("state", {"to": state, "by": "tester", "reason": ""}, clock)
    journal.close()
    return folder
