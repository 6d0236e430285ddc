"""What is known of table and meter already when a package is solved: what sensors together have shown of them.

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


GAIN, OFFSET = "gain", "offset"


@dataclass(frozen=True)
class ProvedChange:
    """A turn of the table, or a change of the meter, in mid-run that visits or check sets proved over all sensors."""

    before: frozenset[DwellLabels]
    """Dwells that were measured before it; those of neither side were measured in between."""
    after: frozenset[DwellLabels]
    parts: tuple[str, ...]
    """What changed: turns of the table by the names that the diagnosis of two visits has for them (about roll, about
    pitch, with the base), :data:`GAIN` and :data:`OFFSET` of what is read."""
    between: str = ""
    """Between which visits, or since which check set, as it is told."""


@dataclass(frozen=True)
class KnownOfRun:
    """Of one run."""

    off: frozenset[DwellLabels] = frozenset()
    """Dwells at which the table stood off: they are in the result, and in no test of a sensor."""
    alike: Mapping[DwellLabels, str] = field(default_factory=dict)
    """Dwells at which the table may have stood off, and by how much: a wrong reading would look the same."""
    changes: tuple[ProvedChange, ...] = ()

    @property
    def has_dwells(self) -> bool:
        """Whether anything is known of single dwells."""
        return bool(self.off or self.alike)


NOTHING_KNOWN: Final = KnownOfRun()


def labels_of(rows: Observations) -> list[DwellLabels]:
    """Return the labels of the N rows."""
    return list(zip(rows.replication.tolist(), rows.point.tolist(), strict=True))


def is_among(rows: Observations, dwells: frozenset[DwellLabels]) -> BoolArray:
    """Return (N,) whether each row is one of some dwells."""
    if not dwells:
        return np.zeros(rows.rows, dtype=bool)
    return np.array([labels in dwells for labels in labels_of(rows)], dtype=bool)
