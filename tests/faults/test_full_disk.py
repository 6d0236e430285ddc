"""A disk that is really full, for a while or for good, and one that answers with an I/O error.

Whatever refuses, people hear of it, a page says why, and the run goes on when the disk is well again.
"""

import errno
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from command import call
from failing_files import failing_files
from faulty_rig import FaultyRig
from finished_job import FinishedJob
from journals import a_clock
from small_disk import SmallDisk, small_disk
from small_run import Bench, bench, measured_in, resumed
from unattended_run import UnattendedRun, events, run_unattended, states

from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.settings import AlertSettings
from procedures.errors import StorageFailed
from procedures.journal.audit.audit_trail import interruptions_in
from procedures.journal.requests.corrections import add_note
from procedures.journal.sidecar.last_words import read_last_words
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.progress import Progress
from procedures.records.states import RESUMABLE, State
from procedures.run.ending import Outcome
from procedures.run.handover import handover
from procedures.run.resume import resume
from procedures.run.services import RunServices
from rig.abilities.abilities import Burst
from rig.assembly.open_rig import Rig
from rig.local_time import at_both

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
WRITES = "import sys, pathlib; open(sys.argv[1], 'a').write(sys.stdin.read())"
SIZE = "6m"
DELIVERY_SHARES = 4
"""A soak case fails each write of a delivery whose number leaves its share as the rest; all together fail every one."""
FEWEST_WRITES = 60
"""Of a delivery: 68 file calls in its run's folder."""
FEWEST_PRODUCTS = 5
"""Set, exports, page, paper."""
LITTLE_MB = 0.05
"""Of room that a run of 24 dwells asks for beside its own need."""


class Told(UnattendedRun):
    """A run whose people have a command that rings; what it said is kept on another disk."""

    def __init__(self, run_dir: Path, told: Path, **happenings: object) -> None:
        super().__init__(run_dir, **happenings)  # type: ignore[arg-type]
        self._told = told
        settings = AlertSettings(command=(sys.executable, "-c", WRITES, str(told)))
        self.alerts = AlertDispatcher(settings, "night", a_clock(), self)
        self._is_inside = False

    def on_event(self, progress: Progress) -> None:
        if self._is_inside:  # the dispatcher passes on what it heard
            super().on_event(progress)
            return
        self._is_inside = True
        self.alerts.on_event(progress)
        self._is_inside = False

    @property
    def said(self) -> str:
        self.alerts.close()
        return self._told.read_text(encoding="utf-8") if self._told.exists() else ""


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[SmallDisk]:
    with small_disk(tmp_path / "disk", SIZE) as mounted:
        yield mounted


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(
        tmp_path_factory.mktemp("bench"),
        rig=(("[twin]\nseed", f"[interlocks]\nmin_free_mb = {LITTLE_MB}\n[twin]\nseed"),),
    )


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    assert small.run(small.folder / "clean").state is State.FINISHED
    return small.folder / "clean"


def _ran(
    small: Bench, run: Told, second: Path, at_burst: int = 0, happens: Callable[[], None] | None = None
) -> Outcome:
    """Run; something happens to the disk while a channel is read, so that the next write is that of the dwell."""

    def spoil(number: int, burst: Burst) -> Burst:
        if number == at_burst and happens is not None:
            happens()
        return burst

    def around(rig: Rig) -> FaultyRig:
        return FaultyRig(rig, spoil=spoil)

    return run_unattended(small, run, RunServices(pulse=run.alerts.pulse, second_folder=second), around)


def _page_in(*folders: Path) -> str:
    pages = [page for folder in folders for page in folder.rglob("why.txt")]
    assert pages, f"no page in {folders}"
    return pages[0].read_text(encoding="utf-8")


