"""How long after Enter the first stop bytes leave: ``calrig abort`` and ``calrig jog --stop`` under load.

    python -m bench.stop_latency [--load 12] [--times 100]

Every time an engine turns a simulated stage over TCP; the shell's moment is that before the command's process is
started. The load comes a second before that and goes behind it, so that the engines begin sooner; it stands in the
session of the command, where the system gives it the same share of a processor. Beside them: how long bare Python takes
to start and end, which no command can beat. Bytecode is there, as `pip` makes it (`uv` with ``--compile-bytecode``).
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from importlib import import_module
from pathlib import Path

import numpy as np

from rig.clock import SystemClock

assert sys.platform != "win32", "processes are held by SIGSTOP"

TESTS = Path(__file__).parents[1] / "tests" / "support"
sys.path.insert(0, str(TESTS))

guarded_engine = import_module("guarded_engine").guarded_engine
STAGE_FOR_ROLL = import_module("turning_rig").STAGE_FOR_ROLL
CLOCK = SystemClock()
BURN = "while True: pass"
STEADY_S = 1.0
STOP = b"stop"
CALRIG = str(Path(sys.executable).with_name("calrig"))
INSTALLED = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


class Load:
    """Processes that do nothing but count, when they are let."""

    def __init__(self, held: ExitStack, count: int) -> None:
        self._burners = [held.enter_context(subprocess.Popen([sys.executable, "-S", "-c", BURN])) for _ in range(count)]
        self.runnable: list[int] = []
        for burner in self._burners:
            held.callback(burner.kill)
        self._all(signal.SIGSTOP)

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Be a steady load."""
        self._all(signal.SIGCONT)
        CLOCK.sleep(STEADY_S)
        self.runnable.append(int(Path("/proc/loadavg").read_text(encoding="ascii").split()[3].partition("/")[0]))
        try:
            yield
        finally:
            self._all(signal.SIGSTOP)

    def _all(self, number: signal.Signals) -> None:
        for burner in self._burners:
            burner.send_signal(number)


def main() -> None:
    """Print the distribution of the latencies, milliseconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--load", type=int, default=12, help="processes that do nothing but count")
    parser.add_argument("--times", type=int, default=100)
    wanted = parser.parse_args()
    found: dict[str, list[float]] = {"bare python -S -c pass": [], "calrig abort": [], "calrig jog --stop": []}
    with ExitStack() as held:
        load = Load(held, wanted.load)
        for words in (["abort", "--out", os.devnull], ["jog", "--rig", os.devnull, "--stop"]):
            subprocess.run([CALRIG, *words], env=INSTALLED, capture_output=True, check=False)
        for _ in range(wanted.times):
            with load.at_work():
                found["bare python -S -c pass"].append(_bare_s())
            for command in ("abort", "jog --stop"):
                found[f"calrig {command}"].append(_latency_s(command, load))
    runnable = np.median(load.runnable)
    print(f"{wanted.times} times each, {runnable:.0f} processes on {os.cpu_count()} processors; milliseconds")
    print(f"{'':<24}{'p50':>8}{'p95':>8}{'most':>8}")
    for name, seconds in found.items():
        p50, p95, most = (1000.0 * float(np.percentile(seconds, part)) for part in (50, 95, 100))
        print(f"{name:<24}{p50:>8.0f}{p95:>8.0f}{most:>8.0f}")


def _bare_s() -> float:
    begun_s = CLOCK.monotonic_s()
    subprocess.run([sys.executable, "-S", "-c", "pass"], check=True)
    return CLOCK.monotonic_s() - begun_s


def _see_first() -> None:
    """Run the threads that note the bytes before all else, where the system permits it: they are no part of it."""
    if sys.platform.startswith("linux"):
        first = os.sched_param(os.sched_get_priority_min(os.SCHED_RR))
        for thread in os.listdir("/proc/self/task"):
            if int(thread) != os.getpid():
                with suppress(PermissionError, ProcessLookupError):
                    os.sched_setscheduler(int(thread), os.SCHED_RR, first)


def _latency_s(command: str, load: Load) -> float:
    with tempfile.TemporaryDirectory() as name, guarded_engine(Path(name), STAGE_FOR_ROLL) as engine:
        words = {
            "abort": ["abort", "--out", str(engine.run.parent)],
            "jog --stop": ["jog", "--rig", str(engine.rig_file), "--stop"],
        }[command]
        _see_first()
        with load.at_work():
            begun_s = CLOCK.monotonic_s()
            with subprocess.Popen([CALRIG, *words], env=INSTALLED, stdout=subprocess.DEVNULL):
                assert engine.until(lambda: engine.line.first_s(STOP, begun_s) is not None, 30.0)
        latency_s: float | None = engine.line.first_s(STOP, begun_s)
        assert latency_s is not None
        return latency_s


if __name__ == "__main__":
    main()
