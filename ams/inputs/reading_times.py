"""When the rows of a file were read, where it tells: ``started_utc``, as ``calrig data`` writes it, and ``time_s``."""

from collections.abc import Iterator
from datetime import UTC, datetime
from itertools import product
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.inputs.csv_table import CsvTable, refuse_cell
from ams.observations import Observations

STARTED: Final = "started_utc"
_LARGEST_PART: Final = 0.05
"""Of the rows: where more are before the row above them the rows are not in the order in which they were read."""
_LEAP: Final = 5.0
"""Times the usual step from row to row: what was measured again stands that far off its place."""


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


def clock_warnings(observations: Observations) -> tuple[str, ...]:
    """Return a warning where the clock of the rows was set back while they were read, or stood still.

    Rows may stand in another order than they were read in: by point, replications exchanged, a dwell that was measured
    again in its old place. Rows of one course that meet times which others have already are none of these.
    """
    time_s, replication = observations.time_s, observations.replication
    if time_s is not None and time_s.size > 1 and float(np.ptp(time_s)) == 0.0:
        return (
            f"{observations.source}: time_s is {time_s[0]:.4g} s in every row: what drifts with time cannot be judged "
            "by it: correct the column, or leave it out",
        )
    falls = [] if time_s is None else list(_falls(time_s, replication))
    if time_s is None or not falls:
        return ()
    worst = max(falls, key=lambda row: float(time_s[row - 1] - time_s[row]))
    more = f" ({len(falls)} such rows)" if len(falls) > 1 else ""
    row, above = (
        f"replication {observations.replication[at]}, point {observations.point[at]}" for at in (worst, worst - 1)
    )
    return (
        f"{observations.source}: time_s goes back in mid-run: {row} is {time_s[worst - 1] - time_s[worst]:.4g} s "
        f"before the row above it ({above}), and time goes on from there{more}: a clock that was set back, or times "
        "that begin anew? Drift, time terms and the order of the rows rest on the times as given: correct the column, "
        "or leave it out",
    )


def _falls(time_s: FloatArray, replication: IntArray) -> Iterator[int]:
    """Yield the rows at which a course of rows goes on at times that were there before."""
    down = np.flatnonzero(np.diff(time_s) < 0.0) + 1
    if not 0 < down.size <= max(np.unique(replication).size, int(_LARGEST_PART * time_s.size)):
        return
    steps = np.diff(time_s)
    usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    edges = [0, *down.tolist(), time_s.size]
    for start, row, end in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
        before, behind = time_s[start:row], time_s[row:end]
        earlier = int(np.searchsorted(before, behind[0]))
        if earlier == 0:
            spans = (_spans(before, replication[start:row]), _spans(behind, replication[row:end]))
            meets = replication[row] == replication[row - 1] or any(
                first[0] <= second[1] and second[0] <= first[1] for first, second in product(*spans)
            )
        else:
            meets = earlier == before.size or bool(before[earlier] - before[earlier - 1] <= _LEAP * usual)
        if meets:
            yield row


def _spans(time_s: FloatArray, replication: IntArray) -> list[tuple[float, float]]:
    """Return the first and last time of every replication of a course of rows."""
    by_label = (time_s[replication == label] for label in np.unique(replication))
    return [(float(part.min()), float(part.max())) for part in by_label]
