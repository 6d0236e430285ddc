"""An output without the dwells that stand at a rail of its channel, and what is said of them."""

import numpy as np

from ams.analysis.diagnostics.clipped import (
    at_extremes,
    clipped_finding,
    first_rows,
    is_rail_by_expectation,
    is_rail_by_replications,
)
from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.arrays import BoolArray
from ams.calibration.output.believed import Believed
from ams.findings import Finding


def without_clipped(seen: Believed) -> tuple[tuple[Finding, ...], Believed]:
    """Return what is said of rails, and the output without the dwells that stand at one.

    They stay in it where the points that are left would not tell what to expect of them.
    """
    output, layout, model = seen.outputs[:, seen.index], seen.evidence.layout, seen.solved.problem.models[seen.index]
    equal = at_extremes(output)
    if not equal:
        return (), seen
    kept = ~np.logical_or.reduce(equal)
    has_points = bool(np.unique(layout.point[kept]).size >= 2 * len(model.primary_names))
    without = seen.of(kept, 0.0) if has_points else None
    rails = [
        rows
        for rows in equal
        if is_rail_by_replications(rows, kept, output, layout.point)
        or (without is not None and _is_unexpected(rows, seen, without))
    ]
    if not rails:
        return (), seen
    if without is not None and len(rails) < len(equal):
        without = seen.of(~np.logical_or.reduce(rails), 0.0)
    dwells = [dwell_words(seen.rows, row) for row in first_rows(rails)]
    steps = seen.rows.step
    finding = clipped_finding(rails, output, model.measured_unit, dwells, steps, are_left_out=has_points)
    return (finding,), without or seen


def _is_unexpected(rows: BoolArray, seen: Believed, without: Believed) -> bool:
    """Return whether a solution ``without`` any extreme expects the readings of these rows apart."""
    predicted = without.solved.problem.models[0].predict(without.solved.primary[0], seen.rows)
    sd = float(without.solved.standard_error_v[0])
    return is_rail_by_expectation(rows, seen.outputs[:, seen.index], predicted, sd)
