"""What a user waits for before anything happens, whole processes: two imports and ``calrig --help``."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from bench.figure import Effort, Figure

CALRIG = Path(sys.executable).with_name("calrig")


def figures(effort: Effort) -> Iterator[Figure]:
    """Seconds of a new process, its interpreter included."""
    bare_s = process_s(effort, [sys.executable, "-c", "pass"])
    ams_s = process_s(effort, [sys.executable, "-c", "import ams"])
    yield Figure("import ams", ams_s, "s", 0.25, at_most=True, note=f"a bare interpreter takes {bare_s:.3f} s")
    calrig_s = process_s(effort, [sys.executable, "-c", "import calrig"])
    yield Figure("import calrig", calrig_s, "s", bare_s + 0.1, at_most=True, note="a bare interpreter and 0.1 s")
    yield Figure("calrig --help", process_s(effort, [str(CALRIG), "--help"]), "s", 0.4, at_most=True)


def process_s(effort: Effort, command: list[str]) -> float:
    """Return the best of five runs."""
    return effort.best_s(lambda: subprocess.run(command, check=True, capture_output=True), least_total_s=0.0)
