"""An output without the dwells that stand at a rail of its channel, and what is said of them."""

import numpy as np

from ams.analysis.diagnostics.clipped import at_extremes, clipped_finding, first_rows, is_rail
from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.calibration.output.believed import Believed
from ams.findings import Finding


def without_clipped(seen: Believed) -> tuple[tuple[Finding, ...], Believed]:
    """Return what is said of rails, and the output without the dwells that stand at one."""
    output, layout, model = seen.outputs[:, seen.index], seen.evidence.layout, seen.solved.problem.models[seen.index]
    equal = at_extremes(output)
    if not equal:
        return (), seen
    kept = ~np.logical_or.reduce(equal)
    if np.unique(layout.point[kept]).size < 2 * len(model.primary_names):
        return (), seen
    without = seen.of(kept, 0.0)
    predicted = without.solved.problem.models[0].predict(without.solved.primary[0], seen.rows)
    sd = float(without.solved.standard_error_v[0])
    rails = [rows for rows in equal if is_rail(rows, output, layout.point, predicted, sd)]
    if not rails:
        return (), seen
    if len(rails) < len(equal):
        without = seen.of(~np.logical_or.reduce(rails), 0.0)
    dwells = [dwell_words(seen.rows, row) for row in first_rows(rails)]
    return (clipped_finding(rails, output, model.measured_unit, dwells, seen.rows.step),), without
