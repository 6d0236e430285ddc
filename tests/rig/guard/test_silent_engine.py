"""An engine without memory, or one that hangs, while an axis turns at a rate: over a pseudo-terminal, in real time.

``starve`` takes every byte that the process may still have and keeps it: whatever asks for memory next fails.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from guarded_engine import CLOCK, rung_in, until
from turning_rig import STAGE_FOR_ROLL, served

from procedures.journal.sidecar.guard_record import guard_sentence, read_guard_record
from rig.assembly.simulate import SimulatedRig

RATE_DPS = 20.0
STANDS_S = 2.0
"""After its memory is gone: the stop, the machine's deceleration, and what a busy machine makes of both."""
SILENCE_S = 5.0
"""What is promised of an axis that turns."""
BUSY_S = 3.0
ENGINE = """
import resource, signal, sys, threading
from pathlib import Path
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.motion.jog import turn_for
from rig.motion.move import home_and_arrive

hoard = []

def starve(number, frame):
    with open("/proc/self/statm") as pages:
        taken = int(pages.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + (32 << 20),) * 2)
    for size in (1 << 20, 1 << 14, 1 << 10, 256, 64):
        try:
            while True:
                hoard.append(bytearray(size))
        except MemoryError:
            pass

def hang(number, frame):
    threading.Event().wait()

def only_lives(number, frame):
    for _ in range(40):
        rig.sign_of_life()
        rig.clock.sleep(0.2)

signal.signal(signal.SIGUSR1, starve)
signal.signal(signal.SIGUSR2, hang)
signal.signal(signal.SIGRTMIN, only_lives)
path, axis, run = Path(sys.argv[1]), "roll", Path(sys.argv[2])
with open_rig(read_rig(path), rig_file=path, purpose="test") as rig:
    rig.belongs_to(run, (sys.executable, "-c", "import sys; print(sys.argv[2], file=open(sys.argv[1], 'a'))",
                         str(run / "rung.jsonl")))
    home_and_arrive(rig.axes[axis], rig.clock, rig.clock.sleep)
    print("homed", flush=True)
    turn_for(rig, axis, float(sys.argv[3]), 600.0, rig.clock.sleep)
"""


@dataclass
class Turning:
    """An engine whose axis turns."""

    process: "subprocess.Popen[str]"
    simulated: SimulatedRig
    run: Path

    @property
    def rate_dps(self) -> float:
        return self.simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s())

    def record(self) -> dict[str, Any]:
        assert until(lambda: read_guard_record(self.run) is not None, BUSY_S)
        return dict(read_guard_record(self.run) or {})


@contextmanager
def _turning(folder: Path) -> Iterator[Turning]:
    with served(folder, CLOCK, STAGE_FOR_ROLL, pty=True) as (simulated, rig_file):
        run = folder / "night"
        run.mkdir()
        command = [sys.executable, "-c", ENGINE, str(rig_file), str(run), str(RATE_DPS)]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
        )
        engine = Turning(process, simulated, run)
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "homed\n"
            assert until(lambda: engine.rate_dps == RATE_DPS, BUSY_S + SILENCE_S), "it never turned"
            yield engine
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            if process.stdout is not None:
                process.stdout.close()


@pytest.mark.parametrize(
    "after_s", [0.1, *(pytest.param(after, marks=pytest.mark.thorough) for after in (0.0, 0.2, 0.35))]
)
def test_fault_74_hungry_an_engine_whose_memory_is_gone_while_an_axis_turns_leaves_it_standing(
    tmp_path: Path, after_s: float
) -> None:
    """Detected: an allocation fails, somewhere. Response: on the way out the stop guard is asked first, by bytes that
    are there already; no stop waits for a new thread.
    """
    with _turning(tmp_path) as engine:
        CLOCK.sleep(after_s)
        os.kill(engine.process.pid, signal.SIGUSR1)
        assert until(lambda: engine.rate_dps == 0.0, STANDS_S)
        assert engine.process.wait(30.0) != 0
        why = engine.record()["why"]
        assert "it had every axis stopped before, since it met a defect or had no memory left" in why
        assert engine.rate_dps == 0.0


def test_fault_74_hung_an_engine_that_hangs_while_an_axis_turns_is_stopped_within_seconds(tmp_path: Path) -> None:
    """Detected: no sign of life. Response: the guard stops the axes, ends the engine, and tells people."""
    with _turning(tmp_path) as engine:
        hung_s = CLOCK.monotonic_s()
        os.kill(engine.process.pid, signal.SIGUSR2)
        assert until(lambda: engine.rate_dps == 0.0, SILENCE_S + BUSY_S)
        assert CLOCK.monotonic_s() - hung_s > 0.8 * SILENCE_S, "too soon: a busy machine would be taken for a dead one"
        assert engine.process.wait(BUSY_S) == -signal.SIGKILL
        assert "the engine gave no sign of life for 5 s; it was ended" in guard_sentence(engine.record())
        assert until(lambda: bool(rung_in(engine.run / "rung.jsonl")), BUSY_S)


def test_an_engine_that_waits_for_something_else_while_an_axis_turns_and_says_so_is_left_alone(tmp_path: Path) -> None:
    """A channel may be read for longer than a silence is borne."""
    with _turning(tmp_path) as engine:
        os.kill(engine.process.pid, signal.SIGRTMIN)
        assert not until(lambda: engine.rate_dps != RATE_DPS, SILENCE_S + 2.0)
        assert engine.process.poll() is None
