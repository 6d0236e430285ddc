"""What a change in mid-run does to an output, as columns that are taken out of it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.tested_terms import linear_base
from ams.analysis.diagnostics.time_order import time_order
from ams.arrays import BoolArray, FloatArray
from ams.inputs.known_table import TableTurn, is_among
from ams.surveillance.common_mode_columns import BASE, PITCH, ROTATIONS
from ams.surveillance.loose_mount import force_changes

LINEAR: Final = 4
"""Offset and three sensitivities."""


@dataclass(frozen=True)
class Changed:
    """A change that is told."""

    rows: BoolArray
    """(N,) whether each row was measured in it."""
    parts: tuple[str, ...] = ()
    """Turns of the table that it is made of, where that is proved; empty: whatever a change does to an output."""


def step_columns(evidence: Evidence, output: int, during: Sequence[Changed]) -> FloatArray:
    """Return (N, c) what changes do to the rows in each: of offset and sensitivities, a turn of the package included
    in these, and of the table's pitch axis and base, which turn the package by its roll; of a proved turn its own.
    """
    linear, base = evidence.basis[evidence.layout.point, :LINEAR], linear_base(evidence.models[output])
    turned = dict[str, FloatArray]()
    if base is not None:
        moved, k = force_changes(evidence.rows.pitch_rad, evidence.rows.roll_rad), evidence.primary[output][1:LINEAR]
        turned = {name: change @ k for name, change in zip(ROTATIONS, moved, strict=True)}
        linear = np.column_stack([linear, turned[PITCH], turned[BASE]])

    def columns_of(changed: Changed) -> FloatArray:
        if not changed.parts:
            return linear
        return np.stack([turned[name] for name in changed.parts], axis=1) if turned else linear[:, :0]

    return np.hstack([np.where(changed.rows[:, None], columns_of(changed), 0.0) for changed in during])


def moments_of(turn: TableTurn, evidence: Evidence) -> Iterator[Changed]:
    """Yield the turn before each of the dwells in between, and after all of them; none where no row is on one side."""
    after, before = is_among(evidence.rows, turn.after), is_among(evidence.rows, turn.before)
    if not (after.any() and before.any()):
        return
    order = time_order(evidence)
    between = order[~(after | before)[order]]
    for first in range(between.size + 1):
        changed = after.copy()
        changed[between[first:]] = True
        yield Changed(changed, turn.parts)
