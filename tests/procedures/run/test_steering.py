"""Requests and signals: taken within a slice, journalled, never in the middle of a commit or of the safe stop."""

import json
import os
import signal
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from journals import a_clock
from small_run import bench, dwells_of, in_child, measured_in, resumed
from unattended_run import events

from procedures.cli.run.stopping import stoppable_wait
from procedures.errors import RequestError, StorageFailed
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Request, Spool, Taken, ask
from procedures.journal.status.status import status
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.resume import resume
from procedures.run.steering import Steering, signals_steer
from rig.clock import ScaledClock, SystemClock
from rig.errors import WaitEnded

pytestmark = pytest.mark.usefixtures("terminal_signals")

NOON = "2026-03-01T12:00:00+00:00"


def _request(kind: str, text: str = "") -> Request:
    return Request(kind, "anna", NOON, text)  # type: ignore[arg-type]


def test_a_request_comes_out_of_the_spool_as_it_went_in(tmp_path: Path) -> None:
    spool = Spool(tmp_path)
    spool.submit(_request("note", "Türe offen <b>\n"))
    (taken,) = Spool(tmp_path).take()
    assert taken.request == _request("note", "Türe offen <b>\n")
    spool.remove(taken)
    assert list(spool.folder.iterdir()) == []


def test_requests_that_arrive_one_after_the_other_are_all_taken(tmp_path: Path) -> None:
    """Also those that share one tick of the file system's clock with the look before."""
    spool, engine = Spool(tmp_path), Spool(tmp_path)
    for number in range(200):
        spool.submit(_request("note", str(number)))
        (taken,) = engine.take()
        assert taken.request is not None
        assert taken.request.text == str(number)
        engine.remove(taken)
        assert engine.take() == []


def test_two_changes_that_share_one_time_stamp_are_both_seen(tmp_path: Path) -> None:
    spool, engine = Spool(tmp_path), Spool(tmp_path)
    spool.folder.mkdir()
    stamp_ns = int(SystemClock().now_utc().timestamp() * 1e9)
    os.utime(spool.folder, ns=(stamp_ns, stamp_ns))
    assert engine.take() == []
    spool.submit(_request("stop"))
    os.utime(spool.folder, ns=(stamp_ns, stamp_ns))
    assert len(engine.take()) == 1


def test_a_quiet_folder_costs_one_stat(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spool = Spool(tmp_path)
    spool.folder.mkdir()
    os.utime(spool.folder, (1e9, 1e9))
    assert spool.take() == []
    monkeypatch.setattr(os, "listdir", lambda _: pytest.fail("read a folder that did not change"))
    assert spool.take() == []


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b'{"kind": "abort"}', b'{"kind": "format", "by": "x", "at_utc": "y"}', b"\xff\xfe", b"[" * 60000,
     b'{"kind": "stop", "by": 7, "at_utc": "y"}', b"x" * 70_000],
)  # fmt: skip
def test_a_file_that_is_no_request_is_told_and_removed(tmp_path: Path, content: bytes) -> None:
    spool = Spool(tmp_path)
    spool.folder.mkdir()
    (spool.folder / "x.json").write_bytes(content)
    messages: list[Taken] = []
    steering = Steering(spool, a_clock(), a_clock(), messages.append)
    steering(1.0)
    assert messages[0].complaint.startswith("not a request")
    json.dumps(dict(messages[0].detail()), allow_nan=False)
    assert list(spool.folder.iterdir()) == []


def test_half_written_requests_are_not_looked_at(tmp_path: Path) -> None:
    spool = Spool(tmp_path)
    spool.folder.mkdir()
    (spool.folder / "x.partial").write_text('{"kind": "ab')
    assert spool.take() == []


def test_an_abort_ends_a_wait_within_a_slice(tmp_path: Path) -> None:
    clock = ScaledClock(1000.0)
    spool = Spool(tmp_path)
    steering = Steering(spool, clock, SystemClock(), lambda _: None)
    spool.submit(_request("abort"))
    began_s = clock.monotonic_s()
    with pytest.raises(WaitEnded, match="abort, asked for by anna"):
        steering(1e6)
    assert clock.monotonic_s() - began_s < 2.0 * clock.slice_s


def test_stop_and_pause_do_not_end_a_wait(tmp_path: Path) -> None:
    spool, clock = Spool(tmp_path), a_clock()
    steering = Steering(spool, clock, clock, lambda _: None)
    for kind in ("pause", "stop"):
        spool.submit(_request(kind))
    steering(5.0)
    assert clock.monotonic_s() == pytest.approx(5.0)
    assert steering.pause is not None
    assert steering.stop is not None


