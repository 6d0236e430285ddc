"""Laws of the stop guard: the stops go within half a second of an engine that dies or freezes while an axis turns."""

import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from guarded_engine import CLOCK, guarded_engine
from turning_rig import DRIVE_FOR_ROLL, SERVO_FOR_PITCH, STAGE_FOR_ROLL, served

from procedures.journal.guard_record import guard_told, read_guard_record
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.guard.ask import of_rig, of_run, stop
from rig.guard.stop_guard import RECORD
from rig.motion.move import home_and_arrive

FAMILIES = {
    "zaber": (STAGE_FOR_ROLL, "roll", 8.0, b"stop"),
    "oriental-az": (DRIVE_FOR_ROLL, "roll", 8.0, bytes.fromhex("1000 7c0002 04 0000 0020")),
    "maestro": (SERVO_FOR_PITCH, "pitch", 0.0, b"\x84\x00"),
    "indexing-table": (("", ""), "roll", 0.0, b"2 STOP\r\n"),
}
ENDS = {"KILL": signal.SIGKILL, "QUIT": signal.SIGQUIT, "STOP": signal.SIGSTOP}
LIMIT_S = 0.5
"""What is promised; held by `make soak` on a machine that does nothing else."""
BUSY_LIMIT_S = 5.0
"""Told from never: on a busy machine the guard waits for a processor as everybody does."""
REST_S = 3.0
"""The machine's own deceleration, and on the bench's processors much else to do."""


def _ends_in_stopped_axes(
    folder: Path, family: str, end: str, after_s: float = 0.3, *, limit_s: float = BUSY_LIMIT_S
) -> None:
    change, axis, rate_dps, stop_bytes = FAMILIES[family]
    with guarded_engine(folder, change, axis, rate_dps) as engine:
        assert engine.until(lambda: engine.rate_dps != 0.0, 5.0)  # a table lifts first
        CLOCK.sleep(after_s)
        ended_s = CLOCK.monotonic_s()
        os.kill(engine.process.pid, ENDS[end])
        assert engine.until(lambda: engine.line.first_s(stop_bytes, ended_s) is not None, 5.0)
        first_s = engine.line.first_s(stop_bytes, ended_s)
        assert first_s is not None
        assert first_s <= limit_s
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
        assert engine.process.wait(5.0) < 0, "a frozen engine is ended: thawed, it would go on"
        assert engine.until(lambda: (engine.run / RECORD).exists(), 5.0)
        record = read_guard_record(engine.run)
        assert record is not None
        assert axis in record["moving"]
        assert set(record["axes"].values()) == {"told to stop"}
        assert "every axis was told to stop" in guard_told(record)


@pytest.mark.parametrize(
    ("family", "end"),
    [("zaber", "KILL"), ("oriental-az", "STOP"), ("maestro", "QUIT")],
)
def test_an_engine_that_dies_or_freezes_leaves_its_axes_standing(tmp_path: Path, family: str, end: str) -> None:
    _ends_in_stopped_axes(tmp_path, family, end)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(200))
def test_an_engine_that_dies_at_any_moment_leaves_its_axes_standing(tmp_path: Path, number: int) -> None:
    chance = np.random.default_rng(number)
    family, end = sorted(FAMILIES)[number % len(FAMILIES)], sorted(ENDS)[number // len(FAMILIES) % len(ENDS)]
    _ends_in_stopped_axes(tmp_path, family, end, float(chance.uniform(0.0, 1.0)), limit_s=LIMIT_S)


def test_an_engine_whose_guard_is_killed_stops_its_axes_and_says_so(tmp_path: Path) -> None:
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        os.kill(engine.guard_pid, signal.SIGKILL)
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
        assert engine.process.wait(10.0) == 1


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


@pytest.mark.parametrize("command", ["abort", "jog"])
def test_a_stop_from_the_shell_goes_by_the_guard(tmp_path: Path, command: str) -> None:
    with guarded_engine(tmp_path, STAGE_FOR_ROLL) as engine:
        words = {
            "abort": ["abort", "--out", str(tmp_path / "runs"), "--operator", "ann"],
            "jog": ["jog", "--rig", str(engine.rig_file), "--stop", "--json"],
        }[command]
        told = _calrig(words)
        assert told.returncode == 0, told.stderr
        assert "roll" in told.stdout
        assert engine.until(lambda: engine.rate_dps == 0.0, REST_S)
        if command == "abort":
            (request,) = (engine.run / "requests").glob("*-abort.json")
            assert json.loads(request.read_text(encoding="utf-8"))["by"] == "ann"


def test_a_guard_that_is_gone_leaves_the_long_way(tmp_path: Path) -> None:
    told = _calrig(["abort", "--out", str(tmp_path)])
    assert told.returncode == 2
    assert told.stderr


def _calrig(words: list[str]) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "procedures.cli.start", *words], capture_output=True, text=True, timeout=60, check=False
    )


def test_an_engine_that_says_goodbye_leaves_no_record_and_no_guard(tmp_path: Path) -> None:
    """Everything that it moved stands by then; a jog over real ports does so."""
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (_, rig_file):
        with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
            rig.belongs_to(tmp_path)
            assert not of_rig(str(rig_file)), "nothing has moved yet"
            home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
            assert of_rig(str(rig_file))
        assert not of_rig(str(rig_file))
        assert not (tmp_path / RECORD).exists()
