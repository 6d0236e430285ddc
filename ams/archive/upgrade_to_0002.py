"""What an archive of schema 0001 holds, brought under schema 0002: points of history, and the chain's first record."""

from sqlalchemy import Connection, insert, select

from ams.archive.ledger import Written, tell
from ams.archive.tables import COEFFICIENTS, POINTS, SETS
from ams.exports.json_text import from_json
from ams.surveillance.history_points import point_row


def upgrade_from_0001(connection: Connection) -> None:
    """Make a point of every set that is there, and a record of the rows. A damaged set stops the migration.

    Raises: SetError naming the set.
    """
    sets = [dict(row) for row in connection.execute(select(SETS).order_by(SETS.c.sha256)).mappings()]
    if not sets:
        return
    points = [
        point_row(from_json(row["document"].encode("utf-8"), f"archive: set {row['sha256'][:12]}"), is_check=False)
        for row in sets
    ]
    connection.execute(insert(POINTS), points)
    coefficients = [dict(row) for row in connection.execute(select(COEFFICIENTS)).mappings()]
    written = [Written(SETS, sets), Written(COEFFICIENTS, coefficients), Written(POINTS, points)]
    tell(connection, max(row["published_utc"] for row in sets), "taken over from schema 0001", written, {})
