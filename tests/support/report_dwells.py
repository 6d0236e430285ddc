"""Dwell records by hand, for tests of what is made from them."""

from collections.abc import Mapping
from datetime import UTC, datetime, timedelta

import numpy as np

from procedures.records.dwells import ChannelReading, DwellRecord, Event

START = datetime(2026, 3, 1, 18, 0, tzinfo=UTC)


def dwell(
    step: int,
    purpose: str = "design",
    replication: int = 1,
    point: int = 1,
    *,
    pitch_deg: float = 0.0,
    roll_deg: float = 0.0,
    volts: Mapping[str, tuple[float, ...]] | None = None,
    accepted: bool = True,
    reasons: tuple[str, ...] = (),
    epoch: int = 1,
    epoch_start_s: float = 0.0,
    degc: float | None = 20.0,
) -> DwellRecord:
    """A dwell of 10 s, 30 s after the one of the step before, in an epoch that began at ``epoch_start_s``."""
    started_s = 30.0 * step - epoch_start_s
    readings = {
        channel: ChannelReading(channel, np.array(samples), started_s, 0.2)
        for channel, samples in (volts or {"dmm.x": (1.0, 1.0)}).items()
    }
    attitude = {"pitch": pitch_deg, "roll": roll_deg}
    utc = START + timedelta(seconds=30.0 * step)
    return DwellRecord(
        step, purpose, replication, point, 1, epoch, accepted, reasons, attitude, attitude,
        {} if degc is None else {"air": degc}, readings, utc, utc + timedelta(seconds=10), started_s, started_s + 10.0,
        2.0, "",
    )  # fmt: skip


def event(sequence: int, kind: str, minutes: float, **detail: object) -> Event:
    return Event(sequence, START + timedelta(minutes=minutes), 60.0 * minutes, kind, detail, "")
