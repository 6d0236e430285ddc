"""A small run on twins in memory: 12 attitudes, twice, three channels, a reference now and then."""

import os
import signal
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import NoReturn

from procedures.description.named_files import files_named_by
from procedures.journal.header import RunHeader, make_header
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Request, Spool
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord
from procedures.records.progress import Progress
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from procedures.run.resume import resume
from rig.assembly.open_rig import open_rig
from rig.clock import SystemClock
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

RIG = """
[rig]
name = "bench of twins"
gravity_mps2 = 9.80665
[axes.pitch]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 180.0
axis = 1
[axes.roll]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 180.0
axis = 2
[readouts.dmm]
driver = "hp3458a"
resource = "twin"
nplc = 1
channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, z = { scanner = 3, range_v = 10.0 } }
[environment.air]
driver = "watlow-f4"
port = "twin"
[sensors.SN1]
model = "three-axis package"
channels = { x = "dmm.x", y = "dmm.y", z = "dmm.z" }
nominal_sensitivity_v_per_g = 2.5
[twin]
seed = 7
[twin.truth.SN1]
x = { offset_v = 0.005, sensitivity_v_per_g = 2.5, coning_deg = 0.5, azimuth_deg = 35.0, noise_v = 2e-5 }
y = { offset_v = -0.003, sensitivity_v_per_g = 2.48, coning_deg = 0.3, azimuth_deg = -110.0, noise_v = 2e-5 }
z = { offset_v = 0.008, sensitivity_v_per_g = 2.52, coning_deg = 0.4, azimuth_deg = 160.0, noise_v = 2e-5 }
"""  # noqa: E501
PROCEDURE = """
[procedure]
title = "small grid"
kind = "grid"
replications = 2
[design]
kind = "D"
pitch_deg = { from = -30.0, to = 30.0, step = 30.0 }
roll_deg = { from = -180.0, to = 90.0, step = 90.0 }
[dwell]
samples = 5
settle = { window_s = 0.25, min_s = 0.5 }
[check]
reference_every = 7
"""
QUICK_SETTLE = "settle = { window_s = 0.25, min_s = 0.5 }"
"""Where what settles slowly is what a test is about, it replaces this line."""


@dataclass(frozen=True)
class Bench:
    """Files of a small run and what is made of them."""

    folder: Path
    rig: RigDescription
    plan: Plan

    def header(self, run_dir: Path) -> RunHeader:
        files = self.folder / "rig.toml", self.folder / "procedure.toml"
        named = files_named_by(self.rig, files[0], read_procedure(files[1]))
        return make_header(run_dir.name, self.plan, self.rig, *files, "tester", datetime.now(UTC), named_files=named)

    def run(self, run_dir: Path, **collaborators: object) -> Outcome:
        """A new run in a folder that is made here."""
        run_dir.mkdir()
        with open_rig(self.rig) as rig:
            return begin(run_dir, self.header(run_dir), self.plan, rig, **collaborators)  # type: ignore[arg-type]


def bench(folder: Path, rig: tuple[tuple[str, str], ...] = (), procedure: tuple[tuple[str, str], ...] = ()) -> Bench:
    """The files in ``folder``, with pieces of their text replaced."""
    rig_file = _written(folder / "rig.toml", RIG, rig)
    procedure_file = _written(folder / "procedure.toml", PROCEDURE, procedure)
    description = read_rig(rig_file)
    return Bench(folder, description, make_plan(description, read_procedure(procedure_file)))


def _written(path: Path, text: str, changes: tuple[tuple[str, str], ...]) -> Path:
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


class StopAt:
    """Asks for a stop after so many design dwells."""

    def __init__(self, run_dir: Path, dwells: int) -> None:
        self._spool, self._dwells = Spool(run_dir), dwells

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done == self._dwells:
            self._spool.submit(Request("stop", "anna", "2026-03-01T12:00:00+00:00", "lunch"))


def dwells_of(run_dir: Path) -> list[DwellRecord]:
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        return list(reader.dwells())


def measured(dwells: list[DwellRecord]) -> dict[int, tuple[object, ...]]:
    """Step to everything measured in its accepted dwell, bit by bit, but for when; refuses a step accepted twice."""
    found: dict[int, tuple[object, ...]] = {}
    for dwell in dwells:
        if dwell.accepted and dwell.purpose != "check":
            assert dwell.step not in found, f"step {dwell.step} was accepted twice"
            samples = {channel: reading.samples.tobytes() for channel, reading in dwell.readings.items()}
            found[dwell.step] = (
                dwell.replication,
                dwell.point,
                dwell.attempt,
                dict(dwell.targets_deg),
                dict(dwell.measured_deg),
                dict(dwell.temperature_degc),
                samples,
            )
    return found


def measured_in(run_dir: Path) -> dict[int, tuple[object, ...]]:
    """As :func:`measured`, of a run's folder."""
    return measured(dwells_of(run_dir))


def in_child(work: Callable[[], object]) -> int:
    """Do ``work`` in a process of its own; returns its process id."""
    child = os.fork()
    if child == 0:
        _work_and_leave(work)
    return child


def _work_and_leave(work: Callable[[], object]) -> NoReturn:
    status = 1
    try:
        work()
        status = 0
    finally:
        os._exit(status)


def killed_after(child: int, delay_s: float) -> bool:
    """Let the child work for ``delay_s``, then SIGKILL it; True where the signal found it alive."""
    SystemClock().sleep(delay_s)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    return os.WIFSIGNALED(status)


def resumed(run_dir: Path) -> Outcome:
    return resume(run_dir, "tester", "after the kill")
