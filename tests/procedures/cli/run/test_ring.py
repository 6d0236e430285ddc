"""A run whose process ends without a word, as real processes see it: people hear of it once, from its stop guard."""

import os
import re
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
import pytest
from alert_sink import AlertSink, alert_sink
from command import call
from guarded_engine import until
from small_run import PROCEDURE, RIG

from procedures.journal.sidecar.alert_record import FILE
from procedures.journal.sidecar.guard_record import read_guard_record
from procedures.journal.sidecar.last_words import read_last_words
from procedures.journal.status.status import status
from procedures.records.states import State
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock
from rig.description.read import read_rig
from rig.guard.ask import of_run

FACTOR = 5.0
NEVER_MIN = 60.0
LONGEST_S = 60.0
"""For a program to begin on a busy machine."""
STACK_BYTES, ROOM_BYTES = 1 << 30, 900 << 20
"""What a thread of a run takes of its addresses, and what else such a run may still take: no thread, and all else."""
KEEPS_NO_STACKS = {"GLIBC_TUNABLES": "glibc.pthread.stack_cache_size=0"}


@dataclass
class Night:
    """A run that has begun, and one of whose axes is on its way."""

    process: "subprocess.Popen[bytes]"
    run: Path
    sink: AlertSink

    @property
    def guard_pid(self) -> int:
        (guard,) = of_run(str(self.run), ".")
        return int(guard["socket"].rpartition("-")[2])

    def has_rung_out(self) -> bool:
        """Whether who rang has ended: then it leaves what became of its messages."""
        return (self.run / FILE).exists()


def _heed_signals() -> None:
    """Take back what a shell without job control does to its background: there a run ignores INT and QUIT."""
    for number in (signal.SIGINT, signal.SIGQUIT):
        signal.signal(number, signal.SIG_DFL)


@contextmanager
def a_night(folder: Path, escalate_after_min: float, stack_bytes: int | None = None) -> Iterator[Night]:
    """``stack_bytes``: what every thread of the run takes of its addresses, as ``ulimit -s`` says it."""
    (folder / "twins.toml").write_text(RIG.replace("speed_dps = 180.0", "speed_dps = 45.0"), encoding="utf-8")
    (folder / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    with alert_sink() as sink, serve_rig(read_rig(folder / "twins.toml"), ScaledClock(FACTOR)) as served:
        write_rig(folder / "twins.toml", served.addresses, FACTOR, folder / "rig.toml")
        words = ["run", "procedure.toml", "--rig", "rig.toml", "--alerts", "alerts.toml"]
        sink.settings(folder / "alerts.toml", escalate_after_min)
        stacks = f"ulimit -s {stack_bytes >> 10}; " if stack_bytes else ""
        process = subprocess.Popen(
            ["sh", "-c", f'{stacks}exec "$0" "$@"', sys.executable, "-m", "procedures.cli.main", *words],
            cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
            env={**os.environ, **KEEPS_NO_STACKS}, preexec_fn=_heed_signals,
        )  # fmt: skip

        def is_moving() -> bool:
            now_s = SystemClock().monotonic_s() * FACTOR
            return any(axis.rate_dps(now_s) != 0.0 for axis in served.world.axes.values())

        try:
            assert until(is_moving, LONGEST_S)
            (run,) = (folder / "runs").iterdir()
            yield Night(process, run, sink)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.mark.parametrize(
    ("how", "cause"),
    [
        (signal.SIGSTOP, "the engine was frozen (SIGSTOP); it was ended"),
        pytest.param(signal.SIGKILL, "the engine ended without a word", marks=pytest.mark.thorough),
    ],
)
def test_fault_89_a_run_whose_process_is_killed_or_frozen_while_an_axis_moves_rings_once_and_escalates(
    tmp_path: Path, how: signal.Signals, cause: str
) -> None:
    """Detected: by the stop guard, which outlives the engine.
    Response: when the axes are told to stop it has people told, in the words of any stop that nobody asked for.
    """
    with a_night(tmp_path, escalate_after_min=0.01) as night:
        night.process.send_signal(how)
        assert until(lambda: night.process.poll() is not None, LONGEST_S)
        assert night.process.returncode == -signal.SIGKILL
        night.process.send_signal(signal.SIGCONT)  # somebody thaws what is no more
        assert until(night.has_rung_out, LONGEST_S)
        (text,), (escalated,) = night.sink.of("/desk"), night.sink.of("/others")
        assert text.startswith("calrig: small grid: interrupted\n\ninterrupted 0/24 · stop guard, ")
        assert f"{cause} while " in text
        assert "every axis was told to stop" in text
        assert f"\nRig: bench of twins, on the computer {socket.gethostname()}." in text
        assert f"calrig ack {night.run.resolve()} ends the repeats" in text
        assert escalated.startswith("calrig: small grid: still interrupted, unacknowledged\n")
        assert read_guard_record(night.run) is not None
        assert read_last_words(night.run, None) is not None, "the resume will journal it and tell nobody again"
        page = (night.run / "why.txt").read_text(encoding="utf-8")
        assert "small grid: interrupted\n" in page
        assert cause in page
        assert "its stop guard told every axis to stop" in page


def test_a_run_that_is_out_of_open_files_rings_by_its_stop_guard(tmp_path: Path) -> None:
    """It unwinds, and can neither journal its end, nor write a page, nor tell anybody; its goodbye is none."""
    with a_night(tmp_path, escalate_after_min=0.01) as night:
        resource.prlimit(night.process.pid, resource.RLIMIT_NOFILE, (6, 6))
        assert until(lambda: night.process.poll() is not None, LONGEST_S)
        assert night.process.returncode > 0
        assert until(lambda: bool(night.sink.of("/others")), LONGEST_S)
        (text,) = (text for text in night.sink.of("/desk") if "interrupted" in text)
        assert "before the end of its run was on record" in text
        assert "every axis was told to stop" in text
        assert read_guard_record(night.run) is not None
        assert "small grid: interrupted\n" in (night.run / "why.txt").read_text(encoding="utf-8")


def _takes_its_threads(pid: int) -> None:
    """From now on a process begins no thread, and neither does what it starts."""
    taken = psutil.Process(pid).memory_info().vms
    resource.prlimit(pid, resource.RLIMIT_AS, (taken + ROOM_BYTES,) * 2)


@pytest.mark.thorough
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="nobody else sets the limits of a process")
def test_a_run_that_gets_no_thread_any_more_tells_people_of_its_end(tmp_path: Path) -> None:
    with a_night(tmp_path, NEVER_MIN, STACK_BYTES) as night:
        _takes_its_threads(night.process.pid)
        night.process.send_signal(signal.SIGQUIT)
        assert until(lambda: night.process.poll() is not None, LONGEST_S)
        assert (status(night.run).state, night.process.returncode) == (State.ABORTED, 4)
        ((_, text),) = night.sink.received
        assert text.startswith("calrig: small grid: aborted\n")


