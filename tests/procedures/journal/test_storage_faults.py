"""Disks and files: damaged, full, gone, on a network; nothing is repaired in place, nothing damaged is used."""

import hashlib
import json
import os
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from journals import a_clock, journal_with
from small_run import Bench, bench, dwells_of, measured, resumed
from unattended_run import UnattendedRun, events, run_unattended
from without_times import without_times

from ams.calibration.together.in_step_hidden import SAME_ORDER
from procedures.delivery.deliver import SolvedRun, sensors_document, solve_run
from procedures.errors import ExitStatus, JournalError, RequestError, StorageFailed
from procedures.journal.emergency import UNSAVED_FILE, EmergencyCopy, emergency_copy
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.location import file_system, require_local
from procedures.journal.requests.corrections import Authorisation, redo
from procedures.journal.salvage import salvage
from procedures.journal.sidecar.last_words import STORAGE
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.services import RunServices

MOUNTS = """\
22 1 0:21 / / rw,relatime - ext4 /dev/vda rw
30 22 0:40 / /mnt/lab\\040share rw,relatime shared:5 - cifs //server/share rw,vers=3.0
31 22 0:41 / /home rw,relatime - nfs4 server:/home rw
32 31 0:42 / /home/anna/local rw,relatime - xfs /dev/vdb rw
"""


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    assert small.run(small.folder / "clean").state is State.FINISHED
    return small.folder / "clean"


def _files(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.glob("journal*")}


def _damaged(clean: Path, folder: Path, steps: tuple[int, ...]) -> Path:
    """A copy of a whole run with the samples of some dwells turned round on the disk."""
    folder.mkdir()
    content = (clean / JOURNAL_FILE).read_bytes()
    for dwell in dwells_of(clean):
        if dwell.step in steps:
            samples = dwell.readings["dmm.y"].samples.tobytes()
            content = content.replace(samples, samples[::-1])
    (folder / JOURNAL_FILE).write_bytes(content)
    return folder


