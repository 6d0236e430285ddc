"""The journal: what is acknowledged is there, what is there is as it was written, and damage is told by name."""

import hashlib
import json
import os
import resource
import shutil
import sqlite3
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import apsw
import numpy as np
import pytest
from journals import HEADER, a_clock, a_dwell, journal_with, with_overload
from small_run import in_child

from procedures.errors import ExitStatus, JournalError, StorageFailed
from procedures.journal.encoding import decode_dwell, encode_dwell
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from rig.clock import SystemClock


def _journal(folder: Path) -> Journal:
    return Journal.create(folder / "journal.sqlite", HEADER, a_clock())


def _query(path: Path, query: str) -> list[tuple[object, ...]]:
    """As somebody with another library reads the file."""
    connection = sqlite3.connect(path)
    try:
        return connection.execute(query).fetchall()
    finally:
        connection.close()


def _change(path: Path, query: str, bindings: tuple[object, ...] = ()) -> None:
    connection = sqlite3.connect(path)
    connection.execute(query, bindings)
    connection.commit()
    connection.close()


def test_a_dwell_comes_back_bit_by_bit(tmp_path: Path) -> None:
    written = _journal(tmp_path).commit_dwell(with_overload(a_dwell(3, accepted=False)), a_clock())
    with JournalReader.open(tmp_path) as reader:
        (read,) = reader.dwells()
    assert encode_dwell(read) == encode_dwell(written)
    assert read.sha256 == written.sha256
    assert list(read.targets_deg) == ["roll", "pitch"]
    assert np.isnan(read.readings["dmm.x"].samples[3])


def _of_units(units: Mapping[str, str]) -> DwellRecord:
    """A dwell whose readings are in these units, by channel."""
    record = a_dwell(3)
    first = record.readings["dmm.x"]
    readings = {name: replace(first, channel=name, unit=unit) for name, unit in units.items()}
    return replace(record, readings=readings)


@pytest.mark.parametrize(
    "units",
    [{"dmm.x": "v"}, {"dmm.x": "v", "imu.gx": "dps", "imu.mx": "ut", "board.ax": "counts"}, {"imu.taken_s": "s"}],
    ids=lambda units: "-".join(units.values()),
)
def test_a_reading_says_its_unit_through_the_journal_and_back(tmp_path: Path, units: dict[str, str]) -> None:
    _journal(tmp_path).commit_dwell(_of_units(units), a_clock())
    with JournalReader.open(tmp_path) as reader:
        (read,) = reader.dwells()
    assert {name: reading.unit for name, reading in read.readings.items()} == units


def test_volts_are_stored_as_they_always_were() -> None:
    text, _ = encode_dwell(a_dwell(3))
    assert "units" not in json.loads(text)


def test_a_dwell_that_was_stored_without_units_takes_them_from_the_rig() -> None:
    text, samples = encode_dwell(_of_units({"dmm.x": "v", "imu.gx": "v", "axes.pitch.angle_deg": "v"}))
    read = decode_dwell(text, samples, "", lambda: {"imu.gx": "dps"})
    assert [reading.unit for reading in read.readings.values()] == ["v", "dps", "deg"]


def test_the_hash_of_a_dwell_is_that_of_its_stored_text_and_samples(tmp_path: Path) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 1)
    ((text, samples, digest),) = _query(path, "SELECT record, samples, sha256 FROM dwells")
    assert isinstance(text, str)
    assert isinstance(samples, bytes)
    assert hashlib.sha256(text.encode() + b"\0" + samples).hexdigest() == digest
    assert len(samples) == 3 * 20 * 8
    assert json.loads(text)["measured_deg"] == {"roll": -180.0, "pitch": 10.0001}


