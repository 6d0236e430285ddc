"""Leases: who has a device that more than one computer reaches, told in the one place that all of them share.

A lease is a row that its holder renews; a holder that died renews nothing, and its lease lapses. Leases are no part of
the archive's record. The clock is the server's own. A SQLite file has none, so there every computer's own clock
counts, and a lease lapses :data:`CLOCKS_APART_S` later for others than for its holder: clocks that differ by less do no
harm.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import Connection, Row, Select, delete, insert, select, text, update

from ams.archive.connection import POSTGRES, reading, writing
from ams.archive.tables import LEASES, UtcDateTime

BUSY_TIMEOUT_S = 5.0
CLOCKS_APART_S = 60.0


@dataclass(frozen=True, slots=True)
class Holder:
    """Who takes a lease."""

    token: str
    """Of one process: no other has it."""
    host: str
    account: str
    purpose: str
    """The run, or the command."""
    place: str = ""
    """What keeps two holders of one computer apart by itself: whoever asks from the same place has seen to it that the
    holder before is gone. Empty where nothing does."""


@dataclass(frozen=True, slots=True)
class Lease:
    """A lease that somebody has."""

    resource: str
    holder: Holder
    since_utc: datetime
    lapses_in_s: float
    """When nothing is heard of its holder."""

    def __str__(self) -> str:
        return f"{self.holder.host}, user {self.holder.account} ({self.holder.purpose})"


@dataclass(frozen=True, slots=True)
class Claim:
    """What became of a claim."""

    begun: tuple[str, ...]
    """Resources that were not this holder's before."""
    others: tuple[Lease, ...]
    """Of the resources that were asked for, those that somebody else has."""


def claim(
    archive_url: str,
    resources: Sequence[str],
    holder: Holder,
    duration_s: float,
    now_utc: datetime,
    *,
    all_or_none: bool = False,
    only_existing: bool = False,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> Claim:
    """Take or renew leases for ``duration_s``, but for those that another has and that have not lapsed.

    ``only_existing``: an archive that is not there is not made: a share that is gone leaves an empty folder.
    Raises: ArchiveError; then nothing was changed.
    """
    begun: list[str] = []
    with writing(archive_url, busy_timeout_s, only_existing=only_existing) as connection:
        now, apart = _clock_of(connection, now_utc)
        rows = {row.resource: row for row in connection.execute(_of(resources))}
        others = tuple(_lease(row, now, apart) for row in rows.values() if not _is_free(row, holder, now, apart))
        held_by_others = {lease.resource for lease in others}
        lapses_utc = now + timedelta(seconds=duration_s)
        for resource in sorted(set(resources) - held_by_others) if not (others and all_or_none) else ():
            row = rows.get(resource)
            values = {"lapses_utc": lapses_utc, "purpose": holder.purpose}
            if row is not None and row.token == holder.token:
                connection.execute(update(LEASES).where(LEASES.c.resource == resource).values(values))
                continue
            begun.append(resource)
            connection.execute(delete(LEASES).where(LEASES.c.resource == resource))
            identity = {"token": holder.token, "host": holder.host, "account": holder.account, "place": holder.place}
            connection.execute(insert(LEASES).values(resource=resource, since_utc=now, **identity, **values))
    return Claim(tuple(begun), others)


def release(archive_url: str, token: str, *, busy_timeout_s: float = BUSY_TIMEOUT_S) -> None:
    """Give back every lease of a holder. Raises: ArchiveError."""
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        connection.execute(delete(LEASES).where(LEASES.c.token == token))


def held(
    archive_url: str, resources: Sequence[str], now_utc: datetime, *, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> tuple[Lease, ...]:
    """Return who has which of the resources now. Raises: ArchiveError."""
    with reading(archive_url, busy_timeout_s) as connection:
        now, apart = _clock_of(connection, now_utc)
        return tuple(_still_held(connection, resources, now, apart))


def _still_held(connection: Connection, resources: Sequence[str], now: datetime, apart: timedelta) -> Iterator[Lease]:
    for row in connection.execute(_of(resources)):
        if row.lapses_utc + apart > now:
            yield _lease(row, now, apart)


def _of(resources: Sequence[str]) -> Select[Any]:
    return select(LEASES).where(LEASES.c.resource.in_(list(resources))).order_by(LEASES.c.resource)


def _clock_of(connection: Connection, now_utc: datetime) -> tuple[datetime, timedelta]:
    """Return what time it is where the leases are, and how far the clocks of two holders may be apart."""
    if connection.dialect.name != POSTGRES:
        return now_utc, timedelta(seconds=CLOCKS_APART_S)
    server_utc = connection.execute(text("SELECT clock_timestamp() AS now").columns(now=UtcDateTime)).scalar_one()
    return server_utc, timedelta()


def _is_free(row: Row[Any], holder: Holder, now: datetime, apart: timedelta) -> bool:
    # Who has the locks of the folder that it was taken under knows that its holder is dead: a resume waits for nobody.
    if row.token == holder.token or (holder.place and row.place == holder.place):
        return True
    return bool(row.lapses_utc + apart <= now)


def _lease(row: Row[Any], now: datetime, apart: timedelta) -> Lease:
    holder = Holder(row.token, row.host, row.account, row.purpose, row.place)
    return Lease(row.resource, holder, row.since_utc, (row.lapses_utc + apart - now).total_seconds())