@pytest.mark.parametrize("left_bytes", [0, pytest.param(8192, marks=pytest.mark.soak)])
@pytest.mark.parametrize("at_burst", [40, *[pytest.param(n, marks=pytest.mark.soak) for n in (1, 19, 55, 70, 83)]])
def test_fault_79_a_disk_that_is_full_in_a_dwell_is_told_explained_and_resumed(
    small: Bench, clean: Path, disk: SmallDisk, tmp_path: Path, at_burst: int, left_bytes: int
) -> None:
    run = Told(disk.path / "run", tmp_path / "told.txt")
    outcome = _ran(small, run, tmp_path / "second", at_burst, lambda: disk.fill(left_bytes))
    if outcome.state is State.FINISHED:
        assert left_bytes, "a full disk took everything"
        return
    assert "calrig: night: " in run.said
    assert "full" in run.said
    page = _page_in(tmp_path / "second", disk.path)
    assert "full" in page
    words = read_last_words(run.run_dir, tmp_path / "second")
    assert words is not None
    assert page.splitlines()[0].endswith(": interrupted"), "not what the journal has it doing"
    assert f"when     {at_both(words.stopped_utc, to_the_second=True)}\n" in page, "not when its last state began"
    disk.free()
    assert status(run.run_dir).state in RESUMABLE
    assert resumed(run.run_dir).state is State.FINISHED
    assert measured_in(run.run_dir) == measured_in(clean)


@pytest.mark.soak
def test_fault_03_room_that_somebody_else_takes_between_dwells_holds_the_run_until_there_is_some(
    small: Bench, clean: Path, disk: SmallDisk, tmp_path: Path
) -> None:
    """Nearly full: the journal still takes a line, a night's dwells would not fit."""
    run = Told(
        disk.path / "run",
        tmp_path / "told.txt",
        after={5: lambda _: disk.fill(60_000)},
        at={20: lambda _: disk.free()},
    )
    assert _ran(small, run, tmp_path / "second").state is State.FINISHED
    assert State.HELD in states(run.run_dir)
    assert "held" in run.said
    assert measured_in(run.run_dir) == measured_in(clean)


def test_fault_79_a_disk_that_stays_full_between_dwells_is_told_explained_and_resumed(
    small: Bench, clean: Path, disk: SmallDisk, tmp_path: Path
) -> None:
    """As it was measured: the alert said that the run goes on when there is room, and the process was dead."""
    run = Told(disk.path / "run", tmp_path / "told.txt", after={5: lambda _: disk.fill()})
    outcome = _ran(small, run, tmp_path / "second")
    assert outcome.cause == "storage"
    assert "calrig: night: stopped" in run.said or "calrig: night: interrupted" in run.said
    assert "full" in _page_in(tmp_path / "second")
    disk.free()
    add_note(run.run_dir, "anna", "I make room")
    taken_up = resume(run.run_dir, "tester", services=RunServices(second_folder=tmp_path / "second"))
    assert taken_up.state is State.FINISHED
    assert measured_in(run.run_dir) == measured_in(clean)
    _require_cause_on_record(run.run_dir)


def _require_cause_on_record(run_dir: Path) -> None:
    """The next resume journals what the disk refused, and the stretch begins with the engine's last sign."""
    told = [event for event in events(run_dir, "state") if event.detail["to"] in ("interrupted", "stopped")]
    assert "full" in str(told[0].detail["reason"])
    assert "full" in handover(run_dir)
    (stretch,) = interruptions_in(events(run_dir))
    (note,) = events(run_dir, "note")
    assert stretch.began_utc not in (note.utc, None)
    assert not list(run_dir.parent.rglob("last-words.json"))


@pytest.mark.parametrize(
    "stuck", [pytest.param(False, id="once", marks=pytest.mark.soak), pytest.param(True, id="for good")]
)
@pytest.mark.parametrize("number", [150, *[pytest.param(n, marks=pytest.mark.soak) for n in range(60, 420, 13)]])
@pytest.mark.parametrize("error", [errno.EIO, pytest.param(errno.ENOSPC, marks=pytest.mark.soak)])
def test_fault_05_79_a_disk_that_fails_at_any_write_is_told_explained_and_resumed(
    small: Bench, clean: Path, tmp_path: Path, error: int, number: int, stuck: bool
) -> None:
    run = Told(tmp_path / "run", tmp_path / "told.txt")
    with failing_files(tmp_path / "run", number, error, stuck=stuck) as files:
        outcome = _ran(small, run, tmp_path / "second")
        said = run.said
    assert files.has_failed
    if outcome.state is not State.FINISHED:
        assert "calrig: night: " in said
        assert _page_in(tmp_path / "second", tmp_path / "run")
        assert resumed(run.run_dir).state is State.FINISHED
    assert measured_in(run.run_dir) == measured_in(clean)


