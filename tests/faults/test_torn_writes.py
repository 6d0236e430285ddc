"""Power cuts: whatever subset of the writes that were not synced has reached the disk, the journal is an intact prefix
of what was measured, and nothing that was acknowledged is missing."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from journals import HEADER, a_clock, a_dwell, journal_with
from torn_disk import Image, Operation, Sync, Write, image_at, recorded

from procedures.errors import JournalError
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.storage import JOURNAL_FILE

pytestmark = pytest.mark.timeout(600)
DWELLS = 24


@dataclass(frozen=True)
class Recording:
    operations: Sequence[Operation]
    sha256: Sequence[str]
    """Of every dwell, in the order of commitment."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A journal made, filled, closed, opened again, filled and closed, with checkpoints in between."""
    folder, clock = tmp_path_factory.mktemp("disk"), a_clock()
    messages: list[str] = []
    with recorded(folder, checkpoint_pages=40) as recorder:
        journal = Journal.create(folder / JOURNAL_FILE, HEADER, clock)
        for step in range(DWELLS):
            if step == DWELLS // 2:
                journal.close()
                journal = Journal.open_for_append(folder / JOURNAL_FILE)
            clock.sleep(1.0)
            journal.append_event("intent", {"step": step}, clock)
            messages.append(journal.commit_dwell(a_dwell(step, samples=150), clock).sha256)
            recorder.acknowledge(len(messages))
        journal.close()
    written = [operation for operation in recorder.operations if isinstance(operation, Write)]
    checkpointed = [entry for entry in written if entry.file == JOURNAL_FILE]
    assert len(checkpointed) > 40, "checkpoints happened"
    assert sum(isinstance(operation, Sync) for operation in recorder.operations) > 2 * DWELLS, "every commit is synced"
    return Recording(recorder.operations, messages)


def _require_intact_prefix(image: Image, folder: Path, recording: Recording) -> int:
    image.write_to(folder)
    if JOURNAL_FILE not in image.files:
        assert image.acknowledged == 0, "the journal is gone"
        return 0
    with JournalReader.open(folder) as reader:
        reader.verify()
        found = [dwell.sha256 for dwell in reader.dwells()]
    assert found == list(recording.sha256[: len(found)])
    assert len(found) >= image.acknowledged
    return len(found)


def _goes_on(folder: Path, held: int) -> None:
    """A resume appends where the image ends."""
    clock = a_clock()
    journal = Journal.open_for_append(folder / JOURNAL_FILE)
    journal.commit_dwell(a_dwell(1000), clock)
    journal.close()
    with JournalReader.open(folder) as reader:
        reader.verify()
        assert reader.committed_dwells() == held + 1


def _images(recording: Recording, folder: Path, images: int, seed: int) -> None:
    chance, most = np.random.default_rng(seed), len(recording.operations)
    for number in range(images):
        moment = int(chance.integers(1, most + 1))
        image = image_at(recording.operations, moment, chance)
        held = _require_intact_prefix(image, folder / f"image-{number}", recording)
        if number % 10 == 0 and JOURNAL_FILE in image.files:
            _goes_on(folder / f"image-{number}", held)


def test_fault_02_two_hundred_torn_disks_hold_an_intact_prefix(recording: Recording, tmp_path: Path) -> None:
    _images(recording, tmp_path, 200, seed=1)


@pytest.mark.parametrize("left", [b"", bytes(128)])
def test_fault_02_a_count_whose_content_never_reached_the_disk_promises_nothing(tmp_path: Path, left: bytes) -> None:
    """Its name is on the disk, its only sector is not: the journal beside it is whole and is read.

    Detected: WAL checksums of SQLite, a SHA-256 for every dwell, the count beside the journal.
    Response: the intact prefix is kept; the dwell in progress is measured again after homing.
    """
    whole = journal_with(tmp_path / JOURNAL_FILE, 3)
    whole.with_name("journal.count").write_bytes(left)
    with JournalReader.open(whole) as reader:
        reader.verify()
        assert reader.committed_dwells() == 3


@pytest.mark.soak
def test_fault_02_two_thousand_torn_disks_hold_an_intact_prefix(recording: Recording, tmp_path: Path) -> None:
    _images(recording, tmp_path, 2000, seed=2)


@pytest.mark.soak
def test_fault_02_the_disk_after_every_single_write_holds_an_intact_prefix(
    recording: Recording, tmp_path: Path
) -> None:
    for moment in range(1, len(recording.operations) + 1):
        _require_intact_prefix(image_at(recording.operations, moment), tmp_path / f"moment-{moment}", recording)


def test_a_disk_that_forgets_synced_writes_is_caught(recording: Recording, tmp_path: Path) -> None:
    """The harness itself: without the syncs of the journal, dwells that were acknowledged are missed."""
    forgetful = [
        operation
        for operation in recording.operations
        if not (isinstance(operation, Sync) and operation.file.endswith("-wal"))
    ]
    chance, caught = np.random.default_rng(3), 0
    for number in range(20):
        image = image_at(forgetful, len(forgetful) // 2, chance)
        try:
            _require_intact_prefix(image, tmp_path / f"image-{number}", recording)
        except (AssertionError, JournalError):
            caught += 1
    assert caught > 10
