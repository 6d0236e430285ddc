"""Journals of past versions are still solved, to the same numbers, and never written to.

``run_v1`` holds the journal of a small run on twins as the first version wrote it, and the set that it solved from it.
``run_v1_repeated`` holds that of a run which was paused and continued, and repeated six dwells that were too noisy.
"""

import json
import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest

from procedures.delivery.deliver import sets_of, solve_run
from procedures.delivery.number_changes import number_changes
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import Authorisation, redo
from procedures.journal.salvage import salvage
from procedures.records.states import State
from procedures.run.resume import resume

DATA = Path(__file__).parents[2] / "data"
RUN_V1 = DATA / "run_v1"
REPEATED = DATA / "run_v1_repeated"
OLD = pytest.mark.parametrize("old", [RUN_V1, REPEATED], ids=lambda old: old.name)


@OLD
def test_the_first_versions_journal_gives_the_same_coefficients(old: Path, tmp_path: Path) -> None:
    """Coefficients to 1e-12 of the scale. Uncertainties may follow better models; they are positive and no wilder.

    Those of two replications that agreed by chance are now at least those of the noise inside them.
    """
    run = Path(shutil.copytree(old, tmp_path / "run"))
    then = json.loads((old / "SN1.json").read_text(encoding="utf-8"))
    now = sets_of(solve_run(run))["SN1"].document
    changed = list(number_changes("SN1", then, now))
    assert [change for change in changed if not change.name.startswith("u(")] == []
    for change in changed:
        assert change.old is not None
        assert change.new is not None
        assert 0.3 < change.new / change.old < 10.0, change


@OLD
def test_the_first_versions_journal_is_read_as_it_is(old: Path, tmp_path: Path) -> None:
    run = Path(shutil.copytree(old, tmp_path / "run"))
    before = (run / "journal.sqlite").read_bytes()
    first, again = (sets_of(solve_run(run))["SN1"].sha256 for _ in range(2))
    assert first == again
    assert (run / "journal.sqlite").read_bytes() == before


def test_the_old_set_follows_from_the_raw_samples_of_the_accepted_dwells_alone() -> None:
    """Nothing of ours between: the blobs by ``sqlite3``, TP (2) in its linear form by ``numpy.linalg.lstsq``."""
    rows, means = _raw(REPEATED / "journal.sqlite")
    then = json.loads((REPEATED / "SN1.json").read_text(encoding="utf-8"))
    for index, axis in enumerate("xyz"):
        values = then["axes"][axis]["primary"]["values"]
        found = np.linalg.lstsq(rows, means[:, index], rcond=None)[0]
        scale = sum(abs(value) for value in values.values())
        np.testing.assert_allclose(found, list(values.values()), rtol=0, atol=1e-12 * scale)


def _raw(journal: Path) -> tuple[np.ndarray, np.ndarray]:
    """(K, 4) rows (1, f) and (K, 3) means in volts of the accepted dwells of the design."""
    connection = sqlite3.connect(f"file:{journal}?immutable=1", uri=True)
    dwells = connection.execute("SELECT record, samples FROM dwells WHERE accepted = 1 ORDER BY number").fetchall()
    connection.close()
    rows, means = [], []
    for text, blob in dwells:
        record = json.loads(text)
        if record["purpose"] != "design":
            continue
        alpha, roll = (np.radians(record["measured_deg"][name]) for name in ("pitch", "roll"))
        rows.append([1.0, np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)])
        means.append(np.frombuffer(blob, dtype="<f8").reshape(3, -1).mean(axis=1))
    assert len(rows) == 24
    return np.array(rows), np.array(means)


def test_the_repeats_and_the_pause_of_an_old_run_are_read(tmp_path: Path) -> None:
    with JournalReader.open(Path(shutil.copytree(REPEATED, tmp_path / "run"))) as reader:
        reader.verify()
        rejected = [dwell for dwell in reader.dwells() if not dwell.accepted]
        states = [event.detail["to"] for event in reader.events("state")]
    assert len(rejected) == 6
    assert all(dwell.reasons for dwell in rejected)
    assert "paused" in states


def test_fault_11_an_old_run_is_redone_by_adding_to_its_journal_and_nothing_of_it_is_rewritten(tmp_path: Path) -> None:
    """An older calrig's journal needs no migration: dwells and events that it wrote stay byte for byte."""
    run = Path(shutil.copytree(REPEATED, tmp_path / "run"))
    before = _rows(run / "journal.sqlite")
    assert redo(run, 2, Authorisation("anna", "the table was bumped")) > 0
    assert resume(run, "carla").state is State.FINISHED
    after = _rows(run / "journal.sqlite")
    assert {name: rows[: len(before[name])] for name, rows in after.items()} == before
    with JournalReader.open(run) as reader:
        reader.verify()
    assert solve_run(run).sensors["SN1"].failure is None


def _rows(journal: Path) -> dict[str, list[tuple[object, ...]]]:
    connection = sqlite3.connect(f"file:{journal}?immutable=1", uri=True)
    found = {name: connection.execute(f"SELECT * FROM {name}").fetchall() for name in ("header", "events", "dwells")}
    connection.close()
    return found


def test_fault_11_an_old_run_is_salvaged_whole(tmp_path: Path) -> None:
    before = (REPEATED / "journal.sqlite").read_bytes()
    found = salvage(Path(shutil.copytree(REPEATED, tmp_path / "run")), tmp_path / "saved")
    assert (found.dwells, found.quarantined) == (39, ())
    assert (tmp_path / "run" / "journal.sqlite").read_bytes() == before


def test_fault_11_a_finished_old_run_is_not_resumed_and_left_as_it_is(tmp_path: Path) -> None:
    run = Path(shutil.copytree(REPEATED, tmp_path / "run"))
    with pytest.raises(RequestError, match="the run is finished"):
        resume(run, "carla")
    assert (run / "journal.sqlite").read_bytes() == (REPEATED / "journal.sqlite").read_bytes()
