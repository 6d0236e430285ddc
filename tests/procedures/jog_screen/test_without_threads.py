"""The bench where no thread can be had, or none any more: it ends with a sentence, and every axis stands."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from procedures.jog_screen.served import jog_for_pages
from rig import threads
from rig.assembly.open_rig import open_rig
from rig.clock import SystemClock
from rig.description.read import read_rig

LIMITS = 'ulimit -s 8000000; ulimit -v 6000000; exec "$0" "$@"'
"""A thread takes more of the addresses than a process may have: there is none, and no want of memory for all else."""
ALERTS = "import sys; open(sys.argv[1], 'w').write(sys.stdin.read())"
PIECES = ("the guard of the bench", "the end of the bench", "the bench", "the orders of the console")


def _without_threads(*words: str | Path) -> "subprocess.CompletedProcess[str]":
    command = ["sh", "-c", LIMITS, sys.executable, "-m", "procedures.cli.main", *map(str, words)]
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.thorough
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere stacks count for nothing")
def test_commands_without_a_thread_end_with_a_sentence_or_do_their_work(tmp_path: Path) -> None:
    file, heard = tmp_path / "alerts.toml", tmp_path / "heard.txt"
    file.write_text(f"command = {json.dumps([sys.executable, '-c', ALERTS, str(heard)])}\n", encoding="utf-8")
    with served(tmp_path, SystemClock(), STAGE_FOR_ROLL, QUICK_METER, pty=True) as (_, rig_file):
        bench = _without_threads("jog", "--rig", rig_file, "--served")
        assert (bench.returncode, bench.stdout) == (1, "")
        assert bench.stderr.startswith("calrig: no thread could be begun for the end of the bench: no memory is left")
        assert bench.stderr.endswith("end other programs, or raise what this account or unit may have\n")
        stop = _without_threads("jog", "--rig", rig_file, "--stop")
        assert (stop.returncode, stop.stderr) == (0, "")
        assert "roll: stands still at" in stop.stdout
    assert _without_threads("alerts", file, "--test").returncode == 0
    assert heard.read_text(encoding="utf-8").startswith("calrig: a trial of the alerts\n")


@pytest.mark.parametrize("piece", PIECES)
def test_a_bench_that_gets_no_thread_for_a_part_of_it_ends_and_serves_nobody(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, piece: str
) -> None:
    offer = threads.BegunThread.offer
    monkeypatch.setattr(threads.BegunThread, "offer", lambda thread: thread.name != piece and offer(thread))
    console, ours = os.pipe()
    with served(tmp_path, SystemClock(), STAGE_FOR_ROLL, QUICK_METER, pty=True) as (simulated, rig_file):
        described, log, out = read_rig(rig_file), tmp_path / "jog.jsonl", io.BytesIO()
        with (
            os.fdopen(console, "rb", buffering=0) as orders,
            open_rig(described, rig_file=rig_file) as rig,
            pytest.raises(MemoryError, match=f"no thread could be begun for {piece}:"),
        ):
            jog_for_pages(rig, log, tmp_path / "snapshots.csv", None, orders, out, pytest.fail)
        now_s = SystemClock().monotonic_s()
        assert all(axis.rate_dps(now_s) == 0.0 for axis in simulated.world.axes.values())
    os.close(ours)
    assert out.getvalue() == b""
