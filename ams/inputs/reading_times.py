"""When the rows of a file were read, where it tells: the column ``started_utc``, as ``calrig data`` writes it."""

from datetime import UTC, datetime
from typing import Final

from ams.inputs.csv_table import CsvTable, refuse_cell

STARTED: Final = "started_utc"


def last_reading_utc(table: CsvTable) -> datetime | None:
    """Return when the last row was begun; None where the file has no such column. Raises: ObservationsError."""
    if STARTED not in table.columns:
        return None
    return max(_moment(table, line, cell) for line, cell in zip(table.lines, table.column(STARTED), strict=True))


def _moment(table: CsvTable, line: int, cell: str) -> datetime:
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        moment = None
    if moment is None or len(cell) < len("2026-03-01T06:20"):
        refuse_cell(table, STARTED, line, cell, "a moment such as 2026-03-01T06:20:00+00:00")
    return moment.replace(tzinfo=moment.tzinfo or UTC)
