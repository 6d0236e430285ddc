"""The laboratory's desk: what is due, what was measured with a standard, and runs by any word that is known of them."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, timedelta
from typing import Literal

from sqlalchemy import ColumnElement, String, and_, cast, func, or_, select

from ams.archive.connection import reading
from ams.archive.runs import RunEntry
from ams.archive.sets import BUSY_TIMEOUT_S, list_sets
from ams.archive.tables import RUNS, SETS, STANDARDS, USES

SENSOR_EVERY_DAYS = 365
_FIELDS = ("run_id", "title", "rig", "operator", "folder", "software_version", "journal_sha256")


@dataclass(frozen=True, slots=True)
class Due:
    """A standard whose certificate ends, or a sensor whose last calibration is an interval ago."""

    kind: Literal["standard", "sensor"]
    name: str
    serial: str
    because: str
    """Certificate, or the last calibration."""
    due: date | None
    """None: no date is known."""

    def days_left(self, today: date) -> int | None:
        return None if self.due is None else (self.due - today).days


@dataclass(frozen=True, slots=True)
class FoundRun:
    """A run with the sensors that it measured and the standards that it used."""

    run: RunEntry
    sensors: tuple[str, ...]
    standards: tuple[str, ...]
    """Serial numbers."""


def due_list(
    archive_url: str, sensor_every_days: int = SENSOR_EVERY_DAYS, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> tuple[Due, ...]:
    """Return the newest certificate of every standard and the last set of every sensor, the earliest date first.

    Twins are left out. Raises: ArchiveError.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        rows = connection.execute(select(STANDARDS)).mappings().all()
    newest: dict[str, Due] = {}
    for row in rows:
        certificate = Due("standard", row["name"], row["serial"], f"certificate {row['certificate']}", row["due"])
        before = newest.get(certificate.serial)
        if before is None or (before.due is not None and (certificate.due is None or certificate.due > before.due)):
            newest[certificate.serial] = certificate
    last = {
        coefficients.sensor: coefficients
        for coefficients in list_sets(archive_url, busy_timeout_s=busy_timeout_s)
        if not coefficients.simulated
    }
    sensors = (
        Due(
            "sensor",
            coefficients.sensor,
            coefficients.serial or "",
            f"calibrated {coefficients.created_utc:%Y-%m-%d}",
            coefficients.created_utc.date() + timedelta(days=sensor_every_days),
        )
        for coefficients in last.values()
    )
    return tuple(sorted((*newest.values(), *sensors), key=lambda item: (item.due or date.max, item.kind, item.name)))


def search_runs(archive_url: str, words: Sequence[str], busy_timeout_s: float = BUSY_TIMEOUT_S) -> tuple[FoundRun, ...]:
    """Return the runs of which every word is known, the newest first.

    A word is looked for, in any case, in what stands of the run, in the documents of its sets (customer, order and
    every other field that the rig file declares) and in its standards. No word: every run. Raises: ArchiveError.
    """
    columns = [RUNS.c[name] for name in RunEntry.__dataclass_fields__]
    query = select(*columns).where(*map(_knows, words)).order_by(RUNS.c.started_utc.desc(), RUNS.c.journal_sha256)
    with reading(archive_url, busy_timeout_s) as connection:
        runs = [RunEntry(*tuple(row)) for row in connection.execute(query)]
        measured = _by_key(connection.execute(select(SETS.c.run_id, SETS.c.sensor).order_by(SETS.c.sensor)))
        used = _by_key(connection.execute(select(USES.c.journal_sha256, USES.c.serial).order_by(USES.c.serial)))
    return tuple(FoundRun(run, measured.get(run.run_id, ()), used.get(run.journal_sha256, ())) for run in runs)


def _knows(word: str) -> ColumnElement[bool]:
    """Return the condition that something of a run holds the word."""
    of_run = [_holds(RUNS.c[name], word) for name in _FIELDS]
    of_run += [_holds(cast(RUNS.c[name], String), word) for name in ("started_utc", "ended_utc")]
    written = json.dumps(word)[1:-1]  # as it stands inside a document where letters are escaped
    document = or_(_holds(SETS.c.document, word), _holds(SETS.c.document, written))
    of_sets = select(SETS.c.sha256).where(
        SETS.c.run_id == RUNS.c.run_id, or_(_holds(SETS.c.sensor, word), _holds(SETS.c.serial, word), document)
    )
    same = and_(USES.c.serial == STANDARDS.c.serial, USES.c.certificate == STANDARDS.c.certificate)
    of_standards = (
        select(USES.c.serial)
        .select_from(USES.join(STANDARDS, same))
        .where(
            USES.c.journal_sha256 == RUNS.c.journal_sha256,
            or_(*(_holds(STANDARDS.c[name], word) for name in ("name", "serial", "certificate"))),
        )
    )
    return or_(*of_run, of_sets.exists(), of_standards.exists())


def _holds(column: ColumnElement[str], word: str) -> ColumnElement[bool]:
    return func.lower(column).contains(word.lower(), autoescape=True)


def _by_key(rows: Iterator[tuple[str, str]]) -> Mapping[str, tuple[str, ...]]:
    found: dict[str, list[str]] = {}
    for key, value in rows:
        if value not in found.setdefault(key, []):
            found[key].append(value)
    return {key: tuple(values) for key, values in found.items()}
