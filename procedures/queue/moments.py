"""Times of day as people say them: ``22:00`` is the next one here; a whole date says it all."""

from datetime import UTC, datetime, time, timedelta, tzinfo

from procedures.errors import RequestError
from rig.local_time import from_the_wall, local_day


def moment(text: str, option: str, now_utc: datetime, zone: tzinfo | None = None) -> datetime:
    """Return the time that is meant; ``zone``: of the reader, by default this machine's. Raises: RequestError."""
    try:
        if len(text) <= 5:
            return _next(datetime.strptime(text, "%H:%M").time(), now_utc, zone)
        given = datetime.fromisoformat(text)
        return given.astimezone(UTC) if given.tzinfo else from_the_wall(given, zone)
    except ValueError:
        raise RequestError(
            f"{option}: got {text!r}, needed is a time such as 22:00 or 2026-03-01T22:00; nothing was changed"
        ) from None


def _next(at: time, now_utc: datetime, zone: tzinfo | None) -> datetime:
    """Return when a clock at the wall shows this next: an hour that summer time gives twice may be its second."""
    today = datetime.combine(local_day(now_utc, zone), at)
    shown = (today, today.replace(fold=1), today + timedelta(days=1))
    return next(found for clock in shown if (found := from_the_wall(clock, zone)) > now_utc)
