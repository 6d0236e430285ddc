"""How long after Enter the first stop bytes leave: ``calrig abort`` and ``calrig jog --stop`` under load.

    python -m bench.stop_latency [--load 12] [--times 40]

Every time an engine turns a simulated stage over TCP; the shell's moment is that before the command's process is
started. Beside them: how long bare Python takes to start and end, which no command can beat.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path

import numpy as np
from psutil import getloadavg

from rig.clock import SystemClock

TESTS = Path(__file__).parents[1] / "tests" / "support"
sys.path.insert(0, str(TESTS))

guarded_engine = import_module("guarded_engine").guarded_engine
STAGE_FOR_ROLL = import_module("turning_rig").STAGE_FOR_ROLL
CLOCK = SystemClock()
BURN = "while True: pass"
STOP = b"stop"


def main() -> None:
    """Print the distribution of the latencies, milliseconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--load", type=int, default=12, help="processes that do nothing but count")
    parser.add_argument("--times", type=int, default=40)
    wanted = parser.parse_args()
    with ExitStack() as held:
        for _ in range(wanted.load):
            burner = held.enter_context(subprocess.Popen([sys.executable, "-S", "-c", BURN]))
            held.callback(burner.kill)
        bare = [_bare_s() for _ in range(wanted.times)]
        found = {
            "calrig abort": [_latency_s("abort") for _ in range(wanted.times)],
            "calrig jog --stop": [_latency_s("jog") for _ in range(wanted.times)],
        }
        load = getloadavg()[0]
    print(f"{wanted.times} times each, load {load:.1f} on {os.cpu_count()} processors; milliseconds")
    print(f"{'':<24}{'p50':>8}{'p95':>8}{'most':>8}")
    for name, seconds in {"bare python -S -c pass": bare, **found}.items():
        p50, p95, most = (1000.0 * float(np.percentile(seconds, part)) for part in (50, 95, 100))
        print(f"{name:<24}{p50:>8.0f}{p95:>8.0f}{most:>8.0f}")


def _bare_s() -> float:
    begun_s = CLOCK.monotonic_s()
    subprocess.run([sys.executable, "-S", "-c", "pass"], check=True)
    return CLOCK.monotonic_s() - begun_s


def _latency_s(command: str) -> float:
    with tempfile.TemporaryDirectory() as name, guarded_engine(Path(name), STAGE_FOR_ROLL) as engine:
        words = {
            "abort": ["abort", "--out", str(engine.run.parent)],
            "jog": ["jog", "--rig", str(engine.rig_file), "--stop"],
        }[command]
        calrig = Path(sys.executable).with_name("calrig")
        begun_s = CLOCK.monotonic_s()
        with subprocess.Popen([str(calrig), *words], stdout=subprocess.DEVNULL):
            assert engine.until(lambda: engine.line.first_s(STOP, begun_s) is not None, 30.0)
        latency_s: float | None = engine.line.first_s(STOP, begun_s)
        assert latency_s is not None
        return latency_s


if __name__ == "__main__":
    main()
