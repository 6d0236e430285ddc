"""Rig and procedure of a small but whole job, as files, and the twins of a rig served by another process."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from example_files import EXAMPLE_RIG

SMALL = """
[procedure]
title = "small"
kind = "grid"
replications = 2
[design]
kind = "D1"
pitch_deg = { from = -60.0, to = 60.0, step = 60.0 }
roll_deg = { from = -180.0, to = 90.0, step = 90.0 }
[dwell]
samples = 5
settle = { window_s = 0.5, windows = 2, min_s = 0.5, max_s = 30.0 }
[check]
reference_every = 5
[export]
formats = ["csv", "mat"]
"""

SPEED_DPS = 90.0
"""The example's own axes take their time, and are looked at all the while."""


def job(
    folder: Path, changes: dict[str, str] | None = None, rig_changes: dict[str, str] | None = None
) -> tuple[str, str]:
    """Paths of ``procedure.toml`` and ``rig.toml`` in ``folder``, with pieces of their text replaced."""
    rig = EXAMPLE_RIG.read_text(encoding="utf-8").replace("speed_dps = 5.0", f"speed_dps = {SPEED_DPS}")
    texts = {"procedure.toml": (SMALL, changes), "rig.toml": (rig, rig_changes)}
    for name, (text, wanted) in texts.items():
        for old, new in (wanted or {}).items():
            assert old in text, old
            text = text.replace(old, new)
        (folder / name).write_text(text, encoding="utf-8")
    return str(folder / "procedure.toml"), str(folder / "rig.toml")


@contextmanager
def simulated(rig: str, written: Path, *options: str) -> Iterator[dict[str, str]]:
    """``calrig simulate`` in a process of its own; yields the addresses that it printed."""
    command = [sys.executable, "-m", "procedures.cli.main", "simulate", rig, "--write", str(written), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        line = process.stdout.readline()
        assert line, process.stderr.read()
        try:
            yield json.loads(line)
        finally:
            process.terminate()
            process.wait(10)
    assert process.returncode == 0
