"""What is due: standards whose certificates end, sensors whose last calibration is an interval ago."""

from dataclasses import dataclass
from datetime import date, timedelta
from typing import Literal

from sqlalchemy import select

from ams.archive.connection import reading
from ams.archive.sets import BUSY_TIMEOUT_S, ArchivedSet, list_sets
from ams.archive.tables import STANDARDS

SENSOR_EVERY_DAYS = 365


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

    def when(self, today: date) -> str:
        """Return ``in 12 days``, ``1 day over``, ``today``, or that no date is known."""
        left = self.days_left(today)
        if left is None:
            return "no date"
        days = f"{abs(left)} day{'' if abs(left) == 1 else 's'}"
        return "today" if left == 0 else f"{days} over" if left < 0 else f"in {days}"


def due_list(
    archive_url: str, sensor_every_days: int = SENSOR_EVERY_DAYS, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> tuple[Due, ...]:
    """Return the newest certificate of every standard and the last set of every sensor, the earliest date first.

    A set that was withdrawn or is in quarantine is no calibration to rest on: the one before counts, and where there
    is none the sensor has been due since then. Twins are left out. Raises: ArchiveError.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        rows = connection.execute(select(STANDARDS)).mappings().all()
    newest: dict[str, Due] = {}
    for row in rows:
        certificate = Due("standard", row["name"], row["serial"], f"certificate {row['certificate']}", row["due"])
        before = newest.get(certificate.serial)
        if before is None or (before.due is not None and (certificate.due is None or certificate.due > before.due)):
            newest[certificate.serial] = certificate
    measured = [row for row in list_sets(archive_url, busy_timeout_s=busy_timeout_s) if not row.simulated]
    standing = {row.sensor: row for row in measured if not _fallen(row)}
    fallen = {row.sensor: row for row in measured if row.sensor not in standing}
    sensors = (
        *(_sensor_due(row, f"calibrated {row.created_utc:%Y-%m-%d}", sensor_every_days) for row in standing.values()),
        *(
            _sensor_due(row, f"no set stands: that of {row.created_utc:%Y-%m-%d} {_fallen(row)}", 0)
            for row in fallen.values()
        ),
    )
    return tuple(sorted((*newest.values(), *sensors), key=lambda item: (item.due or date.max, item.kind, item.name)))


def _sensor_due(row: ArchivedSet, because: str, every_days: int) -> Due:
    return Due("sensor", row.sensor, row.serial or "", because, row.created_utc.date() + timedelta(days=every_days))


def _fallen(row: ArchivedSet) -> str:
    """Return why nobody measures by a set any more; empty where it stands."""
    if row.status == "withdrawn":
        return "is withdrawn"
    return "is in quarantine" if row.quarantine is not None else ""
