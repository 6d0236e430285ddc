"""Alerts: who is told what, once; a slow or dead server never holds the run; the heartbeat stops with the engine."""

import http.server
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from journals import a_clock
from small_run import bench

from ams.errors import WriteFailed
from procedures.alerts.channels import Message, NotDelivered, beat, by_apprise, by_command
from procedures.alerts.dispatcher import AlertDispatcher, tell_people
from procedures.alerts.outbox import MOST_UNDER_WAY
from procedures.alerts.settings import AlertSettings, Escalation, read_alerts
from procedures.errors import ExitStatus, StorageFailed
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import is_acknowledged
from procedures.journal.status.stop_advice import advice_of
from procedures.records.progress import Progress, SilentObserver
from procedures.records.states import State
from procedures.run.resume import resume
from procedures.run.services import RunServices
from rig.clock import Clock, VirtualClock
from rig.errors import DescriptionError
from rig.local_time import at_both

HOLD = Progress("state", State.HELD, 3, 24, 1, 2, None, None, "environment.air: got 25 °C, allowed 18 to 22 °C")
PATIENCE_S = 60.0
ROOT = Path(__file__).parents[3]
WRITES = "import sys, pathlib; path = pathlib.Path(sys.argv[1]); path.write_text((path.read_text() if path.exists() else '') + sys.stdin.read())"  # noqa: E501


@pytest.fixture
def clock() -> VirtualClock:
    return a_clock()


def _dispatcher(clock: VirtualClock, expected: Path, **settings: object) -> AlertDispatcher:
    command = (sys.executable, "-c", WRITES, str(expected))
    return AlertDispatcher(AlertSettings(command=command, **settings), "night", clock, SilentObserver())  # type: ignore[arg-type]


def test_a_hold_is_told_once_with_its_reason_and_again_only_after_the_gap(clock: VirtualClock, tmp_path: Path) -> None:
    text = tmp_path / "told.txt"
    dispatcher = _dispatcher(clock, text, least_gap_s=600.0)
    for wait_s in (0.0, 1.0, 500.0):
        clock.sleep(wait_s)
        dispatcher.on_event(HOLD)
    assert dispatcher.close() == [{"what": "calrig: night: held", "failed": ""}]
    assert text.read_text().startswith("calrig: night: held\n\nheld 3/24")
    assert "environment.air: got 25 °C" in text.read_text()
    clock.sleep(100.0)
    dispatcher.on_event(HOLD)
    dispatcher.close()
    assert text.read_text().count("calrig: night: held") == 2


def test_a_command_is_told_in_utf8_where_the_locale_knows_no_degrees(tmp_path: Path) -> None:
    """As a service without a locale starts calrig: Python's own UTF-8 mode, which would hide it, is off."""
    text = "air: 22.4 °C, 40 µT, 3″ ≥ 2″"
    tell = (
        "from procedures.alerts.channels import Message, by_command\n"
        f"by_command(['tee', 'heard'], Message('held', {text!a}), 20.0)"
    )
    surroundings = {"PATH": os.environ["PATH"], "LC_ALL": "C", "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-X", "utf8=0", "-c", tell], check=True, cwd=tmp_path, env=surroundings)
    assert (tmp_path / "heard").read_bytes().decode("utf-8") == f"held\n\n{text}\n"


