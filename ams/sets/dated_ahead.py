"""A set that is dated later than now: the clock of a computer was wrong, and it stands before the sets to come."""

from collections.abc import Iterable, Iterator
from datetime import datetime, timedelta

from ams.sets.coefficients import CoefficientSet

AHEAD = timedelta(minutes=10)
"""Further apart are no two clocks that are kept by the hour."""


def is_dated_ahead(created_utc: datetime, now_utc: datetime) -> bool:
    """Return whether a calibration is told to have ended after ``now_utc``, by more than clocks differ."""
    return created_utc - now_utc > AHEAD


def dated_ahead(sensor: str, sha256: str, created_utc: datetime, now_utc: datetime) -> str | None:
    """Return what is to be said of a measured set that is; None of any other. Of a twin the time is virtual."""
    if not is_dated_ahead(created_utc, now_utc):
        return None
    left = created_utc - now_utc
    far = f"{left.days} days" if left >= timedelta(days=2) else f"{left.total_seconds() / 3600:.1f} h"
    return (
        f"{sensor}: set {sha256[:12]} is dated {created_utc:%Y-%m-%d %H:%M} UTC, in the future by {far} for the clock "
        "of this computer: that of the one that calibrated was ahead, or this one is behind; until then it counts as "
        "the newest of the sensor, before what is calibrated after it, and the next calibration is due too late; set "
        "the clock that is wrong; where it was that of the calibration, withdraw the set (calrig archive sign "
        f"{sha256[:12]} withdrawn) and calibrate again"
    )


def ahead_of_clock(sets: Iterable[CoefficientSet], now_utc: datetime) -> Iterator[str]:
    """Yield :func:`dated_ahead` of the measured sets."""
    for found in sets:
        if not found.is_simulated and (said := dated_ahead(found.sensor, found.sha256, found.created_utc, now_utc)):
            yield said
