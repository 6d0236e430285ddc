"""What an archive of schema 0005 holds, brought under schema 0006: the verdict of every set that states one."""

import json
from collections.abc import Iterator
from datetime import datetime

from sqlalchemy import Connection, select

from ams.archive.ledger import ROWS_AT_ONCE, Written, write
from ams.archive.tables import SETS, VERDICTS
from ams.sets.stated_verdict import stated_verdict


def upgrade_from_0005(connection: Connection) -> None:
    """Write the verdicts and a record of them.

    A set whose text is damaged gets none: a list then shows none, and ``calrig archive verify`` names the set.
    """
    stated = list(_stated(connection))
    if not stated:
        return
    rows = [{"sha256": sha256, "verdict": verdict} for sha256, verdict, _ in stated]
    latest = max(published_utc for *_, published_utc in stated)
    write(connection, latest, "taken over from schema 0005", [Written(VERDICTS, rows)], {})


def _stated(connection: Connection) -> Iterator[tuple[str, str, datetime]]:
    columns = select(SETS.c.sha256, SETS.c.document, SETS.c.published_utc).order_by(SETS.c.sha256)
    # Of the statement: as an option of the connection it would hold for all that the migration does after.
    for row in connection.execute(columns.execution_options(yield_per=ROWS_AT_ONCE)):
        try:
            verdict = stated_verdict(json.loads(row.document))
        except (ValueError, TypeError, KeyError, AttributeError):
            continue
        if verdict is not None:
            yield row.sha256, verdict, row.published_utc
