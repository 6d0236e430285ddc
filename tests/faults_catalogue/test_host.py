"""Catalogue 4.1: host, process, storage. Each entry of FAULTS 1 to 20 that is not tested beside its own code."""

import os
import signal
from collections.abc import Callable
from pathlib import Path
from threading import Event

import pytest
from case_shares import rest_to_thorough
from faulty_rig import FaultyRig
from journals import a_clock
from small_run import Bench, bench, dwells_of, in_child, measured, resumed
from unattended_run import UnattendedRun, events, run_unattended

from ams.whole_file import write_whole
from procedures.cli.locations import new_run_folder
from procedures.delivery.deliver import solve_run
from procedures.errors import ExitStatus, JournalError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.salvage import salvage
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE, SCHEMA_VERSION
from procedures.records.states import State
from procedures.run.resume import resume
from procedures.run.watch.process_health import growth
from rig.abilities.abilities import Axis, Burst
from rig.assembly.open_rig import Rig, open_rig
from rig.crash_points import VARIABLE, CrashPoint
from rig.errors import DeviceFault
from rig.motion.move import stop_all


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    assert small.run(small.folder / "clean").state is State.FINISHED
    return small.folder / "clean"


@pytest.mark.parametrize(
    "point",
    rest_to_thorough([CrashPoint.MOVE_SENT, CrashPoint.BEFORE_COMMIT, CrashPoint.AFTER_COMMIT], every=3, first=1),
)
def test_fault_01_a_killed_process_loses_no_acknowledged_dwell_and_measures_none_twice(
    small: Bench, clean: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, point: CrashPoint
) -> None:
    """Detected: the journal says the run is active, and no process holds its lock.
    Response: `interrupted`; resume stops the axes, homes, measures the check set, goes on with the first missing dwell.
    """

    def work() -> object:
        os.environ[VARIABLE] = f"{point}:20"
        return small.run(tmp_path / "run")

    child = in_child(work)
    _, status_word = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status_word)
    before = measured(dwells_of(tmp_path / "run"))
    assert status(tmp_path / "run").state is State.INTERRUPTED
    assert solve_run(tmp_path / "run").record.state == State.INTERRUPTED, "a dead run is never shown as running"
    assert resumed(tmp_path / "run").state is State.FINISHED
    after = measured(dwells_of(tmp_path / "run"))
    assert before.items() <= after.items()
    assert after == measured(dwells_of(clean))


def _version_of(run_dir: Path, version: int) -> Path:
    """The journal of a run with another version written into its head (SQLite file format, offset 60)."""
    path = run_dir / JOURNAL_FILE
    content = bytearray(path.read_bytes())
    assert int.from_bytes(content[60:64], "big") == SCHEMA_VERSION
    content[60:64] = version.to_bytes(4, "big")
    path.write_bytes(content)
    return path


def test_fault_11_a_journal_of_another_version_is_never_converted_in_place(small: Bench, tmp_path: Path) -> None:
    """Detected: the version in the journal's head.
    Response: refused by name of both versions and left as it is; there is one version so far, and nothing to migrate.
    """
    small.run(tmp_path / "run")
    path = _version_of(tmp_path / "run", 0)
    before = path.read_bytes()
    for attempt in (
        lambda: resume(tmp_path / "run", "carla"),
        lambda: salvage(tmp_path / "run", tmp_path / "new"),
        lambda: JournalReader.open(tmp_path / "run"),
    ):
        with pytest.raises(JournalError, match=f"journal version: got 0, this calrig reads {SCHEMA_VERSION}"):
            attempt()
    assert path.read_bytes() == before


@pytest.mark.parametrize("dies_at", ["fsync", "replace"])
@pytest.mark.parametrize("is_there", [False, True])
def test_fault_12_a_file_is_complete_or_as_it_was_when_its_writer_is_killed(
    tmp_path: Path, dies_at: str, is_there: bool
) -> None:
    """Detected: a final name is given only after the content is synced; every set and export carries its checksum.
    Response: what a killed writer leaves is a hidden partial file that nobody reads, gone with the next write.
    """
    path = tmp_path / "set.json"
    if is_there:
        write_whole(path, b"before")

    def work() -> object:
        setattr(os, dies_at, lambda *_: os.kill(os.getpid(), signal.SIGKILL))
        return write_whole(path, b"after" * 100_000)

    os.waitpid(in_child(work), 0)
    assert path.exists() == is_there
    assert not is_there or path.read_bytes() == b"before"
    assert not [other for other in tmp_path.glob("*") if other != path and not other.name.startswith(".")]
    write_whole(path, b"again")
    assert list(tmp_path.iterdir()) == [path]


