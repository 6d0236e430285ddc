"""Stretches of rows in which outputs disagree too often for chance: where a fault begins and ends.

A good package has one row in a thousand flagged. Flagged rows that follow one another within so many rows make a
stretch; a handful of them in one is more than chance does, and what is wrong there is then judged by the rows of the
stretch itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.inference.rows.kept_rows import KeptRows

LARGEST_GAP: Final = 64
"""Rows from one flagged row to the next of the same stretch: chance has the next so near once in fifteen."""
LEAST_FLAGGED: Final = 5
"""Of a stretch."""
MOST_KEPT: Final = 256
"""Rows of a stretch that are judged."""
FAR: Final = 10.0
"""Mean distances of flagged rows from one to another that is no part of the same stretch."""
_REACHES: Final = 3.0
"""Mean distances beyond both ends."""
_OUTERMOST: Final = 8


@dataclass
class FlaggedStretch:
    """Rows from the first flagged one to the last."""

    flagged: int
    kept: KeptRows
    begun: int
    """The row that is the first of those kept."""
    outermost: IntArray
    """The first and the last few flagged rows, in order; all of them where these are few."""

    def extended(self, flagged: IntArray) -> None:
        """Take the rows that are flagged after."""
        self.flagged += flagged.size
        among = np.concatenate([self.outermost, flagged])
        if among.size > 2 * _OUTERMOST:
            among = np.concatenate([among[:_OUTERMOST], among[-_OUTERMOST:]])
        self.outermost = among

    @property
    def last(self) -> int:
        return int(self.outermost[-1])

    @property
    def rows(self) -> int:
        return self.last + 1 - int(self.outermost[0])

    @property
    def is_many(self) -> bool:
        """Whether chance does not flag so many."""
        return self.flagged >= LEAST_FLAGGED

    @property
    def spacing(self) -> float:
        """Rows for each flagged one."""
        return self.rows / self.flagged

    def ends(self) -> tuple[int, int]:
        """Return the first row and the last without those far off at either end, which chance has flagged."""
        far = np.flatnonzero(np.diff(self.outermost) > FAR * self.spacing)
        half = self.outermost.size // 2
        before, behind = far[far < half - 1], far[far >= half]
        first = self.outermost[before[-1] + 1] if before.size else self.outermost[0]
        last = self.outermost[behind[0]] if behind.size else self.outermost[-1]
        return int(first), int(last)

    def reach(self, rows: int) -> tuple[int, int]:
        """Return from which row to before which it reaches, of so many: a fault begins before it shows."""
        first, last = self.ends()
        beyond = int(np.ceil(_REACHES * (last + 1 - first) / self.flagged))
        return max(first - beyond, 0), min(last + 1 + beyond, rows)

    def finite(self) -> dict[str, FloatArray]:
        """Return the rows that are judged, by column."""
        first, last = self.ends()
        return self.kept.finite(first - self.begun, last + 1 - self.begun)

    def joins(self, later: "FlaggedStretch") -> bool:
        """Return whether a later one lies no farther off than its own rows do from one another."""
        return int(later.outermost[0]) - self.last <= FAR * max(self.spacing, later.spacing)


class FlaggedStretches:
    """Stretches found while rows come piece by piece."""

    def __init__(self, columns: tuple[str, ...]) -> None:
        self._columns = columns
        self._seen = 0
        self.open: FlaggedStretch | None = None
        """The one that the next row may belong to."""

    def take(self, flagged: IntArray, readings: Mapping[str, FloatArray]) -> list[FlaggedStretch]:
        """Take further rows, the places of the flagged ones among them; return what they end of many flagged rows."""
        rows, first = readings[self._columns[0]].size, self._seen
        self._seen += rows
        ended = []
        running = self.open
        if running is not None and (flagged[0] if flagged.size else rows) + first - running.last > LARGEST_GAP:
            ended.append(running)
            running = self.open = None
        breaks = np.flatnonzero(np.diff(flagged) > LARGEST_GAP) + 1
        starts, ends = np.append(0, breaks), np.append(breaks, flagged.size)
        if not flagged.size:
            starts = ends = np.empty(0, dtype=np.int64)
        if running is not None and not flagged.size:
            running.kept.take(readings)
        is_due = ends - starts >= LEAST_FLAGGED
        if starts.size:
            is_due[0] |= running is not None
            is_due[-1] = True
        for start, end in zip(starts[is_due].tolist(), ends[is_due].tolist(), strict=True):
            stretch = self._continued(running if start == 0 else None, flagged[start:end], first, readings)
            if end == flagged.size and rows + first - stretch.last <= LARGEST_GAP:
                self.open = stretch
            else:
                ended.append(stretch)
                self.open = None
        return [stretch for stretch in ended if stretch.is_many]

    def _continued(
        self, running: FlaggedStretch | None, flagged: IntArray, first: int, readings: Mapping[str, FloatArray]
    ) -> FlaggedStretch:
        begin, until = (0 if running is not None else int(flagged[0])), int(flagged[-1]) + 1
        if first + readings[self._columns[0]].size - (first + until - 1) <= LARGEST_GAP:
            until = readings[self._columns[0]].size
        stretch = running or FlaggedStretch(
            0, KeptRows(self._columns, MOST_KEPT), first + begin, np.empty(0, dtype=np.int64)
        )
        stretch.kept.take({name: readings[name][begin:until] for name in self._columns})
        stretch.extended(first + flagged)
        return stretch

    def finish(self) -> list[FlaggedStretch]:
        """Return the one that is still open, where it has many flagged rows."""
        last, self.open = self.open, None
        return [last] if last is not None and last.is_many else []