def test_the_first_interrupt_is_a_stop_the_second_an_abort(tmp_path: Path) -> None:
    clock, found = a_clock(), []
    steering = Steering(Spool(tmp_path), clock, clock, found.append)
    with signals_steer(steering):
        os.kill(os.getpid(), signal.SIGINT)
        steering(1.0)
        assert steering.stop is not None
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(WaitEnded, match="signal SIGINT"):
            steering(1.0)
    assert [taken.request.kind for taken in found] == ["stop", "abort"]


def test_a_termination_is_a_stop_that_does_not_wait_for_the_dwell(tmp_path: Path) -> None:
    clock = a_clock()
    steering = Steering(Spool(tmp_path), clock, clock, lambda _: None)
    with signals_steer(steering):
        os.kill(os.getpid(), signal.SIGTERM)
        with pytest.raises(WaitEnded, match="SIGTERM"):
            steering(0.0)
    assert steering.at_once is not None
    assert (steering.at_once.state, steering.at_once.by) == (State.STOPPED, "signal SIGTERM")
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


def test_a_quit_is_an_abort(tmp_path: Path) -> None:
    clock = a_clock()
    steering = Steering(Spool(tmp_path), clock, clock, lambda _: None)
    with signals_steer(steering):
        os.kill(os.getpid(), signal.SIGQUIT)
        with pytest.raises(WaitEnded, match="SIGQUIT"):
            steering(0.0)
    assert steering.at_once is not None
    assert steering.at_once.state is State.ABORTED


def test_a_closed_terminal_ends_nothing_and_is_told_once(tmp_path: Path) -> None:
    clock, found = a_clock(), []
    steering = Steering(Spool(tmp_path), clock, clock, lambda _: None, hung_up=lambda: found.append("closed"))
    with signals_steer(steering):
        os.kill(os.getpid(), signal.SIGHUP)
        steering(1.0)
        steering(1.0)
    assert found == ["closed"]
    assert (steering.stop, steering.abort) == (None, None)


def test_a_signal_that_was_ignored_stays_ignored(tmp_path: Path) -> None:
    """As under ``nohup``."""
    clock = a_clock()
    steering = Steering(Spool(tmp_path), clock, clock, lambda _: None)
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with signals_steer(steering):
            os.kill(os.getpid(), signal.SIGHUP)
            steering(1.0)
    finally:
        signal.signal(signal.SIGHUP, before)
    assert steering.stop is None


@pytest.mark.parametrize("number", [signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU])
@pytest.mark.parametrize("where", ["run", "jog"])
def test_nothing_freezes_a_process_that_watches_axes(tmp_path: Path, number: signal.Signals, where: str) -> None:
    """Ctrl-Z, and reads and writes from the background: ignored by the system, whatever group the process is in."""
    clock, before = a_clock(), signal.getsignal(number)
    steering = Steering(Spool(tmp_path), clock, clock, lambda _: None)
    with signals_steer(steering) if where == "run" else stoppable_wait(clock):
        assert signal.getsignal(number) is signal.SIG_IGN
        os.kill(os.getpid(), number)
    assert signal.getsignal(number) is before


def test_what_was_asked_since_this_process_owns_the_run_is_obeyed(tmp_path: Path) -> None:
    """A stop that `calrig stop` acknowledged while the run was being taken up must stop it."""
    clock, found = a_clock(), []
    spool = Spool(tmp_path)
    steering = Steering(spool, clock, clock, found.append)
    owned = datetime.fromisoformat(NOON)
    spool.submit(Request("pause", "anna", (owned - timedelta(seconds=1)).isoformat()))
    spool.submit(Request("stop", "anna", (owned + timedelta(seconds=1)).isoformat()))
    steering.discard_pending(owned)
    assert steering.pause is None
    assert steering.stop is not None
    assert [taken.complaint for taken in found] == ["asked of the process before this one", ""]


class Signalling:
    """Sends itself signals after so many dwells."""

    def __init__(self, *numbers: signal.Signals) -> None:
        self._numbers = numbers

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done == 4:
            for number in self._numbers:
                os.kill(os.getpid(), number)