@pytest.mark.thorough
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="nobody else sets the limits of a process")
def test_who_rings_for_a_dead_run_needs_no_thread(tmp_path: Path) -> None:
    with a_night(tmp_path, 0.01, STACK_BYTES) as night:
        _takes_its_threads(night.guard_pid)
        night.process.kill()
        assert until(night.has_rung_out, LONGEST_S)
        assert [text.partition("\n")[0] for text in night.sink.of("/desk")] == ["calrig: small grid: interrupted"]
        assert len(night.sink.of("/others")) == 1


@pytest.mark.parametrize(
    ("how", "state"),
    [
        (signal.SIGTERM, State.STOPPED),
        pytest.param(signal.SIGQUIT, State.ABORTED, marks=pytest.mark.thorough),
    ],
)
def test_a_run_that_was_told_to_end_while_an_axis_moves_is_rung_for_by_no_guard(
    tmp_path: Path, how: signal.Signals, state: State
) -> None:
    with a_night(tmp_path, NEVER_MIN) as night:
        night.process.send_signal(how)
        assert until(lambda: night.process.poll() is not None, LONGEST_S)
        assert status(night.run).state is state
        assert not of_run(str(night.run), "."), "the guard has ended with it"
        assert read_guard_record(night.run) is None
        ((_, text),) = night.sink.received
        assert text.startswith(f"calrig: small grid: {state}\n"), "by the run itself, once"


@pytest.mark.thorough
def test_whoever_acknowledges_the_death_of_a_run_ends_its_alarm(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Until a resume journals it, status and handover say what happened, once each."""
    with a_night(tmp_path, NEVER_MIN) as night:
        night.process.kill()
        assert until(lambda: bool(night.sink.received), LONGEST_S)
        assert call(capsys, "ack", night.run, "I go and look").status == 0
        assert until(night.has_rung_out, LONGEST_S)
        assert len(night.sink.received) == 1
        told, page = call(capsys, "status", night.run).out, call(capsys, "handover", night.run).out
        assert "calrig: small grid: interrupted: delivered" in told
        assert "because: stop guard, " in told
        assert told.count("the engine ended without a word") == 1
        assert "state      interrupted since " in page
        assert re.search(r" UTC\)?: stop guard, ", page)


@pytest.mark.thorough
def test_where_the_guard_is_killed_too_nobody_is_told_anything(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Who waits for the heartbeat learns of it; nothing that is said is false."""
    with a_night(tmp_path, NEVER_MIN) as night:
        guard = psutil.Process(night.guard_pid)
        guard.suspend()
        night.process.kill()
        night.process.wait()
        guard.kill()
        assert until(lambda: not guard.is_running() or guard.status() == psutil.STATUS_ZOMBIE, LONGEST_S)
        assert not [
            entry for entry in psutil.process_iter(["cmdline"]) if str(night.run) in (entry.info["cmdline"] or ())
        ]
        assert (night.sink.received, read_guard_record(night.run)) == ([], None)
        assert status(night.run).state is State.INTERRUPTED
        assert "stop guard" not in call(capsys, "status", night.run).out
