"""Laws of the stop guard: the stops go within half a second of an engine that dies or freezes while an axis turns."""

import json
import os
import pwd
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from guarded_engine import CLOCK, RINGS, GuardedEngine, guarded_engine, rung_in, until
from open_folder import open_folder
from recording_proxy import Hung
from turning_rig import DRIVE_FOR_ROLL, SERVO_FOR_PITCH, STAGE_FOR_ROLL, served

from procedures.cli.stop_at_once import _login_name
from procedures.journal.sidecar.guard_record import guard_sentence, read_guard_record
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.guard.ask import of_rig, of_run, stop
from rig.guard.stop_guard import DEAF_S, RECORD
from rig.motion.move import home_and_arrive

FAMILIES = {
    "zaber": (STAGE_FOR_ROLL, "roll", 8.0, b"stop"),
    "oriental-az": (DRIVE_FOR_ROLL, "roll", 8.0, bytes.fromhex("1000 7c0002 04 0000 0020")),
    "maestro": (SERVO_FOR_PITCH, "pitch", 0.0, b"\x87\x00"),
    "indexing-table": (("", ""), "roll", 0.0, b"2 STOP\r\n"),
}
ENDS = ("KILL", "QUIT", "STOP", "LIMIT", "MEMORY", "HUNG")
"""LIMIT: killed by the system, as one that is out of memory is; here by its limit of processor time. MEMORY: its
allocations fail, and it has to end in order with none left. HUNG: the machine's answers come no more."""
DEAF = {"maestro": ("HUNG",)}
"""A servo's only stop is its own position, which a line that is hung does not tell: it ends its move by itself."""
LIMIT_S = 0.5
"""What is promised; held by `make soak` on a machine that does nothing else."""
PATIENCE_OF = {"HUNG": 7.0, "MEMORY": 1.0}
"""So long an engine that lives tries to have an answer by its driver's patience, or to have memory."""
BUSY_LIMIT_S = 5.0
"""Told from never: on a busy machine the guard waits for a processor as everybody does."""
DEATH_SEEN_S = 0.05
"""So late, at most, a death that the system chose the moment of is noticed here."""
MEMORY_GROUPS = Path("/sys/fs/cgroup/memory")
"""Of the first version: where the second limits memory, a group that holds processes has none below it."""
GROUP_BYTES = 150_000_000
NOBODY = 65534
AS_NOBODY = f"""
import os
# Another account may not see where Python lies.
import encodings.idna, importlib.readers
import procedures.cli.queues_disarmed, procedures.errors, procedures.journal.requests.spool
from procedures.cli.start import main
os.setuid({NOBODY})
main()
"""
STANDS = """
import sys
from pathlib import Path
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
path = Path(sys.argv[1])
with open_rig(read_rig(path), rig_file=path, purpose="test") as rig:
    rig.belongs_to(Path(sys.argv[2]), sys.argv[3:])
    rig.prepare_to_move()
    print("guarded", flush=True)
    sys.stdin.read()
"""
"""An engine that was about to move something."""
LONGEST_S = BUSY_LIMIT_S + max(PATIENCE_OF.values())
REST_S = 3.0
"""The machine's own deceleration, and on the bench's processors much else to do."""
CASES = [(family, end) for family in sorted(FAMILIES) for end in ENDS if end not in DEAF.get(family, ())]


def _end(engine: GuardedEngine, end: str) -> None:
    pid = engine.process.pid
    match end:
        case "LIMIT":  # the system looks at it while the process works
            resource.prlimit(pid, resource.RLIMIT_CPU, (0, 0))
            os.kill(pid, signal.SIGUSR2)
            assert engine.until(lambda: engine.process.poll() is not None, 30.0)
        case "MEMORY":
            os.kill(pid, signal.SIGUSR1)
        case "HUNG":
            engine.line.faults = Hung()
        case _:
            os.kill(pid, getattr(signal, f"SIG{end}"))


