"""A rehearsal as a user asks for it, ``calrig run … --rehearse``: 481 points × 6 replications × 3 axes.

Everything is in it: twins answering bytes in virtual time, journal, solution, report, coefficient set, exports. A
process of its own tells its time and the most memory it held. Then the run is solved again: solution, figures, report
as page and as PDF, sets.
"""

import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from timeit import Timer

from bench.figure import Effort, Figure

assert sys.platform != "win32", "it is measured with getrusage"

RIG = Path(__file__).parents[1] / "examples" / "rig.toml"
PROCEDURE = """
[procedure]
title = "three-axis, ±180°, six replications"
kind = "grid"
replications = 6
[design]
kind = "D1"
pitch_deg = { from = -180.0, to = 180.0, step = 10.0 }
roll_deg = { from = -180.0, to = 180.0, step = 30.0 }
"""
TINY = PROCEDURE.replace("step = 10.0", "step = 90.0").replace("step = 30.0", "step = 90.0").replace("= 6\n", "= 2\n")
DWELLS = 481 * 6
BYTES_PER_KIB = 1024


def figures(effort: Effort) -> Iterator[Figure]:
    """Seconds and megabytes of one rehearsal."""
    with TemporaryDirectory() as folder:
        procedure = Path(folder) / "procedure.toml"
        procedure.write_text(effort.amount(PROCEDURE, TINY), encoding="utf-8")
        runs = Path(folder) / "runs"
        rehearse = ["run", str(procedure), "--rig", str(RIG), "--rehearse", "--out", str(runs), "--json"]
        fractions: list[float] = []
        seconds = Timer(lambda: fractions.append(peak_mb(rehearse))).timeit(1)
        again = Timer(lambda: fractions.append(peak_mb(["solve", str(runs), "--json"]))).timeit(1)
        paper_mb = next(runs.glob("*/report.pdf")).stat().st_size / 1e6
    yield Figure(
        "rehearsal of 481 × 6, three axes",
        seconds,
        "s",
        30.0,
        at_most=True,
        note=f"{seconds / DWELLS * 1e3:.1f} ms a dwell",
    )
    yield Figure("  peak memory", fractions[0], "MB", 300.0, at_most=True)
    yield Figure("the same solved again, with its report", again, "s", 10.0, at_most=True)
    yield Figure("  peak memory", fractions[1], "MB", 400.0, at_most=True)
    yield Figure("  report.pdf", paper_mb, "MB", 5.0, at_most=True)


def peak_mb(arguments: list[str]) -> float:
    """Run a command in a new process; it writes the most memory it held as the last line of standard error."""
    command = [sys.executable, "-m", "bench.rehearsal", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{arguments[0]} failed with status {done.returncode}:\n{done.stderr}")
    return float(done.stderr.splitlines()[-1])


def main(arguments: list[str]) -> int:
    """The child: one command, then its peak memory."""
    from procedures.cli.main import run_command

    status = run_command(arguments)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * BYTES_PER_KIB / 1e6, file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
