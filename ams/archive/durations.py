"""How long the parts of past runs took: kept beside the runs, and read by rig for the next estimate.

No part of the record: rows are made anew from a journal at any time, so they stand outside the chain.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import delete, insert, select

from ams.archive.connection import reading, writing
from ams.archive.sets import BUSY_TIMEOUT_S
from ams.archive.tables import DURATIONS


@dataclass(frozen=True, slots=True)
class PartDuration:
    """Sums over the steps of one run that have one part; seconds, or their squares."""

    steps: int
    expected_s: float
    measured_s: float
    expected_s2: float
    rest_s2: float
    """Of what was measured, less the run's own ratio times what was expected."""


@dataclass(frozen=True, slots=True)
class RunDurations:
    """One run, as it teaches the next."""

    journal_sha256: str
    rig: str
    simulated: bool
    ended_utc: datetime
    parts: Mapping[str, PartDuration]


def keep_durations(archive_url: str, run: RunDurations, busy_timeout_s: float = BUSY_TIMEOUT_S) -> None:
    """Keep what a run took; once more changes nothing but what is told otherwise now. Raises: ArchiveError."""
    head = {
        "journal_sha256": run.journal_sha256,
        "rig": run.rig,
        "simulated": run.simulated,
        "ended_utc": run.ended_utc,
    }
    rows = [
        {
            **head,
            "part": name,
            "steps": part.steps,
            "expected_s": part.expected_s,
            "measured_s": part.measured_s,
            "expected_s2": part.expected_s2,
            "rest_s2": part.rest_s2,
        }
        for name, part in run.parts.items()
    ]
    with writing(archive_url, busy_timeout_s) as connection:
        connection.execute(delete(DURATIONS).where(DURATIONS.c.journal_sha256 == run.journal_sha256))
        if rows:
            connection.execute(insert(DURATIONS), rows)


def past_durations(
    archive_url: str, rig: str, *, simulated: bool, most: int, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> Sequence[Mapping[str, PartDuration]]:
    """Return the parts of the latest runs of a rig, the latest first; simulated ones and real ones never together.

    Raises: ArchiveError.
    """
    table = DURATIONS
    asked = (
        select(table)
        .where(table.c.rig == rig, table.c.simulated == simulated)
        .order_by(table.c.ended_utc.desc(), table.c.journal_sha256)
    )
    found: dict[str, dict[str, PartDuration]] = {}
    with reading(archive_url, busy_timeout_s) as connection:
        for row in connection.execute(asked):
            if row.journal_sha256 not in found and len(found) == most:
                break
            figures = PartDuration(row.steps, row.expected_s, row.measured_s, row.expected_s2, row.rest_s2)
            found.setdefault(row.journal_sha256, {})[row.part] = figures
    return tuple(found.values())
