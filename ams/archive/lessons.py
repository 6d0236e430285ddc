"""What past runs teach of the next: how long the parts of their steps took, and what each sensor axis showed.

Kept beside the runs and read by rig; simulated runs and real ones never together. No part of the record: a journal
gives it anew at any time, so it stands outside the chain.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, RowMapping, Table, delete, insert, select

from ams.archive.connection import reading, writing
from ams.archive.sets import BUSY_TIMEOUT_S
from ams.archive.tables import COMPONENTS, DURATIONS


@dataclass(frozen=True, slots=True)
class PartDuration:
    """Sums over the steps of one run that have one part; seconds, or their squares."""

    part: str
    steps: int
    expected_s: float
    measured_s: float
    expected_s2: float
    rest_s2: float
    """Of what was measured, less the run's own ratio times what was expected."""


@dataclass(frozen=True, slots=True)
class AxisComponents:
    """What one sensor axis showed in one run, per sensitivity."""

    sensor: str
    axis: str
    type: str
    """As ``sensors.NAME.model`` of the rig file."""
    reading_g: float
    dwell_g: float
    lack_of_fit_g: float
    offset_drift_g: float
    sensitivity_drift: float


@dataclass(frozen=True, slots=True)
class Lesson:
    """What one run teaches."""

    journal_sha256: str
    rig: str
    simulated: bool
    ended_utc: datetime
    parts: Sequence[PartDuration] = ()
    components: Sequence[AxisComponents] = ()


def keep_lesson(archive_url: str, lesson: Lesson, busy_timeout_s: float = BUSY_TIMEOUT_S) -> None:
    """Keep what a run teaches, in the place of what it taught before. Raises: ArchiveError."""
    with writing(archive_url, busy_timeout_s) as connection:
        _replace(connection, DURATIONS, lesson, [asdict(part) for part in lesson.parts])
        _replace(connection, COMPONENTS, lesson, [asdict(component) for component in lesson.components])


def _replace(connection: Connection, table: Table, lesson: Lesson, rows: Sequence[Mapping[str, object]]) -> None:
    connection.execute(delete(table).where(table.c.journal_sha256 == lesson.journal_sha256))
    head = {
        "journal_sha256": lesson.journal_sha256,
        "rig": lesson.rig,
        "simulated": lesson.simulated,
        "ended_utc": lesson.ended_utc,
    }
    if rows:
        connection.execute(insert(table), [{**head, **row} for row in rows])


def past_lessons(
    archive_url: str, rig: str, *, simulated: bool, most: int, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> tuple[Lesson, ...]:
    """Return what the latest runs of a rig taught, the latest first. Raises: ArchiveError."""
    with reading(archive_url, busy_timeout_s) as connection:
        parts = _latest(connection, DURATIONS, rig, simulated, most)
        components = _latest(connection, COMPONENTS, rig, simulated, most)
    lessons = [
        Lesson(
            sha256,
            rig,
            simulated,
            next(iter(parts.get(sha256) or components[sha256]))["ended_utc"],
            tuple(PartDuration(**_fields_of(row, PartDuration)) for row in parts.get(sha256, ())),
            tuple(AxisComponents(**_fields_of(row, AxisComponents)) for row in components.get(sha256, ())),
        )
        for sha256 in dict.fromkeys([*parts, *components])
    ]
    return tuple(sorted(lessons, key=lambda lesson: lesson.ended_utc, reverse=True)[:most])


def _latest(connection: Connection, table: Table, rig: str, simulated: bool, most: int) -> dict[str, list[RowMapping]]:
    selected = (
        select(table)
        .where(table.c.rig == rig, table.c.simulated == simulated)
        .order_by(table.c.ended_utc.desc(), table.c.journal_sha256)
    )
    found: dict[str, list[RowMapping]] = {}
    for row in connection.execute(selected).mappings():
        if row["journal_sha256"] not in found and len(found) == most:
            break
        found.setdefault(row["journal_sha256"], []).append(row)
    return found


def _fields_of(row: RowMapping, kind: type[PartDuration] | type[AxisComponents]) -> dict[str, Any]:
    return {name: row[name] for name in kind.__dataclass_fields__}