@pytest.mark.parametrize("number", [5, 25, *[pytest.param(n, marks=pytest.mark.soak) for n in range(1, 60)]])
@pytest.mark.parametrize("error", [errno.ENOSPC, pytest.param(errno.EIO, marks=pytest.mark.soak)])
def test_fault_79_a_disk_that_refuses_a_run_before_it_moves_is_told(
    small: Bench, clean: Path, tmp_path: Path, error: int, number: int
) -> None:
    """Of the journal or of the plan beside it: nobody was told, since the engine was not there yet."""
    run = Told(tmp_path / "run", tmp_path / "told.txt")
    with failing_files(tmp_path / "run", number, error, stuck=True), suppress(StorageFailed):
        _ran(small, run, tmp_path / "second")
    assert "calrig: night: interrupted" in run.said or "calrig: night: stopped" in run.said
    page, is_there = _page_in(tmp_path / "second", tmp_path / "run"), (run.run_dir / JOURNAL_FILE).exists()
    assert ("begin the run again" in page, "calrig resume" in page) == (not is_there, is_there)
    assert "axes     at rest, read back" in page
    if is_there:
        assert resumed(run.run_dir).state is State.FINISHED
        assert measured_in(run.run_dir) == measured_in(clean)


@pytest.mark.soak
@pytest.mark.usefixtures("no_report")
def test_fault_79_a_delivery_on_a_full_disk_says_what_is_missing_and_is_completed(
    finished_job: FinishedJob, disk: SmallDisk, capsys: pytest.CaptureFixture[str]
) -> None:
    run = finished_job.copied_to(disk.path)
    sets = {path.name: path.read_bytes() for path in (run / "exports").iterdir()}
    for path in (run / "exports").iterdir():
        path.unlink()
    disk.fill()
    told = call(capsys, "solve", run)
    assert told.status == 1
    assert "space" in told.err
    disk.free()
    assert call(capsys, "solve", run).status == 0
    assert {path.name for path in (run / "exports").iterdir()} == sets.keys()


@pytest.mark.thorough
def test_fault_79_a_delivery_whose_nth_write_fails_says_what_is_missing_and_is_completed(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Set, archive, exports, page and paper: nothing half written under its own name, and a sentence for each."""
    assert _delivery_fails(finished_job.copied_to(tmp_path), 12, errno.ENOSPC, capsys, stuck=True)


@pytest.mark.soak
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("share", range(DELIVERY_SHARES))
@pytest.mark.parametrize("stuck", [False, True], ids=["once", "for good"])
@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EIO])
def test_fault_79_every_write_of_a_delivery_fails_once(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str], error: int, stuck: bool, share: int
) -> None:
    run, number = finished_job.copied_to(tmp_path), 1 + share
    while _delivery_fails(run, number, error, capsys, stuck=stuck):
        number += DELIVERY_SHARES
    assert number > FEWEST_WRITES


def _delivery_fails(run: Path, number: int, error: int, capsys: pytest.CaptureFixture[str], *, stuck: bool) -> bool:
    """Deliver a run anew while a write fails, then again; returns whether there were so many writes."""
    names = {path.relative_to(run) for folder in ("exports", "coefficients") for path in (run / folder).iterdir()}
    made = [run / name for name in names] + [run / "report.html", run / "report.pdf"]
    assert len(made) >= FEWEST_PRODUCTS
    for path in made:
        path.unlink()
    with failing_files(run, number, error, stuck=stuck) as files:
        told = call(capsys, "solve", run)
    assert (told.status in (0, 1), "Traceback" in told.err) == (True, False), told.err
    if told.status == 0:  # what was refused is there all the same: a folder that was not synced
        assert all(path.exists() for path in made)
    for path in (run / "exports").iterdir():
        assert call(capsys, "verify", path).status == 0, path
    if files.has_failed:
        assert call(capsys, "solve", run).status == 0
        assert all(path.exists() for path in made)
    return files.has_failed
