"""An engine, its stop guard and its machine in processes and threads of their own: what reaches the machine, and when.

The engine turns an axis, or drives it on and on, over a proxy that notes the moment of every piece of bytes. It is
ended in the ways in which processes end.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recording_proxy import RecordingProxy
from turning_rig import served

from rig.assembly.simulate import SimulatedRig
from rig.clock import SystemClock

CLOCK = SystemClock()
BEGIN_S = 60.0
ROOM_BYTES = 32 << 20
"""What an engine that runs out of memory may still take."""
RINGS = "import sys; print(sys.argv[2], file=open(sys.argv[1], 'a'))"
ENGINE = """
import resource
import signal
import sys
from pathlib import Path
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.errors import WaitEnded
from rig.motion.move import home_and_arrive, move_and_arrive

hoard = []

def run_out_of_memory(number, frame):
    with open("/proc/self/statm") as pages:
        taken = int(pages.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + ROOM, taken + ROOM))
    for size in (1 << 20, 1 << 14, 1 << 10):
        try:
            while True:
                hoard.append(bytearray(size))
        except MemoryError:
            pass
    raise MemoryError("an allocation failed, and nothing was given back")

def take_memory_for_ever(number, frame):
    while True:
        hoard.append(bytearray(b"x" * (1 << 20)))

def work_for_ever(number, frame):
    while True:
        pass

signal.signal(signal.SIGUSR2, work_for_ever)
signal.signal(signal.SIGRTMIN, take_memory_for_ever)
signal.signal(signal.SIGQUIT, signal.SIG_DFL)  # what began in a background is born deaf to it
signal.signal(signal.SIGUSR1, run_out_of_memory)
path, axis, rate_dps, run = Path(sys.argv[1]), sys.argv[2], float(sys.argv[3]), Path(sys.argv[4])
with open_rig(read_rig(path), rig_file=path, purpose="test") as rig:
    rig.belongs_to(run, (sys.executable, "-c", RINGS, str(run / "rung.jsonl")))
    clock, turning = rig.clock, rig.axes[axis]
    home_and_arrive(turning, clock, clock.sleep)
    if rate_dps:
        turning.start_rate(rate_dps)
    else:
        turning.start_move(turning.limits_deg[1])
    clock.sleep(0.2)
    print("turning", rig._guard.pid, flush=True)
    try:
        while True:
            turning.turn_look(clock) if rate_dps else turning.state()
            clock.sleep(0.1)
    except WaitEnded:
        if sys.argv[5] != "stays":
            raise
        while True:
            clock.sleep(1.0)
""".replace("ROOM", str(ROOM_BYTES)).replace(
    "RINGS", repr("import sys; print(sys.argv[2], file=open(sys.argv[1], 'a'))")
)


@dataclass
class GuardedEngine:
    """One that is at work: its axis turns."""

    process: "subprocess.Popen[str]"
    guard_pid: int
    line: RecordingProxy
    simulated: SimulatedRig
    axis: str
    rig_file: Path
    run: Path

    @property
    def rung(self) -> list[dict[str, Any]]:
        """What was told to people, each as the guard knows it."""
        return rung_in(self.run / "rung.jsonl")

    @property
    def rate_dps(self) -> float:
        return self.simulated.world.axes[self.axis].rate_dps(CLOCK.monotonic_s())

    def until(self, is_so: Callable[[], bool], limit_s: float) -> bool:
        return until(is_so, limit_s)


def until(is_so: Callable[[], bool], limit_s: float) -> bool:
    """Whether it came to be so within that time."""
    ends_s = CLOCK.monotonic_s() + limit_s
    while not is_so():
        if CLOCK.monotonic_s() > ends_s:
            return False
        CLOCK.sleep(0.005)
    return True


def rung_in(file: Path) -> list[dict[str, Any]]:
    """What RINGS wrote, whole lines."""
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True) if file.exists() else []
    return [json.loads(line) for line in lines if line.endswith("\n")]


@contextmanager
def guarded_engine(
    folder: Path, change: tuple[str, str], axis: str = "roll", rate_dps: float = 8.0, *, stays: bool = False
) -> Iterator[GuardedEngine]:
    """An engine in its own process group whose axis turns at a rate (0: is on its way to the end of its limits).

    ``stays``: it lives on when the guard was asked to stop the axes, so that it can be asked again.
    """
    with served(folder, SystemClock(), change) as (simulated, rig_file):
        address = simulated.addresses[f"axes.{axis}"]
        host, _, port = address.removeprefix("socket://").rpartition(":")
        line = RecordingProxy((host, int(port)))
        rig_file.write_text(rig_file.read_text(encoding="utf-8").replace(address, line.address), encoding="utf-8")
        run = folder / "runs" / "night"
        run.mkdir(parents=True)
        process = subprocess.Popen(
            [sys.executable, "-c", ENGINE, str(rig_file), axis, str(rate_dps), str(run), "stays" * stays],
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            assert process.stdout is not None
            word, _, pid = process.stdout.readline().partition(" ")
            assert word == "turning", "the engine ended before its axis turned"
            yield GuardedEngine(process, int(pid), line, simulated, axis, rig_file, run)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, 9)
            process.wait()
            if process.stdout is not None:
                process.stdout.close()
            line.close()
