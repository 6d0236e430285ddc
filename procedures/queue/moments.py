"""Times of day as people say them: ``22:00`` is the next one here; a whole date says it all."""

from datetime import datetime, timedelta, tzinfo

from procedures.errors import RequestError


def moment(text: str, option: str, now_utc: datetime, zone: tzinfo | None = None) -> datetime:
    """Return the time that is meant; ``zone``: of the reader, by default this machine's. Raises: RequestError."""
    now = now_utc.astimezone(zone)
    try:
        if len(text) <= 5:
            at = datetime.strptime(text, "%H:%M").time()
            found = now.replace(hour=at.hour, minute=at.minute, second=0, microsecond=0)
            return (found if found > now else found + timedelta(days=1)).astimezone(now_utc.tzinfo)
        given = datetime.fromisoformat(text)
        return (given if given.tzinfo else given.replace(tzinfo=now.tzinfo)).astimezone(now_utc.tzinfo)
    except ValueError:
        raise RequestError(
            f"{option}: got {text!r}, needed is a time such as 22:00 or 2026-03-01T22:00; nothing was changed"
        ) from None