def _ends_in_stopped_axes(folder: Path, family: str, end: str, after_s: float = 0.3) -> float:
    """End the engine in that way; returns when the first stop bytes were seen, seconds after it."""
    change, axis, rate_dps, stop_bytes = FAMILIES[family]
    with guarded_engine(folder, change, axis, rate_dps) as engine:
        assert engine.until(lambda: engine.rate_dps != 0.0, 5.0)  # a table lifts first
        CLOCK.sleep(after_s)
        asked_s = CLOCK.monotonic_s()
        _end(engine, end)
        ended_s = CLOCK.monotonic_s() - DEATH_SEEN_S if end == "LIMIT" else asked_s
        assert engine.until(lambda: engine.line.first_s(stop_bytes, ended_s) is not None, LONGEST_S)
        first_s = engine.line.first_s(stop_bytes, ended_s)
        assert first_s is not None
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
        status = engine.process.wait(30.0)
        if end in ("MEMORY", "HUNG"):
            assert status > 0, "nobody ends it: what it still can say stands on its screen"
        else:
            assert status < 0, "a frozen engine is ended: thawed, it would go on"
        assert engine.until(lambda: (engine.run / RECORD).exists(), 5.0)
        record = read_guard_record(engine.run)
        assert record is not None
        assert axis in record["moving"]
        assert all(outcome.startswith("told to stop") for outcome in record["axes"].values()), record
        assert "every axis was told to stop" in guard_sentence(record)
        assert engine.until(lambda: bool(engine.rung), BUSY_LIMIT_S)
        assert engine.rung == [record], "told once, in the guard's words"
        return first_s


@pytest.mark.parametrize(
    ("family", "end"),
    [
        ("zaber", "KILL"),
        ("oriental-az", "STOP"),
        pytest.param("maestro", "QUIT", marks=pytest.mark.thorough),
        ("indexing-table", "MEMORY"),
        pytest.param("zaber", "HUNG", marks=pytest.mark.thorough),
    ],
)
def test_fault_74_an_engine_that_dies_or_freezes_leaves_its_axes_standing(
    tmp_path: Path, family: str, end: str
) -> None:
    """Detected: a process of its own holds the lines, and hears or misses the engine while anything may move.
    Response: it stops every axis, ends what is left of the engine, and writes what it did beside the run.
    """
    assert _ends_in_stopped_axes(tmp_path, family, end) <= BUSY_LIMIT_S + PATIENCE_OF.get(end, 0.0)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(200))
def test_an_engine_that_dies_at_any_moment_leaves_its_axes_standing(
    tmp_path: Path, number: int, record_property: Callable[[str, object], None]
) -> None:
    chance = np.random.default_rng(number)
    family, end = CASES[number % len(CASES)]
    first_s = _ends_in_stopped_axes(tmp_path, family, end, float(chance.uniform(0.0, 1.0)))
    record_property(f"first stop after {end} by {family}", first_s)
    assert first_s <= LIMIT_S + PATIENCE_OF.get(end, 0.0)


@pytest.mark.soak
@pytest.mark.skipif(not os.access(MEMORY_GROUPS, os.W_OK), reason="needs a group with a limit of memory")
@pytest.mark.parametrize("family", ["zaber", "oriental-az", "maestro"])
def test_an_engine_that_the_kernel_kills_for_its_memory_leaves_its_axes_standing(tmp_path: Path, family: str) -> None:
    """Engine and guard share the group and its limit, as in a unit: the kernel takes the one that has grown."""
    change, axis, rate_dps, stop_bytes = FAMILIES[family]
    group = MEMORY_GROUPS / f"calrig-test-{os.getpid()}"
    group.mkdir()
    try:
        with guarded_engine(tmp_path, change, axis, rate_dps) as engine:
            (group / "memory.limit_in_bytes").write_text(str(GROUP_BYTES), encoding="ascii")
            for pid in (engine.process.pid, engine.guard_pid):
                (group / "cgroup.procs").write_text(str(pid), encoding="ascii")
            os.kill(engine.process.pid, signal.SIGRTMIN)
            asked_s = CLOCK.monotonic_s()
            assert engine.until(lambda: engine.process.poll() is not None, 60.0)
            ended_s = CLOCK.monotonic_s()
            assert engine.process.returncode == -signal.SIGKILL
            assert engine.until(lambda: engine.line.first_s(stop_bytes, asked_s) is not None, LONGEST_S)
            assert asked_s + engine.line.first_s(stop_bytes, asked_s) - ended_s <= LIMIT_S  # type: ignore[operator]
            assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
            assert engine.until(lambda: (engine.run / RECORD).exists(), 5.0)
            assert engine.until(lambda: not (group / "cgroup.procs").read_text(encoding="ascii"), 5.0), (
                "a guard is left"
            )
    finally:
        group.rmdir()


