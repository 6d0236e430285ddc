"""What an archive holds that is dated later than now."""

from collections.abc import Iterable
from datetime import datetime

from ams.archive.sets import list_sets
from ams.errors import ArchiveAbsent
from ams.sets.dated_ahead import dated_ahead


def archived_ahead(archive_url: str, sensors: Iterable[str], now_utc: datetime) -> tuple[str, ...]:
    """Return a sentence for each measured set of these sensors that is dated ahead and was not withdrawn.

    None where nobody has an archive yet. Raises: ArchiveError where it cannot be read.
    """
    try:
        rows = [row for sensor in dict.fromkeys(sensors) for row in list_sets(archive_url, sensor)]
    except ArchiveAbsent:
        return ()
    said = (
        dated_ahead(row.sensor, row.sha256, row.created_utc, now_utc)
        for row in rows
        if not row.simulated and row.withdrawal is None
    )
    return tuple(sentence for sentence in said if sentence is not None)
