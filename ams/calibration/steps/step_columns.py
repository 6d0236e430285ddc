"""What a change in mid-run does to an output, as columns that are taken out of it."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.sensed_force import along_force, is_rolled, yaw_of
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.analysis.diagnostics.time_order import even_course
from ams.arrays import BoolArray, FloatArray
from ams.inputs.known_of_run import GAIN, OFFSET, ProvedChange, is_among
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.surveillance.turns import BASE, PITCH, YAW, force_changes

Drifting = Literal["offset", "sensitivity"]
"""What of an output goes evenly through the run."""


@dataclass(frozen=True)
class Changed:
    """A change that is told."""

    rows: BoolArray
    """(N,) whether each row was measured in it."""
    parts: tuple[str, ...] = ()
    """What of table and meter it is made of, where that is proved; empty: whatever a change does to an output."""


def step_columns(evidence: Evidence, output: int, during: Sequence[Changed]) -> FloatArray:
    """Return (N, c) what changes do to the rows in each: of offset and sensitivities, a turn of the package included
    in these, and of the table's pitch and yaw axes and base, which turn the package by its roll; of what is proved its
    own.
    """
    linear, base = evidence.basis[evidence.layout.point, :LINEAR_COLUMNS], accelerometer_base(evidence.models[output])
    known = {GAIN: evidence.sensed[:, output], OFFSET: np.ones(evidence.rows.rows)}
    if base is not None:
        rows, k = evidence.rows, along_force(base, evidence.primary[output])
        moved = force_changes(rows.pitch_rad, rows.roll_rad if is_rolled(base) else None, yaw_of(base, rows))
        known |= {name: change @ k for name, change in moved.items()}
        outer = (PITCH, YAW, BASE) if is_rolled(base) else (PITCH, BASE)  # yaw turns the package on a sting itself
        linear = np.column_stack([linear, *(known[name] for name in outer if name in known)])

    def columns_of(changed: Changed) -> FloatArray:
        if not changed.parts:
            return linear
        return np.column_stack([linear[:, :0], *(known[name] for name in changed.parts if name in known)])

    return np.hstack([np.where(changed.rows[:, None], columns_of(changed), 0.0) for changed in during])


def beside_of(evidence: Evidence, output: int, drifting: Collection[Drifting]) -> FloatArray:
    """Return (N, c) the even drifts of what drifts of an output, beside which changes are estimated."""
    course = even_course(evidence.time_order)
    columns = {"offset": course, "sensitivity": course * evidence.sensed[:, output]}
    return np.array([column for what, column in columns.items() if what in drifting]).reshape(-1, course.size).T


def part_of(
    evidence: Evidence, output: int, during: Sequence[Changed], drifting: Collection[Drifting] = ()
) -> FloatArray:
    """Return (N,) what changes put into an output, as far as its replications differ by them.

    ``drifting``: what of it drifts evenly beside them.
    """
    return evidence.part_of(output, step_columns(evidence, output, during), beside_of(evidence, output, drifting))


def moments_of(change: ProvedChange, evidence: Evidence) -> Iterator[Changed]:
    """Yield the change before each dwell in between, and after all of them; none where no row is on one side."""
    after, before = is_among(evidence.rows, change.after), is_among(evidence.rows, change.before)
    if not (after.any() and before.any()):
        return
    order = evidence.time_order
    between = order[~(after | before)[order]]
    for first in range(between.size + 1):
        changed = after.copy()
        changed[between[first:]] = True
        yield Changed(changed, change.parts)
