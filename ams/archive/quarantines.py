"""Sets in quarantine: the run that they come from had a table that turned, so none is trusted and none is lost.

The set's bytes stay; that it is in quarantine is a row of its own, told by the chain like every other. Such a set is
given only to whoever asks for it by its checksum: it is no sensor's latest, nothing is found against it, and it is no
point of a history. A person may release it (:mod:`ams.archive.signatures`): that is a signature of its own, and the
row of the quarantine stays beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import ColumnElement, Connection, and_, exists, not_, select

from ams.archive.approvals import is_signed
from ams.archive.ledger import Written, write
from ams.archive.tables import QUARANTINES, SETS


def quarantine(connection: Connection, sets: Sequence[str], reason: str, utc: datetime) -> None:
    """Put the sets that are not there yet into quarantine, inside a write transaction."""
    known = set(connection.execute(select(QUARANTINES.c.sha256).where(QUARANTINES.c.sha256.in_(sets))).scalars())
    rows = [{"sha256": sha256, "reason": reason, "quarantined_utc": utc} for sha256 in sets if sha256 not in known]
    if rows:
        write(connection, utc, "quarantine", [Written(QUARANTINES, rows)], {})


def is_quarantined(sha256: ColumnElement[str]) -> ColumnElement[bool]:
    """Return the condition that a set, by the column of its checksum, is in quarantine and nobody released it."""
    held = QUARANTINES.alias()
    return and_(exists().where(held.c.sha256 == sha256), not_(is_signed(sha256, "released")))


@dataclass(frozen=True)
class Quarantined:
    """A set that a history leaves out."""

    sha256: str
    created_utc: datetime
    reason: str


def quarantined_of(connection: Connection, sensor: str, until_utc: datetime | None) -> tuple[Quarantined, ...]:
    """Return the sets of a sensor that are in quarantine, made up to a moment, the earliest first."""
    query = (
        select(SETS.c.sha256, SETS.c.created_utc, QUARANTINES.c.reason)
        .select_from(SETS.join(QUARANTINES, SETS.c.sha256 == QUARANTINES.c.sha256))
        .where(SETS.c.sensor == sensor, is_quarantined(SETS.c.sha256))
        .order_by(SETS.c.created_utc, SETS.c.sha256)
    )
    found = [Quarantined(*row) for row in connection.execute(query)]
    return tuple(held for held in found if until_utc is None or held.created_utc <= until_utc)
