"""Rows evenly spaced over all that came, however many these are."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray


@dataclass
class KeptRows:
    """At most so many rows of some columns; of more every second is left out."""

    columns: tuple[str, ...]
    most: int
    stride: int = 1
    seen: int = 0

    def __post_init__(self) -> None:
        self.rows = np.empty((len(self.columns), 0))

    def take(self, readings: Mapping[str, FloatArray]) -> None:
        """Take (n,) further rows of every column."""
        further = readings[self.columns[0]].size
        while -(-(self.seen + further) // self.stride) > self.most:
            self.rows, self.stride = self.rows[:, ::2], 2 * self.stride
        start = -self.seen % self.stride
        self.rows = np.concatenate(
            [self.rows, np.stack([readings[name][start :: self.stride] for name in self.columns])], axis=1
        )
        self.seen += further

    def finite(self, first: int = 0, end: int | None = None) -> dict[str, FloatArray]:
        """Return the kept rows from ``first`` to before ``end`` whose readings are all numbers, by column."""
        among = self.rows[:, -(-first // self.stride) : None if end is None else -(-end // self.stride)]
        return dict(zip(self.columns, among[:, np.isfinite(among).all(axis=0)], strict=True))
