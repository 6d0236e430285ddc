"""Sets in quarantine: the run that they come from had a table that turned, so none is trusted and none is lost.

The set's bytes stay; that it is in quarantine is a row of its own, told by the chain like every other. Such a set is
given only to whoever asks for it by its checksum: it is no sensor's latest, nothing is found against it, and it is no
point of a history. A person may release it (:mod:`ams.archive.signatures`): that is a signature of its own, and the
row of the quarantine stays beside it.
"""

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy import Connection, Select, select

from ams.archive.ledger import Written, write
from ams.archive.tables import QUARANTINES, SIGNATURES


def quarantine(connection: Connection, sets: Sequence[str], reason: str, utc: datetime) -> None:
    """Put the sets that are not there yet into quarantine, inside a write transaction."""
    known = set(connection.execute(select(QUARANTINES.c.sha256)).scalars())
    rows = [{"sha256": sha256, "reason": reason, "quarantined_utc": utc} for sha256 in sets if sha256 not in known]
    if rows:
        write(connection, utc, "quarantine", [Written(QUARANTINES, rows)], {})


def quarantined() -> Select[tuple[str]]:
    """Return the query of the checksums of those that nobody released."""
    return select(QUARANTINES.c.sha256).where(QUARANTINES.c.sha256.not_in(released()))


def released() -> Select[tuple[str]]:
    """Return the query of the checksums of those that a person released."""
    return select(SIGNATURES.c.sha256).where(SIGNATURES.c.role == "released")