def test_rejected_dwells_are_kept_with_their_reason(tmp_path: Path) -> None:
    journal, clock = _journal(tmp_path), a_clock()
    journal.commit_dwell(a_dwell(0, accepted=False), clock)
    journal.commit_dwell(a_dwell(0, attempt=2), clock)
    with JournalReader.open(tmp_path) as reader:
        assert [dwell.reasons for dwell in reader.dwells()] == [("dmm.x: noise: …",), ()]
        assert [dwell.attempt for dwell in reader.dwells(accepted_only=True)] == [2]
        assert reader.accepted_steps() == {0}


def test_a_dwell_without_samples_has_everything_else(tmp_path: Path) -> None:
    _journal(tmp_path).commit_dwell(a_dwell(4), a_clock())
    with JournalReader.open(tmp_path) as reader:
        (dwell,) = reader.dwells(with_samples=False)
    assert (dwell.readings, dwell.point) == ({}, 5)


def test_committing_the_same_dwell_twice_stores_it_once(tmp_path: Path) -> None:
    journal, clock = _journal(tmp_path), a_clock()
    assert journal.commit_dwell(a_dwell(), clock).sha256 == journal.commit_dwell(a_dwell(), clock).sha256
    with JournalReader.open(tmp_path) as reader:
        assert reader.committed_dwells() == 1
        assert len(list(reader.events("dwell"))) == 1


def test_a_stored_dwell_is_never_changed(tmp_path: Path) -> None:
    journal, clock = _journal(tmp_path), a_clock()
    journal.commit_dwell(a_dwell(), clock)
    with pytest.raises(JournalError, match="step 0, attempt 1, epoch 1 is stored already, with other content"):
        journal.commit_dwell(a_dwell(samples=19), clock)


def test_events_are_chained_from_the_header_on(tmp_path: Path) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 3)
    ((previous,),) = _query(path, "SELECT sha256 FROM header")
    for sequence, utc, monotonic_s, kind, detail, digest in _query(path, "SELECT * FROM events ORDER BY sequence"):
        line = json.dumps(
            [previous, sequence, utc, monotonic_s, kind, detail], ensure_ascii=False, separators=(",", ":")
        )
        assert hashlib.sha256(line.encode()).hexdigest() == digest
        previous = digest


def test_a_journal_is_taken_up_where_it_ended(tmp_path: Path) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 2)
    journal = Journal.open_for_append(path)
    journal.commit_dwell(a_dwell(2), a_clock())
    journal.close()
    with JournalReader.open(path) as reader:
        reader.verify()
        assert [dwell.step for dwell in reader.dwells()] == [0, 1, 2]
        assert reader.state() is State.PLANNED
        assert reader.header == HEADER


def test_a_journal_is_never_in_rollback_mode(tmp_path: Path) -> None:
    """Bytes 18 and 19 of an SQLite file are 2 for WAL, 1 for rollback (sqlite.org/fileformat2.html, 1.3). A kill in
    rollback mode leaves a hot journal, which no read-only reader can open."""
    path = tmp_path / "journal.sqlite"
    journal = _journal(tmp_path)
    assert path.read_bytes()[18:20] == b"\2\2"
    journal.close()
    assert path.read_bytes()[18:20] == b"\2\2"
    Journal.open_for_append(path).close()
    assert path.read_bytes()[18:20] == b"\2\2"


def test_a_closed_journal_is_one_plain_file(tmp_path: Path) -> None:
    journal_with(tmp_path / "journal.sqlite", 2)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["journal.count", "journal.sqlite"]


def test_a_reader_does_not_hinder_the_writer_and_sees_what_is_committed(tmp_path: Path) -> None:
    journal, clock = _journal(tmp_path), a_clock()
    journal.commit_dwell(a_dwell(0), clock)
    with JournalReader.open(tmp_path) as reader:
        rows = reader.dwells()
        assert next(rows).step == 0
        journal.commit_dwell(a_dwell(1), clock)
        assert reader.committed_dwells() == 2
        journal.close()
        assert len(list(reader.dwells())) == 2
    with JournalReader.open(tmp_path) as reader:
        reader.verify()


