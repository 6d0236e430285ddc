"""What is known of the table already when a package is solved: what sensors and runs together have shown of it.

A package by itself would blame its axes for some of it. Dwells are known by their labels of replication and point.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ams.arrays import BoolArray
from ams.observations import Observations

DwellLabels = tuple[int, int]
"""Replication and point."""


@dataclass(frozen=True)
class KnownTable:
    """Of one run."""

    off: frozenset[DwellLabels] = frozenset()
    """Dwells at which the table stood off: they are in the result, and in no test of a sensor."""
    alike: Mapping[DwellLabels, str] = field(default_factory=dict)
    """Dwells at which the table may have stood off, and by how much: a wrong reading would look the same."""

    @property
    def is_nothing(self) -> bool:
        return not (self.off or self.alike)


NOTHING_KNOWN: Final = KnownTable()


def labels_of(rows: Observations) -> list[DwellLabels]:
    """Return the labels of the N rows."""
    return list(zip(rows.replication.tolist(), rows.point.tolist(), strict=True))


def is_among(rows: Observations, dwells: frozenset[DwellLabels]) -> BoolArray:
    """Return (N,) whether each row is one of some dwells."""
    return np.array([labels in dwells for labels in labels_of(rows)], dtype=bool)
