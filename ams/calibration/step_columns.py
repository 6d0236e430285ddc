"""What a change in mid-run does to an output, as columns that are taken out of it."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.tested_terms import linear_base
from ams.arrays import BoolArray, FloatArray
from ams.surveillance.loose_mount import force_changes

LINEAR: Final = 4
"""Offset and three sensitivities."""


def step_columns(evidence: Evidence, output: int, during: Sequence[BoolArray]) -> FloatArray:
    """Return (N, c) what changes do to the rows in each: of offset and sensitivities, a turn of the package included
    in these, and of the table's pitch axis and base, which turn the package by its roll.
    """
    linear, base = evidence.basis[evidence.layout.point, :LINEAR], linear_base(evidence.models[output])
    if base is not None:
        _, by_pitch, by_base, *_ = force_changes(evidence.rows.pitch_rad, evidence.rows.roll_rad)
        k = evidence.primary[output][1:LINEAR]
        linear = np.column_stack([linear, by_pitch @ k, by_base @ k])
    return np.hstack([np.where(changed[:, None], linear, 0.0) for changed in during])