def test_a_reader_cannot_write(tmp_path: Path) -> None:
    _journal(tmp_path)
    with JournalReader.open(tmp_path) as reader, pytest.raises(apsw.ReadOnlyError):
        reader._connection.execute("DELETE FROM events")


def test_the_content_has_one_hash_whether_the_log_is_folded_in_or_not(tmp_path: Path) -> None:
    journal, clock = _journal(tmp_path), a_clock()
    for step in range(3):
        journal.commit_dwell(a_dwell(step), clock)
    with JournalReader.open(tmp_path) as reader:
        before = reader.sha256_of_content()
    journal.close()
    with JournalReader.open(tmp_path) as reader:
        assert reader.sha256_of_content() == before


def test_a_new_journal_never_replaces_one(tmp_path: Path) -> None:
    journal_with(tmp_path / "journal.sqlite", 1)
    with pytest.raises(JournalError, match="exists already"):
        _journal(tmp_path)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "has zero length"),
        (b"x,y\n1,2\n", "is not a journal"),
        (b"SQLite format 3", "is truncated after 15 bytes"),
        (b"SQLite format 3\0", "truncated or damaged|not a whole journal"),
    ],
)
def test_what_is_no_journal_is_told(tmp_path: Path, content: bytes, expected: str) -> None:
    path = tmp_path / "journal.sqlite"
    path.write_bytes(content)
    for opened in (JournalReader.open, Journal.open_for_append):
        with pytest.raises(JournalError, match=expected):
            opened(path)
    assert path.read_bytes() == content


def test_a_missing_journal_is_told(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match=r"journal\.sqlite: cannot be read: No such file"):
        JournalReader.open(tmp_path)


def test_another_programs_database_is_told(tmp_path: Path) -> None:
    _change(tmp_path / "journal.sqlite", "CREATE TABLE header (id)")
    with pytest.raises(JournalError, match="not a journal of calrig"):
        JournalReader.open(tmp_path)


def test_a_newer_version_is_read_by_nobody(tmp_path: Path) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 1)
    _change(path, "PRAGMA user_version = 99")
    before = path.read_bytes()
    for opened in (JournalReader.open, Journal.open_for_append):
        with pytest.raises(JournalError, match="journal version: got 99, this calrig reads 1"):
            opened(path)
    assert path.read_bytes() == before


@pytest.mark.parametrize("kept", [0.1, 0.5, 0.9, 0.999])
def test_a_truncated_journal_is_told_and_left(tmp_path: Path, kept: float) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 30)
    content = path.read_bytes()[: int(path.stat().st_size * kept)]
    path.write_bytes(content)
    with pytest.raises(JournalError, match=r"journal\.sqlite: "), JournalReader.open(path) as reader:
        reader.verify()
    with pytest.raises(JournalError):
        Journal.open_for_append(path)
    assert path.read_bytes() == content


def test_a_lost_write_ahead_log_is_noticed(tmp_path: Path) -> None:
    journal, clock = _journal(tmp_path), a_clock()
    for step in range(5):
        journal.commit_dwell(a_dwell(step), clock)
    copy = tmp_path / "copy"
    copy.mkdir()
    for name in ("journal.sqlite", "journal.count"):
        shutil.copy(tmp_path / name, copy)
    with pytest.raises(JournalError, match="holds 0 dwells and 1 events, but 5 and 6 were committed; its file journal"):
        JournalReader.open(copy)
    shutil.copy(tmp_path / "journal.sqlite-wal", copy)
    with JournalReader.open(copy) as reader:
        reader.verify()
        assert reader.committed_dwells() == 5


