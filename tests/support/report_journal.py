"""A journal written by hand: the example rig's truth seen through explicit rotations, a pause and a rejected dwell."""

from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from procedures.journal.header import make_header
from procedures.journal.journal import Journal
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell
from procedures.records.dwells import ChannelReading, DwellRecord
from rig.clock import VirtualClock
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

START = datetime(2026, 3, 1, 18, 0, tzinfo=UTC)
EXAMPLE_RIG = Path(__file__).parents[2] / "examples" / "rig.toml"
PROCEDURE = """
[procedure]
title = "small grid, three replications"
kind = "grid"
replications = 3
[design]
kind = "D1"
pitch_deg = { from = -60.0, to = 60.0, step = 30.0 }
roll_deg = { from = -180.0, to = 180.0, step = 60.0 }
[check]
reference_every = 20
"""


@dataclass(frozen=True)
class Slip:
    """From a step on the roll axis stands beside what it reads."""

    step: int
    roll_deg: float


NO_SLIP = Slip(0, 0.0)


def write_journal(
    folder: Path, *, until_step: int | None = None, slip: Slip = NO_SLIP, procedure: str = PROCEDURE
) -> Path:
    """A finished run, or one that was aborted at a step."""
    procedure_path = folder / "procedure.toml"
    procedure_path.write_text(procedure, encoding="utf-8")
    rig = read_rig(EXAMPLE_RIG)
    plan = make_plan(rig, read_procedure(procedure_path))
    clock = VirtualClock(START)
    header = make_header("20260301T180000Z-small", plan, rig, EXAMPLE_RIG, procedure_path, "A. Operator", START)
    journal = Journal.create(folder / "journal.sqlite", header, clock)
    _tell(journal, clock, "checking", "running")
    for record in _records(plan, rig, slip):
        if record.step == until_step:
            break
        clock.sleep(30.0)
        journal.commit_dwell(record, clock)
        if record.step == 40:
            _tell(journal, clock, "paused")
            clock.sleep(600.0)
            _tell(journal, clock, "running")
    _tell(journal, clock, "finished" if until_step is None else "aborted")
    journal.close()
    return folder / "journal.sqlite"


def _tell(journal: Journal, clock: VirtualClock, *states: str) -> None:
    for state in states:
        journal.append_event("state", {"to": state, "by": "A. Operator", "reason": ""}, clock)


def _records(plan: Plan, rig: RigDescription, slip: Slip) -> list[DwellRecord]:
    chance = np.random.default_rng(11)
    records = []
    for dwell in plan.dwells:
        record = _record(dwell, rig, chance, slip.roll_deg if dwell.step >= slip.step else 0.0)
        if dwell.step == 30:
            records.append(replace(record, accepted=False, reasons=("scatter 4.1 times the reference",)))
            record = replace(record, attempt=2)
        records.append(record)
    return records


def _record(dwell: Dwell, rig: RigDescription, chance: np.random.Generator, slipped_deg: float) -> DwellRecord:
    assert rig.twin is not None
    force = _force(*np.deg2rad([dwell.targets_deg["pitch"], dwell.targets_deg["roll"] + slipped_deg]))
    readings = {}
    for axis, truth in rig.twin.truth["SN1047"].items():
        direction = _direction(str(axis), np.deg2rad(truth.coning_deg), np.deg2rad(truth.azimuth_deg))
        mean_v = truth.offset_v + truth.sensitivity_v_per_g * float(direction @ force)
        samples = mean_v + truth.noise_v * chance.normal(size=20)
        readings[f"dmm.{axis}"] = ChannelReading(f"dmm.{axis}", samples, 30.0 * dwell.step, 0.2)
    started = START + timedelta(seconds=30.0 * dwell.step)
    return DwellRecord(
        dwell.step, dwell.purpose, dwell.replication, dwell.point, 1, 1, True, (), dwell.targets_deg, dwell.targets_deg,
        {"air": 20.0 + 0.02 * chance.normal()}, readings, started, started + timedelta(seconds=10),
        30.0 * dwell.step, 30.0 * dwell.step + 10.0, 2.0, "",
    )  # fmt: skip


def _force(pitch_rad: float, roll_rad: float) -> np.ndarray:
    """Specific force at rest: (0, 0, −1) turned by pitch, then by roll, as explicit matrices."""
    c, s = np.cos(pitch_rad), np.sin(pitch_rad)
    about_y = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    c, s = np.cos(roll_rad), np.sin(roll_rad)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    return about_x @ about_y @ np.array([0.0, 0.0, -1.0])


def _direction(axis: str, coning_rad: float, azimuth_rad: float) -> np.ndarray:
    i = "xyz".index(axis)
    direction = np.zeros(3)
    direction[i] = np.cos(coning_rad)
    direction[(i + 1) % 3] = np.sin(coning_rad) * np.cos(azimuth_rad)
    direction[(i + 2) % 3] = np.sin(coning_rad) * np.sin(azimuth_rad)
    return direction
