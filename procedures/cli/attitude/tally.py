"""Answers counted by what their flags say, so that whoever reads the file last is told of them first."""

from collections import Counter
from typing import Final

import numpy as np

from procedures.cli.attitude.rows import Rows, RowWriter
from procedures.cli.output import note

MOST_REASONS: Final = 3
"""That are told one by one."""


class TalliedRows:
    """Answers that are written, with a line about the flagged ones at their end."""

    def __init__(self, sensor: str, writer: RowWriter) -> None:
        self.sensor, self.rows = sensor, 0
        self.flagged: Counter[str] = Counter()
        self._writer = writer

    def write(self, rows: Rows) -> None:
        """Write rows and count them."""
        self._writer.write(rows)
        self.rows += rows.indices.size
        for index, count in enumerate(np.bincount(rows.indices, minlength=len(rows.words)).tolist()):
            if count and rows.words[index]:
                self.flagged[_reason(rows.words[index])] += count

    def close(self) -> None:
        """Finish what is written, and say how many rows are flagged and why."""
        self._writer.close()
        if self.flagged:
            note(f"{self.sensor}: {self.in_words()}")

    def discard(self) -> None:
        """End without a word."""
        self._writer.discard()

    def in_words(self) -> str:
        """Tell how many rows are flagged, the most frequent reasons first."""
        most_frequent = self.flagged.most_common(MOST_REASONS)
        others = self.flagged.total() - sum(count for _, count in most_frequent)
        reasons = [f"{reason} ({count})" for reason, count in most_frequent] + (
            [f"others ({others})"] if others else []
        )
        return f"{self.flagged.total()} of {self.rows} rows are flagged: {', '.join(reasons)}"


def _reason(word: str) -> str:
    """Return a flag without the number of its line."""
    return word.partition(": ")[2] if word.startswith("line ") else word