@pytest.mark.parametrize("folder", ["a bin", "bin"])
def test_absolute_paths_of_the_program_and_of_the_heartbeat_hold_wherever_the_run_was_begun(
    folder: str, clock: VirtualClock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A service starts calrig in another folder than a person does: what is told goes to the same place."""
    (tmp_path / folder).mkdir()
    program, heard, alive = tmp_path / folder / "tell", tmp_path / "heard", tmp_path / folder / "alive"
    program.write_text(f"#!/bin/sh\ncat > '{heard}'\n", encoding="utf-8")
    program.chmod(0o755)
    file = tmp_path / "alerts.toml"
    file.write_text(f"command = ['{program}']\nheartbeat = '{alive}'\n", encoding="utf-8")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    dispatcher = AlertDispatcher(read_alerts(file), "night", clock, SilentObserver())
    dispatcher.on_event(HOLD)
    outcomes = [*dispatcher.pulse(), *dispatcher.close()]
    assert outcomes == [{"what": "calrig: night: held", "failed": ""}]
    assert heard.read_text(encoding="utf-8").startswith("calrig: night: held\n\nheld 3/24")
    assert alive.exists()
    assert list(elsewhere.iterdir()) == []


def test_an_alarm_says_where_the_page_is_also_where_the_disk_of_the_run_takes_none(
    clock: VirtualClock, tmp_path: Path
) -> None:
    text = tmp_path / "told.txt"
    settings = AlertSettings(command=(sys.executable, "-c", WRITES, str(text)))
    dispatcher = AlertDispatcher(settings, "night", clock, SilentObserver(), "runs/night", "/var/emergency/night")
    dispatcher.on_event(HOLD)
    dispatcher.close()
    assert (
        "The folder runs/night holds why.txt and why.html; where its disk takes nothing, /var/emergency/night does."
    ) in text.read_text()


def test_one_telephone_of_several_benches_hears_which_bench_and_which_computer(
    clock: VirtualClock, tmp_path: Path
) -> None:
    """Also what others are told, and what is told of a run that there is not."""
    desk, others = tmp_path / "desk.txt", tmp_path / "others.txt"
    settings = AlertSettings(
        command=(sys.executable, "-c", WRITES, str(desk)),
        escalate=Escalation(after_min=0.5, command=(sys.executable, "-c", WRITES, str(others))),
    )
    dispatcher = AlertDispatcher(settings, "night", clock, SilentObserver(), rig="bench 2")
    dispatcher.on_event(HOLD)
    dispatcher.close()
    clock.sleep(60.0)
    dispatcher.pulse()
    dispatcher.close()
    here = f"on the computer {socket.gethostname()}."
    for told in (desk, others):
        assert told.read_text().endswith(f"\nRig: bench 2, {here}\n")
    tell_people(settings, clock, "night", "not begun", "no file")
    assert desk.read_text().endswith(f"no file\nIt comes from calrig {here}\n")


def test_states_that_need_nobody_are_not_told(clock: VirtualClock, tmp_path: Path) -> None:
    dispatcher = _dispatcher(clock, tmp_path / "told.txt")
    dispatcher.on_event(Progress("state", State.RUNNING, 3, 24, 1, 2, None, None, ""))
    dispatcher.on_event(Progress("dwell", State.RUNNING, 4, 24, 1, 2, None, None, ""))
    assert dispatcher.close() == []


def test_progress_is_told_every_so_many_hours(clock: VirtualClock, tmp_path: Path) -> None:
    text = tmp_path / "told.txt"
    dispatcher = _dispatcher(clock, text, every_h=4.0)
    dispatcher.on_event(Progress("dwell", State.RUNNING, 4, 24, 1, 2, 7.4, None, ""))
    for _ in range(9):
        clock.sleep(3600.0)
        dispatcher.pulse()
        dispatcher._outbox.join(lambda: PATIENCE_S)
    assert text.read_text().count("running 4/24") == 2


def test_a_failing_command_is_told_to_the_engine_and_never_raises(clock: VirtualClock) -> None:
    settings = AlertSettings(command=(sys.executable, "-c", "import sys; sys.exit('no network')"))
    dispatcher = AlertDispatcher(settings, "night", clock, SilentObserver())
    dispatcher.on_event(HOLD)
    (outcome,) = dispatcher.close()
    assert "exit status 1: no network" in str(outcome["failed"])


def test_a_server_that_never_answers_holds_nothing_up(clock: VirtualClock, monkeypatch: pytest.MonkeyPatch) -> None:
    released = threading.Event()
    monkeypatch.setattr("procedures.alerts.dispatcher.by_command", lambda *_: released.wait(60.0))
    dispatcher = AlertDispatcher(
        AlertSettings(command=("x",), least_gap_s=0.001, deadline_s=0.01), "night", clock, SilentObserver()
    )
    for number in range(MOST_UNDER_WAY + 1):
        dispatcher.on_event(Progress("state", State.HELD, number, 24, 1, 2, None, None, f"reason {number}"))
    (outcome,) = dispatcher.close()
    assert f"{MOST_UNDER_WAY} messages are under way already" in str(outcome["failed"])
    released.set()


def test_the_heartbeat_touches_its_file_only_while_the_engine_looks(clock: VirtualClock, tmp_path: Path) -> None:
    beats = tmp_path / "alive"
    dispatcher = AlertDispatcher(AlertSettings(heartbeat=str(beats)), "night", clock, SilentObserver())
    dispatcher.pulse()
    assert dispatcher.close() == [], "a good heartbeat is no event"
    first = beats.stat().st_mtime_ns
    clock.sleep(59.0)
    dispatcher.pulse()
    dispatcher.close()
    assert beats.stat().st_mtime_ns == first
    clock.sleep(2.0)
    dispatcher.pulse()
    dispatcher.close()
    assert beats.stat().st_mtime_ns > first


@pytest.fixture
def server() -> Iterator[tuple[str, list[str]]]:
    heard: list[str] = []

    class Hears(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            body = self.rfile.read(int(self.headers.get("Content-Length", 0))).decode()
            heard.append(f"{self.command} {self.path} {body}")
            self.send_response(500 if self.path == "/broken" else 200)
            self.end_headers()

        def do_POST(self) -> None:
            self.do_GET()

        def log_message(self, format: str, *arguments: object) -> None: ...

    with http.server.HTTPServer(("127.0.0.1", 0), Hears) as served:
        thread = threading.Thread(target=served.serve_forever)
        thread.start()
        yield f"127.0.0.1:{served.server_port}", heard
        served.shutdown()
        thread.join()


def test_a_heartbeat_address_is_fetched_and_its_refusal_told(server: tuple[str, list[str]]) -> None:
    address, heard = server
    beat(f"http://{address}/ping/1234", 5.0)
    assert heard == ["GET /ping/1234 "]
    with pytest.raises(NotDelivered, match="heartbeat not sent: HTTP Error 500"):
        beat(f"http://{address}/broken", 5.0)


@pytest.mark.filterwarnings("ignore:'imghdr' is deprecated:DeprecationWarning")
def test_apprise_delivers_and_a_dead_host_is_told_without_its_address(server: tuple[str, list[str]]) -> None:
    pytest.importorskip("apprise")
    address, heard = server
    by_apprise([f"json://{address}/chat"], Message("calrig: night: tripped", "look"))
    assert '"title": "calrig: night: tripped"' in heard[0]
    with pytest.raises(NotDelivered, match=r"^apprise: json://… did not take the message$"):
        by_apprise(["json://secret:word@127.0.0.1:9/chat"], Message("a", "b"))


def test_a_command_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(NotDelivered, match="No such file"):
        by_command([str(tmp_path / "nothing")], Message("a", "b"), 5.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('heartbeat = "ftp://x/y"', "heartbeat must be a file"),
        ("every_h = -1.0", "every_h"),
        ('mail = "anna"', "unknown key: write urls, a list of addresses; mail is one of them"),
    ],
)
def test_a_wrong_file_is_refused_by_line(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "alerts.toml").write_text(text)
    with pytest.raises(DescriptionError, match=expected):
        read_alerts(tmp_path / "alerts.toml")


def test_what_became_of_an_alert_is_in_the_journal(tmp_path: Path) -> None:
    due: list[Mapping[str, object]] = [{"what": "calrig: night: held", "failed": "apprise: ntfy://… did not take it"}]

    def pulse() -> list[Mapping[str, object]]:
        found, due[:] = list(due), []
        return found

    small = bench(tmp_path)
    small.run(tmp_path / "run", services=RunServices(pulse=pulse))
    with JournalReader.open(tmp_path / "run") as reader:
        (event,) = reader.events("alert")
    assert event.detail["failed"] == "apprise: ntfy://… did not take it"


def _escalating(clock: VirtualClock, folder: Path, **settings: object) -> AlertDispatcher:
    others = {"after_min": 30.0, "command": [sys.executable, "-c", WRITES, str(folder / "others.txt")]}
    return _dispatcher(clock, folder / "told.txt", escalate=others, **settings)


def _let_pass(dispatcher: AlertDispatcher, clock: VirtualClock, minutes: int) -> None:
    for _ in range(minutes):
        clock.sleep(60.0)
        dispatcher.pulse()
        dispatcher._outbox.join(lambda: PATIENCE_S)


def test_an_alarm_that_nobody_acknowledges_is_told_again_and_then_to_others(
    clock: VirtualClock, tmp_path: Path
) -> None:
    dispatcher = _escalating(clock, tmp_path, repeat_every_s=600.0)
    dispatcher.on_event(HOLD)
    _let_pass(dispatcher, clock, 29)
    assert (tmp_path / "told.txt").read_text().count("calrig: night: still held\n") == 2
    assert not (tmp_path / "others.txt").exists()
    _let_pass(dispatcher, clock, 31)
    others = (tmp_path / "others.txt").read_text()
    assert others.count("calrig: night: still held, unacknowledged") == 1
    assert "Nobody has acknowledged it for 30 min: calrig ack RUN" in others
    assert (tmp_path / "told.txt").read_text().count("calrig: night: still held\n") == 6


@pytest.mark.parametrize(
    "word",
    [
        Progress("ack", State.HELD, 3, 24, 1, 2, None, None, "acknowledged by anna"),
        Progress("state", State.RUNNING, 3, 24, 1, 2, None, None, ""),
    ],
    ids=["acknowledged", "over by itself"],
)
def test_an_alarm_that_is_known_or_over_rings_no_more(clock: VirtualClock, tmp_path: Path, word: Progress) -> None:
    dispatcher = _escalating(clock, tmp_path)
    dispatcher.on_event(HOLD)
    _let_pass(dispatcher, clock, 5)
    dispatcher.on_event(word)
    _let_pass(dispatcher, clock, 120)
    assert (tmp_path / "told.txt").read_text().count(": held\n") == 1
    assert "still held" not in (tmp_path / "told.txt").read_text()
    assert not (tmp_path / "others.txt").exists()


RUNS = Progress("state", State.RUNNING, 3, 24, 1, 2, None, None, "")


def test_whoever_was_told_of_a_hold_is_told_that_the_run_goes_on(clock: VirtualClock, tmp_path: Path) -> None:
    """Who was woken at two need not drive in; who was not told of the hold is not told of its end either."""
    dispatcher = _escalating(clock, tmp_path, least_gap_s=7200.0)
    dispatcher.on_event(RUNS)
    dispatcher.on_event(HOLD)
    _let_pass(dispatcher, clock, 31)
    dispatcher.on_event(Progress("state", State.CHECKING, 3, 24, 1, 2, None, None, ""))
    dispatcher.on_event(RUNS)
    for _ in range(2):  # the same hold again is too soon to be told, and so is its end
        dispatcher.on_event(HOLD)
        clock.sleep(60.0)
        dispatcher.on_event(RUNS)
    dispatcher.close()
    for name in ("told.txt", "others.txt"):
        told = (tmp_path / name).read_text()
        assert told.count("calrig: night: goes on\n\nrunning 3/24") == 1, told
        assert "The hold is over, 31 min after it was told." in told


def test_a_run_that_ended_in_a_trip_rings_on_until_others_are_told(clock: VirtualClock, tmp_path: Path) -> None:
    dispatcher = _escalating(clock, tmp_path)
    dispatcher.on_event(Progress("state", State.TRIPPED, 3, 24, 1, 2, None, None, "stop button"))
    began_s = clock.monotonic_s()
    dispatcher.ring_out(lambda: False)
    assert clock.monotonic_s() - began_s == pytest.approx(1800.0, abs=2.0)
    assert "stop button" in (tmp_path / "others.txt").read_text()


def test_a_run_that_ended_rings_no_longer_than_to_its_acknowledgement(clock: VirtualClock, tmp_path: Path) -> None:
    dispatcher = _escalating(clock, tmp_path)
    dispatcher.on_event(Progress("state", State.TRIPPED, 3, 24, 1, 2, None, None, "stop button"))
    looks = iter([False] * 5 + [True])
    dispatcher.ring_out(lambda: next(looks))
    assert not (tmp_path / "others.txt").exists()
    quiet = _dispatcher(clock, tmp_path / "told.txt")
    quiet.on_event(Progress("state", State.TRIPPED, 3, 24, 1, 2, None, None, "stop button"))
    quiet.ring_out(lambda: pytest.fail("there is nobody else to tell, so nobody waits"))


def test_an_escalation_to_nobody_is_refused_by_line(tmp_path: Path) -> None:
    path = tmp_path / "alerts.toml"
    path.write_text("[escalate]\nafter_min = 5.0\n")
    with pytest.raises(DescriptionError, match=r"alerts.toml:\d+: escalate: .*an escalation to nobody is none"):
        read_alerts(path)


def test_fault_79_a_disk_that_stays_full_is_told_and_its_page_lies_elsewhere(
    tmp_path: Path, clock: VirtualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Detected: the disk refuses the journal, and goes on refusing whatever is written.
    Response: people are told before the disk is asked; the page is written in a second place; the run is resumable.
    """
    small, run_dir, file = bench(tmp_path), tmp_path / "run", tmp_path / "told.txt"
    dispatcher = _dispatcher(clock, file)
    write = Journal.append_event

    class Fills:
        def on_event(self, progress: Progress) -> None:
            dispatcher.on_event(progress)
            if progress.dwells_done == 3:
                monkeypatch.setattr(Journal, "append_event", _refuse)
                monkeypatch.setattr("procedures.run.stop_page.write_whole", _only_elsewhere)

    def _only_elsewhere(path: Path, content: bytes) -> None:
        if path.parent == run_dir:
            raise WriteFailed(f"{path}: no space left on device")
        path.write_bytes(content)

    outcome = small.run(
        run_dir, observer=Fills(), services=RunServices(pulse=dispatcher.pulse, second_folder=tmp_path / "second")
    )
    dispatcher.close()
    monkeypatch.setattr(Journal, "append_event", write)
    assert outcome.exit_status == ExitStatus.FAILED
    assert "calrig: night: stopped" in file.read_text(encoding="utf-8")
    assert "no space left" in file.read_text(encoding="utf-8")
    assert "no space left" in (tmp_path / "second" / "run" / "why.txt").read_text(encoding="utf-8")
    assert str(tmp_path / "second" / "run" / "why.html") in outcome.reason
    assert not is_acknowledged(run_dir)
    assert resume(run_dir, "tester").state is State.FINISHED


def _refuse(journal: Journal, kind: str, detail: Mapping[str, object], clock: object) -> None:
    raise StorageFailed(f"{journal.path}: cannot be written: no space left on device")


def test_a_stop_that_nobody_asked_for_rings_and_one_that_somebody_asked_for_does_not(
    clock: VirtualClock, tmp_path: Path
) -> None:
    text = tmp_path / "told.txt"
    for by, subjects in (("anna", 1), ("", 2)):
        dispatcher = _dispatcher(clock, text, repeat_every_s=900.0)
        dispatcher.on_event(Progress("state", State.STOPPED, 3, 24, 1, 2, None, None, "why", by))
        clock.sleep(901.0)
        dispatcher.pulse()
        assert len(dispatcher.close()) == subjects


def test_people_are_told_before_the_journal_is_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small, order = bench(tmp_path), []
    write = Journal.append_event

    def journalled(journal: Journal, kind: str, detail: Mapping[str, object], clock: Clock) -> None:
        order.append(f"journal {detail.get('to')}" if kind == "state" else "")
        write(journal, kind, detail, clock)

    class Tells:
        def on_event(self, progress: Progress) -> None:
            if progress.event == "state":
                order.append(f"told {progress.state}")
            if progress.dwells_done == 3:
                raise ZeroDivisionError("of ours")

    monkeypatch.setattr(Journal, "append_event", journalled)
    with pytest.raises(ZeroDivisionError):
        small.run(tmp_path / "run", observer=Tells())
    assert order.index("told failed") < order.index("journal failed")


SAID = "/data/night of today"
STANDS = "Every axis was told to stop and seen to stand: pitch at 10.0000°; nothing moved since."


@pytest.mark.parametrize(
    ("state", "cause", "motion", "said"),
    [
        (State.HELD, "link", "", ("The run waits, and moves nothing", "Check plug, cable, adapter and power")),
        (State.HELD, "noise", "", ("The run waits", f"calrig continue '{SAID}'")),
        (State.TRIPPED, "device", STANDS, (STANDS, f"calrig resume '{SAID}' --operator NAME --reason TEXT")),
        (State.FAILED, "", STANDS, (STANDS, f"calrig handover '{SAID}'", "begin a new one")),
        (State.INTERRUPTED, "process died", "", ("its stop guard told every axis to stop", f"calrig resume '{SAID}'")),
    ],
)
def test_whoever_is_woken_reads_what_stopped_where_when_whether_it_moves_and_what_to_do(
    clock: VirtualClock, tmp_path: Path, state: State, cause: str, motion: str, said: tuple[str, ...]
) -> None:
    command = (sys.executable, "-c", WRITES, str(tmp_path / "told.txt"))
    words = ("night", clock, SilentObserver(), SAID, "", "table of room 3", advice_of(SAID))
    dispatcher = AlertDispatcher(AlertSettings(command=command, repeat_every_s=600.0), *words)  # type: ignore[arg-type]
    began = at_both(clock.now_utc(), to_the_second=True)
    dispatcher.on_event(replace(HOLD, state=state, cause=cause, motion=motion))
    dispatcher.close()
    told = (tmp_path / "told.txt").read_text(encoding="utf-8")
    for words_of_it in (
        *said,
        "environment.air: got 25 °C",
        f"Since {began}.",
        f"calrig ack '{SAID}' ends the repeats",
        f"Run: {SAID}.\nRig: table of room 3, on",
    ):
        assert words_of_it in told
    _let_pass(dispatcher, clock, 11)
    again = (tmp_path / "told.txt").read_text(encoding="utf-8").removeprefix(told)
    assert f"Since {began}." in again, "when it began, not when it is told again"
