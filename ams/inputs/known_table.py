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
class TableTurn:
    """A turn of the table in mid-run that reference visits or check sets have proved over all sensors."""

    before: frozenset[DwellLabels]
    """Dwells that were measured before it; those of neither side were measured in between."""
    after: frozenset[DwellLabels]
    parts: tuple[str, ...]
    """What turned, as the diagnosis of two visits names it: about roll, about pitch, with the base."""


@dataclass(frozen=True)
class KnownTable:
    """Of one run."""

    off: frozenset[DwellLabels] = frozenset()
    """Dwells at which the table stood off: they are in the result, and in no test of a sensor."""
    alike: Mapping[DwellLabels, str] = field(default_factory=dict)
    """Dwells at which the table may have stood off, and by how much: a wrong reading would look the same."""
    turns: tuple[TableTurn, ...] = ()

    @property
    def has_dwells(self) -> bool:
        """Whether anything is known of single dwells."""
        return bool(self.off or self.alike)


NOTHING_KNOWN: Final = KnownTable()


def labels_of(rows: Observations) -> list[DwellLabels]:
    """Return the labels of the N rows."""
    return list(zip(rows.replication.tolist(), rows.point.tolist(), strict=True))


def is_among(rows: Observations, dwells: frozenset[DwellLabels]) -> BoolArray:
    """Return (N,) whether each row is one of some dwells."""
    return np.array([labels in dwells for labels in labels_of(rows)], dtype=bool)
