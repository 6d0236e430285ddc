"""What a laboratory must have in order before a result may be called a calibration: standards in date, a level read.

What is missing makes the result an engineering one, and the journal says why; what contradicts itself stops the run
before anything moves. A simulated run needs none of it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date, timedelta

from procedures.errors import RequestError
from procedures.records.overdue_standards import overdue_standards
from rig.description.rig_file import RigDescription

FRESH = timedelta(days=7)
"""A level reading that is older says little about the base of today."""


@dataclass(frozen=True, slots=True)
class Readiness:
    """Two lists of sentences."""

    missing: tuple[str, ...]
    contradictions: tuple[str, ...]

    def require(self, source: str) -> None:
        """Check that nothing contradicts. Raises: RequestError where the rig file contradicts itself or the day."""
        if self.contradictions:
            reasons = "; ".join(self.contradictions)
            raise RequestError(
                f"{source}: not ready for a calibration: {reasons}; nothing moved; renew it, or correct the rig file"
            )


def readiness(rig: RigDescription, today: date) -> Readiness:
    return Readiness(tuple(_missing(rig, today)), tuple(_contradictions(rig, today)))


def _missing(rig: RigDescription, today: date) -> Iterator[str]:
    for table, devices in (("axes", rig.axes), ("readouts", rig.readouts), ("environment", rig.environment)):
        for name, device in devices.items():
            if device.standard is None:
                yield f"{table}.{name}: no standard stands behind it"
    if rig.level.before is None:
        yield "level.before: the base was not levelled before the run"
    elif (taken := rig.level.before.day) is None:
        yield "level.before.taken: no day is given (write it as 2026-03-01)"
    elif taken < today - FRESH:
        yield f"level.before.taken: {taken} is more than {FRESH.days} days ago"
    if rig.approved_by is None:
        yield "approved_by: nobody has approved it"


def _contradictions(rig: RigDescription, today: date) -> Iterator[str]:
    yield from overdue_standards(rig, today)
    yield from days_to_come(rig, today)


def days_to_come(rig: RigDescription, today: date) -> Iterator[str]:
    """Yield readings of the level that nobody can have taken yet."""
    for which, reading in (("before", rig.level.before), ("after", rig.level.after)):
        taken = None if reading is None else reading.day
        if taken is not None and taken > today:
            yield f"level.{which}.taken: {taken} is still to come (today is {today})"
