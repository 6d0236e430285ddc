"""Times as people read them, in every message, page and alert: by this machine's clock first, UTC beside it."""

from datetime import UTC, date, datetime, tzinfo


def at_both(moment_utc: datetime, zone: tzinfo | None = None, *, to_the_second: bool = False) -> str:
    """``Sun 05:40 local (2026-03-01 04:40 UTC)``; once where the two are the same. ``zone``: this machine's own."""
    clock = "%H:%M:%S" if to_the_second else "%H:%M"
    local, in_utc = moment_utc.astimezone(zone), moment_utc.astimezone(UTC)
    both = f"{in_utc:%Y-%m-%d {clock}} UTC"
    return both if not local.utcoffset() else f"{local:%a {clock}} local ({both})"


def local_day(moment_utc: datetime, zone: tzinfo | None = None) -> date:
    """Return the day on a calendar at the wall. ``zone``: this machine's own.

    A certificate's due day is such a day, and holds to its end.
    """
    return moment_utc.astimezone(zone).date()


def from_the_wall(clock: datetime, zone: tzinfo | None = None) -> datetime:
    """Return the moment, in UTC, at which a clock at the wall shows this, by the summer time of that day.

    ``zone``: this machine's own. Of an hour that is shown twice the first is meant, or the second with ``fold=1``.
    """
    return (clock if zone is None else clock.replace(tzinfo=zone)).astimezone(UTC)


def text_at_both(iso_utc: str) -> str:
    """Return a moment that a file of ours keeps as text as people read it; what is none is left as it is."""
    try:
        return at_both(datetime.fromisoformat(iso_utc), to_the_second=True)
    except ValueError:
        return iso_utc


def local_clock(moment_utc: datetime) -> str:
    """``Sun 05:40:07``, for lists that stand below a time that is told in full."""
    return f"{moment_utc.astimezone():%a %H:%M:%S}"


def local_hour(moment_utc: datetime) -> str:
    """``05:40:07``, for what was said a moment ago."""
    return f"{moment_utc.astimezone():%H:%M:%S}"