def test_an_engine_whose_guard_is_killed_stops_its_axes_and_says_so(tmp_path: Path) -> None:
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        os.kill(engine.guard_pid, signal.SIGKILL)
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
        assert engine.process.wait(10.0) == 1
        assert not engine.rung, "a run tells people itself that it trips"


def test_an_engine_that_dies_while_every_axis_stands_is_told_of_too(tmp_path: Path) -> None:
    """Nobody asked for that end either; there is no record, since nothing had to be stopped."""
    file, run = tmp_path / "rung.jsonl", tmp_path / "night"
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (_, rig_file):
        engine = [sys.executable, "-c", STANDS, str(rig_file), str(run), sys.executable, "-c", RINGS, str(file)]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        with subprocess.Popen(engine, **pipes, start_new_session=True) as process:  # type: ignore[call-overload]
            assert process.stdout is not None
            assert process.stdout.readline() == b"guarded\n"
            process.kill()
        assert until(lambda: bool(rung_in(file)), BUSY_LIMIT_S)
        (told,) = rung_in(file)
    assert guard_sentence(told).endswith(
        "the engine ended without a word while every axis stood; every axis was told to stop"
    )
    assert not (run / RECORD).exists()


def test_an_engine_whose_guard_is_frozen_stops_its_axes_and_says_so(tmp_path: Path) -> None:
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        os.kill(engine.guard_pid, signal.SIGSTOP)
        assert engine.until(lambda: engine.rate_dps == 0.0, DEAF_S)
        assert engine.process.wait(20.0) == 1


@pytest.mark.thorough
def test_a_stop_from_the_shell_wakes_a_guard_that_was_frozen_and_whose_engine_is_dead(tmp_path: Path) -> None:
    """It holds the lines of a machine that allows one connection: nobody else could stop the axis."""
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        os.kill(engine.guard_pid, signal.SIGSTOP)
        engine.process.kill()
        engine.process.wait()
        told = _calrig(["jog", "--rig", str(engine.rig_file), "--stop"])
        assert told.returncode == 0, told.stderr
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S + BUSY_LIMIT_S)


def test_whoever_asks_the_guard_has_the_axes_stopped_and_the_engine_ends(tmp_path: Path) -> None:
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        (guard,) = of_rig(str(engine.rig_file))
        runs = str(tmp_path / "runs")
        assert of_run(None, runs) == of_run("night", runs) == of_run(str(engine.run), ".") == [guard]
        for nonsense in (b"\xff\xfe", b"ann", b"\n\n\n\n", b"x" * 5000, b""):
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
                line.connect("\0" + guard["socket"])
                line.sendall(nonsense)
        assert engine.rate_dps != 0.0
        assert stop(guard, ["roll"], "ann") == {"roll": "told to stop"}
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
        assert engine.process.wait(10.0) == 1
        assert engine.until(lambda: not of_rig(str(engine.rig_file)), 5.0)