def test_a_flipped_bit_in_the_samples_names_the_dwell(tmp_path: Path) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 5)
    samples = a_dwell(3).readings["dmm.x"].samples.tobytes()
    flipped = bytes(byte ^ (0x10 if index == 17 else 0) for index, byte in enumerate(samples))
    content = path.read_bytes()
    assert samples in content
    path.write_bytes(content.replace(samples, flipped))  # wherever it lies: pages that were split leave a copy behind
    text = "the dwell of step 3, attempt 1, epoch 1 is not as it was written"
    with JournalReader.open(path) as reader, pytest.raises(JournalError, match=text):
        reader.verify()


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("UPDATE dwells SET record = replace(record, '10.0001', '10.0002') WHERE step = 1", "dwell of step 1"),
        ("UPDATE dwells SET accepted = 0 WHERE step = 2", "dwell of step 2.*filed under another key"),
        ("DELETE FROM dwells WHERE step = 1", "3 dwells were committed, 2 are there"),
        ("DELETE FROM events WHERE sequence = 3", "event 3 is missing"),
        (
            "UPDATE events SET detail = '{\"step\":9}' WHERE sequence = 4",
            r"event 4 \(intent\) is not as it was written",
        ),
        ("UPDATE header SET document = replace(document, 'tester', 'nobody')", "the header is not as it was written"),
    ],
)
def test_a_changed_record_is_noticed(tmp_path: Path, change: str, expected: str) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 3)
    _change(path, change)
    (tmp_path / "journal.count").unlink()
    with pytest.raises(JournalError, match=expected), JournalReader.open(path) as reader:
        reader.verify()


def test_a_forged_dwell_with_a_matching_hash_breaks_the_chain(tmp_path: Path) -> None:
    path = journal_with(tmp_path / "journal.sqlite", 2)
    text, samples = encode_dwell(a_dwell(1, samples=18))
    digest = hashlib.sha256(text.encode() + b"\0" + samples).hexdigest()
    _change(path, "UPDATE dwells SET record = ?, samples = ?, sha256 = ? WHERE step = 1", (text, samples, digest))
    with JournalReader.open(path) as reader, pytest.raises(JournalError, match="dwell of step 1"):
        reader.verify()


def _fill_a_limited_disk(folder: Path) -> None:
    """FAULTS f3: RLIMIT_FSIZE gives an I/O error in the middle of a commit."""
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, 150_000))
    journal, acknowledged = _journal(folder), 0
    try:
        for step in range(1000):
            journal.commit_dwell(a_dwell(step), a_clock())
            acknowledged += 1
    except StorageFailed as error:
        (folder / "told.json").write_text(json.dumps([acknowledged, str(error), int(error.exit_status)]))


def test_a_full_disk_is_one_clear_error_and_loses_nothing_acknowledged(tmp_path: Path) -> None:
    _, status = os.waitpid(in_child(lambda: _fill_a_limited_disk(tmp_path)), 0)
    assert status == 0
    acknowledged, file, exit_status = json.loads((tmp_path / "told.json").read_text())
    assert "cannot be written" in file
    assert "everything committed before is intact" in file
    assert exit_status == ExitStatus.FAILED
    with JournalReader.open(tmp_path) as reader:
        reader.verify()
        assert reader.committed_dwells() == acknowledged > 5
    journal = Journal.open_for_append(tmp_path / "journal.sqlite")
    journal.commit_dwell(a_dwell(acknowledged), a_clock())


def test_a_folder_that_is_not_there_is_a_clear_error(tmp_path: Path) -> None:
    with pytest.raises(StorageFailed, match="cannot be written"):
        _journal(tmp_path / "missing")


@pytest.mark.soak
def test_a_commit_takes_under_two_milliseconds(tmp_path: Path) -> None:
    journal, rig_clock, clock = _journal(tmp_path), a_clock(), SystemClock()
    took_s = []
    for step in range(300):
        record, began_s = a_dwell(step), clock.monotonic_s()
        journal.commit_dwell(record, rig_clock)
        took_s.append(clock.monotonic_s() - began_s)
    assert float(np.median(took_s)) < 2e-3
