"""An engine keeps of an accepted dwell what later ones are judged by, and no samples: those are in the journal."""

import gc
import weakref
from pathlib import Path
from typing import Any

import pytest
from small_run import bench

from procedures.journal.journal import Journal
from procedures.records.dwells import DwellRecord
from rig.clock import Clock


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many dwells had samples in memory after each commit, check sets and visits left out."""
    committed: list[list[weakref.ref[Any]]] = []
    alive: list[int] = []
    original = Journal.commit_dwell

    def commit_and_count(journal: Journal, record: DwellRecord, clock: Clock) -> DwellRecord:
        if record.purpose == "design":
            committed.append([weakref.ref(reading.samples) for reading in record.readings.values()])
        stored = original(journal, record, clock)
        gc.collect()
        alive.append(sum(any(samples() is not None for samples in dwell) for dwell in committed))
        return stored

    monkeypatch.setattr(Journal, "commit_dwell", commit_and_count)
    return alive


def test_samples_of_dwells_that_are_committed_are_not_kept(tmp_path: Path, held: list[int]) -> None:
    small = bench(tmp_path)
    small.run(tmp_path / "run")
    assert len(held) >= len(small.plan.design_dwells)
    assert max(held) <= 2, "the one that is committed, and the one before it"