def test_fault_75_a_frozen_process_keeps_nobody_from_a_stop(tmp_path: Path) -> None:
    """Detected: the stop guard sees that the process is stopped while an axis may move.
    Response: the axes are stopped and the process is ended, so its locks are free; `jog --stop` is obeyed at once.
    """
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        os.kill(engine.process.pid, signal.SIGSTOP)
        told = _calrig(["jog", "--rig", str(engine.rig_file), "--stop", "--json"])
        assert told.returncode == 0, told.stderr
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)


@pytest.mark.parametrize(
    ("command", "way"), [("abort", "start"), ("jog", "start"), pytest.param("jog", "main", marks=pytest.mark.thorough)]
)
def test_fault_86_a_stop_from_the_shell_goes_by_the_guard(tmp_path: Path, command: str, way: str) -> None:
    """Detected: `abort` and `jog --stop` look at their words before they import anything.
    Response: the stop guard of the rig sends the stops at once; the engine hears who asked, and ends.
    """
    runs = os.path.relpath(tmp_path / "runs")
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        words = {
            "abort": ["abort", "--out", runs, "--operator", "ann"],
            "jog": ["jog", "--rig", str(engine.rig_file), "--stop", "--json"],
        }[command]
        told = _calrig(words, way)
        assert told.returncode == 0, told.stderr
        assert "roll" in told.stdout
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
        if command == "abort":
            assert f"\n{os.path.join(runs, engine.run.name)}: asked to abort; " in told.stdout
            (request,) = (engine.run / "requests").glob("*-abort.json")
            assert json.loads(request.read_text(encoding="utf-8"))["by"] == "ann"


@pytest.mark.skipif(os.getuid() != 0, reason="needs two accounts")
def test_fault_86_another_account_aborts_a_run_whose_folder_it_cannot_write() -> None:
    """The engine hears it from the guard, and who asked; what the folder does not take is no failure."""
    with open_folder() as folder, guarded_engine(folder, STAGE_FOR_ROLL) as engine:
        engine.run.chmod(0o755)
        command = ["-c", AS_NOBODY, "abort", str(engine.run)]
        asked = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False)
        assert (asked.returncode, asked.stderr) == (0, "")
        assert "roll: told to stop" in asked.stdout
        assert not (engine.run / "requests").exists()
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S + BUSY_LIMIT_S)


def test_who_stops_has_a_name_where_no_variable_tells_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("LOGNAME", "USER", "LNAME", "USERNAME"):
        monkeypatch.delenv(name, raising=False)
    assert _login_name() == pwd.getpwuid(os.getuid()).pw_name


def test_a_guard_that_is_gone_leaves_the_long_way(tmp_path: Path) -> None:
    told = _calrig(["abort", "--out", str(tmp_path)])
    assert told.returncode == 2
    assert told.stderr


def _calrig(words: list[str], way: str = "start") -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", f"procedures.cli.{way}", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_an_engine_that_says_goodbye_leaves_no_record_and_no_guard(tmp_path: Path) -> None:
    """Everything that it moved stands by then; a jog over real ports does so."""
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (_, rig_file):
        with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
            end_is_on_record = rig.belongs_to(tmp_path)
            assert not of_rig(str(rig_file)), "nothing has moved yet"
            home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
            assert of_rig(str(rig_file))
            end_is_on_record()
        assert not of_rig(str(rig_file))
        assert not (tmp_path / RECORD).exists()


def test_a_run_whose_end_is_not_on_record_when_its_rig_is_given_back_is_told_as_dead(tmp_path: Path) -> None:
    """Also while every axis stands: without memory or open files an engine leaves no other word. It is not ended."""
    rung = tmp_path / "rung.jsonl"
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (_, rig_file):
        with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
            rig.belongs_to(tmp_path, (sys.executable, "-c", RINGS, str(rung)))
            home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
        assert not of_rig(str(rig_file))
        record = read_guard_record(tmp_path)
        assert record is not None
        assert set(record["axes"].values()) == {"told to stop"}
        assert record["why"] == "the engine gave the axes back before the end of its run was on record"
        assert until(lambda: rung_in(rung) == [record], BUSY_LIMIT_S)