@pytest.mark.parametrize(
    ("numbers", "state"),
    [
        ([signal.SIGINT], State.STOPPED),
        pytest.param([signal.SIGINT] * 2, State.ABORTED, marks=pytest.mark.thorough),
        ([signal.SIGINT] * 11, State.ABORTED),
        pytest.param([signal.SIGTERM], State.STOPPED, marks=pytest.mark.thorough),
        pytest.param([signal.SIGQUIT], State.ABORTED, marks=pytest.mark.thorough),
        ([signal.SIGHUP], State.FINISHED),
        ([signal.SIGINT, signal.SIGTERM, signal.SIGHUP], State.STOPPED),
    ],
)
def test_fault_19_signals_never_skip_the_last_line(tmp_path: Path, numbers: list[signal.Signals], state: State) -> None:
    """FAULTS 19: once, twice, eleven times; the same handler gets them all, so a burst before one look is one abort.

    Two interrupts before one look may be one signal to the kernel; then the first is a stop.
    """
    small, run_dir = bench(tmp_path), tmp_path / "run"
    _, exit_status = os.waitpid(in_child(lambda: small.run(run_dir, observer=Signalling(*numbers))), 0)
    assert exit_status == 0
    assert status(run_dir).state is state
    with JournalReader.open(run_dir) as reader:
        last = reader.last_event()
        assert last is not None
        assert last.detail["to"] == state
    if state is State.FINISHED:
        assert "terminal" in {event.kind for event in events(run_dir)}
    else:
        assert str(last.detail["by"]).startswith("signal SIG")
        assert len([dwell for dwell in dwells_of(run_dir) if dwell.purpose == "design"]) == 4
        assert resumed(run_dir).state is State.FINISHED


def test_a_run_is_steered_from_another_process(tmp_path: Path) -> None:
    """Pause, status, continue and stop of a run in real time, all by way of files."""
    small, run_dir = bench(tmp_path, rig=(("seed = 7", "seed = 7\ntime = 60.0"),)), tmp_path / "run"
    child, clock = in_child(lambda: small.run(run_dir)), SystemClock()
    try:
        _until(run_dir, State.RUNNING)
        ask(run_dir, "pause", "anna", clock.now_utc())
        _until(run_dir, State.PAUSED)
        paused = status(run_dir)
        assert paused.eta_utc is None
        assert paused.to_document()["state"] == "paused"
        ask(run_dir, "continue", "anna", clock.now_utc())
        _until(run_dir, State.RUNNING)
        assert status(run_dir).eta_utc is not None
        ask(run_dir, "stop", "bert", clock.now_utc(), "enough")
        _until(run_dir, State.STOPPED)
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    assert status(run_dir).dwells_done < len(small.plan.design_dwells)


def _until(run_dir: Path, state: State) -> None:
    """Look until the run is there, at most 20 real seconds."""
    clock = SystemClock()
    ends_s = clock.monotonic_s() + 20.0
    while not (run_dir / "journal.count").exists() or status(run_dir).state is not state:
        assert clock.monotonic_s() < ends_s, f"not {state} in time"
        clock.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGQUIT])
def test_fault_76_a_run_that_was_told_to_end_or_aborted_goes_on_with_the_same_numbers(
    tmp_path: Path, number: signal.Signals
) -> None:
    """Detected: signals and requests leave a mark that every slice of every wait reads.
    Response: axes stop at once; stopped can be resumed, aborted with a name and a reason; the record says who asked.
    """
    small, run_dir = bench(tmp_path), tmp_path / "run"
    small.run(tmp_path / "clean")
    os.waitpid(in_child(lambda: small.run(run_dir, observer=Signalling(number))), 0)
    if number is signal.SIGQUIT:
        with pytest.raises(RequestError, match="the run is aborted, so a person has to look first"):
            resume(run_dir, "")
    assert resume(run_dir, "anna", "looked at it").state is State.FINISHED
    assert measured_in(run_dir) == measured_in(tmp_path / "clean")


def test_what_was_asked_while_a_run_was_ending_is_heard_and_ends_nothing_twice(tmp_path: Path) -> None:
    """Also where the journal takes no record of it any more."""

    def refuse(_taken: Taken) -> None:
        raise StorageFailed("the disk is full")

    for record in (lambda _taken: None, refuse):
        spool = Spool(tmp_path)
        steering = Steering(spool, a_clock(), a_clock(), record)
        steering.on_signal(signal.SIGTERM, None)
        spool.submit(_request("abort", "smoke"))
        for _ in range(2):
            steering.hear()
        assert steering.at_once is not None
        if record is not refuse:
            assert (steering.at_once.state, steering.at_once.by) == (State.ABORTED, "anna")