def test_fault_14_the_local_time_zone_never_orders_or_names_anything(
    small: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Detected: nothing to detect: every stamp is UTC with its offset, every order is the journal's own number.
    Response: none needed.
    """
    clock = a_clock()
    assert clock.now_utc().isoformat() == "2026-03-29T00:59:30+00:00", "half a minute before Europe's clocks go on"
    monkeypatch.setenv("TZ", "Europe/Berlin")
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended)
    assert outcome.state is State.FINISHED
    stamps = [dwell.started_utc for dwell in dwells_of(unattended.run_dir)]
    assert stamps == sorted(stamps)
    assert all(str(stamp.utcoffset()) == "0:00:00" for stamp in stamps)
    names = []
    for _ in range(3):
        names.append(new_run_folder(tmp_path / "runs", "night", clock.now_utc()).name)
        clock.sleep(3600.0)
    assert names == sorted(set(names))


def test_fault_16_a_starved_host_changes_no_sample(small: Bench, clean: Path, tmp_path: Path) -> None:
    """Detected: the meter times its own samples, a stream is held against its counter and the host's stamps.
    Response: none for a meter: a slow host waits longer between bursts; a gap in a stream is listed or voids the dwell.
    """

    class Starved(FaultyRig):
        def __init__(self, rig: Rig) -> None:
            super().__init__(rig, spoil=self._slow)

        def _slow(self, number: int, burst: Burst) -> Burst:
            if number % 5 == 0:
                self._rig.clock.sleep(25.0)
            return burst

    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(small, unattended, rig_of=Starved).state is State.FINISHED
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))
    intervals = {reading.interval_s for dwell in dwells_of(unattended.run_dir) for reading in dwell.readings.values()}
    assert len(intervals) == 1


def test_fault_17_a_process_that_grows_ends_its_run_in_time_and_a_fresh_one_goes_on(
    small: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Detected: memory, open files and threads of the process, every hundred dwells, in the journal.
    Response: far above its first look the run stops after the dwell and says so; resume goes on in a fresh process.
    """
    monkeypatch.setattr("procedures.run.context.PROCESS_EVERY", 5)
    looks = iter([{"open_files": 10.0, "threads": 1.0}, {"open_files": 600.0, "threads": 1.0}])
    monkeypatch.setattr("procedures.run.context.process_figures", lambda: next(looks, {"open_files": 10.0}))
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended)
    assert (outcome.state, outcome.exit_status) == (State.STOPPED, ExitStatus.FAILED)
    assert "this process has grown: open_files from 10 to 600, allowed 500 more" in outcome.reason
    assert f"calrig resume {unattended.run_dir} goes on" in (unattended.run_dir / "why.txt").read_text(encoding="utf-8")
    assert [event.detail["open_files"] for event in events(unattended.run_dir, "process")] == [10.0, 600.0]
    assert resumed(unattended.run_dir).state is State.FINISHED


def test_fault_17_what_is_stable_never_ends_a_run() -> None:
    assert growth({"resident_mb": 120.0, "threads": 4.0}, {"resident_mb": 400.0, "threads": 9.0}) == ""
    assert "resident_mb from 120 to 1300" in growth({"resident_mb": 120.0}, {"resident_mb": 1300.0})


OFTEN = ("axis.state", "axis.start_move", "axis.check_target", "meter.read", "chamber.temperature_degc")
ONCE = ("axis.home", "meter.prepare")


@pytest.mark.parametrize(
    ("method", "nth"), [*((name, nth) for name in OFTEN for nth in (1, 7)), *((name, 1) for name in ONCE)]
)
def test_fault_18_an_exception_in_any_driver_method_stops_the_axes_and_is_journalled(
    small: Bench, tmp_path: Path, method: str, nth: int
) -> None:
    """Detected: one rim around everything that the engine does.
    Response: axes stopped and seen at rest, traceback in the journal, `failed`, a page that says why.
    """
    kept: list[FaultyRig] = []

    def broken(rig: Rig) -> FaultyRig:
        wrong = FaultyRig(rig)
        device, name = method.split(".")
        target = {"axis": wrong.pitch, "meter": wrong.meter, "chamber": rig.environments["air"]}[device]
        monkey = _raises_at(nth, getattr(target, name))
        setattr(target, name, monkey)
        kept.append(wrong)
        return wrong

    unattended = UnattendedRun(tmp_path / "run")
    with pytest.raises(ZeroDivisionError):
        run_unattended(small, unattended, rig_of=broken)
    assert status(unattended.run_dir).state is State.FAILED
    (defect,) = events(unattended.run_dir, "defect")
    assert "ZeroDivisionError: of ours" in str(defect.detail["traceback"])
    (safe,) = events(unattended.run_dir, "safe")
    assert safe.sequence < events(unattended.run_dir)[-1].sequence
    assert kept[0].pitch.stops == 1
    assert "a defect of calrig" in (unattended.run_dir / "why.txt").read_text(encoding="utf-8")


def _raises_at(nth: int, method: Callable[..., object]) -> Callable[..., object]:
    calls = iter(range(1, 10**9))

    def wrapped(*arguments: object, **named: object) -> object:
        if next(calls) == nth:
            raise ZeroDivisionError("of ours")
        return method(*arguments, **named)

    return wrapped


class _Hangs:
    """An axis whose stop never returns; all else is another axis'."""

    def __init__(self, axis: Axis, released: Event) -> None:
        self._axis, self._released = axis, released
        self.name = axis.name

    def stop(self) -> None:
        self._released.wait(20.0)
        raise DeviceFault("too late to matter")


def test_fault_20_stuck_a_stop_that_hangs_keeps_no_other_axis_from_its_stop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Detected: every stop has a thread and a deadline of its own.
    Response: all are attempted; what did not answer is named, and the run is tripped, also where it was aborted.
    """
    monkeypatch.setattr("rig.motion.move._ALLOWANCE_S", 0.05)
    released = Event()
    slow = bench(tmp_path, rig=(("speed_dps = 180.0", "speed_dps = 20.0"),))
    with open_rig(slow.rig) as rig:
        for axis in rig.axes.values():
            axis.home()
        rig.clock.sleep(60.0)
        for axis in rig.axes.values():
            axis.start_move(90.0)
        rig.clock.sleep(2.0)
        hung: Axis = _Hangs(rig.axes["pitch"], released)  # type: ignore[assignment]
        with pytest.raises(DeviceFault, match=r"pitch: no answer within 2\.55 s, or no memory to ask"):
            stop_all({"pitch": hung, "roll": rig.axes["roll"]}, rig.clock, limit_s=2.5)
        released.set()
        assert not rig.axes["roll"].state().is_moving
        assert 0.0 < rig.axes["roll"].state().position_deg < 90.0
