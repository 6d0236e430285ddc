"""Journals with dwells in them, without a rig."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from procedures.journal.header import RunHeader, sha256
from procedures.journal.journal import Journal
from procedures.records.dwells import ChannelReading, DwellRecord
from rig.clock import SystemClock, VirtualClock

START_UTC = datetime(2026, 3, 29, 0, 59, 30, tzinfo=UTC)
HEADER = RunHeader(
    run_id="20260329T005930Z-test",
    title="a title with ünïcode and 'quotes'",
    created_utc=START_UTC,
    operator="tester",
    is_simulated=True,
    is_rehearsal=False,
    software={"calrig": "0.1.0"},
    plan_json="{}",
    plan_sha256=sha256("{}"),
    rig_path="/nowhere/rig.toml",
    rig_text="[rig]\n",
    rig_json="{}",
    rig_sha256=sha256("[rig]\n"),
    procedure_path="/nowhere/procedure.toml",
    procedure_text="",
    procedure_sha256=sha256(""),
)


def a_clock() -> VirtualClock:
    return VirtualClock(START_UTC)


def a_dwell(
    step: int = 0, *, attempt: int = 1, epoch: int = 1, accepted: bool = True, samples: int = 20
) -> DwellRecord:
    """A dwell whose samples follow from its step."""
    chance = np.random.default_rng(step)
    readings = {
        channel: ChannelReading(channel, chance.normal(2.5, 2e-5, samples), 100.0 + step, 0.4)
        for channel in ("dmm.x", "dmm.y", "dmm.z")
    }
    return DwellRecord(
        step=step,
        purpose="design",
        replication=1,
        point=step + 1,
        attempt=attempt,
        epoch=epoch,
        accepted=accepted,
        reasons=() if accepted else ("dmm.x: noise: …",),
        targets_deg={"roll": -180.0, "pitch": 10.0},
        measured_deg={"roll": -180.0, "pitch": 10.0001},
        temperature_degc={"air": 20.01},
        readings=readings,
        started_utc=START_UTC + timedelta(seconds=step),
        ended_utc=START_UTC + timedelta(seconds=step + 0.9),
        started_s=float(step),
        ended_s=step + 0.9,
        settle_s=3.0,
        sha256="",
    )


def with_overload(record: DwellRecord) -> DwellRecord:
    first = record.readings["dmm.x"]
    samples = first.samples.copy()
    samples[3] = np.nan
    return replace(record, readings={**record.readings, "dmm.x": replace(first, samples=samples)})


def note_of_an_older_version(run: Path, text: str, by: str = "anna") -> None:
    """Write a note as versions did that refused no letter of it."""
    journal = Journal.open_for_append(run / "journal.sqlite")
    journal.append_event("note", {"by": by, "text": text, "at_utc": START_UTC.isoformat()}, SystemClock())
    journal.close()


def journal_with(path: Path, dwells: int) -> Path:
    """A closed journal of so many dwells."""
    clock = a_clock()
    journal = Journal.create(path, HEADER, clock)
    for step in range(dwells):
        clock.sleep(1.0)
        journal.append_event("intent", {"step": step}, clock)
        journal.commit_dwell(a_dwell(step), clock)
    journal.close()
    return path