def test_fault_06_a_damaged_dwell_is_quarantined_by_name_and_never_solved_with(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    """Detected: a SHA-256 for every dwell, chained in the audit trail, checked at open and at solve.
    Response: told as damaged, neither solved nor resumed: salvage leaves it out by name, a resume measures it again.
    """
    folder = _damaged(clean, tmp_path / "rotten", (10, 20))
    with JournalReader.open(folder) as reader:
        assert reader.damage().names == ("step 10, attempt 1, epoch 1", "step 20, attempt 1, epoch 1")
        left = {dwell.step for dwell in reader.dwells(accepted_only=True)}
        rotten = {dwell.step: dwell.reasons for dwell in reader.dwells() if not dwell.accepted}
    assert left == {dwell.step for dwell in small.plan.dwells} - {10, 20}
    assert rotten.keys() == {10, 20}
    assert rotten[10] == ("quarantined: it is not as it was written (SHA-256 differs)",)
    with pytest.raises(JournalError, match=r"dwell of step 10, .* is not as it was written .*calrig salvage"):
        solve_run(folder)


_LOW_ORDER = ("quadratic", "cubic", "asymmetry", "cross-coupling")


def _whatever_the_order(run: SolvedRun) -> dict[str, Any]:
    """Return what is told of the sensors but for the test of what was before a dwell, which is another one now.

    That the journal was salvaged is left out as well, among findings and warnings, and that the order repeats.
    The terms of low order are tested beside it, so their p-values move with it; whether they are significant does not.
    """
    document = without_times(json.loads(json.dumps(sensors_document(run))))
    for sensor in document.values():
        for axis in sensor["axes"].values():
            axis["findings"] = [
                {name: entry[name] for name in ("kind", "text", "significant")}
                if entry["kind"] in _LOW_ORDER
                else entry
                for entry in axis["findings"]
                if "previous attitude" not in entry["text"] and entry["kind"] != "record-lost"
            ]
            axis["warnings"] = _but_for_the_salvage(axis["warnings"])
            axis["remarks"] = [text for text in axis["remarks"] if not text.startswith(SAME_ORDER)]
    return document


def _but_for_the_salvage(warnings: list[str]) -> list[str]:
    return [text for text in warnings if not text.startswith("the journal was damaged and salvaged")]


def test_fault_06_a_quarantined_dwell_is_measured_again_after_salvage_and_the_numbers_are_those_of_the_clean_run(
    clean: Path, tmp_path: Path
) -> None:
    folder = _damaged(clean, tmp_path / "rotten", (10, 20))
    before = _files(folder)
    found = salvage(folder, tmp_path / "saved")
    assert _files(folder) == before
    assert found.quarantined == ("step 10, attempt 1, epoch 1", "step 20, attempt 1, epoch 1")
    with JournalReader.open(tmp_path / "saved") as reader:
        reader.verify()
        assert reader.quarantined() == found.quarantined
        assert reader.state() is State.STOPPED
    assert resumed(tmp_path / "saved").state is State.FINISHED
    assert measured(dwells_of(tmp_path / "saved")) == measured(dwells_of(clean))
    assert _whatever_the_order(solve_run(tmp_path / "saved")) == _whatever_the_order(solve_run(clean))


def test_fault_06_redo_takes_nothing_back_in_a_damaged_journal_and_does_in_the_salvaged_one(
    clean: Path, tmp_path: Path
) -> None:
    folder = _damaged(clean, tmp_path / "rotten", (10,))
    authorisation = Authorisation("anna", "damaged on the disk")
    with pytest.raises(JournalError, match=r"dwell of step 10, .* calrig salvage takes the rest into a new folder"):
        redo(folder, 1, authorisation)
    salvage(folder, tmp_path / "saved")
    assert redo(tmp_path / "saved", 1, authorisation) > 0
    assert resumed(tmp_path / "saved").state is State.FINISHED
    assert {dwell.attempt for dwell in dwells_of(tmp_path / "saved") if dwell.accepted and dwell.replication == 1} <= {
        1,
        2,
    }
    assert solve_run(tmp_path / "saved").sensors["SN1"].failure is None


@pytest.mark.parametrize("length", [0.3, 0.6, 0.9])
def test_fault_07_a_truncated_journal_gives_an_intact_prefix_in_a_new_file(tmp_path: Path, length: float) -> None:
    """Detected: head, quick check, chain of events, SHA-256 of every dwell.
    Response: told as damaged and left untouched; salvage takes what is provably intact into a new file, of the
    audit trail all but the damaged lines themselves, which it names; what they took back stays taken back.
    """
    whole = journal_with(tmp_path / JOURNAL_FILE, 30)
    with JournalReader.open(whole) as reader:
        kept = {dwell.step: dwell.sha256 for dwell in reader.dwells()}
    torn = tmp_path / "torn"
    torn.mkdir()
    content = whole.read_bytes()
    (torn / JOURNAL_FILE).write_bytes(content[: int(length * len(content))])
    before = _files(torn)
    found = salvage(torn, tmp_path / "saved")
    assert _files(torn) == before
    with JournalReader.open(tmp_path / "saved") as reader:
        reader.verify()
        dwells = {dwell.step: dwell.sha256 for dwell in reader.dwells()}
    assert dwells.items() <= kept.items()
    assert found.dwells == len(dwells)


def test_fault_07_random_damage_never_brings_a_wrong_dwell_through(tmp_path: Path) -> None:
    import numpy as np

    whole = journal_with(tmp_path / JOURNAL_FILE, 20)
    with JournalReader.open(whole) as reader:
        kept = {dwell.step: dwell.sha256 for dwell in reader.dwells()}
    content, chance, saved = whole.read_bytes(), np.random.default_rng(3), 0
    for number in range(40):
        torn = tmp_path / f"torn-{number}"
        torn.mkdir()
        page = 4096 * int(chance.integers(1, len(content) // 4096))
        rubbish = chance.bytes(int(chance.integers(1, 3000)))
        (torn / JOURNAL_FILE).write_bytes(content[:page] + rubbish + content[page + len(rubbish) :])
        try:
            salvage(torn, tmp_path / f"saved-{number}")
        except JournalError:
            continue
        with JournalReader.open(tmp_path / f"saved-{number}") as reader:
            reader.verify()
            found = {dwell.step: dwell.sha256 for dwell in reader.dwells()}
        assert found.items() <= kept.items()
        saved += len(found)
    assert saved > 200, "most of the dwells survive most of the damage"


def test_fault_07_salvage_never_writes_over_a_journal(tmp_path: Path) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, 3)
    with pytest.raises(JournalError, match="exists already; nothing was written"):
        salvage(whole, tmp_path)


def test_fault_08_a_journal_without_its_wal_keeps_what_is_there_and_says_what_is_lost(tmp_path: Path) -> None:
    """Detected: a count of committed dwells and events beside the journal.
    Response: refused; says how many are missing; salvage takes what is there.
    """
    whole = journal_with(tmp_path / JOURNAL_FILE, 5)
    count = whole.with_name("journal.count")
    count.write_text(count.read_text().replace('"events": 11', '"events": 19').replace('"dwells": 5', '"dwells": 9'))
    with pytest.raises(JournalError, match="holds 5 dwells and 11 events, but 9 and 19 were committed"):
        JournalReader.open(whole)
    found = salvage(whole, tmp_path / "saved")
    assert (found.dwells, found.events, found.events_promised) == (5, 11, 19)


def test_fault_04_a_disk_that_turns_read_only_leaves_a_copy_in_the_second_place(
    small: Bench, clean: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The n-th commit of a dwell is refused as a read-only file system refuses it.

    Detected: the system's refusal of a write.
    Response: stopped; what is intact and the dwell that found no room go to a second place; resume goes on.
    """
    import apsw

    commit, commits = Journal.commit_dwell, 0

    def refused(journal: Journal, *arguments: object) -> object:
        nonlocal commits
        commits += 1
        if commits == 15:
            from procedures.journal.storage import storage_errors_of

            with storage_errors_of(journal.path):
                raise apsw.ReadOnlyError("attempt to write a readonly database")
        return commit(journal, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Journal, "commit_dwell", refused)
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, RunServices(second_folder=tmp_path / "second"))
    assert (outcome.state, outcome.exit_status) == (State.STOPPED, ExitStatus.FAILED)
    assert "attempt to write a readonly database" in outcome.reason
    assert f"copied to {tmp_path / 'second' / 'run'} (14 dwells" in outcome.reason
    with JournalReader.open(tmp_path / "second" / "run") as reader:
        reader.verify()
        assert [dwell.step for dwell in reader.dwells()] == list(range(14))
    assert '\\"step\\":14' in (tmp_path / "second" / "run" / UNSAVED_FILE).read_text()
    monkeypatch.setattr(Journal, "commit_dwell", commit)
    assert resumed(unattended.run_dir).state is State.FINISHED
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))


def test_fault_04_a_second_place_that_fails_as_well_is_told(clean: Path, tmp_path: Path) -> None:
    location = tmp_path / "a-file"
    location.write_text("")
    with closing(Journal.open_for_append(clean / JOURNAL_FILE)) as journal:
        copy = emergency_copy(journal, location, STORAGE, None, a_clock())
    assert copy.words.startswith(f"; no copy could be made in {location}")
    assert copy.folder is None


def test_fault_05_a_sync_that_fails_is_not_believed(tmp_path: Path, small: Bench) -> None:
    """EIO of a commit ends the process' use of the journal: the next one verifies all of it before it appends.

    Detected: the return code of the sync.
    Response: the journal counts as failed: stopped, never tried again and believed; resume verifies everything.
    """
    folder = tmp_path / "run"

    class Stops:
        def on_event(self, progress: Progress) -> None:
            if progress.event == "dwell" and progress.dwells_done == 3:
                Journal.append_event = broken  # type: ignore[method-assign]

    append = Journal.append_event

    def broken(journal: Journal, *arguments: object) -> None:
        import apsw

        from procedures.journal.storage import storage_errors_of

        with storage_errors_of(journal.path):
            raise apsw.IOError("disk I/O error")

    try:
        outcome = small.run(folder, observer=Stops())
    finally:
        Journal.append_event = append  # type: ignore[method-assign]
    assert (outcome.state, outcome.exit_status) == (State.INTERRUPTED, ExitStatus.FAILED)
    assert resumed(folder).state is State.FINISHED


@pytest.mark.parametrize(
    ("folder", "kind"),
    [("/mnt/lab share/runs", "cifs"), ("/home/anna/runs", "nfs4"), ("/home/anna/local/runs", "xfs"), ("/srv", "ext4")],
)
def test_fault_09_the_file_system_of_a_folder_is_that_of_the_innermost_mount(
    tmp_path: Path, folder: str, kind: str
) -> None:
    mounts = tmp_path / "mountinfo"
    mounts.write_text(MOUNTS)
    assert file_system(Path(folder), mounts) == kind


def test_fault_09_a_network_folder_is_refused(tmp_path: Path) -> None:
    mounts = tmp_path / "mountinfo"
    mounts.write_text(MOUNTS)
    with pytest.raises(RequestError, match=r"network file system \(cifs\).*--allow-network-folder"):
        require_local(Path("/mnt/lab share/runs"), mounts)
    require_local(Path("/srv/runs"), mounts)


@pytest.mark.parametrize("name", ["Dropbox", "OneDrive - Laboratory", "Google Drive", "Nextcloud"])
def test_fault_09_a_synchronised_folder_is_refused_by_its_name(tmp_path: Path, name: str) -> None:
    with pytest.raises(RequestError, match="kept by a synchroniser"):
        require_local(tmp_path / name / "runs")


def test_fault_09_a_synchronised_folder_is_refused_by_what_lies_in_it(tmp_path: Path) -> None:
    (tmp_path / "shared" / ".stfolder").mkdir(parents=True)
    with pytest.raises(RequestError, match="shared is kept by a synchroniser"):
        require_local(tmp_path / "shared" / "runs")
    require_local(tmp_path / "runs")


def test_fault_10_a_journal_of_a_newer_version_is_read_by_nobody_and_left_as_it_is(tmp_path: Path) -> None:
    """Detected: the version in the journal's head.
    Response: refused by name of both versions; read by nobody, left as it is.
    """
    import apsw

    whole = journal_with(tmp_path / JOURNAL_FILE, 2)
    connection = apsw.Connection(str(whole))
    connection.execute("PRAGMA user_version = 99")
    connection.close()
    before = whole.read_bytes()
    with pytest.raises(JournalError, match="journal version: got 99, this calrig reads 1"):
        JournalReader.open(whole)
    with pytest.raises(JournalError, match="journal version: got 99"):
        salvage(whole, tmp_path / "saved")
    assert whole.read_bytes() == before


def test_the_process_is_looked_at_every_hundred_dwells(tmp_path: Path) -> None:
    long = bench(tmp_path, procedure=(("replications = 2", "replications = 9"),))
    long.run(tmp_path / "run")
    (figures,) = events(tmp_path / "run", "process")
    assert set(figures.detail) == {"threads", "resident_mb", "open_files"}
    assert 10.0 < float(str(figures.detail["resident_mb"])) < 4000.0
    assert int(str(figures.detail["open_files"])) < len(os.listdir("/proc/self/fd")) + 50


def test_a_copy_is_made_when_people_know_and_the_axes_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bad disk may take its time over the copy: nothing waits for it."""

    def refuse(journal: Journal, *_: object) -> None:
        raise StorageFailed(f"{journal.path}: cannot be written: no space left on device")

    seen: list[tuple[State, list[bool]]] = []

    def copy(*_: object) -> EmergencyCopy:
        seen.append((run.heard[-1].state, [axis.state().is_moving for axis in run.rig.axes.values()]))
        return EmergencyCopy("; copied elsewhere")

    run = UnattendedRun(tmp_path / "run", after={3: lambda _: monkeypatch.setattr(Journal, "append_event", refuse)})
    monkeypatch.setattr("procedures.run.progress_log.emergency_copy", copy)
    outcome = run_unattended(bench(tmp_path), run, RunServices(second_folder=tmp_path / "second"))
    assert seen == [(State.STOPPED, [False, False])]
    assert "; copied elsewhere" in outcome.reason
