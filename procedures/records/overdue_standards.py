"""Standards whose certificate no longer holds: asked before a run, and of what a fit takes from a rig file."""

from collections.abc import Iterator
from datetime import date, datetime

from rig.description.rig_file import RigDescription
from rig.local_time import local_day


def overdue_standards(rig: RigDescription, today: date) -> Iterator[str]:
    """Yield a sentence for every standard that is past; one holds through its due day, by the calendar at the wall."""
    for name, standard in rig.standards.items():
        if standard.due < today:
            yield f"standards.{name}.due: {standard.due} is past (today is {today}), certificate {standard.certificate}"


def overdue_warnings(rig: RigDescription, today: date, measured_utc: datetime | None = None) -> tuple[str, ...]:
    """Say it of observations from a file, as a reservation; ``measured_utc``: when they were taken, where known."""
    if measured_utc is not None:
        day = local_day(measured_utc)
        return tuple(
            f"standards.{name}.due: {standard.due}, before the readings of {day}, certificate {standard.certificate}; "
            "what was measured after the due day is not known to the stated uncertainty; renew the certificate and "
            "measure again, or let whoever signs the set answer for it"
            for name, standard in rig.standards.items()
            if standard.due < day
        )
    return tuple(
        f"{sentence}; a file of observations tells no day: what was measured after the due day is not known to the "
        "stated uncertainty; renew the certificate and measure again, or let whoever signs the set answer for it"
        for sentence in overdue_standards(rig, today)
    )
